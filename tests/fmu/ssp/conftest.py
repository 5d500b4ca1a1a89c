"""Packages of system structures."""

import zipfile
from pathlib import Path

import pytest

from support.structures import Pack


@pytest.fixture
def pack(mass: Path, tmp_path: Path) -> Pack:
    """Writes a package with a description, the FMU and more files."""

    def of(text: str, fmu: Path = mass, **more: str) -> Path:
        path = tmp_path / "yard.ssp"
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr("SystemStructure.ssd", text)
            archive.write(fmu, "resources/mass.fmu")
            for name, content in more.items():
                archive.writestr(f"resources/{name.replace('__', '.')}", content)
        return path

    return of
