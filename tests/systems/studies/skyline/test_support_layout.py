"""The search for supports against payload studies of all combinations."""

from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ropeway as rw
from ropeway.systems.rigs.rig_builder import with_supports
from ropeway.systems.studies.skyline.carriage_model import Solved
from ropeway.systems.studies.skyline.limits import LoadLimits
from ropeway.systems.studies.skyline.station_solver import Stations
from ropeway.systems.studies.skyline.support_trial import SupportTrial, TrialRigs

CORRIDOR = Path(rw.__file__).parent / "examples" / "corridor.csv"
STATIONS = np.arange(20.0, 480.0, 20.0)


def rig() -> rw.SkylineRig:
    return rw.standing_skyline(
        rw.Profile.from_csv(CORRIDOR),
        headspar=rw.HeadSpar("head", station=0.0, height=15.0),
        tailspar=rw.TailSpar("tail", station=480.0, height=8.0),
        skyline=rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3),
        tension=70e3,
        carriage=rw.Carriage("carriage", mass=450.0, depth=3.0),
    )


TREES = (
    rw.Candidate("oak", station=200.0, heights=(7.0, 10.0)),
    rw.Candidate("fir", station=260.0, heights=(6.0, 8.0, 10.0)),
    rw.Candidate("ash", station=330.0, heights=(8.0, 10.0)),
)


def test_it_is_the_best_of_all_combinations() -> None:
    plan = rw.optimise_supports(rig(), TREES, payload=2500.0, clearance=0.5, stations=STATIONS)
    assert plan.feasible
    assert plan.rig.supports == tuple(s.placed(rig().terrain) for s in plan.supports)
    bare = rw.payload(rig(), clearance=0.5, stations=STATIONS)
    assert bare.payload < 2500.0
    possible = []
    for tree in TREES:
        for height in tree.heights:
            trial = with_supports(rig(), [tree.support(height)])
            if rw.payload(trial, clearance=0.5, stations=STATIONS).payload >= 2500.0:
                possible.append((height, tree.name))
    assert possible, "one support must be enough"
    assert len(plan.supports) == 1
    assert plan.height == min(possible)[0]


def test_two_supports_if_one_is_not_enough() -> None:
    most = rw.payload(with_supports(rig(), [TREES[1].support(10.0)]), clearance=0.5, stations=STATIONS).payload
    wanted = most + 400.0
    plan = rw.optimise_supports(rig(), TREES, payload=wanted, clearance=0.5, stations=STATIONS)
    pairs = []
    for a, b in ((0, 1), (0, 2), (1, 2)):
        for heights in product(TREES[a].heights, TREES[b].heights):
            chosen = [TREES[a].support(heights[0]), TREES[b].support(heights[1])]
            if rw.payload(with_supports(rig(), chosen), clearance=0.5, stations=STATIONS).payload >= wanted:
                pairs.append(sum(heights))
    if pairs:
        assert plan.feasible
        assert len(plan.supports) == 2
        assert plan.height == min(pairs)
    else:
        assert not plan.feasible or len(plan.supports) == 3


def test_a_state_without_its_certificate_does_not_count(monkeypatch: pytest.MonkeyPatch) -> None:
    """The carriage is 0.3 m too low at one station, although all its margins hold."""
    right = Stations.solve

    def spoiled(self: Stations, station: float, payload: float, height: float | None = None, **how: Any) -> Solved:
        solved = right(self, station, payload, height, **how)
        if station != 240.0:
            return solved
        point = solved.point.copy()
        point.z[solved.at.model.z.index["carriage.z"]] -= 0.3
        return replace(solved, point=point, case=None)

    support = rw.Candidate("fir", station=260.0, heights=(10.0,))
    assert rw.optimise_supports(rig(), [support], payload=1000.0, clearance=0.5, stations=STATIONS).feasible
    monkeypatch.setattr(Stations, "solve", spoiled)
    plan = rw.optimise_supports(rig(), [support], payload=1000.0, clearance=0.5, stations=STATIONS)
    assert (plan.feasible, plan.limited_by, plan.station) == (False, "no equilibrium", 240.0)


def test_an_infeasible_corridor_is_a_result() -> None:
    plan = rw.optimise_supports(rig(), TREES[:1], payload=50_000.0, stations=STATIONS)
    assert not plan.feasible
    assert plan.limited_by in ("skyline tension", "clearance")
    assert plan.station in STATIONS


