"""FMUs made once for all tests of this folder."""

import os
import subprocess
import sys
import time
import zipfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal

import pytest

from ropeway.fmu import export
from support.fmus import HYDRAULIC, RESPONSE, Opener, corridor, example_line, one_span, opening, short_line
from support.hostiles import hostile_fmu, library
from support.kinds import kinds_fmu
from support.masses import mass_fmu

Make = Callable[..., Path]
"""A function that exports a system to a file of a name: `make(name, system, fmi, ...)`."""


@pytest.fixture(scope="session")
def fmus(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the FMUs that all workers share."""
    base = tmp_path_factory.getbasetemp()
    folder = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / "fmus"
    folder.mkdir(exist_ok=True)
    return folder


@contextmanager
def turn(path: Path) -> Iterator[None]:
    """One worker at a time."""
    lock = path.with_suffix(".lock")
    while True:
        try:
            lock.mkdir()
            break
        except FileExistsError:
            time.sleep(0.05)
    try:
        yield
    finally:
        lock.rmdir()


@pytest.fixture(scope="session")
def make(fmus: Path) -> Make:
    """Exports a system, unless another worker has done so; `as_users_do`: with the compiler's optimisation."""

    def of(name: str, system: Any, fmi: Literal["2.0", "3.0"], *, as_users_do: bool = False, **more: Any) -> Path:
        path = fmus / f"{name}.fmu"
        with turn(path), pytest.MonkeyPatch.context() as patch:
            if as_users_do:
                patch.delenv("CFLAGS", raising=False)
            return path if path.exists() else export(system, path, fmi, **more)

    return of


@pytest.fixture(scope="session")
def line2(make: Make) -> Path:
    return make("line2", example_line(), "2.0", as_users_do=True)


@pytest.fixture(scope="session")
def line3(make: Make) -> Path:
    return make("line3", example_line(), "3.0")


@pytest.fixture(scope="session")
def driven(make: Make) -> Path:
    return make("driven", short_line(drive=HYDRAULIC, response=RESPONSE), "2.0", tolerance=1e-8)


@pytest.fixture(scope="session")
def span2(make: Make) -> Path:
    return make("span2", one_span(), "2.0")


@pytest.fixture(scope="session")
def span3(make: Make) -> Path:
    return make("span3", one_span(), "3.0", as_users_do=True)


@pytest.fixture(scope="session")
def corridor2(make: Make) -> Path:
    return make("corridor2", corridor(), "2.0", station=345.0, payload=2500.0)


@pytest.fixture(scope="session")
def corridor3(make: Make) -> Path:
    """Its mainline sags so much that it lies on rollers before the carriage comes to a shoe."""
    return make("corridor3", corridor(haulback_tension=3e3), "3.0", station=345.0, payload=0.0)


@pytest.fixture
def open_fmu(tmp_path: Path) -> Iterator[Opener]:
    with opening(tmp_path) as opener:
        yield opener


@pytest.fixture(scope="session")
def mass(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return mass_fmu(tmp_path_factory.mktemp("mass") / "mass.fmu")


@pytest.fixture(scope="session")
def kinds2(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return kinds_fmu(tmp_path_factory.mktemp("kinds2") / "kinds2.fmu", "2.0")


@pytest.fixture(scope="session")
def kinds3(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return kinds_fmu(tmp_path_factory.mktemp("kinds3") / "kinds3.fmu", "3.0")


@pytest.fixture(scope="session")
def hostile_binary(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return library(tmp_path_factory.mktemp("hostile") / "hostile.so")


@pytest.fixture(scope="session")
def hostile(hostile_binary: Path) -> Path:
    """Its outputs are its inputs at once."""
    return hostile_fmu(hostile_binary.with_name("hostile.fmu"), hostile_binary)


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
