"""Fits to series, and estimates while a line runs."""

from collections.abc import Iterator
from functools import cache
from typing import Any

import numpy as np
import pandas as pd
import pytest

import ropeway as rw
from support.drives import hydraulic_drive

ROPE = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)
SUPPORTS = pd.DataFrame(
    [
        ("start", 0.0, 0.0, "drum"),
        ("s1", 70.0, 9.0, "idler"),
        ("c1", 150.0, 15.0, "control"),
        ("s2", 230.0, 24.0, "idler"),
        ("c2", 300.0, 28.0, "control"),
        ("end", 370.0, 26.0, "drum"),
    ],
    columns=["name", "x", "z", "kind"],
).assign(y=0.0)
COLUMNS = ["c1.tension_in", "c1.tension_out", "c2.tension_in", "c2.tension_out"]
SPEED = rw.Schedule([0.0, 10.0, 20.0, 400.0], [1.0, 1.0, 1.03, 1.03])
MASSES = tuple(float(m) for m in np.random.default_rng(5).uniform(220.0, 430.0, 12))


def line(masses: float | tuple[float, ...] = 300.0, **parts: Any) -> rw.System:
    return rw.monocable(ROPE, SUPPORTS, tension=45e3, load_mass=masses, load_spacing=62.0, **parts)


@cache
def run() -> rw.Result:
    """A run with loads of different masses; the second control sheave becomes a little faster."""
    return rw.simulate(line(MASSES), 300.0, every=1.0, inputs={"c2.speed": SPEED}, tolerance=1e-9)


def log(until: float, noise: float, seed: int = 1) -> pd.DataFrame:
    frame = run().frame.loc[:until, COLUMNS].copy()
    frame += np.random.default_rng(seed).normal(0.0, noise, frame.shape)
    return frame.assign(v2=[SPEED.at(t) for t in frame.index])


def test_a_series_gives_the_mass_and_the_pretension_it_was_made_with() -> None:
    declared = list(MASSES)
    declared[2] = 300.0
    table = log(30.0, 0.0).iloc[[0, 2, 6, 10, 16, 20, 30]]
    columns = {"time": "time", "v2": "c2.speed", "c1.tension_out": "c1.tension_out", "c2.tension_in": "c2.tension_in"}
    fit = rw.fit(line(tuple(declared)), table, columns=columns, free=["l3.mass", "start.pretension"], sigma=100.0)
    assert fit.values["l3.mass"] == pytest.approx(MASSES[2], rel=1e-4)
    assert fit.values["start.pretension"] == pytest.approx(45e3, rel=1e-6)
    assert fit.residuals.index.name == "time"
    assert "time" in fit.suggestion


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"times": [0.0, 1.0, 2.5]}, "multiples of 1 s"),
        ({"times": [0.0, 2.0, 1.0]}, "do not increase"),
        ({"columns": {"mass": "l3.mass"}}, "cannot be given over time"),
    ],
)
def test_series_that_cannot_be_fitted(change: dict[str, Any], message: str) -> None:
    table = pd.DataFrame({"t": change.get("times", [0.0, 1.0, 2.0]), "A": 45e3, "mass": 300.0})
    columns = {"t": "time", "A": "c1.tension_in", **change.get("columns", {})}
    with pytest.raises(rw.InputError, match=message):
        rw.fit(line(), table, columns=columns, free="start.pretension", sigma=100.0)


def monitored(until: float = 300.0, **changes: Any) -> tuple[rw.Monitor, list[rw.Estimate]]:
    columns = {"time": "time", "v2": "c2.speed", **{c: c for c in COLUMNS}}
    arguments = {"free": "*.mass", "sigma": 100.0, "prior": {"*.mass": (300.0, 100.0)}} | changes
    watch = rw.monitor(line(), columns=columns, **arguments)
    return watch, list(watch.follow(log(until, 100.0)))


