"""Packages within packages, files inside FMUs, and values that are mapped one by one."""

import zipfile
from pathlib import Path

import pytest

import ropeway as rw
from ropeway.fmu import CoSimulation, FmuImportError
from support.fmus import rewritten
from support.structures import (
    MASS_ENDS,
    NAMES,
    ONE,
    PAIR,
    TWO,
    Pack,
    as_coupled_here,
    bound,
    component,
    connections,
    connectors,
    description,
    values,
)

SSP = "application/x-ssp-package"


def test_a_package_within_another(pack: Pack, mass: Path, tmp_path: Path) -> None:
    """The pair as a component of type .ssp; a value of the outer system, and one in a file beside the inner FMU."""
    given = (
        '<ssd:ParameterBindings><ssd:ParameterBinding source="two.ssv" sourceBase="component"/></ssd:ParameterBindings>'
    )
    parts = (
        component("one", connectors(**MASS_ENDS) + bound(values({**ONE, "mass": 7.0}))),
        component("two", connectors(**MASS_ENDS) + given),
    )
    with_values = tmp_path / "with.fmu"
    rewritten(mass, with_values, str)
    with zipfile.ZipFile(with_values, "a") as archive:
        archive.writestr("two.ssv", values(TWO))
    inside = description(f"<ssd:Elements>{''.join(parts)}</ssd:Elements>{PAIR}")
    inner = pack(inside, with_values).rename(tmp_path / "in.ssp")
    given = bound(values({"one.mass": 1.0}))
    outer = f'<ssd:Component name="pair" type="{SSP}" source="resources/in.ssp">{given}</ssd:Component>'
    path = pack(description(f"<ssd:Elements>{outer}</ssd:Elements>"))
    with zipfile.ZipFile(path, "a") as archive:
        archive.write(inner, "resources/in.ssp")
    frame = CoSimulation.from_ssp(path, step=0.05).run(1.0)
    assert frame.columns[0] == "pair_one.x"
    assert as_coupled_here(frame, mass)
    with pytest.raises(FmuImportError, match=r"with\.fmu holds|in\.ssp holds|holds 3 files"):
        CoSimulation.from_ssp(path, step=0.1, limits=rw.fmu.ArchiveLimits(files=2))


def test_packages_without_end(pack: Pack, tmp_path: Path) -> None:
    """Each package refers to one file on the disk, as an archive could that contains itself."""
    source = (tmp_path / "yard.ssp").as_uri()
    inside = f'<ssd:Component name="a" type="{SSP}" source="{source}"/>'
    with pytest.raises(FmuImportError, match="is the 20th system within another"):
        CoSimulation.from_ssp(pack(description(f"<ssd:Elements>{inside}</ssd:Elements>")), step=0.1)


def test_values_pass_tables_on_their_way(pack: Pack, kinds3: Path) -> None:
    """A Boolean is negated into a system and again within it; a connector of the whole system gives a gear by name."""

    def table(kind: str, **rows: str) -> str:
        entries = "".join(f'<ssc:MapEntry source="{key}" target="{value}"/>' for key, value in rows.items())
        return f"><ssc:{kind}MappingTransformation>{entries}</ssc:{kind}MappingTransformation></ssd:Connection>"

    def ends(**kinds: str) -> str:
        types = {"brake": "<ssc:Boolean/>", "brake_out": "<ssc:Boolean/>"}
        gear = '<ssc:Enumeration name="Gear"/>'
        each = (
            f'<ssd:Connector name="{n}" kind="{kind}">{types.get(n, gear)}</ssd:Connector>' for n, kind in kinds.items()
        )
        return f"<ssd:Connectors>{''.join(each)}</ssd:Connectors>"

    true = '<ssv:Parameter name="brake"><ssv:Boolean value="true"/></ssv:Parameter>'
    high = '<ssv:Parameter name="gear"><ssv:Enumeration value="up"/></ssv:Parameter>'

    def given(row: str) -> str:
        rows = f"<ssv:Parameters>{row}</ssv:Parameters>"
        return bound(f'<ssv:ParameterSet {NAMES} version="1.0" name="set">{rows}</ssv:ParameterSet>')

    no = table("Boolean", true="false", false="true")
    inner = component("m", ends(brake="input", gear="input"), "resources/mass.fmu")
    parts = f"<ssd:Elements>{inner}</ssd:Elements>{connections(f'brake m.brake {no}')}"
    system = f'<ssd:System name="s">{ends(brake="input")}{parts}</ssd:System>'
    first = component("one", ends(brake_out="output", brake="input", gear="input") + given(true))
    item = '<ssc:Item name="up" value="1"/>'
    items = f'<ssd:Enumerations><ssc:Enumeration name="Gear">{item}</ssc:Enumeration></ssd:Enumerations>'
    links = connections(f"one.brake_out s.brake {no}", f"gear one.gear {table('Enumeration', up='high', down='low')}")
    text = description(f"{ends(gear='input')}{given(high)}<ssd:Elements>{first}{system}</ssd:Elements>{links}", items)
    master = CoSimulation.from_ssp(pack(text, kinds3), step=0.1)
    assert [c.mapping for c in master._connections] == [{True: True, False: False}]
    last = master.run(0.2).iloc[-1]
    assert [last[n] for n in ("one.brake_out", "s_m.brake_out", "one.gear_out")] == [True, True, 2]
