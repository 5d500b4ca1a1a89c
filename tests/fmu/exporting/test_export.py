"""What is inside an exported FMU, and that importers find nothing wrong with it."""

import subprocess
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import fmpy
import pytest
from fmpy.validation import validate_fmu
from lxml import etree

import ropeway as rw
from ropeway.components.errors import CompilerError
from ropeway.fmu import export
from ropeway.fmu.exporting.binaries import universal
from ropeway.systems.native import compiler
from support.fmus import ROPE, WEAK_UNIT, one_span, open_line, short_line, skyline


@pytest.mark.parametrize("name", ["line2", "line3", "driven", "span3"])
def test_fmpy_finds_no_problem(name: str, request: pytest.FixtureRequest) -> None:
    assert validate_fmu(str(request.getfixturevalue(name))) == []


@pytest.mark.parametrize("name", ["line2", "line3"])
def test_archive_is_complete_and_small(name: str, request: pytest.FixtureRequest) -> None:
    path: Path = request.getfixturevalue(name)
    assert path.stat().st_size < 1e6
    with zipfile.ZipFile(path) as archive:
        names = set(archive.namelist())
        page = archive.read("documentation/index.html").decode()
        picture = archive.read("model.png" if name == "line2" else "documentation/diagram.png")
    assert {"modelDescription.xml", "sources/model_data.c", "sources/buildDescription.xml"} <= names
    assert any(n.startswith("binaries/") for n in names)
    assert "c5.tension_in" in page or "c1.tension_in" in page
    assert picture.startswith(b"\x89PNG")


def test_description_of_a_system(tmp_path: Path) -> None:
    """A picture of ropes only where there are some."""
    unit = rw.System("power unit")
    unit.add(WEAK_UNIT)
    found = {}
    for name, system in (("unit", unit), ("span", one_span())):
        path = export(system, tmp_path / f"{name}.fmu", platforms=())
        with zipfile.ZipFile(path) as archive:
            page = archive.read("documentation/index.html").decode()
            found[name] = fmpy.read_model_description(str(path)).description, "model.png" in archive.namelist()
        assert ("<img" in page) == found[name][1]
        assert "<h2>Parameters</h2>" in page
    assert found["unit"] == ("System of DieselHydraulicUnit unit", False)
    assert found["span"] == ("Cable system of 1 span on 1 rope, 1 load at the start", True)


def test_variables_are_described(line2: Path) -> None:
    variables = {v.name: v for v in fmpy.read_model_description(str(line2)).modelVariables}
    speed, tension = variables["c1.speed"], variables["c1.tension_in"]
    assert (speed.causality, speed.unit, float(speed.start)) == ("input", "m/s", 1.0)
    assert (tension.causality, tension.unit) == ("output", "N")
    assert tension.description == "tension of the incoming rope"
    assert float(tension.nominal) > 1e4
    assert variables["der(c1.travel)"].unit == "m/s"
    assert variables["gravity"].causality == "parameter"
    assert not any("slot_" in name for name in variables)


def test_units_have_their_dimensions(line2: Path) -> None:
    with zipfile.ZipFile(line2) as archive:
        root = ElementTree.fromstring(archive.read("modelDescription.xml"))
    units = {u.get("name"): u.find("BaseUnit") for u in root.iter("Unit")}
    newton = units["N"]
    assert newton is not None
    assert newton.attrib == {"kg": "1", "m": "1", "s": "-2"}
    assert all(base is not None for base in units.values())


def test_terminals(tmp_path: Path) -> None:
    """Rope ends, the drive and its hydraulic port, by the schema of FMI 3.0."""
    path = export(open_line(), tmp_path / "line.fmu", "3.0", platforms=())
    with zipfile.ZipFile(path) as archive:
        data = archive.read("terminalsAndIcons/terminalsAndIcons.xml")
    schema = etree.XMLSchema(file=str(Path(fmpy.__file__).parent / "schema" / "fmi3" / "fmi3TerminalsAndIcons.xsd"))
    schema.assertValid(etree.fromstring(data))
    found = {
        t.get("name"): {m.get("memberName"): m.get("variableName") for m in t}
        for t in ElementTree.fromstring(data).iter("Terminal")
    }
    assert set(found) == {"start_s1.a", "s5_s6.b", "c1.drive", "c1.hydraulic"}
    assert found["s5_s6.b"] == {
        "tension": "s5_s6.tension_b", "vertical": "s5_s6.vertical_b", "horizontal": "s5_s6.horizontal",
        "travel": "s6.travel",
    }  # fmt: skip
    assert {"speed", "drive_force", "travel"} <= found["c1.drive"].keys()
    assert {"pump_flow", "relief_pressure", "hydraulic_power"} <= found["c1.hydraulic"].keys()
    known = {v.name for v in fmpy.read_model_description(str(path)).modelVariables}
    assert all(set(members.values()) <= known for members in found.values())
    for system, count in ((skyline(), 5), (one_span(), 2)):
        path = export(system, tmp_path / "other.fmu", "3.0", platforms=())
        with zipfile.ZipFile(path) as archive:
            assert archive.read("terminalsAndIcons/terminalsAndIcons.xml").count(b"<Terminal ") == count


