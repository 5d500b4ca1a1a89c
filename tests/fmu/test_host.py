"""The FMU in a process that has no Python in it."""

import subprocess
from pathlib import Path

import fmpy
import numpy as np
from fmus import Opener

from ropeway.fmu import compiler

HEADERS = Path(fmpy.__file__).with_name("c-code")


def test_runs_in_a_c_program(line2: Path, open_fmu: Opener, tmp_path: Path) -> None:
    folder = Path(fmpy.extract(str(line2), unzipdir=str(tmp_path / "fmu")))
    program = tmp_path / "host"
    source = Path(__file__).with_name("host.c")
    flags = ["-std=gnu99", f"-I{HEADERS}", "-ldl"]
    subprocess.run([*compiler.command(compiler.host()), str(source), *flags, "-o", str(program)], check=True)
    one, two = open_fmu(line2), open_fmu(line2)
    library = next((folder / "binaries").rglob("*.so"))
    references = [str(one.references[n]) for n in ("c1.tension_in", "c1.speed")]
    arguments = [str(library), one.description.guid, *references, "100", "0.5"]
    run = subprocess.run([str(program), *arguments], env={}, capture_output=True, text=True, check=True)
    printed = np.array([[float(v) for v in row.split()] for row in run.stdout.splitlines()])
    one.initialize()
    two.initialize()
    two.set(c1__speed=1.05)
    assert np.array_equal(printed[:, 0], one.run(0.0, 50.0, 0.5, ["c1.tension_in"])[:, 0])
    assert np.array_equal(printed[:, 1], two.run(0.0, 50.0, 0.5, ["c1.tension_in"])[:, 0])


def test_library_needs_libc_and_libm_only(line2: Path, tmp_path: Path) -> None:
    folder = Path(fmpy.extract(str(line2), unzipdir=str(tmp_path / "fmu")))
    library = next((folder / "binaries").rglob("*.so"))
    needed = subprocess.run(["objdump", "-p", str(library)], capture_output=True, text=True, check=True).stdout
    names = {line.split()[1].split(".")[0] for line in needed.splitlines() if "NEEDED" in line}
    assert names <= {"libc", "libm", "libpthread"}
