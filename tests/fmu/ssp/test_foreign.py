"""System structures of other tools: written here by the rules of the standard and the habits of FMPy's reader."""

import zipfile
from pathlib import Path

import numpy as np
import pytest
from fmpy.ssp.simulation import simulate_ssp
from typer.testing import CliRunner

import ropeway as rw
from ropeway.__main__ import app
from ropeway.fmu import CoSimulation, FmuImportError, FmuVariableError
from support.fmus import rewritten, with_units
from support.structures import (
    MASS_ENDS,
    NAMES,
    ONE,
    TWO,
    Pack,
    as_coupled_here,
    bound,
    component,
    connections,
    connectors,
    description,
    two_masses,
    values,
)


@pytest.mark.parametrize("version", ["1.0", "2.0"])
def test_two_fmus(pack: Pack, mass: Path, version: str) -> None:
    assert as_coupled_here(CoSimulation.from_ssp(pack(two_masses(version)), step=0.05).run(3.0), mass)


def test_as_fmpy_runs_it(pack: Pack, line2: Path) -> None:
    """Two lines: the travel of one, in metres, is the command of the other's sheave."""
    first = component("a", connectors(**{"c1.travel": "output"}))
    second = component("b", connectors(**{"c1.speed": "input", "c1.travel": "output"}))
    text = f"<ssd:Elements>{first}{second}</ssd:Elements>{connections('a.c1.travel b.c1.speed')}"
    with pytest.raises(FmuVariableError, match=r"a\.c1\.travel to b\.c1\.speed: 'm' and 'm/s' measure different"):
        CoSimulation.from_ssp(pack(description(text), line2), step=0.5)
    path = pack(
        description(text.replace("/></ssd:Connections>", 'suppressUnitConversion="true"/></ssd:Connections>')), line2
    )
    theirs = simulate_ssp(str(path), stop_time=2.0, step_size=0.5)
    ours = CoSimulation.from_ssp(path, step=0.5).run(2.0).iloc[1:]
    for name in ("a.c1.travel", "b.c1.travel"):  # the rows of FMPy have the time before the step
        assert np.array_equal(theirs[name][:4], ours[name])
    assert ours["b.c1.travel"].to_list() == pytest.approx([0.0, 0.25, 0.75, 1.5])


def test_systems_within_systems(pack: Pack, mass: Path) -> None:
    """The pair in two subsystems; start values of a hierarchy, in a file, with a mapping; inner ones are overridden."""
    own = bound(values({"x": 7.0, "mass": 1.0}))
    left = (
        f'<ssd:System name="left">{connectors(place="input", speed="input", pull="output")}'
        f"<ssd:Elements>{component('m', connectors(**MASS_ENDS) + own)}</ssd:Elements>"
        f"{connections('place m.x_in', 'speed m.v_in', 'm.f pull')}</ssd:System>"
    )
    right = (
        f'<ssd:System name="right">{connectors(x="output", v="output", push="input")}'
        f"<ssd:Elements>{component('m', connectors(**MASS_ENDS))}</ssd:Elements>"
        f"{connections('m.x x', 'm.v v', 'push m.force')}</ssd:System>"
    )
    twice = '<ssc:LinearTransformation factor="2" offset="-2"/>'
    rows = "".join(
        f'<ssm:MappingEntry source="{source}" target="right.m.{target}">{change}</ssm:MappingEntry>'
        for source, target, change in (("heavy", "mass", twice), ("soft", "spring", ""), ("damp", "damper", ""))
    )
    mapping = f'<ssm:ParameterMapping {NAMES} version="1.0">{rows}</ssm:ParameterMapping>'
    given = bound(
        values({"heavy": 2.0, "soft": 2.0, "damp": 0.5}),
        mapping=f"<ssd:ParameterMapping>{mapping}</ssd:ParameterMapping>",
    )
    outside = '<ssd:ParameterBinding source="resources/left.ssv" prefix="left.m."/>'
    sets = given.replace("<ssd:ParameterBindings>", f"<ssd:ParameterBindings>{outside}")
    links = connections("right.x left.place", "right.v left.speed", "left.pull right.push")
    text = description(f"{sets}<ssd:Elements>{left}{right}</ssd:Elements>{links}")
    frame = CoSimulation.from_ssp(pack(text, left__ssv=values(ONE)), step=0.05).run(1.0)
    assert list(frame)[:2] == ["left_m.x", "left_m.v"]
    assert as_coupled_here(frame, mass)