def test_chosen_variables_only(tmp_path: Path) -> None:
    path = export(
        short_line(),
        tmp_path / "few.fmu",
        inputs=["c1.speed"],
        outputs=["c1.tension_in", "c1.tension_out", "c1.loads_passed"],
        parameters=["start.load_mass[1]"],
        platforms=(),
    )
    shown = {v.name for v in fmpy.read_model_description(str(path)).modelVariables}
    wanted = {"c1.speed", "c1.tension_in", "c1.tension_out", "c1.loads_passed", "start.load_mass[1]"}
    assert {n for n in shown if "travel" not in n} == wanted
    assert validate_fmu(str(path)) == []


@pytest.mark.parametrize(
    ("name", "identifier"), [("Seilbahn Süd", "Seilbahn_S_d"), ("3 Spans", "system_3_Spans"), ("Öd", "system__d")]
)
def test_identifier_is_one_of_c(name: str, identifier: str, tmp_path: Path) -> None:
    system = rw.System(name)
    system.string(ROPE, rw.Anchor("a", at=(0.0, 0.0)), rw.Anchor("b", at=(90.0, 5.0)), length=92.0)
    description = fmpy.read_model_description(str(export(system, tmp_path / "named.fmu", platforms=())))
    assert (description.modelName, description.coSimulation.modelIdentifier) == (name, identifier)


def test_same_system_same_fingerprint(tmp_path: Path) -> None:
    one, two = (export(one_span(), tmp_path / f"{n}.fmu", platforms=()) for n in "ab")
    assert fmpy.read_model_description(str(one)).guid == fmpy.read_model_description(str(two)).guid


@pytest.mark.parametrize(
    ("more", "cause"),
    [
        ({"fmi": "1.0"}, "fmi is '1.0'"),
        ({"platforms": ("amiga",)}, "'amiga' is unknown"),
        ({"platforms": "host"}, "platforms is 'host'. Give a sequence of texts"),
        ({"tolerance": 0.0}, "tolerance"),
        ({"outputs": "a_b.tension_a"}, "outputs is 'a_b.tension_a'. Give a sequence of texts"),
        ({"outputs": ["a.b"]}, "'a.b' is not an output"),
        ({"inputs": ["x"]}, "'x' is not an input"),
        ({"parameters": ["x"]}, "'x' is not a parameter"),
    ],
)
def test_bad_arguments(more: dict[str, object], cause: str, tmp_path: Path) -> None:
    with pytest.raises(rw.InputError, match=cause):
        export(one_span(), tmp_path / "x.fmu", **more)  # type: ignore[arg-type]


def test_invalid_paths(tmp_path: Path) -> None:
    with pytest.raises(rw.InputError, match=r"does not end in \.fmu"):
        export(one_span(), tmp_path / "x.zip")
    with pytest.raises(rw.InputError, match=r"There is no folder .*nowhere"):
        export(one_span(), tmp_path / "nowhere" / "x.fmu")


def test_open_inputs_are_described(tmp_path: Path) -> None:
    path = export(open_line(), tmp_path / "open.fmu", platforms=())
    inputs = [v for v in fmpy.read_model_description(str(path)).modelVariables if v.causality == "input"]
    named = {v.name for v in inputs if "requires a value" in v.description}
    assert named == {"c1.relief_pressure", "c1.pump_flow"} < {v.name for v in inputs}


def test_open_input_must_be_shown(tmp_path: Path) -> None:
    with pytest.raises(rw.InputError, match="is open"):
        export(short_line(speed=None), tmp_path / "x.fmu", inputs=[])


def test_compiler_messages_reach_the_user(tmp_path: Path) -> None:
    (tmp_path / "bad.c").write_text("int f(void) { return wrong; }\n")
    with pytest.raises(CompilerError, match="wrong"):
        compiler.compile_library(tmp_path, ["bad.c"], compiler.host(), tmp_path / "bad.so")


def test_cc_selects_the_compiler(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    own = compiler.command(compiler.host())
    if len(own) == 1:
        monkeypatch.setenv("CC", f"{own[0]} -DNOTHING")
        assert compiler.command(compiler.host()) == [*own, "-DNOTHING"]
    monkeypatch.setenv("CC", str(tmp_path / "none"))
    (tmp_path / "good.c").write_text("int f(void) { return 1; }\n")
    with pytest.raises(CompilerError, match=r"cannot be started.*Correct the environment variable CC"):
        compiler.compile_library(tmp_path, ["good.c"], compiler.host(), tmp_path / "good.so")


def test_core_compiles_without_a_warning(tmp_path: Path) -> None:
    path = export(one_span(), tmp_path / "x.fmu", platforms=())
    with zipfile.ZipFile(path) as archive:
        archive.extractall(tmp_path)
    ours = [f.name for f in (tmp_path / "sources").glob("*.c") if not f.name.startswith("rw_")]
    flags = ["-std=c99", "-Wall", "-Wextra", "-Wno-unused-parameter", "-Werror", "-fsyntax-only", "-I."]
    subprocess.run([*compiler.command(compiler.host()), *flags, *ours], cwd=tmp_path / "sources", check=True)


def test_universal_library_has_both_slices() -> None:
    data = universal({"x86_64": b"one", "aarch64": b"second"})
    assert data[:8] == b"\xca\xfe\xba\xbe\x00\x00\x00\x02"
    assert data[1 << 14 :][:3] == b"one"
    assert data[2 << 14 :][:6] == b"second"
