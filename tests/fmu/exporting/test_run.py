"""The exported line against rw.simulate, and what else an FMU must do while it runs."""

from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.validation import validate_fmu

import ropeway as rw
from ropeway.fmu import Slave, export, load
from support.fmus import HYDRAULIC, RESPONSE, ROPE, Opener, example_line, one_span, short_line, skyline, valley

EVERY = 0.73  # no load crosses at one of its multiples


def deviation(path: Path, system: rw.System, until: float, kind: str, least: int = 40) -> tuple[str, float]:
    """The output that differs most from rw.simulate, relative to its largest value, away from events."""
    result = rw.simulate(system, until, every=EVERY)
    run = fmpy.simulate_fmu(
        str(path),
        fmi_type=kind,
        stop_time=until,
        output_interval=EVERY,
        step_size=EVERY,
        relative_tolerance=1e-8,
        record_events=False,
    )
    frame, events = result.frame, result.events["time"].to_numpy()
    names = [c for c in frame.columns if c in run.dtype.names]
    assert len(names) >= least
    times = [t for t in frame.index if np.abs(events - t).min(initial=1.0) > 1e-4 and t < until]
    at = [int(np.argmin(np.abs(run["time"] - t))) for t in times]
    assert np.abs(run["time"][at] - times).max() < 1e-9
    wanted = frame.loc[times, names].to_numpy()
    got = np.column_stack([run[n][at] for n in names])
    error = np.abs(got - wanted).max(axis=0) / np.maximum(1.0, np.abs(frame[names].to_numpy()).max(axis=0))
    return names[int(error.argmax())], float(error.max())


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        pytest.param("line2", "CoSimulation", marks=pytest.mark.slow),
        ("line2", "ModelExchange"),
        ("line3", "CoSimulation"),
        pytest.param("line3", "ModelExchange", marks=pytest.mark.slow),
    ],
)
def test_ten_minutes_with_hundreds_of_crossings(name: str, kind: str, request: pytest.FixtureRequest) -> None:
    where, error = deviation(request.getfixturevalue(name), example_line(), 600.0, kind)
    assert error < 1e-7, where


@pytest.mark.parametrize("kind", ["CoSimulation", "ModelExchange"])
def test_hydraulic_drives_and_responses(driven: Path, kind: str) -> None:
    where, error = deviation(driven, short_line(drive=HYDRAULIC, response=RESPONSE), 120.0, kind)
    assert error < 1e-4, where


def test_event_times_in_model_exchange(line2: Path) -> None:
    result = rw.simulate(example_line(), 60.0)
    run = fmpy.simulate_fmu(str(line2), fmi_type="ModelExchange", stop_time=60.0, relative_tolerance=1e-8)
    found = np.unique(run["time"][np.flatnonzero(np.diff(run["time"]) == 0.0)])
    events = result.events["time"].to_numpy()
    assert len(events) > 20
    assert max(np.abs(found - t).min() for t in events) < 1e-6


@pytest.mark.parametrize("kind", ["CoSimulation", "ModelExchange"])
def test_a_skyline_hauls_its_carriage(tmp_path: Path, kind: str) -> None:
    path = export(skyline(), tmp_path / "skyline.fmu", "3.0")
    assert validate_fmu(str(path)) == []
    run = fmpy.simulate_fmu(
        str(path), fmi_type=kind, stop_time=20.0, start_values={"mainline.speed": -1.0}, relative_tolerance=1e-8
    )
    last = rw.simulate(skyline(), 20.0, every=20.0, inputs={"mainline.speed": -1.0}).frame.iloc[-1]
    names = ["carriage.x", "carriage.z", "head.tension", "tail.tension", "mainline.rope_tension"]
    assert [run[n][-1] for n in names] == pytest.approx([last[n] for n in names], rel=1e-9)


@pytest.mark.parametrize(("speed", "at", "friction"), [(1.0, 80.0, 0.0), (-1.0, 125.0, 0.03)])
def test_a_load_held_at_a_hold_down(tmp_path: Path, speed: float, at: float, friction: float) -> None:
    line = valley(speed, at, friction)
    result = rw.simulate(line, 40.0, every=EVERY)
    assert result.events["event"].str.contains("held").any()
    path = export(line, tmp_path / "valley.fmu")
    for kind in ("CoSimulation", "ModelExchange"):
        where, error = deviation(path, line, 40.0, kind, least=10)
        assert error < 1e-5, (kind, where)


