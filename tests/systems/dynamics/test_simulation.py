"""A line over time: crossings, balances, both directions, failures."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import ropeway as rw
from support.fmus import valley

ROPE = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)
EXAMPLES = Path(__file__).resolve().parents[3] / "examples"


def zigzag(speed=1.0, count=9, every=4, **more):
    """Supports of a small line: drums at the ends, a control sheave at every `every`-th support."""
    rng = np.random.default_rng(7)
    x = 80.0 * np.arange(count)
    z = 0.05 * x + np.where(np.arange(count) % 2, 2.0, -1.0) + rng.uniform(-0.5, 0.5, count)
    kind = ["drum" if i in (0, count - 1) else "control" if i % every == 0 else "idler" for i in range(count)]
    table = pd.DataFrame({"name": [f"n{i}" for i in range(count)], "x": x, "y": rng.uniform(-4, 4, count), "z": z})
    settings = {"tension": 45e3, "load_mass": (300.0, 150.0, 420.0), "load_spacing": 37.0, **more}
    return rw.monocable(ROPE, table.assign(kind=kind), speed=speed, **settings)


def on_line(record) -> int:
    return int(record.passed[0][0] - record.passed[0][-1])


def test_script_of_the_design_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(EXAMPLES.parent)
    line = rw.monocable(ROPE, supports="examples/line.csv", tension=45e3, speed=1.0, load_mass=300.0, load_spacing=50.0)
    result = rw.simulate(line, until=60.0, every=1.0)
    frame = result.frame
    assert frame.index.name == "time"
    assert frame.index.to_numpy() == pytest.approx(np.arange(61.0))
    assert frame.attrs["units"]["c1.tension_in"] == "N"
    assert set(frame.attrs["units"]) == set(frame.columns)
    assert list(result.events.columns)[:4] == ["time", "component", "event", "value"]
    assert (result.events["event"] == "crossing forward").sum() > 20
    assert result.plot().axes
    assert result.plot_line(time=30.0).axes
    assert np.isfinite(frame.to_numpy()).all()


def test_the_figure_of_a_rope_without_sheaves_has_no_empty_panel() -> None:
    s = rw.System("one span")
    s.string(ROPE, rw.Drum("a", at=(0, 0), speed=0.01), rw.Anchor("b", at=(100, 5)), length=101.0)
    assert len(rw.simulate(s, until=1.0).plot().axes) == 1


def test_travel_of_drives_is_exact_and_of_a_schedule_its_integral() -> None:
    schedule = rw.Schedule([0.0, 10.0, 25.0, 60.0], [0.0, 1.2, 0.4, 0.9])
    result = rw.simulate(zigzag(schedule), until=60.0)
    for t in (7.0, 10.0, 31.0, 60.0):
        times = np.union1d(np.linspace(0.0, t, 200_001), [10.0, 25.0])
        times = times[times <= t]
        exact = np.trapezoid(np.interp(times, schedule.times, schedule.speeds), times)
        assert result.frame.loc[t, "n4.travel"] == pytest.approx(exact, abs=1e-7)


def test_a_steep_step_of_a_schedule_is_a_step() -> None:
    step = rw.Schedule([0.0, 10.0, 10.0 + 1e-9, 20.0], [0.5, 0.5, 1.0, 1.0])
    result = rw.simulate(zigzag(step), until=20.0)
    assert result.frame.loc[20.0, "n4.travel"] == pytest.approx(15.0, abs=1e-7)


def test_crossings_are_located_to_a_billionth_of_a_span() -> None:
    result = rw.simulate(zigzag(), until=60.0)
    model, run = result.model, result.runs[0]
    start = model.layouts[0].start(result.parameters)
    crossings = result.events[result.events["event"].str.startswith(("crossing", "load put", "load taken"))]
    assert len(crossings) > 10
    times = result.times
    for row in crossings.itertuples():
        before = result.records[int(np.searchsorted(times, row.time, side="left"))]
        k = [n.name for n in run.nodes].index(row.component)
        travel = model.layouts[0].travel.read(before.x, before.z)[k]
        assert start[k] - travel == pytest.approx(run.loads.place[int(row.value) - 1], abs=1e-9 * 80.0)


def test_no_load_is_lost_or_duplicated() -> None:
    result = rw.simulate(zigzag(), until=150.0)
    events = result.events["event"].value_counts()
    change = on_line(result.records[-1]) - on_line(result.records[0])
    assert change == events["load put on"] - events["load taken off"]
    assert events["load put on"] >= 4
    for record in result.records:
        assert np.all(np.diff(record.passed[0]) <= 0)
    names = result.at(150.0).loads["load"]
    assert names.is_unique
    assert len(names) == on_line(result.records[-1])
    for support in ("n1", "n4", "n6"):  # each load once, in order
        numbers = result.events[result.events["component"] == support]["value"].to_numpy()
        assert np.array_equal(np.diff(numbers), np.ones(len(numbers) - 1))


def test_equals_an_equilibrium_at_every_output_time() -> None:
    """The line is quasi-static: for given travels of its drives, each instant is an equilibrium."""
    line = zigzag()
    result = rw.simulate(line, until=40.0, every=4.0)
    model = rw.assemble(line)
    start = rw.equilibrium(model)
    assert start["n0_n1.tension_a"] == pytest.approx(result.frame.loc[0.0, "n0_n1.tension_a"], rel=1e-12)
    for t in result.frame.index:
        # The drive of the run is n4. The equilibrium is solved from a cold start.
        rest = rw.equilibrium(model, parameters={"n4.travel": float(t)})
        for name in ("n0_n1.tension_a", "n3_n4.tension_b", "n4_n5.tension_a", "n7_n8.horizontal", "n2_n3.length"):
            assert result.frame.loc[t, name] == pytest.approx(rest[name], rel=2e-9), (t, name)


def test_forward_and_backward_returns_the_line() -> None:
    there_and_back = rw.Schedule([0.0, 2.0, 42.0, 46.0, 86.0, 88.0], [0.0, 1.0, 1.0, -1.0, -1.0, 0.0])
    result = rw.simulate(zigzag(there_and_back), until=88.0)
    events = result.events["event"].value_counts()
    assert events["crossing forward"] == events["crossing backward"] >= 5
    assert events["load put on"] == events["load taken off"]
    first, last = result.frame.iloc[0], result.frame.iloc[-1]
    tensions = [c for c in result.frame.columns if ".tension" in c]
    assert last[tensions].to_numpy() == pytest.approx(first[tensions].to_numpy(), rel=1e-8)
    assert last["n2.travel"] == pytest.approx(first["n2.travel"], abs=1e-7)
    assert list(result.records[-1].passed[0]) == list(result.records[0].passed[0])


def test_backward_travel_takes_loads_off_at_the_start() -> None:
    result = rw.simulate(zigzag(-0.8), until=60.0)
    events = result.events
    assert set(events["event"]) == {"crossing backward", "load taken off", "load put on"} - {"load put on"}
    assert set(events.query("event == 'load taken off'")["component"]) == {"n0"}


def test_drives_supply_the_potential_energy_of_the_loads() -> None:
    """Energy: work of both drives = gain of gravity and elastic energy, while no load crosses a support."""
    s = rw.System("two spans")
    drums = rw.Drum("d0", at=(0.0, 0.0), speed=1.0), rw.Drum("d1", at=(230.0, 30.0), speed=1.02)
    spans = s.string(ROPE, drums[0], rw.Sheave("s1", at=(120.0, 12.0)), drums[1], tension=40e3)
    s.hang(rw.Load("l1", mass=500.0), spans, at=30.0)
    s.hang(rw.Load("l2", mass=700.0), spans, at=150.0)
    result = rw.simulate(s, until=40.0, every=0.25)
    assert not len(result.noted)

    def potential(t: float) -> float:
        state = result.at(t)
        energy = (state.loads["mass"] * state.loads["z"]).sum() * 9.80665
        for name in ("d0_s1", "s1_d1"):
            curve = state.profile(name, 4001)
            weight = ROPE.mass_per_length * 9.80665
            density = weight * curve["z"] + curve["tension"] ** 2 / (2.0 * ROPE.axial_stiffness)
            energy += np.trapezoid(density, curve["station"])
        return energy

    def flow(tension: pd.Series, height: float) -> pd.Series:
        """Energy of a metre of unstretched rope that passes a support at a height."""
        return tension + tension**2 / (2.0 * ROPE.axial_stiffness) - ROPE.mass_per_length * 9.80665 * height

    frame = result.frame
    power = frame["d1.speed"] * flow(frame["d1.rope_tension"], 30.0) - frame["d0.speed"] * flow(
        frame["d0.rope_tension"], 0.0
    )
    work = np.trapezoid(power, frame.index)
    gain = potential(40.0) - potential(0.0)
    assert abs(gain) > 5e4
    assert work == pytest.approx(gain, rel=2e-5)


@pytest.mark.parametrize("friction", [0.0, 0.004, 0.03])
@pytest.mark.parametrize(("speed", "at", "direction"), [(1.0, 80.0, "forward"), (-1.0, 125.0, "backward")])
def test_load_held_at_a_hold_down_is_reported_and_passes(
    speed: float, at: float, direction: str, friction: float
) -> None:
    result = rw.simulate(valley(speed, at, friction), until=40.0, every=0.5)
    events = result.events.query("component == 'h'")
    assert list(events["event"]) == ["load held", f"load released {direction}"]
    held, released = events["time"]
    assert 0.0 < released - held < 0.05
    frame = result.full_frame
    # While the sheave holds it, the travel is constant and the tension difference grows.
    on = frame[(frame.index >= held) & (frame.index <= released)]
    assert np.ptp(on["h.travel"].iloc[1:-1]) < 1e-8
    after = frame[frame.index > released]
    ratio = after["h.tension_out"] / after["h.tension_in"]
    assert np.abs(ratio - np.exp(np.sign(speed) * friction * after["h.wrap"])).max() < 1e-7
    assert len(result.at(40.0).loads) == 1


def test_limits_are_events_and_stop_the_run_only_on_request() -> None:
    weak = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=150e3)
    s = rw.System("over the limit")
    spans = s.string(weak, rw.Anchor("a", at=(0, 0)), rw.Drum("d", at=(150, 0), speed=0.02), tension=40e3)
    s.hang(rw.Load("l", mass=500.0), spans, at=70.0)
    result = rw.simulate(s, until=60.0)
    found = result.events[["component", "event"]].to_numpy().tolist()
    assert found == [["a_d", "tension above SWL"], ["a_d", "tension above MBL"]]
    stopped = rw.simulate(s, until=60.0, stop_at="tension above MBL")
    assert stopped.times[-1] < 60.0
    assert stopped.events["event"].iloc[-1] == "tension above MBL"
    with pytest.raises(rw.InputError, match="cannot stop at"):
        rw.simulate(s, until=60.0, stop_at=("no such event",))


def test_lift_off_is_reported() -> None:
    s = rw.System("dip")
    ends = rw.Drum("d0", at=(0, 10), speed=0.0), rw.Drum("d1", at=(200, 10), speed=0.05)
    s.string(ROPE, ends[0], rw.Sheave("low", at=(100, 8)), ends[1], tension=20e3)
    result = rw.simulate(s, until=20.0)
    assert "lift-off" in set(result.events.query("component == 'low'")["event"])


def test_inputs_replace_and_open_inputs_must_be_given() -> None:
    line = zigzag(None)
    with pytest.raises(rw.InputError, match=r"Input 'n4.speed' is open.*inputs="):
        rw.simulate(line, until=5.0)
    result = rw.simulate(line, until=5.0, inputs={"n4.speed": 0.5})
    assert result.frame["n4.travel"].iloc[-1] == pytest.approx(2.5)
    with pytest.raises(rw.UnknownNameError, match=r"n4.sped.*n4.speed"):
        rw.simulate(line, until=5.0, inputs={"n4.sped": 0.5})
    with pytest.raises(rw.InputError, match="finite"):
        rw.simulate(line, until=5.0, inputs={"n4.speed": float("nan")})
    with pytest.raises(rw.InputError, match="ends at 3 s, the run at 5 s"):
        rw.simulate(line, until=5.0, inputs={"n4.speed": rw.Schedule([0, 3], [1, 1])})


@pytest.mark.parametrize("wrong", [{"until": 0.0}, {"until": -1.0}, {"until": 5.0, "every": 0.0}])
def test_bad_times(wrong: dict[str, float]) -> None:
    with pytest.raises(rw.InputError):
        rw.simulate(zigzag(), **wrong)


def test_a_failed_run_keeps_its_records() -> None:
    """The drum winds in an anchored, nearly inextensible rope until no equilibrium exists."""
    stiff = rw.Rope(mass_per_length=3.48, axial_stiffness=float("inf"), breaking_load=576.6e3)
    s = rw.System("wound up")
    s.string(stiff, rw.Anchor("a", at=(0, 0)), rw.Drum("d", at=(150, 0), speed=0.05), tension=40e3)
    with pytest.raises(rw.SimulationError) as failure:
        rw.simulate(s, until=60.0)
    assert failure.value.remedy
    result = failure.value.result
    assert isinstance(result, rw.Result)
    assert 0.0 < result.times[-1] <= failure.value.time + 1e-9
    assert np.isfinite(result.frame.to_numpy()).all()


def test_result_at_any_time_and_files(tmp_path: Path) -> None:
    result = rw.simulate(zigzag(), until=10.0)
    fine = rw.simulate(zigzag(), until=10.0, every=0.25)
    middle = result.at(3.25)
    for name in ("n0_n1.tension_a", "n4.tension_out", "n3.travel"):
        assert middle[name] == pytest.approx(fine.frame.loc[3.25, name], rel=1e-8)
    with pytest.raises(rw.InputError, match="outside the run"):
        result.at(11.0)
    back = pd.read_csv(result.to_csv(tmp_path / "r.csv"), index_col="time [s]")
    assert back.to_numpy() == pytest.approx(result.frame.to_numpy(), rel=1e-12)
    again = pd.read_parquet(result.to_parquet(tmp_path / "r.parquet"))
    pd.testing.assert_frame_equal(again, result.frame)
    assert again.attrs["units"]["n4.travel"] == "m"


def test_runs_are_deterministic() -> None:
    one, two = rw.simulate(zigzag(), until=20.0), rw.simulate(zigzag(), until=20.0)
    assert np.array_equal(one.frame.to_numpy(), two.frame.to_numpy())
    pd.testing.assert_frame_equal(one.events, two.events)


def test_slots_are_added_when_loads_bunch_up() -> None:
    """A long span between two short ones, which receives more loads than it has at the start."""
    s = rw.System("bunch")
    ends = rw.Drum("d0", at=(0, 0), speed=1.0), rw.Drum("d1", at=(330, 3), tension=50e3)
    spans = s.string(ROPE, ends[0], rw.Sheave("s1", at=(60, 3)), rw.Sheave("s2", at=(300, 4)), ends[1], tension=50e3)
    for i in range(5):
        s.hang(rw.Load(f"l{i}", mass=100.0), spans, at=5.0 + 10.0 * i)
    result = rw.simulate(s, until=130.0, every=10.0)
    assert len(result.at(110.0).loads.query("span == 's1_s2'")) == 5
    assert result.frame.shape[0] == 14


def paid_out(heights: tuple[float, ...], stations: tuple[float, ...]) -> rw.System:
    """A drum pays out half a metre of rope a second over idlers."""
    s = rw.System("paid out")
    first, *between, last = zip(stations, heights, strict=True)
    idlers = [rw.Sheave(f"s{i}", at=at) for i, at in enumerate(between, 1)]
    s.string(ROPE, rw.Drum("d", at=first, speed=0.5), *idlers, rw.Anchor("b", at=last), length=stations[-1] + 5.0)
    return s


def test_a_rope_that_is_paid_out_stays_in_balance() -> None:
    """Most of it ends in the longest span, for any interval of records; some once gave a distant root."""
    ends = []
    for every in (10.0, 200.0, 400.0):
        frame = rw.simulate(paid_out((0.0, 0.0, 3.0, 0.0), (0.0, 100.0, 210.0, 300.0)), 400.0, every=every).frame
        ends.append(frame.filter(like=".length").iloc[-1].to_numpy())
    assert ends[0].argmax() == 1
    assert ends[1] == pytest.approx(ends[0], abs=1e-6)
    assert ends[2] == pytest.approx(ends[0], abs=1e-6)


def test_a_balance_that_becomes_unstable_ends_a_run_at_its_time() -> None:
    """Two equal spans share the rope until their end tension is minimal; then the rope would run into one of them."""
    found = []
    for every in (1.0, 30.0, 400.0):
        with pytest.raises(rw.SimulationError, match="rope over 's1' is unstable") as caught:
            rw.simulate(paid_out((0.0, 0.0, 0.0), (0.0, 100.0, 200.0)), 400.0, every=every)
        found.append(caught.value.time)
    assert found == pytest.approx([found[0]] * 3, abs=1e-4)
    # Inextensible: u tanh(u) = 1 at u = L / 2a, and a length of 2a sinh(u) = L sinh(u) / u.
    assert 205.0 + 0.5 * found[0] == pytest.approx(200.0 * 1.508879561538 / 1.199678640257, rel=1e-3)


def test_a_carriage_does_not_run_past_the_end_of_its_span() -> None:
    rig = rw.standing_skyline(
        None,
        headspar=rw.HeadSpar("head", at=(0.0, 0.0)),
        tailspar=rw.TailSpar("tail", at=(200.0, -60.0)),
        skyline=ROPE,
        length=213.0,
        carriage=rw.Carriage("carriage", mass=450.0),
        mainline=rw.Rope(mass_per_length=0.73, axial_stiffness=8e6, breaking_load=120e3),
    )
    with pytest.raises(rw.SimulationError, match=r"No rope is left in span 'head_carriage'") as caught:
        rw.simulate(rig.system(0, 100.0, payload=1500.0), 200.0, inputs={"mainline.speed": -1.0})
    assert isinstance(caught.value.result, rw.Result)
    good = caught.value.result.frame
    assert 90.0 < good.index[-1] < 120.0
    assert (good["head_carriage.length"] > 0.0).all()