def test_masses_are_known_three_spans_after_they_are_put_on() -> None:
    """Within 5 % (two standard errors), with noise of 100 N at 1 Hz; the reserve is that of the run."""
    watch, estimates = monitored()
    true = {f"l{i + 1}.mass": MASSES[i % len(MASSES)] for i in range(20)}
    events = run().events
    there = events[events["load"] == "l7"].set_index("component")["time"]
    assert there["start"] > 20.0
    now = next(e for e in estimates if e.time >= there["s2"])
    assert 2.0 * now.standard_error["l7.mass"] < 0.05 * true["l7.mass"]
    assert abs(now.value["l7.mass"] - true["l7.mass"]) < 0.05 * true["l7.mass"]
    off = [(e.value[n] - true[n]) / e.standard_error[n] for e in estimates[::60] for n in e.value]
    assert 0.6 < np.std(off) < 1.5
    frame = watch.frame
    tensions = run().frame.filter(regex=r"_.*\.tension_[ab]$").max(axis=1)
    reserve = frame["reserve"].iloc[100:]
    missed = (reserve["value"] - (ROPE.safe_working_load - tensions.loc[reserve.index])) / reserve["standard_error"]
    assert missed.abs().quantile(0.95) < 3.0
    assert reserve["standard_error"].max() < 300.0
    assert repr(watch) == "<Monitor of 'mono-cable line': 301 rows>"


def test_rows_from_an_iterator_with_gaps() -> None:
    columns = {"t": "time", "T_kN": "c2.tension_in", "v2": "c2.speed"}
    watch = rw.monitor(line(MASSES), columns=columns, free=["l3.mass"], sigma={"T_kN": 100.0}, drift={"l3.mass": 1.0})
    true = log(12.0, 0.0)

    def rows() -> Iterator[dict[str, Any]]:
        for t in (0.0, 4.0, 5.0, 10.0):
            row: dict[str, Any] = {"t": t, "v2": true.loc[t, "v2"], "T_kN": true.loc[t, "c2.tension_in"] / 1e3}
            yield row | ({"T_kN": ""} if t == 4.0 else {})

    found = list(watch.follow(rows()))
    assert [e.time for e in found] == [0.0, 4.0, 5.0, 10.0]
    assert found[1].misses == {}
    assert found[1].standard_error["l3.mass"] > found[0].standard_error["l3.mass"]
    assert found[-1].value["l3.mass"] == pytest.approx(MASSES[2], abs=2.0 * found[-1].standard_error["l3.mass"])
    with pytest.raises(rw.InputError, match="Sort the rows"):
        watch.update({"t": 3.0, "T_kN": 45.0})
    with pytest.raises(rw.InputError, match="from the start of the run"):
        watch.update({"t": 1.7e9, "T_kN": 45.0})
    with pytest.raises(rw.InputError, match="has no time"):
        watch.update({"T_kN": 45.0})
    with pytest.raises(rw.InputError, match="T_kN is 'high'"):
        watch.update({"t": 20.0, "T_kN": "high"})
    with pytest.raises(rw.InputError, match="is 46123 with a decimal point and"):
        watch.update({"t": 20.0, "T_kN": "46,123"})
    point, comma = (watch.update({"t": t, "T_kN": text}) for t, text in ((20.0, "46.1"), (20.0, "46,1")))
    assert comma.misses["T_kN"] == pytest.approx(point.misses["T_kN"], rel=0.1)  # the same value, filtered again


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"columns": {"A": "c1.tension_in"}}, "no time"),
        ({"columns": {"t": "time", "v": "c1.speed"}}, "No column is measured"),
        ({"columns": {"t": "time", "A": "c1.tension_in", "z": "s1.z"}}, "cannot be given over time"),
        ({"columns": {"t": "time", "A_kg": "c1.tension_in"}}, "different quantities"),
        ({"free": []}, "free is empty"),
        ({"free": "c1.tension_in"}, "cannot be estimated"),
        ({"sigma": {"B": 1.0}}, "no value for A"),
        ({"drift": {"*.mass": -1.0}}, "zero or more"),
        ({"drift": {"l3.mas": 1.0}}, "drift has 'l3.mas', which is not free"),
        ({"prior": {"c1.friction": (0.1, 0.1)}}, "prior has 'c1.friction', which is not free"),
    ],
)
def test_monitors_that_cannot_be(change: dict[str, Any], message: str) -> None:
    arguments = {"columns": {"t": "time", "A": "c1.tension_in"}, "free": "*.mass", "sigma": 100.0} | change
    with pytest.raises(rw.InputError, match=message):
        rw.monitor(line(), **arguments)