def test_a_load_beyond_a_sheave_as_the_rope_reverses(tmp_path: Path, open_fmu: Opener) -> None:
    """Friction turns with the rope, and takes 7 mm of it over the sheave at once: more than the load is away."""
    s = rw.System("turning")
    drums = rw.Drum("d", at=(0.0, 0.0), speed=1.0), rw.Drum("e", at=(200.0, 0.0), tension=50e3)
    spans = s.string(ROPE, drums[0], rw.Sheave("m", at=(100.0, 15.0), friction=0.05), drums[1], tension=50e3)
    s.hang(rw.Load("l", mass=400.0), spans, at=spans[0].length + 5e-4)
    path = export(s, tmp_path / "turning.fmu")
    one = open_fmu(path)
    one.initialize()
    one.set(d__speed=-1.0)
    one.step(0.0, 1e-3)
    with Slave(load(path), kind="ModelExchange") as other:
        other.enter(0.0, {})
        other.leave()
        other.step(1e-3, {"d.speed": -1.0}, {"d.speed": -1.0})
        names = ["m.travel", "m.tension_in"]
        assert one.get(*names) == pytest.approx(other.get(names), rel=1e-8)
        assert other.get(["m.loads_passed"])[0] == 1
    assert one.fmu.getInteger([one.references["m.loads_passed"]]) == [1]


@pytest.mark.parametrize(("speed", "at"), [(1.0, 100.0), (-1.0, 140.0)])
def test_a_load_held_between_driven_sheaves(tmp_path: Path, open_fmu: Opener, speed: float, at: float) -> None:
    """The rope there has its length: forces rise at 500 kN a second, and the load is released after 40 us."""
    drums = rw.Drum("d0", at=(0.0, 0.0), speed=speed), rw.Drum("d1", at=(250.0, 4.0), tension=60e3)
    driven = [rw.ControlSheave(n, at=p, speed=speed) for n, p in (("c1", (60.0, 0.0)), ("c2", (170.0, 12.0)))]
    line = rw.System("driven valley")
    nodes = drums[0], driven[0], rw.Sheave("h", at=(120.0, 4.0), hold_down=True), driven[1], drums[1]
    line.hang(rw.Load("l1", mass=260.0), line.string(ROPE, *nodes, tension=60e3), at=at)
    events = rw.simulate(line, 40.0).events
    wanted = events["time"][events["event"].str.startswith("load")].to_list()
    assert len(wanted) == 2
    path = export(line, tmp_path / "driven_valley.fmu")
    for size in (0.1, 1.0, 40.0):
        one = open_fmu(path)
        one.fmu.setDebugLogging(True, ["logEvents"])
        one.initialize()
        one.run(0.0, 40.0, size, ["h.tension_in"])
        told = [float(text.split("t = ")[1].split(" s")[0]) for text in one.log if "load" in text]
        assert told == pytest.approx(wanted, abs=1e-6), size


def test_a_schedule_in_the_fmu(tmp_path: Path) -> None:
    ramp = rw.Schedule((0.0, 10.0, 20.0, 40.0), (0.0, 1.0, 0.6, 1.2))
    line = short_line(speed=ramp)
    path = export(line, tmp_path / "ramp.fmu")
    assert not [v for v in fmpy.read_model_description(str(path)).modelVariables if v.causality == "input"]
    for kind in ("CoSimulation", "ModelExchange"):
        where, error = deviation(path, line, 39.0, kind)
        assert error < 1e-7, (kind, where)


def test_inputs_are_held(line2: Path, open_fmu: Opener) -> None:
    one = open_fmu(line2)
    one.initialize()
    one.run(0.0, 10.0, 0.5, ["c1.tension_in"])
    one.set(c1__speed=1.02)
    one.run(10.0, 20.0, 0.5, ["c1.tension_in"])
    step = rw.Schedule((0.0, 10.0, 10.0 + 1e-6, 30.0), (1.0, 1.0, 1.02, 1.02))
    result = rw.simulate(example_line(), 20.0, inputs={"c1.speed": step})
    names = ["c1.tension_in", "c1.tension_out", "c1.travel"]
    assert one.get(*names) == pytest.approx(result.frame.iloc[-1][names].to_list(), rel=1e-6)