def test_a_free_range_and_bad_candidates() -> None:
    free = rw.support_range(200.0, 300.0, 50.0, (8.0,))
    assert [c.station for c in free] == [200.0, 250.0, 300.0]
    with pytest.raises(rw.InputError, match="lower station first"):
        rw.support_range(300.0, 200.0, 50.0, (8.0,))
    with pytest.raises(rw.InputError, match="outside the spars"):
        rw.optimise_supports(rig(), [rw.Candidate("far", station=700.0, heights=(8.0,))], payload=1.0)
    with pytest.raises(rw.InputError, match="no height"):
        rw.Candidate("stump", station=1.0, heights=())
    with pytest.raises(rw.InputError, match="same name"):
        rw.optimise_supports(rig(), [TREES[0], TREES[0]], payload=1.0)
    rejected: dict[str, object] = {"clearance": np.nan, "safety_factor": 0.0, "most": -1, "stations": []}
    for name, wrong in rejected.items():
        with pytest.raises(rw.InputError, match=name):
            rw.optimise_supports(rig(), TREES, payload=1.0, **{name: wrong})  # type: ignore[arg-type]


MAIN = rw.Rope(mass_per_length=0.73, axial_stiffness=8e6, breaking_load=120e3)
LINES: dict[str, dict[str, Any]] = {
    "ideal hold": {},
    "mainline": {"mainline": MAIN},
    "clamped": {"clamped": True},
    "haulback": {"mainline": MAIN, "haulback": MAIN, "haulback_tension": 8e3},
    "guyed": {"mainline": MAIN, "guyed": True},
}


def over(supports: list[rw.IntermediateSupport], how: dict[str, Any]) -> rw.SkylineRig:
    ropes = {name: rope for name, rope in how.items() if name not in ("clamped", "guyed")}
    tail: rw.TailSpar | rw.GuyedSpar = rw.TailSpar("tail", station=480.0, height=8.0)
    if "guyed" in how:
        low = rig().tailspar.at[2] - 8.0
        anchors = ((500.0, 15.0, low), (500.0, -15.0, low), (470.0, 20.0, low), (470.0, -20.0, low))
        guys = [rw.Guyline(f"g{i}", at=at, rope=rig().skyline, pretension=20e3) for i, at in enumerate(anchors)]
        tail = rw.GuyedSpar("tail", station=480.0, height=8.0, mass=300.0, guylines=guys)
    return rw.standing_skyline(
        rw.Profile.from_csv(CORRIDOR),
        headspar=rw.HeadSpar("head", station=0.0, height=15.0),
        supports=supports,
        tailspar=tail,
        skyline=rig().skyline,
        tension=70e3,
        carriage=rw.Carriage("carriage", mass=450.0, clamped="clamped" in how),
        **ropes,
    )


@pytest.mark.parametrize("how", LINES)
def test_a_moved_model_has_the_states_of_an_assembled_one(how: str) -> None:
    """The supports of a rig stand elsewhere; all outputs and places are those of its own model."""
    first, second = (
        rw.IntermediateSupport("a", station=150.0, height=9.0),
        rw.IntermediateSupport("b", station=300.0, height=12.0),
    )
    like = over([first, second], LINES[how])
    moved = over([replace(first, station=200.0, height=12.0), replace(second, station=380.0, height=8.0)], LINES[how])
    own, other = Stations(moved), Stations(moved, like=like)
    for station in (90.0, 290.0, 420.0):
        expected, found = own.solve(station, 1500.0), other.solve(station, 1500.0)
        assert found.held_by == expected.held_by
        assert found.at.model is not expected.at.model
        np.testing.assert_allclose(found.outputs, expected.outputs, rtol=1e-8, atol=1e-6)
        assert found.at.certificate([found.point]).failed is None


def test_trial_rigs_share_names_and_empty_spans() -> None:
    """Supports have the names of the first trial's; the skyline has the length that its own rig has."""
    rigs, sites = TrialRigs(rig()), [[tree.support(h) for h in tree.heights] for tree in TREES[:2]]
    rigs.prepare(sites)
    first, like = rigs.over([sites[0][0], sites[1][0]])
    assert first is like
    rigs.prepare(sites[1:])
    rigs.over([sites[0][1]])
    other, one = rigs.over([sites[1][2]])
    own = with_supports(rig(), [sites[1][2]])
    assert [s.name for s in other.supports] == [s.name for s in one.supports] == ["oak"]
    assert other.length == pytest.approx(own.length, rel=1e-13)
    np.testing.assert_array_equal(other.points, own.points)
    trial = SupportTrial(other, one, 1000.0, LoadLimits(3.0, clearance=0.0))
    assert trial.named("lift-off at oak", own) == "lift-off at fir"
    assert trial.named("clearance", own) == "clearance"
    assert trial.named("no equilibrium", own) == "no equilibrium"


def test_a_slack_trial_does_not_count() -> None:
    """5 kN do not hold the empty skyline over any of the trees."""
    slack = replace(rig(), tension=5e3)
    plan = rw.optimise_supports(slack, TREES, payload=1000.0, stations=STATIONS, most=1)
    assert (plan.feasible, plan.limited_by, plan.tried) == (False, "slack rope", 8)
