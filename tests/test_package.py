"""The package list, the wheel and the public names."""

import shutil
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path
from types import ModuleType

import pytest

import ropeway as rw

ROOT = Path(__file__).resolve().parents[1]
CODE = ("components", "systems", "fmu", "examples")


def packages() -> list[str]:
    return tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]["packages"]


def test_every_folder_with_code_is_listed() -> None:
    found = {"ropeway"}
    for top in CODE:
        for file in (ROOT / top).rglob("*.py"):
            found.add(".".join(("ropeway", *file.parent.relative_to(ROOT).parts)))
    assert set(packages()) == found


def test_every_package_has_an_init() -> None:
    for package in packages():
        assert (ROOT.joinpath(*package.split(".")[1:]) / "__init__.py").is_file(), package


def test_folders_are_small_and_named_in_the_readme() -> None:
    structure = (ROOT / "README.md").read_text().split("## Structure")[1]
    for package in packages()[1:]:
        folder = ROOT.joinpath(*package.split(".")[1:])
        assert f"{folder.name}/" in structure, package
        modules = [p for p in folder.glob("*.py") if p.name != "__init__.py"]
        assert len(modules) <= 18 or folder.name in ("components", "examples"), package


@pytest.mark.slow
def test_wheel_holds_the_tree(tmp_path: Path) -> None:
    source = tmp_path / "source"
    shutil.copytree(ROOT, source, ignore=shutil.ignore_patterns(".*", "build", "*.egg-info", "__pycache__"))
    build = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", str(tmp_path), str(source)]
    subprocess.run(build, check=True, capture_output=True, cwd=tmp_path)
    (wheel,) = tmp_path.glob("*.whl")
    names = set(zipfile.ZipFile(wheel).namelist())
    tracked = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.split()
    wanted = {f"ropeway/{f}" for f in tracked if f.endswith(".py") and ("/" not in f or f.split("/")[0] in CODE)}
    assert wanted <= names
    data = ("py.typed", "components/catalogue/ropes.csv", "__init__.pyi", "fmu/__init__.pyi", "examples/line.csv")
    sources = ("systems/native/ropeway.h", "fmu/exporting/templates/fmi3.c")
    assert {f"ropeway/{name}" for name in (*data, *sources)} <= names
    assert wheel.name.startswith(f"ropeway-{rw.__version__}-")
    assert not any(n.startswith(("tests/", "ropeway/tests/", "ropeway/benchmarks/")) for n in names)


@pytest.mark.parametrize("package", [rw, rw.fmu], ids=["ropeway", "ropeway.fmu"])
def test_public_names_resolve(package: ModuleType) -> None:
    assert set(dir(package)) == set(package.__all__)
    for name in package.__all__:
        assert getattr(package, name) is not None
    with pytest.raises(AttributeError, match="attribute rope_way"):
        _ = package.rope_way


def test_stubs_with_the_public_names_are_installed() -> None:
    data = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]["package-data"]
    for package in packages():
        folder = ROOT.joinpath(*package.split(".")[1:])
        assert (folder / "__init__.pyi").is_file() == ("__init__.pyi" in data.get(package, [])), package


def test_import_is_light() -> None:
    code = "import sys, ropeway; print([m for m in ('casadi', 'pandas', 'matplotlib', 'scipy') if m in sys.modules])"
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT.parent)
    assert out.stdout.strip() == "[]"


def test_the_citation_has_this_version() -> None:
    assert f"\nversion: {rw.__version__}\n" in (ROOT / "CITATION.cff").read_text()
