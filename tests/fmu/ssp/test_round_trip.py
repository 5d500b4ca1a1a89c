"""A co-simulation written as a system structure and read again runs as before, to the bit."""

import zipfile
from pathlib import Path
from xml.etree import ElementTree

import pandas as pd
import pytest
from fmpy.ssp.ssd import find_components, get_connections, read_ssd

import ropeway as rw
from ropeway.fmu import CoSimulation, StepControl
from ropeway.fmu.ssp import documents
from support.fmus import one_span
from support.masses import pair


def again(master: CoSimulation, path: Path, until: float) -> tuple[pd.DataFrame, pd.DataFrame]:
    return master.run(until), CoSimulation.from_ssp(master.to_ssp(path, until=until)).run(until)


@pytest.mark.parametrize(
    "how",
    [
        {},
        {"iterated": True, "master": "Gauss-Seidel", "tolerance": 1e-7, "iterations": 30},
        {"control": StepControl("Richardson", tolerance=1e-3, most=0.5)},
    ],
)
def test_round_trip_is_exact(mass: Path, tmp_path: Path, how: dict[str, object]) -> None:
    """Start values such as 0.1, which have no finite binary fraction, and all settings of the master."""
    before, after = again(pair(mass, 0.07, {"damper": 0.1 + 1e-16, "x": 1.0 / 3.0}, **how), tmp_path / "pair.ssp", 2.0)
    pd.testing.assert_frame_equal(before, after, check_exact=True)
    assert before.attrs == after.attrs


def test_a_system_is_exported_on_the_way(tmp_path: Path) -> None:
    """Its outputs are numbers and Booleans; the mass of its load is a start value."""
    master = CoSimulation(0.5)
    master.add("span", one_span(), start={"turn.mass": 5000.5})
    before, after = again(master, tmp_path / "span.ssp", 1.0)
    pd.testing.assert_frame_equal(before, after, check_exact=True)
    rest = rw.equilibrium(one_span(), parameters={"turn.mass": 5000.5})
    assert after["span.a_b.tension_a"].iloc[-1] == pytest.approx(rest["a_b.tension_a"], rel=1e-9)


def test_values_of_all_kinds(kinds3: Path, tmp_path: Path) -> None:
    start = {
        "text": 'a "<&> text', "gear": "high", "count": -4, "brake": True, "binary": b"\x00\xff", "n": 2,
        "v": [1.5, 2.5], "uint64": 2**31 - 1,
    }  # fmt: skip
    master = CoSimulation(0.1)
    master.add("one", kinds3, start=start, kind="ModelExchange")
    master.add("two", kinds3)
    for name in ("text", "gear", "count", "brake", "binary"):
        master.connect(f"one.{name}_out", f"two.{name}")
    before, after = again(master, tmp_path / "kinds.ssp", 0.3)
    pd.testing.assert_frame_equal(before, after, check_exact=True)
    assert after["two.text_out"].iloc[-1] == start["text"]
    master.add("three", kinds3, start={"uint64": 2**63})
    with pytest.raises(rw.InputError, match=r"'three\.uint64' is 9223372036854775808"):
        master.to_ssp(tmp_path / "large.ssp")


def test_mapped_connections(kinds3: Path, tmp_path: Path) -> None:
    """Booleans, items of an enumeration by name, integers, and an enumeration to an integer by number."""
    master = CoSimulation(0.1)
    master.add("one", kinds3, start={"brake": True, "gear": "high", "count": 2})
    master.add("two", kinds3)
    master.connect("one.brake_out", "two.brake", mapping={True: False, False: True})
    master.connect("one.gear_out", "two.gear", mapping={"low": "high", "high": "low"})
    master.connect("one.count_out", "two.count", mapping={2: -5, 3: 0})
    master.connect("one.gear_out", "two.int16", mapping={1: 10, 2: 20})
    path = tmp_path / "mapped.ssp"
    before, after = again(master, path, 0.3)
    pd.testing.assert_frame_equal(before, after, check_exact=True)
    last = after.iloc[-1]
    assert [last[f"two.{n}_out"] for n in ("brake", "gear", "count", "int16")] == [False, 1, -5, 20]
    with zipfile.ZipFile(path) as archive:
        written = archive.read("SystemStructure.ssd")
    documents.require_valid(written, "it", documents.STRUCTURE)
    kinds = [e.tag.partition("}")[2] for e in ElementTree.fromstring(written).iter() if "Mapping" in e.tag]
    assert kinds == [f"{kind}MappingTransformation" for kind in ("Boolean", "Enumeration", "Integer", "Integer")]
    master.connect("one.brake_out", "two.uint8", mapping={True: 7, False: 8})
    with pytest.raises(rw.InputError, match=r"The mapping of one\.brake_out to two\.uint8 is between different kinds"):
        master.to_ssp(path)