def test_other_parameters_are_solved_again(span3: Path, open_fmu: Opener) -> None:
    one = open_fmu(span3)
    one.set(turn__mass=9000.0, a_b__length_start=407.0)
    one.initialize()
    rest = rw.equilibrium(one_span(), parameters={"turn.mass": 9000.0, "a_b.length_start": 407.0})
    names = ["a_b.tension_a", "a_b.tension_b", "a_b.vertical_a"]
    assert one.get(*names) == pytest.approx([rest[n] for n in names], rel=1e-9)


@pytest.mark.parametrize("early", [True, False])
def test_event_mode_in_co_simulation(line3: Path, early: bool) -> None:
    """With early return a step ends at each crossing, which the importer handles in event mode."""
    modes = {"use_event_mode": True, "early_return_allowed": early}
    run = fmpy.simulate_fmu(
        str(line3), fmi_type="CoSimulation", stop_time=60.0, output_interval=5.0, record_events=True, **modes
    )
    result = rw.simulate(example_line(), 60.0, every=5.0)
    crossings = np.unique(result.events["time"].round(6))
    stops = np.setdiff1d(np.unique(run["time"].round(6)), np.arange(0.0, 61.0, 5.0))
    assert len(stops) == (len(crossings) if early else 0)
    assert not early or stops == pytest.approx(crossings, abs=2e-6)
    last = result.frame.iloc[-1]
    assert run["c2.tension_in"][-1] == pytest.approx(last["c2.tension_in"], rel=1e-9)
    assert run["c1.loads_passed"][-1] == run["c1.loads_passed"][0] + 1


@pytest.mark.parametrize("kind", ["CoSimulation", "ModelExchange"])
def test_parameters_change_in_mid_run(span3: Path, kind: str) -> None:
    """All parameters but lengths are tunable: here a load grows and gravity falls."""
    fmu = load(span3)
    assert fmu.entry("turn.mass").variability == "tunable"
    assert fmu.entry("a_b.length_start").variability == "fixed"
    with Slave(fmu, kind=kind) as one:
        one.enter(0.0, {})
        one.leave()
        one.step(1.0, {}, {})
        one.set({"turn.mass": 9000.0, "gravity": 9.7})
        one.step(1.0, {}, {})
        rest = rw.equilibrium(one_span(), parameters={"turn.mass": 9000.0, "gravity": 9.7})
        assert one.get(["a_b.tension_a"]) == pytest.approx([rest["a_b.tension_a"]], rel=1e-9)


def test_limits_are_outputs(span3: Path, open_fmu: Opener) -> None:
    one = open_fmu(span3)
    flags = [one.references[f"a_b.tension_above_{limit}"] for limit in ("SWL", "MBL")]
    one.set(turn__mass=60e3)
    one.initialize()
    assert list(one.fmu.getBoolean(flags)) == [True, True]
    assert any("above_MBL" in text for text in one.log)


def breaking(line: Path, open_fmu: Opener, until: float) -> tuple[float, np.ndarray]:
    """A breaking load of the span s4_c1 that its tension exceeds at some time before `until` [s], and its tension
    by then every 0.5 s."""
    one = open_fmu(line)
    one.initialize()
    share = one.run(0.0, until, 0.5, ["s4_c1.utilisation"])[:, 0]
    load = float(start_of(one.description, "s4_c1.breaking_load"))
    return load * (0.3 * share.min() + 0.7 * share.max()), load * share


def start_of(description: Any, name: str) -> str:
    return next(str(v.start) for v in description.modelVariables if v.name == name)


@pytest.mark.parametrize("name", ["line2", "line3"])
def test_a_rope_breaks_in_mid_run(name: str, open_fmu: Opener, request: pytest.FixtureRequest) -> None:
    line = request.getfixturevalue(name)
    limit, tension = breaking(line, open_fmu, 30.0)
    above = tension > limit
    assert above.any()
    assert not above[0]
    one = open_fmu(line)
    one.set(s4_c1__breaking_load=limit)
    one.initialize()
    flag, found = [one.references["s4_c1.tension_above_MBL"]], []
    for i in range(len(tension)):
        one.step(0.5 * i, 0.5)
        found.append(bool(one.fmu.getBoolean(flag)[0]))
    assert found == above.tolist()
    told = next(text for text in one.log if "s4_c1.tension_above_MBL" in text)
    first = 0.5 * int(np.argmax(above))
    assert first <= float(told.split("t = ")[1].split(" s")[0]) <= first + 0.5