@pytest.mark.parametrize(
    "change",
    [{"sigma": 1e-9}, {"sigma": 1e200}, {"prior": {"*.mass": (300.0, 1e15)}}, {"drift": {"*.mass": 1e200}}],
)
def test_deviations_beyond_the_digits_of_numbers_are_refused(change: dict[str, Any]) -> None:
    """Two gauges on one span would be one to them."""
    arguments: dict[str, Any] = {"free": "*.mass", "sigma": 100.0} | change
    columns = {"t": "time", "A": "s1_s2.tension_a", "B": "s1_s2.tension_b"}
    watch = rw.monitor(loaded_span(), columns=columns, **arguments)
    with pytest.raises(rw.InputError, match="more apart than numbers resolve"):
        list(watch.follow([{"t": t, "A": 40e3, "B": 41e3} for t in (0.0, 1.0)]))


def test_a_mass_stays_above_zero() -> None:
    """Tensions far below those of the empty rope contradict the model: no load is lighter than nothing."""
    watch = rw.monitor(loaded_span(), columns={"t": "time", "A": "s1_s2.tension_a"}, free="*.mass", sigma=1.0)
    now = watch.update({"t": 0.0, "A": 1e3})
    assert 0.0 < now.value["turn.mass"] < 1.0
    assert now.misses["A"] < -2.0
    with pytest.raises(rw.InputError, match=r"expected value of turn\.mass is -5"):
        rw.monitor(
            loaded_span(), columns={"t": "time", "A": "s1_s2.tension_a"}, free="*.mass", sigma=1.0,
            prior={"*.mass": (-5.0, 1.0)},
        ).update({"t": 0.0, "A": 1e3})  # fmt: skip


def test_a_small_parameter_keeps_its_value() -> None:
    """A flow of 0.4 l/s: a limit that were not relative would move it. At rest no tension depends on it."""
    s, drive = rw.System("driven"), hydraulic_drive(pump_flow=4e-4)
    ends = rw.Drum("a", at=(0.0, 0.0)), rw.Drum("b", at=(200.0, 4.0), tension=45e3)
    s.string(ROPE, ends[0], rw.ControlSheave("c", at=(100.0, 10.0), drive=drive), ends[1], length=201.5)
    watch = rw.monitor(s, columns={"t": "time", "A": "c.tension_in"}, free="c.pump_flow", sigma=100.0)
    now = watch.update({"t": 0.0, "A": 40e3})
    assert now.value["c.pump_flow"] == pytest.approx(4e-4, rel=1e-9)


def loaded_span() -> rw.System:
    """A turn on a standing rope."""
    s = rw.System("span")
    ends = rw.Anchor("s1", at=(0.0, 0.0)), rw.Anchor("s2", at=(100.0, 5.0))
    (span,) = s.string(ROPE, *ends, length=100.6)
    s.hang(rw.Load("turn", mass=500.0), span, at=40.0)
    return s


def test_a_responding_sheave_needs_its_speed() -> None:
    responding = line(response=rw.ProportionalResponse(gain=1e-5, limit=0.1))
    with pytest.raises(rw.InputError, match=r"c1\.speed"):
        rw.monitor(responding, columns={"t": "time", "A": "c1.tension_in"}, free="*.mass", sigma=100.0)