def test_scaled_connections(mass: Path, tmp_path: Path) -> None:
    """A connection may be scaled; both ends of another have no unit."""
    master = pair(mass, 0.05)
    master.add("three", mass)
    master.connect("two.x", "three.force", factor=3.0, offset=0.5)
    before, after = again(master, tmp_path / "scaled.ssp", 1.0)
    pd.testing.assert_frame_equal(before, after, check_exact=True)
    assert before["three.v"].iloc[1] == pytest.approx(0.5 * 0.05, rel=1e-3)


def test_the_file_holds_the_schema(mass: Path, tmp_path: Path) -> None:
    """The published schemas of SSP 1.0, and FMPy's reader."""
    path = pair(mass, 0.05).to_ssp(tmp_path / "pair.ssp", until=3.0, start_time=1.0)
    with zipfile.ZipFile(path) as archive:
        names = archive.namelist()
        documents.require_valid(archive.read("SystemStructure.ssd"), "it", documents.STRUCTURE)
        documents.require_valid(archive.read("resources/one.ssv"), "it", documents.VALUES)
    assert [n for n in names if n.endswith(".fmu")] == ["resources/one.fmu"]  # both are of one file
    read = read_ssd(str(path))
    assert [c.name for c in find_components(read.system)] == ["one", "two"]
    assert len(list(get_connections(read.system))) == 3


def test_references_instead_of_copies(mass: Path, tmp_path: Path) -> None:
    path = pair(mass, 0.05).to_ssp(tmp_path / "pair.ssp", embed=False)
    with zipfile.ZipFile(path) as archive:
        assert not [n for n in archive.namelist() if n.endswith(".fmu")]
        root = ElementTree.fromstring(archive.read("SystemStructure.ssd"))
    assert {c.get("source") for c in root.iter(f"{{{documents.SSD}}}Component")} == {mass.resolve().as_uri()}
    again = CoSimulation.from_ssp(path)
    assert len(again.run(0.1)) == 3
    again.add("span", one_span())  # it has no file of its own
    with zipfile.ZipFile(again.to_ssp(tmp_path / "more.ssp", embed=False)) as archive:
        assert [n for n in archive.namelist() if n.endswith(".fmu")] == ["resources/span.fmu"]


def test_open_inputs_stay_open(tmp_path: Path) -> None:
    """An open input of a system needs a value, before and after."""
    s = rw.System("unit")
    s.add(
        rw.DieselHydraulicUnit(
            "unit", rated_power=2e4, rated_speed=200.0, inertia=1.0, displacement=2e-5, relief_pressure=3e7
        )
    )
    master = CoSimulation(0.1)
    master.add("unit", s)
    with pytest.raises(rw.InputError, match="is open"):
        CoSimulation.from_ssp(master.to_ssp(tmp_path / "unit.ssp")).run(0.1)


def test_bad_files_to_write(mass: Path, tmp_path: Path) -> None:
    master = pair(mass, 0.05)
    with pytest.raises(rw.InputError, match=r"does not end in \.ssp"):
        master.to_ssp(tmp_path / "pair.zip")
    with pytest.raises(rw.InputError, match="There is no folder"):
        master.to_ssp(tmp_path / "none" / "pair.ssp")
    with pytest.raises(rw.InputError, match="There is no slave"):
        CoSimulation(1.0).to_ssp(tmp_path / "empty.ssp")
    assert not list(tmp_path.glob("*.ssp"))