@pytest.mark.parametrize("size", [1.0, 10.0, 120.0, 240.0])
def test_a_rope_that_breaks_within_a_long_step_is_reported(size: float, tmp_path: Path, open_fmu: Opener) -> None:
    """The load is heaviest on its rope in mid-span; the tension is below the limit again when it crosses, at 140 s."""
    line = rw.System("long spans")
    ends = rw.Drum("d0", at=(0.0, 0.0), speed=2.0), rw.Drum("d1", at=(650.0, 0.0), tension=60e3)
    middle = rw.Sheave("s1", at=(300.0, 5.0)), rw.ControlSheave("c1", at=(600.0, 0.0), speed=2.0)
    line.hang(rw.Load("l1", mass=900.0), line.string(ROPE, ends[0], *middle, ends[1], tension=60e3), at=20.0)
    tension = rw.simulate(line, 240.0).frame["d0_s1.utilisation"] * ROPE.breaking_load
    limit = 0.1 * tension.min() + 0.9 * tension.max()
    above = (tension > limit).to_numpy()
    rises = list(tension.index[1:][above[1:] & ~above[:-1]])
    assert len(rises) == 2
    one = open_fmu(export(line, tmp_path / "long.fmu"))
    one.set(d0_s1__breaking_load=limit)
    one.initialize()
    one.run(0.0, 240.0, size, ["d0_s1.utilisation"])
    told = [float(text.split("t = ")[1].split(" s")[0]) for text in one.log if "d0_s1.tension_above_MBL" in text]
    assert told == pytest.approx(rises, abs=2.0)


def test_a_breaking_rope_is_an_event(line2: Path, open_fmu: Opener) -> None:
    limit, _ = breaking(line2, open_fmu, 30.0)
    name = "s4_c1.utilisation"
    run = fmpy.simulate_fmu(
        str(line2),
        fmi_type="ModelExchange",
        stop_time=30.0,
        relative_tolerance=1e-8,
        start_values={"s4_c1.breaking_load": limit},
        output=[name],
    )
    broken = run[name] > 1.0 - 1e-12  # at the event it is one to rounding, from either side
    rises = np.flatnonzero(~broken[:-1] & broken[1:])
    assert len(rises)
    assert run[name][rises[0] + 1] == pytest.approx(1.0, abs=1e-7)
    assert run["time"][rises[0] + 1] in run["time"][np.flatnonzero(np.diff(run["time"]) == 0.0)]


def test_counts_of_loads(line2: Path, open_fmu: Opener) -> None:
    one = open_fmu(line2)
    one.initialize()
    first = one.fmu.getInteger([one.references["c1.loads_passed"]])[0]
    one.run(0.0, 100.0, 1.0, ["c1.tension_in"])
    assert one.fmu.getInteger([one.references["c1.loads_passed"]])[0] == first + 2


@pytest.mark.slow
def test_a_hundred_spans_with_two_hundred_loads(tmp_path: Path) -> None:
    nodes: list[Any] = [rw.Drum("d0", at=(0.0, 0.0, 0.0), speed=1.0)]
    for i in range(1, 100):
        at = (100.0 * i, 3.0 * np.sin(i), 30.0 * np.sin(i / 8.0) + (4.0 if i % 2 else 0.0))
        nodes.append(rw.Sheave(f"s{i}", at=at) if i % 5 else rw.ControlSheave(f"c{i}", at=at, speed=1.0))
    nodes.append(rw.Drum("d100", at=(10e3, 0.0, 0.0), tension=45e3))
    line = rw.System("hundred spans")
    line.feed(line.string(ROPE, *nodes, tension=45e3), spacing=50.0, masses=300.0)
    path = export(line, tmp_path / "hundred.fmu")
    where, error = deviation(path, line, 60.0, "CoSimulation")
    assert error < 1e-7, where


