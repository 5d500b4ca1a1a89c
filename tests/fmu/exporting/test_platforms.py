"""Binaries for other platforms, built here (needs the package ziglang)."""

import re
import zipfile
from pathlib import Path
from typing import Literal

import fmpy
import pytest

from ropeway.fmu import export
from ropeway.systems.native import compiler
from support.fmus import one_span

pytestmark = pytest.mark.importers


@pytest.fixture(scope="module")
def every(tmp_path_factory: pytest.TempPathFactory) -> dict[str, dict[str, bytes]]:
    """Binaries by FMI version and place."""
    found: dict[str, dict[str, bytes]] = {}
    versions: tuple[Literal["2.0", "3.0"], ...] = ("2.0", "3.0")
    for fmi in versions:
        path = export(one_span(), tmp_path_factory.mktemp("all") / "all.fmu", fmi, platforms=compiler.PLATFORMS)
        with zipfile.ZipFile(path) as archive:
            names = [n for n in archive.namelist() if n.startswith("binaries/")]
            found[fmi] = {n.removeprefix("binaries/"): archive.read(n) for n in names}
    return found


@pytest.mark.parametrize(
    ("place", "start"),
    [
        ("x86_64-linux/one_span.so", b"\x7fELF"),
        ("aarch64-linux/one_span.so", b"\x7fELF"),
        ("x86-linux/one_span.so", b"\x7fELF\x01"),
        ("x86_64-windows/one_span.dll", b"MZ"),
        ("x86-windows/one_span.dll", b"MZ"),
        ("x86_64-darwin/one_span.dylib", b"\xcf\xfa\xed\xfe"),
        ("aarch64-darwin/one_span.dylib", b"\xcf\xfa\xed\xfe"),
    ],
)
def test_all_platforms_from_here(every: dict[str, dict[str, bytes]], place: str, start: bytes) -> None:
    assert every["3.0"][place].startswith(start)
    assert b"fmi3DoStep" in every["3.0"][place]


def test_folders_of_version_2(every: dict[str, dict[str, bytes]]) -> None:
    assert every["2.0"]["darwin64/one_span.dylib"].startswith(b"\xca\xfe\xba\xbe")
    folders = {"linux64": ".so", "linux32": ".so", "aarch64-linux": ".so", "win64": ".dll", "win32": ".dll"}
    folders["darwin64"] = ".dylib"
    assert every["2.0"].keys() == {f"{folder}/one_span{suffix}" for folder, suffix in folders.items()}


@pytest.mark.parametrize(("fmi", "place"), [("2.0", "win64/one_span.dll"), ("3.0", "x86_64-windows/one_span.dll")])
def test_windows_library_exports_every_function(every: dict[str, dict[str, bytes]], fmi: str, place: str) -> None:
    """All functions of the standard's header and no other; nothing imported but the C library."""
    from pefile import DIRECTORY_ENTRY, PE

    library = PE(data=every[fmi][place], fast_load=True)
    library.parse_data_directories([DIRECTORY_ENTRY[f"IMAGE_DIRECTORY_ENTRY_{d}"] for d in ("EXPORT", "IMPORT")])
    assert library.FILE_HEADER.Machine == 0x8664
    header = (Path(fmpy.__file__).with_name("c-code") / f"fmi{fmi[0]}Functions.h").read_text()
    wanted = set(re.findall(rf"FMI{fmi[0]}_Export\s+fmi\d\w+TYPE\s+(fmi\d\w+);", header))
    assert len(wanted) > 40
    assert {symbol.name.decode() for symbol in library.DIRECTORY_ENTRY_EXPORT.symbols} == wanted
    needed = {entry.dll.decode().lower() for entry in library.DIRECTORY_ENTRY_IMPORT}
    assert all(name.startswith(("api-ms-win-crt-", "kernel32", "ucrtbase", "msvcrt")) for name in needed), needed
