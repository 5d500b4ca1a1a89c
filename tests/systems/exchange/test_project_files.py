"""Project files: saved, loaded and saved again they are the same bytes; errors name file, line and field."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ropeway as rw
from ropeway.systems.exchange import project_file
from ropeway.systems.exchange.project_text import line_of
from support import call_objects as objects, maps

EXAMPLES = Path(__file__).resolve().parents[3] / "examples"


def heavy_rig() -> rw.SkylineRig:
    """A live skyline with a guyed spar, a haulback block, a tailhold and a log, of ropes that have equal names."""
    return rw.live_skyline(
        objects.GROUND,
        headspar=objects.guyed(),
        tailspar=rw.TailSpar(
            "tail", station=240.0, height=9.0, tailhold=rw.Tailhold("stump", station=258.0, height=0.0)
        ),
        supports=[rw.IntermediateSupport("jack", station=125.0, height=8.0, radius=3.0, capacity=2e5)],
        skyline=objects.ROPE,
        length=262.0,
        mainline=objects.THIN,
        haulback=objects.THIN,
        haulback_tension=4e3,
        haulback_block=rw.Block("back", station=238.0, height=2.0, friction=0.01),
        carriage=objects.CARRIAGE,
        turn=rw.Turn(objects.log(), dropline=objects.THIN, length=6.0),
        name="slope above the Bärenbach",
    )


def yard() -> rw.System:
    """Two systems in one: names have dots."""
    outer = rw.System("yard")
    outer.add(objects.line_of_two(), name="p")
    outer.add(objects.one_span(), name="q")
    return outer


def powered() -> rw.System:
    line = rw.monocable(
        rw.Rope(2.4, float("inf"), 450e3, stretch=rw.ConstructionStretch()),
        objects.supports(),
        tension=22e3,
        speed=rw.Schedule([0.0, 9.0], [0.5, 1.0]),
        load_mass=[90.0, 0.0],
        load_spacing=33.0,
        drive=objects.drive(),
        response=rw.ThresholdResponse(low=1e4, high=3e4, increment=0.01),
        precedence="worst first",
    )
    unit = line.add(rw.HydraulicPowerUnit("unit", pump_flow=2e-3, engine_power=3e4))
    sheave = line.components["c"]
    assert isinstance(sheave, rw.ControlSheave)
    line.connect(sheave.supply, unit.outlet)
    return line


def running() -> rw.SkylineRig:
    return rw.running_skyline(
        objects.GROUND, headspar=objects.HEAD, tailspar=objects.TAIL, haulback=objects.ROPE, mainline=objects.THIN,
        carriage=objects.CARRIAGE, tension=60e3,
    )  # fmt: skip


def ring() -> rw.System:
    return rw.endless(objects.ROPE, objects.endless_supports(), tension=22e3, load_mass=90.0, load_spacing=40.0)


THINGS: dict[str, Callable[[], Any]] = {
    "rig on a map": maps.rig, "line on a map": maps.line,
    "standing": objects.rig, "shoe": objects.shod_rig, "new rope": objects.new_rig, "heavy": heavy_rig,
    "running": running, "one span": objects.one_span, "powered": powered, "yard": yard, "ring": ring,
    "schedule": lambda: rw.Schedule([0, 4], [0.1, 1 / 3]), "rope": lambda: objects.ROPE,
    "inputs": lambda: rw.StudyInputs(
        "payload", objects.rig(), {"stations": np.array([70.0, 150.0]), "clearance": None, "lift_off": True}
    ),
    "planning": lambda: rw.StudyInputs(
        "optimise_schedule", objects.line_of_two(), {"until": 6.0, "limits": rw.ScheduleLimits(force={"c": 9e4})}
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", THINGS)
def test_saved_loaded_and_saved_again_is_the_same(name: str, tmp_path: Path) -> None:
    first, again = tmp_path / "a.json", tmp_path / "b.json"
    assert rw.save(THINGS[name](), first) == first
    loaded = rw.load(first)
    rw.save(loaded, again)
    assert first.read_bytes() == again.read_bytes()
    assert type(loaded) is type(THINGS[name]())


def test_a_loaded_rig_gives_the_same_payloads_to_the_bit(tmp_path: Path) -> None:
    for make in (objects.rig, objects.live_rig, running):
        rig = make()
        loaded = rw.load(rw.save(rig, tmp_path / "rig.json"))
        one, other = (rw.payload(r, stations=[70.0, 150.0], clearance=0.5) for r in (rig, loaded))
        assert one.frame.equals(other.frame)
        assert one.frame["payload"].max() > 100.0


def test_a_loaded_line_runs_as_the_saved_one(tmp_path: Path) -> None:
    for system in (objects.line(), yard()):
        loaded = rw.load(rw.save(system, tmp_path / "line.json"))
        assert np.array_equal(rw.equilibrium(system).outputs, rw.equilibrium(loaded).outputs)
    line = objects.line()
    loaded = rw.load(rw.save(line, tmp_path / "line.json"))
    assert rw.simulate(loaded, 2.0).frame.equals(rw.simulate(line, 2.0).frame)


def test_a_study_is_run_from_its_file(tmp_path: Path) -> None:
    inputs = rw.load(rw.save(THINGS["inputs"](), tmp_path / "study.json"))
    assert "payload of 'rig'" in repr(inputs)
    assert rw.run_study(inputs).frame.equals(rw.payload(objects.rig(), stations=[70.0, 150.0]).frame)
    with pytest.raises(rw.UnknownNameError, match="Studies are equilibrium, inhaul"):
        rw.run_study(rw.StudyInputs("payloads", objects.rig()))


@dataclass(frozen=True)
class Winch(rw.Anchor):
    """A component of a user."""

    pull: float = 3.0
    rope_of: rw.Rope | None = None


def test_components_of_ones_own_are_supplied_and_never_imported(tmp_path: Path) -> None:
    s = rw.System("own")
    s.string(objects.ROPE, Winch("w", at=(0, 0), rope_of=objects.THIN), rw.Anchor("b", at=(60.0, 3.0)), length=62.0)
    path = rw.save(s, tmp_path / "own.json")
    assert f'"{__name__}:Winch"' in path.read_text()
    loaded = rw.load(path, components=[Winch])
    assert loaded.components["w"] == s.components["w"]
    with pytest.raises(rw.InputError, match=r"own.json, line \d+, components.0.type: Winch .*components=\[Winch\]"):
        rw.load(path)
    path.write_text(path.read_text().replace(f"{__name__}:Winch", "antigravity:Winch2"))
    with pytest.raises(rw.InputError, match="components=\\[Winch2\\]"):
        rw.load(path, components=[Winch])
    assert "antigravity" not in sys.modules


EDITS = [
    ('"mass_per_length": 2.4', '"mass_per_length": -2.4', "ropes.rope.mass_per_length: Rope 'rope': mass_per_length"),
    ('"height": 14.0', '"heigth": 14.0', r"headspar.heigth: there is no such field. Is height meant\?"),
    ('"height": 14.0', '"height": "tall"', "headspar.height: HeadSpar 'head': height is 'tall'. Give"),
    ('"station": 125.0', '"station": 900.0', "Station 900 m is outside the profile"),
    ('"type": "TailSpar"', '"type": "TailSpur"', r"tailspar.type: there is no type 'TailSpur'. Is TailSpar meant\?"),
    ('"skyline": "rope"', '"skyline": "wire"', "skyline: there is no rope 'wire'"),
    ('"tension": 60000.0', '"tension": 6e9', "tension: rig: tension"),
    ('"tension": 60000.0,', '"tension": 60000.0', "Expecting ',' delimiter"),
    ('"tension": 60000.0', '"tension": NaN', 'NaN is no number of JSON. Write it in quotes, as "nan"'),
    ('"tension": 60000.0', '"tension": 6e4, "tension": 6e4', "'tension' is given twice"),
    ('"ropeway": 1', '"ropeway": 2', "ropeway: the file is of version 2, this ropeway reads versions up to 1"),
    ('"ropeway": 1', '"rope": 1', "this is no project file"),
    ("standing skyline", "sitting skyline", "kind: 'sitting skyline' is no kind of thing. Kinds are system"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "message"), EDITS)
def test_an_error_names_file_line_and_field(old: str, new: str, message: str, tmp_path: Path) -> None:
    path = rw.save(objects.rig(), tmp_path / "line.json")
    text = path.read_text()
    assert old in text
    path.write_text("// a comment\n" + text.replace(old, new, 1))
    line = next(i for i, t in enumerate(path.read_text().splitlines(), 1) if new.split("\n")[0] in t)
    with pytest.raises(rw.InputError, match=message) as refused:
        rw.load(path)
    assert str(path) in str(refused.value)
    if "twice" not in message and "NaN" not in message and '"rope": 1' not in new:
        where = int(str(refused.value).split(", line ")[1].split(",")[0].split(":")[0])
        assert where in (line, line + 1) if "delimiter" in message else where <= line
        if "outside" not in message and "delimiter" not in message:
            assert where == line


def test_a_line_written_by_hand(tmp_path: Path) -> None:
    (tmp_path / "line.csv").write_text(objects.supports().to_csv(index=False))
    text = """// Lines that begin with two slashes are comments.
{"ropeway": 1, "kind": "monocable", "rope": "6x19 EEIP 25", "tension": 22e3, "supports": "line.csv"}"""
    (tmp_path / "line.json").write_text(text)
    line = rw.load(tmp_path / "line.json")
    assert list(line.components)[:3] == ["a", "c", "b"]
    rows = [objects.supports().columns.tolist(), *objects.supports().to_numpy().tolist()]
    (tmp_path / "line.json").write_text(text.replace('"line.csv"', json.dumps(rows)))
    assert rw.load(tmp_path / "line.json").components.keys() == line.components.keys()
    rows[2].pop()
    (tmp_path / "line.json").write_text(text.replace('"line.csv"', json.dumps(rows)))
    with pytest.raises(rw.InputError, match=r"line 2, supports.2: a row needs 5 values"):
        rw.load(tmp_path / "line.json")


def test_older_versions_are_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = rw.save(objects.rig(), tmp_path / "old.json")
    monkeypatch.setattr(project_file, "VERSION", 3)
    monkeypatch.setattr(project_file, "MIGRATIONS", {1: lambda d: {**d, "name": d["name"] + "!"}, 2: lambda d: d})
    assert rw.load(path).name == "rig!"
    assert '"ropeway": 3' in rw.save(rw.load(path), path).read_text()


def test_what_cannot_be_saved_is_refused(tmp_path: Path) -> None:
    from dataclasses import replace

    for value, message in (
        (object(), "object cannot be saved"),
        (3.0, "float cannot be saved"),
        ({"a": 1.0}, "dict cannot be saved"),
        (rw.StudyInputs("payload", objects.rig(), {"stations": {1.0}}), "a set cannot be saved"),
        (replace(objects.rig(), length=300.0), "its length does not follow"),
    ):
        with pytest.raises(rw.InputError, match=message):
            rw.save(value, tmp_path / "x.json")
    with pytest.raises(rw.WriteError):
        rw.save(objects.rig(), tmp_path / "no" / "folder.json")
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(rw.InputError, match="There is no file"):
        rw.load(tmp_path / "none.json")


def test_a_damaged_file_is_an_error_of_its_own(tmp_path: Path) -> None:
    """Values anywhere in a file replaced by others: a typed error, or another valid file."""
    rng = np.random.default_rng(7)
    path = tmp_path / "x.json"
    for make in (heavy_rig, powered, THINGS["planning"]):
        data = json.loads(rw.save(make(), path).read_text())
        for _ in range(60):
            spoilt = json.loads(json.dumps(data))
            at, key = spoilt, str(rng.choice(list(spoilt)))
            while isinstance(at[key], (dict, list)) and at[key] and rng.random() < 0.8:
                at = at[key]
                key = str(rng.choice(list(at))) if isinstance(at, dict) else int(rng.integers(len(at)))
            at[key] = [None, -1.0, "x", [], {}, [1, 2], {"a": 1}, True, 1e300][int(rng.integers(9))]
            path.write_text(json.dumps(spoilt))
            try:
                rw.load(path)
            except rw.RopewayError:
                continue


def test_line_of_finds_values() -> None:
    text = '{"a": [1,\n {"b": "x{}[],"},\n [2,\n 3]], "c": {}, \n"d": {"e": "\\""}}'
    keys = {("a",): 1, ("a", 1, "b"): 2, ("a", 2, 0): 3, ("a", 2, 1): 4, ("c",): 4, ("d", "e"): 5, ("d", "f"): 5}
    assert {k: line_of(text, k) for k in keys} == keys


def test_results_and_studies_are_saved_and_reopened(tmp_path: Path) -> None:
    result = rw.load(rw.save(objects.run(), tmp_path / "run.zip"))
    assert result.frame.equals(objects.run().frame)
    assert result.events.equals(objects.run().events)
    assert result.at(1.3)["c.tension_in"] == objects.run().at(1.3)["c.tension_in"]
    on = rw.simulate(result.model.system, 1.0, start=result.at(2.0))
    assert on.frame.equals(rw.simulate(objects.line(), 1.0, start=objects.run().at(2.0)).frame)
    study = rw.payload(objects.rig(), stations=[70.0, 150.0])
    again = rw.load(rw.save(study, tmp_path / "study.zip"))
    assert repr(again) == repr(study)
    assert again.frame.equals(study.frame)
    assert again.frame.attrs["units"] == study.frame.attrs["units"]
    rest = rw.load(rw.save(objects.rest(), tmp_path / "rest.json"))
    assert np.array_equal(rest.outputs, objects.rest().outputs)
    for value, name in ((result, "run"), (again, "study"), (rest, "rest")):
        first = next(tmp_path.glob(f"{name}.*")).read_bytes()
        assert rw.save(value, tmp_path / "again").read_bytes() == first
    (tmp_path / "bad.zip").write_bytes((tmp_path / "run.zip").read_bytes()[:900])
    with pytest.raises(rw.InputError, match=r"bad.zip is damaged"):
        rw.load(tmp_path / "bad.zip")


def test_a_run_with_inertia_is_saved_and_reopened(tmp_path: Path) -> None:
    stop = [rw.Intervention(0.5, "emergency stop", deceleration=4.0)]
    run = rw.simulate(objects.line(), 1.5, every=0.25, inertia=rw.Inertia(damping=1e-3), interventions=stop)
    result = rw.load(rw.save(run, tmp_path / "run.zip"))
    assert result.model.inertia == run.model.inertia
    assert result.frame.equals(run.frame)
    assert result.dynamic_factor().equals(run.dynamic_factor())
    assert rw.save(result, tmp_path / "again.zip").read_bytes() == (tmp_path / "run.zip").read_bytes()