class _Constant:
    """Inputs that keep their values, for FMPy's CVODE."""

    def apply(self, time: float) -> None:
        """Nothing changes."""


@pytest.mark.parametrize("name", ["line3", "driven"])
@pytest.mark.parametrize("tolerance", [1e-3, 1e-8])
def test_a_strict_importer(
    name: str, tolerance: float, open_fmu: Opener, request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch
) -> None:
    """CVODE without a limit on its steps: it tries states far beyond a crossing, and no call may fail there.

    It restarts after an event only if the FMU reports changed states, as some importers do.
    """
    from fmpy.sundials import CVodeSolver

    one = open_fmu(request.getfixturevalue(name), kind="ModelExchange")
    one.initialize()
    fmu, failures, until, calls = one.fmu, [], 60.0, [0]
    update = fmu.updateDiscreteStates if one.three else fmu.newDiscreteStates
    nx, nz = one.description.numberOfContinuousStates, one.description.numberOfEventIndicators
    rates = fmu.getContinuousStateDerivatives if one.three else fmu.getDerivatives

    def watched(call: Any) -> Any:
        def of(*arguments: Any) -> None:
            calls[0] += 1
            try:
                call(*arguments)
            except FMICallException as error:  # in a callback of C it would be lost
                failures.append(error)

        return of

    time, (_, _, _, _, defined, coming) = 0.0, update()
    fmu.enterContinuousTimeMode()
    get_z = watched(fmu.getEventIndicators)
    states = fmu.getContinuousStates, watched(fmu.setContinuousStates), watched(rates), get_z
    nominals = fmu.getNominalsOfContinuousStates
    solver = CVodeSolver(nx, nz, *states, nominals, watched(fmu.setTime), _Constant(), time, np.inf, tolerance)
    events = 0
    while time < until:
        stop = min(until, coming if defined else until)
        found, _, time = solver.step(time, stop)
        fmu.setTime(time)
        fmu.completedIntegratorStep()
        if found or time >= (coming if defined else until):
            fmu.enterEventMode()
            _, _, _, changed, defined, coming = update()
            fmu.enterContinuousTimeMode()
            if changed:
                solver.reset(time)
            events += 1
    assert failures == []
    assert events > 20
    assert calls[0] < 40000
    line = example_line() if name == "line3" else short_line(drive=HYDRAULIC, response=RESPONSE)
    last = rw.simulate(line, until, every=until).frame.iloc[-1]
    tension = [n for n in last.index if n.endswith((".tension_in", ".travel"))]
    assert one.get(*tension) == pytest.approx(last[tension].to_numpy(), rel=30.0 * tolerance)


@pytest.mark.parametrize("name", ["line2", "driven"])
def test_states_far_beyond_a_crossing(name: str, open_fmu: Opener, request: pytest.FixtureRequest) -> None:
    """Rates are finite, indicators of crossings change their signs, and an accepted point is as before."""
    one = open_fmu(request.getfixturevalue(name), kind="ModelExchange")
    one.initialize()
    one.fmu.newDiscreteStates()
    one.fmu.enterContinuousTimeMode()
    nx, nz = one.description.numberOfContinuousStates, one.description.numberOfEventIndicators
    x, rate, signs = np.zeros(nx), np.zeros(nx), np.zeros(nz)

    def vector(call: Any, values: np.ndarray) -> np.ndarray:
        call(np.ctypeslib.as_ctypes(values), len(values))
        return values.copy()

    start = vector(one.fmu.getContinuousStates, x)
    slope, before = vector(one.fmu.getDerivatives, rate), vector(one.fmu.getEventIndicators, signs)
    tension = one.get("c1.tension_in")
    assert np.all(before > 0.0)
    for ahead in (1.0, 100.0, 1e4, 0.0):
        one.fmu.setTime(ahead)
        vector(one.fmu.setContinuousStates, start + ahead * slope)
        assert np.all(np.isfinite(vector(one.fmu.getDerivatives, rate)))
        crossed = vector(one.fmu.getEventIndicators, signs) < 0.0
        assert np.any(crossed) == (ahead > 20.0)
    assert one.get("c1.tension_in") == pytest.approx(tension, rel=1e-12)
    assert one.log == []