def test_a_signal_dictionary(pack: Pack, mass: Path) -> None:
    """Values pass through named signals, which two systems use."""
    bus = (
        '<ssd:SignalDictionaries><ssd:SignalDictionary name="bus" source="resources/bus.ssb"/></ssd:SignalDictionaries>'
    )
    signals = "".join(f'<ssb:DictionaryEntry name="{n}"><ssc:Real/></ssb:DictionaryEntry>' for n in ("x", "v", "f"))
    dictionary = f'<ssb:SignalDictionary {NAMES} version="1.0">{signals}</ssb:SignalDictionary>'

    def use(**kinds: str) -> str:
        what = "ssd:SignalDictionaryReference"
        return f'<{what} name="bus" dictionary="bus">{connectors(**kinds)}</{what}>'

    one = component("one", connectors(**MASS_ENDS) + bound(values(ONE)))
    two = component("two", connectors(**MASS_ENDS) + bound(values(TWO)))
    inner = (
        f'<ssd:System name="right"><ssd:Elements>{two}{use(x="inout", v="input", f="output")}</ssd:Elements>'
        f"{connections('two.x bus.x', 'two.v bus.v', 'bus.f two.force')}</ssd:System>"
    )
    outer = f"<ssd:Elements>{one}{use(x='output', v='inout', f='inout')}{inner}</ssd:Elements>"
    text = description(f"{outer}{connections('bus.x one.x_in', 'bus.v one.v_in', 'one.f bus.f')}{bus}")
    assert as_coupled_here(CoSimulation.from_ssp(pack(text, bus__ssb=dictionary), step=0.05).run(1.0), mass)


UNITS = """<ssd:Units><ssc:Unit name="kN"><ssc:BaseUnit kg="1" m="1" s="-2" factor="1000"/></ssc:Unit>
<ssc:Unit name="N"><ssc:BaseUnit kg="1" m="1" s="-2"/></ssc:Unit></ssd:Units>"""


@pytest.mark.parametrize(
    ("connection", "factor", "offset"),
    [
        ("one.f two.force", 1e3, 0.0),
        ('one.f two.force suppressUnitConversion="true"/>', 1.0, 0.0),
        ('one.f two.force ><ssc:LinearTransformation factor="2" offset="3"/></ssd:Connection>', 2e3, 3.0),
    ],
)
def test_units(pack: Pack, mass: Path, tmp_path: Path, connection: str, factor: float, offset: float) -> None:
    """A force in kN drives one in N."""
    both = with_units(mass, tmp_path / "both.fmu", {"f": "kN", "force": "N", "mass": "t"})
    parts = component("one", connectors(f="output")) + component("two", connectors("N", force="input"))
    text = description(f"<ssd:Elements>{parts}</ssd:Elements>{connections(connection)}", UNITS)
    master = CoSimulation.from_ssp(pack(text, both), step=0.1)
    (found,) = master._connections
    assert (found.factor, found.offset) == (pytest.approx(factor), offset)


def test_a_connector_may_have_its_own_unit(pack: Pack, mass: Path, tmp_path: Path) -> None:
    """The force in N is declared in kN and passes without a conversion to one in N: 1 N becomes 0.001."""
    both = with_units(mass, tmp_path / "both.fmu", {"f": "N", "force": "N"})
    parts = component("one", connectors("kN", f="output")) + component("two", connectors("N", force="input"))
    link = connections('one.f two.force suppressUnitConversion="true"/>')
    text = description(f"<ssd:Elements>{parts}</ssd:Elements>{link}", UNITS)
    (found,) = CoSimulation.from_ssp(pack(text, both), step=0.1)._connections
    assert found.factor == pytest.approx(1e-3)


def test_parameters_in_other_units(pack: Pack, mass: Path, tmp_path: Path) -> None:
    """A mass in kg for a variable in tonnes; the force at a connector of the whole system, in kN."""
    tonnes = with_units(mass, tmp_path / "tonnes.fmu", {"mass": "t", "force": "N", "x": "m"})
    inside = connectors(force="input") + bound(values({"mass": 2500.0}, "kg"))
    system = connectors(pull="input") + bound(values({"pull": 5.0}, "kN"))
    text = description(
        f"{system}<ssd:Elements>{component('one', inside)}</ssd:Elements>{connections('pull one.force')}"
    )
    frame = CoSimulation.from_ssp(pack(text, tonnes), step=0.1).run(0.1)
    assert frame["one.a"].iloc[0] == pytest.approx(5e3 / 2.5)


def test_values_for_no_variable_are_reported(pack: Pack) -> None:
    text = description(f"<ssd:Elements>{component('one', bound(values({'mas': 2.0, 'mass': 3.0})))}</ssd:Elements>")
    with pytest.warns(rw.RopewayWarning, match="1 parameter values fit no variable: mas"):
        master = CoSimulation.from_ssp(pack(text), step=0.1)
    assert master._participants["one"].start == {"mass": 3.0}


def test_a_description_beside_its_files(pack: Pack, tmp_path: Path) -> None:
    path = pack(two_masses())
    with zipfile.ZipFile(path) as archive:
        archive.extractall(tmp_path / "open")
    frame = CoSimulation.from_ssp(tmp_path / "open" / "SystemStructure.ssd", step=0.01).run(0.1)
    assert frame.equals(CoSimulation.from_ssp(path, step=0.01).run(0.1))


