"""Units that an FMU names, with and without a definition."""

import re
import zipfile
from pathlib import Path

import pytest
from fmus import WEAK_UNIT

import ropeway as rw
from ropeway.fmu import CoSimulation, FmuVariableError, component, export


def with_units(mass: Path, path: Path, units: dict[str, str], definitions: str = "") -> Path:
    """The FMU of a mass with units at some of its variables."""
    with zipfile.ZipFile(mass) as source, zipfile.ZipFile(path, "w") as target:
        for item in source.namelist():
            data = source.read(item)
            if item == "modelDescription.xml":
                text = data.decode()
                for name, unit in units.items():
                    text = re.sub(
                        rf'(name="{re.escape(name)}" [^>]*>\s*<Real )(?:unit="[^"]*")?', rf'\1unit="{unit}" ', text
                    )
                if definitions:
                    text = text.replace(
                        "<ModelVariables>", f"<UnitDefinitions>{definitions}</UnitDefinitions><ModelVariables>"
                    )
                data = text.encode()
            target.writestr(item, data)
    return path


def factor(mass: Path, folder: Path, source: str, target: str, definitions: str = "") -> tuple[float, float]:
    together = CoSimulation(0.1)
    together.add("one", with_units(mass, folder / "one.fmu", {"f": source}, definitions))
    together.add("two", with_units(mass, folder / "two.fmu", {"force": target}))
    found = together.connect("one.f", "two.force")
    return found.factor, found.offset


@pytest.mark.parametrize(
    ("source", "target", "expected"),
    [("daN", "N", 10.0), ("lbf", "kN", 4.4482216152605e-3), ("bar", "psi", 14.503773773), ("rpm", "deg/s", 6.0)],
)
def test_units_without_a_definition_are_read(
    mass: Path, tmp_path: Path, source: str, target: str, expected: float
) -> None:
    assert factor(mass, tmp_path, source, target) == (pytest.approx(expected), 0.0)


@pytest.mark.parametrize(
    ("source", "target"), [("bar", "N"), ("cubit", "m"), ("m", "cubit"), ("1", "kN"), ("Hz", "rpm")]
)
def test_units_that_do_not_fit_are_refused(mass: Path, tmp_path: Path, source: str, target: str) -> None:
    with pytest.raises(FmuVariableError, match=rf"one\.fmu is in {source}") as error:
        factor(mass, tmp_path, source, target)
    assert error.value.remedy


def test_a_definition_goes_before_the_symbol(mass: Path, tmp_path: Path) -> None:
    cubit = '<Unit name="cubit"><BaseUnit m="1" factor="0.4572"/></Unit>'
    assert factor(mass, tmp_path, "cubit", "m", cubit)[0] == pytest.approx(0.4572)
    mole = '<Unit name="u"><BaseUnit mol="1"/></Unit>'
    with pytest.raises(FmuVariableError, match="different quantities"):
        factor(mass, tmp_path, "u", "1", mole)


def test_a_component_is_in_si(tmp_path: Path) -> None:
    s = rw.System("unit")
    s.add(WEAK_UNIT)
    path, own = export(s, tmp_path / "unit.fmu"), {"unit.load_power": "hp", "unit.pressure": "psi", "unit.flow": "ell"}
    named = component("power", with_units(path, tmp_path / "named.fmu", own), ignore_events=True)
    assert [named.unit_of(n) for n in own] == ["W", "Pa", "ell"]
    assert named.scales["unit.load_power"] == (pytest.approx(745.69987158), 0.0)
    assert named.scales["unit.pressure"] == (pytest.approx(6894.757293168), 0.0)
    yard = rw.System("yard")
    yard.add(named)
    sheave = yard.add(rw.ControlSheave("c1", at=(100.0, 0.0)))
    with pytest.raises(rw.InputError, match=r"power\.unit\.flow is in ell, c1\.speed in m/s"):
        yard.connect(named.output("unit.flow"), sheave.input("speed"))
