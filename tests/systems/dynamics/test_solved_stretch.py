"""A stretch that IDAS has integrated: interpolation of known functions, the time of an event, bounds of travels."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

import ropeway as rw
from ropeway.systems.dynamics.inertia.inertial_state import inertial_state
from ropeway.systems.dynamics.inertia.solved_stretch import SolvedStretch
from ropeway.systems.dynamics.inertia.support_zones import TIE
from ropeway.systems.dynamics.inertia.zone_bounds import Bounds
from ropeway.systems.solvers.points import Point
from ropeway.systems.statics.line_state import LineState

START, LONG, PARTS, RATE = 3.0, 0.8, 40, 5.0


def known(t: np.ndarray) -> np.ndarray:
    """A polynomial of the fifth degree and a sine."""
    tau = t - START
    return np.stack([1.0 + tau - 2.0 * tau**3 + tau**5, np.sin(RATE * tau)], axis=-1)


@pytest.fixture(scope="module")
def stretch() -> SolvedStretch:
    t = START + np.linspace(0.0, LONG, PARTS + 1)
    none = np.zeros(0)
    return SolvedStretch(Point(known(t)[0], none, none, none, none, START), LONG, known(t), 2.0 * known(t))


def between(low: float, high: float) -> Bounds:
    """Bounds of the sine."""
    seen = SimpleNamespace(watched=np.array([1]), low=np.array([low]), high=np.array([high]))
    seen.excess = lambda x: Bounds.excess(cast(Any, seen), x)
    return cast(Any, seen)


def test_the_line_is_known_at_any_time(stretch: SolvedStretch) -> None:
    for t in START + np.array([0.0, 0.003, 0.1234, 0.4, 0.7777, LONG]):
        x, z = stretch.at(t)
        assert x[0] == pytest.approx(known(np.array(t))[0], abs=1e-13)  # exact up to the fifth degree
        assert x[1] == pytest.approx(np.sin(RATE * (t - START)), abs=1e-7)
        np.testing.assert_allclose(z, 2.0 * x, rtol=1e-12)
    np.testing.assert_array_equal(stretch.at(START + LONG)[0], stretch.x[-1])


def test_the_error_is_that_of_the_interpolation(stretch: SolvedStretch) -> None:
    middle = START + LONG * (np.arange(10, 30) + 0.5) / PARTS
    true = max(abs(stretch.at(t)[0][1] - np.sin(RATE * (t - START))) for t in middle)
    assert stretch.error[0] < 1e-14
    assert true / 3.0 < stretch.error[1] < 3.0 * true


def test_an_event_is_found_where_a_state_comes_to_its_bound(stretch: SolvedStretch) -> None:
    assert stretch.time_of_event(START, between(-1.1, 0.7)) == pytest.approx(START + np.arcsin(0.7) / RATE, abs=1e-8)
    below = START + (np.pi + np.arcsin(0.5)) / RATE
    assert stretch.time_of_event(START, between(-0.5, 2.0)) == pytest.approx(below, abs=1e-8)
    assert stretch.time_of_event(START, between(-2.0, 2.0)) == np.inf
    # One that is beyond its bound already is no event.
    assert stretch.time_of_event(START + 0.2, between(-2.0, 0.7)) == np.inf


def test_a_stretch_goes_on_only_from_its_own_points(stretch: SolvedStretch) -> None:
    point = stretch.start.copy()
    assert stretch.continues(point)
    point.x[0] += 1e-9
    assert not stretch.continues(point)
    x, z = stretch.at(START + 0.3)
    later = Point(x, z, point.u, point.p, point.d, START + 0.3)
    assert stretch.continues(later)
    assert not stretch.continues(replace(later, t=START + LONG))
    assert not stretch.continues(replace(later, p=np.ones(1)))


def test_bounds_are_the_travels_at_which_loads_come_to_supports() -> None:
    """Loads 14 m and 62 m from the first of three supports, spans of 50 m, zones of 0.5 m: the rope runs 35.5 m until
    the first is in the zone of the middle support, and 37.5 m until the second is in that of the last; backwards 13.5 m
    and 11.5 m."""
    points = [(0.0, 0.0), (50.0, 0.0), (100.0, 0.0)]
    s = rw.System("two")
    ends = rw.Drum("a", at=points[0], speed=1.0), rw.Drum("c", at=points[2], tension=60e3, inertia=100.0)
    rope = rw.Rope(mass_per_length=2.0, axial_stiffness=2e7, breaking_load=4e5)
    spans = s.string(rope, ends[0], rw.Sheave("b", at=points[1], inertia=100.0), ends[1], length=100.0)
    for name, at in (("one", 14.0), ("two", 62.0)):
        s.hang(rw.Load(name, mass=100.0), spans, at=at)
    model = rw.assemble(s)
    quasi = LineState.cold(model)
    state = inertial_state(quasi, rw.Inertia(zone=0.5))
    bounds, names = Bounds(state), state.model.x.names
    rope_at = dict(zip("abc", state.rope(0), strict=True))
    place = {name: float(at) for name, at in zip(state.runs[0].loads.names, state.runs[0].loads.place, strict=True)}
    seen = {names[i]: (bounds.low[k], bounds.high[k]) for k, i in enumerate(bounds.watched)}
    forward = {"b": rope_at["b"] - place["one"], "c": rope_at["c"] - place["two"]}
    backward = {"a": place["one"] - rope_at["a"], "b": place["two"] - rope_at["b"]}
    for node, gap in forward.items():
        assert seen[f"{node}.travel"][1] == pytest.approx(state.point.x[names.index(f"{node}.travel")] + gap - 0.5)
    for node, gap in backward.items():
        assert seen[f"{node}.travel"][0] == pytest.approx(state.point.x[names.index(f"{node}.travel")] - gap + 0.5)
    rates = np.zeros(len(names))
    for node in "abc":
        rates[names.index(f"{node}.travel")] = 2.0
    assert bounds.time_left(state.point.x, rates) == pytest.approx((min(forward.values()) - 0.5) / 2.0)
    assert (bounds.excess(state.point.x) < 0.0).all()
    assert not bounds.due(state, [rates[:3] + 2.0])
    # Just there the first load is due; the second one comes to its support more than half a metre later.
    state.point.x[[names.index(f"{node}.travel") for node in "abc"]] += min(forward.values()) - 0.5
    due = bounds.due(state, [np.full(3, 2.0)])
    loads = state.runs[0].loads
    assert [(event.what, loads.names[event.load - loads.first]) for event in due] == [(TIE, "one")]
