"""Units that an FMU names, with and without a definition."""

from functools import reduce
from pathlib import Path

import pytest

import ropeway as rw
from ropeway.fmu import CoSimulation, FmuVariableError, component, export
from support.fmus import WEAK_UNIT, rewritten, with_units


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


DEGREES = '<Unit name="degC"><BaseUnit K="1" offset="273.15"/></Unit><Unit name="K"><BaseUnit K="1"/></Unit>'
WARMING = 'unit="degC" relativeQuantity="true"'


def warming(mass: Path, kinds3: Path, path: Path, fmi: str) -> tuple[str, str]:
    """An FMU with a difference of temperatures, declared at the variable (2.0) or its type (3.0), and a temperature;
    their names."""
    if fmi == "2.0":
        with_units(mass, path, {"f": WARMING[6:-1], "x": "degC"}, DEGREES)
        return "f", "x"
    types = f'<UnitDefinitions>{DEGREES}</UnitDefinitions><TypeDefinitions><Float64Type name="Warming" {WARMING}/>'
    changes = {
        '<Float64 name="x"': '<Float64 name="x" declaredType="Warming"',
        '<Float64 name="d_out"': '<Float64 name="d_out" unit="degC"',
        "<TypeDefinitions>": types,
    }
    rewritten(kinds3, path, lambda text: reduce(lambda made, item: made.replace(*item), changes.items(), text))
    return "x", "d_out"


@pytest.mark.parametrize("fmi", ["2.0", "3.0"])
def test_a_difference_does_not_take_the_zero_of_its_scale(mass: Path, kinds3: Path, tmp_path: Path, fmi: str) -> None:
    """FMI's relativeQuantity: 10 degC of warming are 10 K."""
    difference, value = warming(mass, kinds3, tmp_path / "one.fmu", fmi)
    inputs = {"force": 'K" relativeQuantity="true', "x_in": "degF", "v_in": "K"}
    together = CoSimulation(0.1)
    together.add("one", tmp_path / "one.fmu")
    together.add("two", with_units(mass, tmp_path / "two.fmu", inputs, DEGREES))
    found = together.connect(f"one.{difference}", "two.force")
    assert (found.factor, found.offset) == (1.0, 0.0)
    with pytest.raises(FmuVariableError, match="become a value on the scale of 'degF'"):
        together.connect(f"one.{difference}", "two.x_in")
    found = together.connect(f"one.{value}", "two.v_in")
    assert (found.factor, found.offset) == (1.0, 273.15)


def test_a_table_of_differences_does_not_take_a_zero(mass: Path, tmp_path: Path) -> None:
    """Of a mass: its acceleration is the force, here called a difference in K."""
    path = with_units(mass, tmp_path / "two.fmu", {"force": 'K" relativeQuantity="true'})
    table = tmp_path / "inputs.csv"
    table.write_text("time,two.force [degF]\n0,18\n2,18\n")
    together = CoSimulation(0.5)
    together.add("two", path)
    assert together.run(2.0, inputs=table)["two.a"].to_list() == pytest.approx([10.0] * 5)


def test_a_component_is_in_si(tmp_path: Path) -> None:
    s = rw.System("unit")
    s.add(WEAK_UNIT)
    path, own = export(s, tmp_path / "unit.fmu"), {"unit.load_power": "hp", "unit.pressure": "psi", "unit.flow": "ell"}
    warm = {"unit.load_power": WARMING[6:-1], "unit.pressure": "degC"}
    temperatures = component("warm", with_units(path, tmp_path / "warm.fmu", warm), ignore_events=True)
    assert [temperatures.scales[n] for n in warm] == [(1.0, 0.0), (1.0, 273.15)]
    named = component("power", with_units(path, tmp_path / "named.fmu", own), ignore_events=True)
    assert [named.unit_of(n) for n in own] == ["W", "Pa", "ell"]
    assert named.scales["unit.load_power"] == (pytest.approx(745.69987158), 0.0)
    assert named.scales["unit.pressure"] == (pytest.approx(6894.757293168), 0.0)
    yard = rw.System("yard")
    yard.add(named)
    sheave = yard.add(rw.ControlSheave("c1", at=(100.0, 0.0)))
    with pytest.raises(rw.InputError, match=r"power\.unit\.flow is in ell, c1\.speed in m/s"):
        yard.connect(named.output("unit.flow"), sheave.input("speed"))
