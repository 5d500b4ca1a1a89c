"""FMUs made once for all tests of this folder."""

import subprocess
import sys
import zipfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from fmus import HYDRAULIC, RESPONSE, Opener, corridor, example_line, one_span, opening, short_line
from kinds import kinds_fmu
from masses import mass_fmu

from ropeway.fmu import export


@pytest.fixture(scope="session")
def fmus(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("fmus")


@pytest.fixture(scope="session")
def line2(fmus: Path) -> Path:
    return export(example_line(), fmus / "line2.fmu", "2.0")


@pytest.fixture(scope="session")
def line3(fmus: Path) -> Path:
    return export(example_line(), fmus / "line3.fmu", "3.0")


@pytest.fixture(scope="session")
def driven(fmus: Path) -> Path:
    return export(short_line(drive=HYDRAULIC, response=RESPONSE), fmus / "driven.fmu", "2.0", tolerance=1e-8)


@pytest.fixture(scope="session")
def span2(fmus: Path) -> Path:
    return export(one_span(), fmus / "span2.fmu", "2.0")


@pytest.fixture(scope="session")
def span3(fmus: Path) -> Path:
    return export(one_span(), fmus / "span3.fmu", "3.0")


@pytest.fixture(scope="session")
def corridor2(fmus: Path) -> Path:
    return export(corridor(), fmus / "corridor2.fmu", "2.0", station=345.0, payload=2500.0)


@pytest.fixture(scope="session")
def corridor3(fmus: Path) -> Path:
    """Its mainline sags so much that it lies on rollers before the carriage comes to a shoe."""
    return export(corridor(haulback_tension=3e3), fmus / "corridor3.fmu", "3.0", station=345.0, payload=0.0)


@pytest.fixture
def open_fmu(tmp_path: Path) -> Iterator[Opener]:
    with opening(tmp_path) as opener:
        yield opener


@pytest.fixture(scope="session")
def mass(fmus: Path) -> Path:
    return mass_fmu(fmus / "mass.fmu")


@pytest.fixture(scope="session")
def kinds2(fmus: Path) -> Path:
    return kinds_fmu(fmus / "kinds2.fmu", "2.0")


@pytest.fixture(scope="session")
def kinds3(fmus: Path) -> Path:
    return kinds_fmu(fmus / "kinds3.fmu", "3.0")


@pytest.fixture(params=["2.0", "3.0"])
def kinds(request: pytest.FixtureRequest, kinds2: Path, kinds3: Path) -> Path:
    return kinds2 if request.param == "2.0" else kinds3


@pytest.fixture(params=["CoSimulation", "ModelExchange"])
def kind(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture(scope="session")
def foreign(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of OpenModelica's FMUs from the gemseo-fmu wheel (LGPL; test data, not part of this project)."""
    folder = tmp_path_factory.mktemp("foreign")
    download = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--dest", str(folder)]
    subprocess.run([*download, "gemseo-fmu==3.1.1"], check=True)
    (wheel,) = folder.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(folder, [n for n in archive.namelist() if "/linux/" in n])
    return next(folder.rglob("linux"))
