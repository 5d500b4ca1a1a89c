"""The FMU in a process that has no Python in it."""

import subprocess
from pathlib import Path

import fmpy
import numpy as np
import pytest

from ropeway.fmu import export
from ropeway.systems.native import compiler
from support.fmus import Opened, Opener, short_line

HEADERS = Path(fmpy.__file__).with_name("c-code")


def compiled_host(platform: str, program: Path) -> Path:
    """The host of `host.c`."""
    source = Path(__file__).with_name("host.c")
    libraries = [] if "windows" in platform else ["-ldl"]
    flags = ["-std=gnu99", f"-I{HEADERS}", *libraries, "-o", str(program)]
    subprocess.run([*compiler.command(platform), str(source), *flags], check=True)
    return program


def arguments(library: str, opened: Opened) -> list[str]:
    """Arguments of the host: a hundred steps of 0.5 s, the second instance with another speed."""
    references = [str(opened.references[n]) for n in ("c1.tension_in", "c1.speed")]
    return [library, opened.description.guid, *references, "100", "0.5"]


def printed(output: str) -> np.ndarray:
    return np.array([[float(v) for v in row.split()] for row in output.splitlines()])


def test_runs_in_a_c_program(line2: Path, open_fmu: Opener, tmp_path: Path) -> None:
    folder = Path(fmpy.extract(str(line2), unzipdir=str(tmp_path / "fmu")))
    program = compiled_host(compiler.host(), tmp_path / "host")
    one, two = open_fmu(line2), open_fmu(line2)
    library = str(next((folder / "binaries").rglob("*.so")))
    command = [str(program), *arguments(library, one)]
    run = subprocess.run(command, env={}, capture_output=True, text=True, check=True)
    values = printed(run.stdout)
    one.initialize()
    two.initialize()
    two.set(c1__speed=1.05)
    assert np.array_equal(values[:, 0], one.run(0.0, 50.0, 0.5, ["c1.tension_in"])[:, 0])
    assert np.array_equal(values[:, 1], two.run(0.0, 50.0, 0.5, ["c1.tension_in"])[:, 0])


def test_library_needs_libc_and_libm_only(line2: Path, tmp_path: Path) -> None:
    folder = Path(fmpy.extract(str(line2), unzipdir=str(tmp_path / "fmu")))
    library = next((folder / "binaries").rglob("*.so"))
    needed = subprocess.run(["objdump", "-p", str(library)], capture_output=True, text=True, check=True).stdout
    names = {line.split()[1].split(".")[0] for line in needed.splitlines() if "NEEDED" in line}
    assert names <= {"libc", "libm", "libpthread"}


@pytest.mark.importers
def test_runs_on_windows(open_fmu: Opener, tmp_path: Path) -> None:
    """Under wine, whose C library rounds in its own way."""
    path = export(short_line(), tmp_path / "both.fmu", platforms=("host", "x86_64-windows"))
    folder = Path(fmpy.extract(str(path), unzipdir=str(tmp_path / "fmu")))
    program = compiled_host("x86_64-windows", tmp_path / "host.exe")
    one = open_fmu(path)
    library = "Z:" + str(next((folder / "binaries").rglob("*.dll"))).replace("/", "\\")
    run = subprocess.run(
        ["wine", str(program), *arguments(library, one)],
        env={"PATH": "/usr/bin:/bin", "WINEPREFIX": str(tmp_path / "wine"), "WINEDEBUG": "-all"},
        capture_output=True,
        text=True,
        check=True,
    )
    one.initialize()
    here = one.run(0.0, 50.0, 0.5, ["c1.tension_in"])[:, 0]
    np.testing.assert_allclose(printed(run.stdout)[:, 0], here, rtol=1e-12)
