"""A run does not depend on the interval of its records."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import ropeway as rw
from ropeway.systems.statics.certificate.checks import IN_SPAN
from support.runs import random_run

ROPE = rw.Rope(mass_per_length=3.36, axial_stiffness=30e6, breaking_load=600e3)
LINE = Path(__file__).resolve().parents[3] / "examples" / "line.csv"
RAMP = rw.Schedule((0.0, 3.0, 60.0), (0.0, 1.0, 1.0))


def line(stations: Sequence[float], heights: Sequence[float], controls: Sequence[int], **more: object) -> rw.System:
    """Drums at the ends, control sheaves at given supports."""
    last = len(stations) - 1
    kind = ["drum" if i in (0, last) else "control" if i in controls else "idler" for i in range(last + 1)]
    names = [f"n{i}" for i in range(last + 1)]
    table = pd.DataFrame({"name": names, "x": stations, "y": 0.0, "z": heights, "kind": kind})
    return rw.monocable(ROPE, table, **{"tension": 50e3, "load_mass": [245.0, 467.0, 433.0, 387.0], **more})


def drive(displacement: float, power: float, inertia: float, **more: float) -> rw.HydraulicDrive:
    usual = {"relief_pressure": 200e5, "pump_flow": 8.5e-3, "friction": 0.01, "gear_ratio": 20.0, "sheave_radius": 0.6}
    return rw.HydraulicDrive(displacement=displacement, engine_power=power, inertia=inertia, **{**usual, **more})


def lost(sheaves: Sequence[str], begin: float, end: float) -> list[rw.Intervention]:
    return [
        rw.Intervention(time, action, name)
        for name in sheaves
        for time, action in ((begin, "pressure lost"), (end, "pressure back"))
    ]


CASES = {
    # From rest, rates at the start predict no crossing.
    "a ramp from rest": (
        rw.monocable(rw.Rope.named("RHOL-IWRC 29"), LINE, tension=45e3, speed=RAMP, load_mass=300.0, load_spacing=61.0),
        [],
        12.0,
        (0.5, 3.0, 12.0),
    ),
    # The engine limits the second drive between two records.
    "an engine at its limit": (
        line(
            (0.0, 122.8, 207.4, 289.9, 410.6, 489.1, 577.4, 655.7),
            (0.0, 20.2, 33.4, 45.1, 60.0, 68.3, 76.7, 83.6),
            (2, 6),
            speed=rw.Schedule((0.0, 10.0, 60.0), (0.0, 0.6, 0.6)),
            load_spacing=49.4,
            drive=drive(111e-6, 9900.0, 965.0, recovers=False),
            tension=50.9e3,
        ),
        [],
        15.0,
        (0.5, 5.0, 15.0),
    ),
    # A load also passes a support backwards, before the next record.
    "pressure lost, and back": (
        line(
            (0.0, 90.0, 195.8, 279.9, 354.0, 472.5),
            (0.0, 6.3, 12.0, 14.7, 15.6, 15.1),
            (2, 4),
            load_mass=[300.0, 100.0, 400.0],
            load_spacing=13.14,
            tension=46.9e3,
            drive=drive(120e-6, 60e3, 2075.0, drag=8000.0),
        ),
        lost(("n2", "n4"), 3.0, 7.0),
        10.0,
        (0.1, 1.0, 10.0),
    ),
    # Rates at the end of a step, where the rope hardly moves, do not give the time of the crossing.
    "a drive that stops behind a crossing": (
        line(
            (0.0, 104.6, 220.9, 347.5, 469.0, 546.1, 622.8, 751.9),
            (0.0, 18.2, 37.5, 56.7, 72.8, 81.8, 90.2, 103.2),
            (3, 4, 6),
            speed=1.4,
            load_mass=[453.0, 290.0, 230.0, 323.0],
            load_spacing=22.3,
            tension=55.6e3,
            drive=drive(171.5e-6, 19e3, 445.5, relief_pressure=109e5, command_lag=0.0, recovers=False),
        ),
        lost(("n3",), 12.3, 20.0),
        20.5,
        (1.0, 7.5),
    ),
    # Within a second a load passes a support, returns, and passes again.
    "a drive without pressure that swings": (
        line(
            (0.0, 105.2, 224.6, 312.4, 423.5, 521.3, 644.8),
            (0.0, 18.5, 38.5, 52.2, 67.9, 80.5, 95.4),
            (2, 3),
            speed=-1.0,
            load_mass=[489.7, 490.4, 183.0, 83.7],
            load_spacing=37.5,
            tension=55.3e3,
            drive=drive(90e-6, 38e3, 515.3, relief_pressure=111e5, friction=0.0),
        ),
        lost(("n2",), 12.3, 20.0),
        18.0,
        (0.2, 1.0),
    ),
}


@pytest.mark.parametrize(
    "case", [pytest.param(case, marks=[pytest.mark.slow] if "behind a crossing" in case else []) for case in CASES]
)
def test_coarse_and_fine_records_agree(case: str) -> None:
    system, interventions, until, intervals = CASES[case]
    fine, *coarse = (
        rw.simulate(system, until, every=every, tolerance=1e-7, interventions=interventions) for every in intervals
    )
    happened = fine.events[fine.events["load"] != ""]
    for result in coarse:
        assert np.all(np.diff(result.times) >= 0.0)
        found = result.events[result.events["load"] != ""]
        assert found["load"].tolist() == happened["load"].tolist()
        assert found["event"].tolist() == happened["event"].tolist()
        assert found["time"].to_numpy() == pytest.approx(happened["time"].to_numpy(), abs=1e-3)
        both = result.frame.index.intersection(fine.frame.index)
        for quantity, near in ((".travel", 1e-3), (".tension_in", 20.0)):
            ours, theirs = (r.frame.loc[both].filter(like=quantity).to_numpy() for r in (result, fine))
            assert ours == pytest.approx(theirs, abs=near)


@pytest.mark.parametrize(
    ("seed", "until"),
    [
        (2223148, 1.5),  # the engine limits a drive that slows down, after the first of its checks and before the last
        (5000011, 4.0),
    ],
)
def test_records_do_not_steer_an_integration(seed: int, until: float) -> None:
    run = replace(random_run(seed), until=until)
    fine, *others = run.simulate(0.1, tolerance=1e-8), run.simulate(1.0), run.simulate(0.3), run.simulate(0.7)
    travels, ends = fine.frame.filter(regex=r"\.travel$").columns, [r.frame.iloc[-1] for r in (fine, *others)]
    for end in ends[1:]:
        assert end[travels].to_numpy() == pytest.approx(ends[0][travels].to_numpy(), abs=3e-6)
        assert end[travels].to_numpy() == pytest.approx(ends[1][travels].to_numpy(), abs=1e-9)
    for result, every in zip(others, (1.0, 0.3, 0.7), strict=True):
        grid = [*np.arange(0.0, until - 1e-9, every), until]
        assert result.frame.index.to_numpy() == pytest.approx(np.array(grid), abs=1e-12)
        assert np.all(np.diff(result.times) >= 0.0)


def hillside(masses: float, spacing: float, rise: float, tension: float, speed: float) -> rw.System:
    """A mono-cable of six spans over a hump, rising by `rise` [m] per span, between constant-tension drums."""
    x = 90.0 * np.arange(7)
    table = pd.DataFrame(
        {
            "name": [f"n{i}" for i in range(7)],
            "x": x,
            "y": 0.0,
            "z": rise * np.arange(7) + 5.0 * np.sin(np.pi * x / x[-1]),
            "kind": ["drum", "idler", "idler", "control", "idler", "idler", "drum"],
        }
    )
    rope = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)
    return rw.monocable(rope, table, tension=tension, speed=speed, load_mass=masses, load_spacing=spacing)


@pytest.mark.parametrize(("mass", "rise"), [(350.0, 25.0), (900.0, 45.0)])
def test_a_load_rests_on_a_drum_that_would_draw_it_back(mass: float, rise: float) -> None:
    """Uphill, a load that is put on lowers the tension, and the drum draws the rope back. The load is put on when the
    rope carries it, and the line then starts from there."""
    line = hillside(mass, 40.0, rise, 70e3, 1.1)
    run = rw.simulate(line, until=80.0, progress=False)
    put_on = [e for e in run.noted if e.event == "load put on"]
    assert len(put_on) >= 2
    assert run.certificate.loc[IN_SPAN, "value"] < 1e-9
    for event in put_on:
        before, after = (i for i in range(len(run.times)) if run.times[i] == event.time)
        assert event.load not in run.record(before).loads["load"].tolist()
        own = run.record(after).loads.set_index("load").loc[event.load]
        assert own["span"] == "n0_n1"
        assert 0.0 <= own["distance"] < 0.01
    # At the time of its arrival at the drum, it would be drawn back by more than rounding.
    early = run.at(put_on[0].time - 1e-4)
    assert early["n0.rope_tension"] == pytest.approx(70e3, rel=1e-9)
    rest = rw.simulate(line, 80.0 - put_on[0].time + 1e-4, start=early, progress=False)
    assert rest.frame["n1.tension_in"].iloc[-1] == pytest.approx(run.frame["n1.tension_in"].iloc[-1], rel=1e-8)


def test_rope_that_runs_away_at_a_crossing_is_reported_as_unstable() -> None:
    """Loads far too heavy for the drum's tension: the jump at a crossing does not converge."""
    x = 100.0 * np.arange(7)
    table = pd.DataFrame(
        {
            "name": [f"n{i}" for i in range(7)],
            "x": x,
            "y": 0.0,
            "z": -20.0 * np.arange(7) + 6.0 * np.sin(np.pi * x / x[-1]),
            "kind": ["drum", "idler", "control", "idler", "idler", "idler", "drum"],
        }
    )
    rope = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)
    line = rw.monocable(rope, table, tension=60e3, speed=-1.0, load_mass=3000.0, load_spacing=70.0)
    with pytest.raises(rw.SimulationError, match="rope over 'n1' is unstable") as caught:
        rw.simulate(line, until=150.0, progress=False)
    assert caught.value.result.times[-1] == pytest.approx(122.75, abs=0.01)


@pytest.mark.parametrize("speed", [1.0, -1.0])
def test_a_load_at_a_rough_idler_as_the_rope_starts_the_other_way(speed: float) -> None:
    """Friction turns with the rope, and draws a millimetre of it over the idler at once, and the load with it."""
    s = rw.System("starting")
    drums = rw.Drum("d", at=(0.0, 0.0), speed=speed), rw.Drum("e", at=(200.0, 0.0), tension=50e3)
    spans = s.string(ROPE, drums[0], rw.Sheave("m", at=(100.0, 15.0), friction=0.05), drums[1], tension=50e3)
    s.hang(rw.Load("l", mass=400.0), spans, at=spans[0].length)
    result = rw.simulate(s, until=1.0, every=0.5, inputs={"d.speed": -speed}, progress=False)
    assert result.certificate["holds"].all()
    assert result.events["event"].str.startswith("crossing").any()
