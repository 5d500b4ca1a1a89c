"""Payloads at discontinuities of a rig's state: the result is on the inner side and names the limit of the outer
side."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

import ropeway as rw
from ropeway.systems.studies.skyline.limits import LoadLimits
from ropeway.systems.studies.skyline.payload.search import PayloadSearch, Trial, _guess
from ropeway.systems.studies.skyline.root_selection import Effort
from ropeway.systems.studies.skyline.station_solver import Stations
from support.random_rigs import Drawn, drawn
from support.rig_verdicts import Verdict, judge_curve, path_row


def _case(seed: int, i: int) -> Drawn:
    case = drawn(np.random.default_rng([seed, i]))
    assert case is not None
    return case


@pytest.mark.parametrize(("seed", "i", "station"), [(1013, 142, 257.55), (1024, 211, 295.29), (1024, 120, 147.87)])
def test_payload_is_within_its_limit_at_the_change_from_clamp_to_mainline(seed: int, i: int, station: float) -> None:
    """The log's front drops by decimetres when the mainline instead of the clamp holds the carriage."""
    case = _case(seed, i)
    (found,) = rw.payload(case.rig, clearance=case.clearance, stations=[station]).frame.to_dict("records")
    assert found["limited_by"] == "clearance"
    inner, outer = (path_row(case.rig, found["payload"] * share, station) for share in (1.0, 1.0001))
    assert (inner["held_by"], outer["held_by"]) == ("clamp", "mainline")
    assert outer["front_clearance"] < case.clearance <= inner["front_clearance"]
    assert found["front_clearance"] == pytest.approx(inner["front_clearance"], abs=1e-9)


def test_carriage_is_raised_over_a_gap_in_height() -> None:
    """The skyline clears the ground if raised by 4 cm; raised by 1 m it lifts off its support even with an empty
    carriage."""
    case = _case(1024, 154)

    def at(clearance: float) -> dict[str, object]:
        return rw.payload(case.rig, clearance=clearance, stations=[243.2]).frame.to_dict("records")[0]

    found = at(case.clearance)
    assert found["limited_by"] == "rope clearance"
    assert found["rope_clearance"] == pytest.approx(0.0, abs=1e-5)
    assert found["payload"] == pytest.approx(at(float(found["clearance"]))["payload"], rel=1e-6)
    assert found["payload"] > 350.0
    assert at(2.0)["payload"] == 0.0


def test_payload_near_a_shoe_ends_without_a_certified_state() -> None:
    """Heavier payloads press the carriage against the steep flank of the shoe, where the rope from above would leave it
    backwards."""
    case = _case(1013, 266)
    (found,) = rw.payload(case.rig, clearance=case.clearance, stations=[238.97957]).frame.to_dict("records")
    assert found["limited_by"] == "no equilibrium"
    assert path_row(case.rig, found["payload"], 238.97957)["held_by"] == "clamp"
    with pytest.raises(rw.EquilibriumError, match="at station 238"):
        rw.load_path(case.rig, found["payload"] * 1.002, [238.97957])


def test_the_campaign_finds_a_payload_of_nothing_between_two_others(monkeypatch: pytest.MonkeyPatch) -> None:
    case, solve = _case(1024, 154), rw.payload

    def broken(*arguments: object, **more: object) -> SimpleNamespace:
        frame = solve(*arguments, **more).frame
        frame.loc[[4, 5, 6], "payload"] = [60.0, 0.0, 60.0]
        return SimpleNamespace(frame=frame)

    first, found = float(case.rig.points[0, 0]) + 40.0, Verdict()
    monkeypatch.setattr(rw, "payload", broken)
    judge_curve(found, case, first)
    assert ("zero", first + 5.0, [60.0, 0.0, 60.0]) in [fault[:3] for fault in found.faults]


def test_equal_margins_say_nothing_of_where_a_limit_is_reached() -> None:
    """Two payloads with the same margin used to divide by zero."""
    tried = {0.0: 0.5, 1000.0: 0.5, 4000.0: 0.2, 16000.0: -1.0}
    trials = {mass: Trial("pull", margin=margin, margins={"pull": margin}) for mass, margin in tried.items()}
    assert 4000.0 < _guess(trials, 4000.0, 16000.0) < 16000.0


def test_the_tension_of_a_guyline_is_that_which_its_limit_sees() -> None:
    """An anchor up a slope is above the top of the spar: the guyline's tension is highest there."""
    guys = [
        rw.Guyline("up", at=(-60.0, 0.0, 40.0), rope="compacted skyline 22", pretension=20e3),
        rw.Guyline("left", at=(20.0, 30.0, 0.0), rope="compacted skyline 22", pretension=20e3),
        rw.Guyline("right", at=(20.0, -30.0, 0.0), rope="compacted skyline 22", pretension=20e3),
    ]
    rig = rw.standing_skyline(
        None,
        skyline="compacted skyline 22",
        headspar=rw.GuyedSpar("head", foot=(0.0, 0.0), height=12.0, guylines=guys),
        tailspar=rw.TailSpar("tail", at=(300.0, -40.0)),
        length=307.0,
        carriage=rw.Carriage("car", mass=400.0),
    )
    found = rw.payload(rig, safety_factor=5.0, stations=[140.0], clearance=None).frame.iloc[0]
    solved = Stations(rig).solve(140.0, float(found.payload))
    ends = [solved[f"up_head.tension_{end}"] for end in "ab"]
    assert found.up_tension == pytest.approx(max(ends), rel=1e-9)
    assert ends[0] > ends[1]  # the end at the anchor


def test_a_search_ends_where_quick_trials_find_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """The empty carriage hangs, and light payloads do after a full search: the bracket closed onto zero, and grew from
    there without end."""

    def tried(self: PayloadSearch, station: float, mass: float, height: object, effort: Effort = Effort.FULL) -> Trial:
        hangs = mass == 0.0 or (effort is Effort.FULL and mass < 400.0)
        return (
            Trial("clearance", cast(Any, SimpleNamespace(held_by="mainline")), 1.0)
            if hangs
            else Trial("no equilibrium")
        )

    rig = _case(1024, 154).rig
    monkeypatch.setattr(PayloadSearch, "_try", tried)
    row = PayloadSearch(rig, LoadLimits(safety_factor=3.0, clearance=None))._largest(100.0, None)
    assert 0.0 < row[0] < 400.0
    assert row[1].limit == "no equilibrium"