def test_command_line(pack: Pack, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = pack(two_masses())
    monkeypatch.chdir(tmp_path)
    done = CliRunner().invoke(app, ["fmu", "ssp", "run", str(path), "--step", "0.5", "-o", "yard.csv"])
    assert done.exit_code == 0, done.stderr
    assert len(Path("yard.csv").read_text().splitlines()) == 8  # 0 to 3 s, the end of the default experiment
    done = CliRunner().invoke(app, ["fmu", "ssp", "run", str(path)])
    assert done.stderr.startswith("ropeway: The system structure has no communication step")


ELEMENTS = f"<ssd:Elements>{''.join(component(n, connectors(**MASS_ENDS)) for n in ('one', 'two'))}</ssd:Elements>"


@pytest.mark.parametrize(
    ("text", "cause"),
    [
        ("<no", "is not XML"),
        (description(ELEMENTS, version="3.0"), "of SSP version 3.0"),
        (description(ELEMENTS, "<ssd:Wrong/>"), r"line 2.*violates the schema"),
        (description(ELEMENTS + connections("one.x two.x")), "both give a value"),
        (description(ELEMENTS + connections("one.x two.force", "one.v two.force")), "driven by one.x and one.v"),
        (description(ELEMENTS + connections("one.x three.y")), "three is connected, but is missing"),
        (description(ELEMENTS + connections("one.x y")), "y is connected, but is not declared"),
        (description(ELEMENTS.replace("mass.fmu", "none.fmu")), "no file 'resources/none.fmu'"),
        (description(ELEMENTS.replace("resources/mass.fmu", "https://example.org/a.fmu")), "not a file"),
        (description(ELEMENTS.replace("resources/mass.fmu", "../mass.fmu")), "no file"),
        (description(ELEMENTS.replace("x-fmu-sharedlibrary", "x-other")), "of type application/x-other"),
        (description("<ssd:Elements><ssd:System name='a'/></ssd:Elements>"), "has no FMU"),
    ],
)  # fmt: skip
def test_faults_are_named(pack: Pack, text: str, cause: str) -> None:
    with pytest.raises(FmuImportError, match=cause) as error:
        CoSimulation.from_ssp(pack(text), step=0.1)
    assert error.value.remedy


def test_wrong_values_are_named(pack: Pack, tmp_path: Path, mass: Path) -> None:
    both = with_units(mass, tmp_path / "both.fmu", {"mass": "kg"})
    text = description(f"<ssd:Elements>{component('one', bound(values({'mass': 1.0}, 'bar')))}</ssd:Elements>")
    with pytest.raises(FmuVariableError, match="'mass' of values inside the description: 'bar' and 'kg'"):
        CoSimulation.from_ssp(pack(text, both), step=0.1)


def test_not_a_package(tmp_path: Path) -> None:
    for name, content, cause in (("a.ssp", b"x", "neither a zip archive"), ("b.ssp", None, "There is no file")):
        if content is not None:
            (tmp_path / name).write_bytes(content)
        with pytest.raises(FmuImportError, match=cause):
            CoSimulation.from_ssp(tmp_path / name)


def test_packages_that_mean_harm(pack: Pack) -> None:
    path = pack(two_masses())
    with pytest.raises(FmuImportError, match="holds 2 files; at most 1 are allowed"):
        CoSimulation.from_ssp(path, step=0.1, limits=rw.fmu.ArchiveLimits(files=1))
    inside = '<ssd:Component name="a" type="application/x-ssp-definition" source="SystemStructure.ssd"/>'
    with pytest.raises(FmuImportError, match=r"SystemStructure\.ssd contains itself"):
        CoSimulation.from_ssp(pack(description(f"<ssd:Elements>{inside}</ssd:Elements>")), step=0.1)
    wrong = two_masses("2.0").replace('stopTime="3.0"', 'stopTime="soon"')
    with pytest.raises(FmuImportError, match=r"has a value that cannot be read: .*soon"):
        CoSimulation.from_ssp(pack(wrong), step=0.1)


def test_isolated_slaves(pack: Pack) -> None:
    path = pack(two_masses())
    master = CoSimulation.from_ssp(path, step=0.1, isolated=True)
    assert all(p.fmu.isolated for p in master._participants.values())
    assert master.run(0.3).equals(CoSimulation.from_ssp(path, step=0.1).run(0.3))


def test_a_description_within_another(pack: Pack, mass: Path) -> None:
    """The pair is a component of type .ssd, in another folder: its addresses count from there."""
    inner = two_masses().replace("resources/mass.fmu", "mass.fmu")
    outer = '<ssd:Component name="pair" type="application/x-ssp-definition" source="resources/inner.ssd"/>'
    path = pack(description(f"<ssd:Elements>{outer}</ssd:Elements>"), inner__ssd=inner)
    frame = CoSimulation.from_ssp(path, step=0.05).run(1.0)
    assert frame.columns[0] == "pair_one.x"
    assert as_coupled_here(frame, mass)


def test_a_package_without_a_description(tmp_path: Path, mass: Path) -> None:
    with pytest.raises(FmuImportError, match=r"has no SystemStructure\.ssd"):
        CoSimulation.from_ssp(rewritten(mass, tmp_path / "c.ssp", str))
