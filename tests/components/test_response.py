"""Responses by themselves, and what they refuse."""

from types import SimpleNamespace

import casadi as ca
import pytest

import ropeway as rw
from ropeway.components.response import Response


def decide(response: Response, tension_in: float, tension_out: float, **state: float) -> tuple[bool, float, float]:
    """Wants to act, target when granted, target when refused."""
    values = {v.name: v.value for v in response.variables()}
    values.update(state, tension_in=tension_in, tension_out=tension_out)
    decision = response.decide(SimpleNamespace(**{k: ca.DM(v) for k, v in values.items()}))
    return (
        bool(decision.wants),
        float(decision.granted["response_target"]),
        float(decision.refused["response_target"]),
    )


RULE = rw.ThresholdResponse(low=40e3, high=60e3, increment=0.01, hold=2.0, limit=0.05)


@pytest.mark.parametrize(
    ("tension_in", "tension_out", "step"),
    [(50e3, 65e3, 0.01), (65e3, 50e3, -0.01), (35e3, 50e3, 0.01), (50e3, 35e3, -0.01), (70e3, 62e3, -0.01)],
)
def test_threshold_acts_on_the_worse_side(tension_in: float, tension_out: float, step: float) -> None:
    wants, granted, refused = decide(RULE, tension_in, tension_out)
    assert wants
    assert granted == pytest.approx(step)
    assert refused == 0.0


def test_threshold_rests_inside_and_goes_back_after_the_hold() -> None:
    assert decide(RULE, 50e3, 55e3) == (False, 0.0 + 0.01, 0.0)
    _, _, early = decide(RULE, 50e3, 55e3, response_target=0.03, response_calm=0.0)
    _, _, late = decide(RULE, 50e3, 55e3, response_target=0.03, response_calm=1.0)
    assert early == pytest.approx(0.03)
    assert late == pytest.approx(0.02)


def test_threshold_is_limited_and_initiation_moves_the_edge() -> None:
    assert decide(RULE, 50e3, 80e3, response_target=0.05)[1] == pytest.approx(0.05)
    eager = rw.ThresholdResponse(low=40e3, high=60e3, increment=0.01, initiation=-2e3)
    lazy = rw.ThresholdResponse(low=40e3, high=60e3, increment=0.01, initiation=2e3)
    assert decide(eager, 50e3, 59e3)[0]
    assert not decide(lazy, 50e3, 61e3)[0]


def test_proportional_is_limited_in_size_and_rate() -> None:
    rule = rw.ProportionalResponse(gain=1e-5, limit=0.1, rate=0.02, period=1.0)
    assert decide(rule, 50e3, 51e3)[1] == pytest.approx(0.01)
    assert decide(rule, 50e3, 90e3)[1] == pytest.approx(0.02)
    assert decide(rule, 50e3, 90e3, response_target=0.095)[1] == pytest.approx(0.1)
    aimed = rw.ProportionalResponse(gain=1e-6, target=55e3)
    assert decide(aimed, 10e3, 60e3)[1] == pytest.approx(0.005)


def test_proportional_follows_a_planned_difference() -> None:
    planned = rw.Schedule((0.0, 10.0, 20.0), (0.0, 1e3, -1e3))
    rule = rw.ProportionalResponse(gain=1e-5, difference=planned)
    for time, difference in ((-1.0, 0.0), (5.0, 500.0), (10.0, 1e3), (12.5, 500.0), (30.0, -1e3)):
        assert decide(rule, 50e3, 50.2e3, time=time)[1] == pytest.approx(1e-5 * (200.0 - difference))
    assert decide(rw.ProportionalResponse(gain=1e-5, difference=150.0), 50e3, 50.2e3)[1] == pytest.approx(5e-4)
    with pytest.raises(rw.InputError, match="a target and a difference"):
        rw.ProportionalResponse(gain=1e-5, target=50e3, difference=planned)


def test_delay_waits_in_a_queue() -> None:
    rule = rw.ThresholdResponse(low=40e3, high=60e3, increment=0.01, period=2.0, delay=5.0)
    assert rule.waiting == 3
    assert rule.phase == pytest.approx(1.0)
    assert rw.ThresholdResponse(low=1.0, high=2.0, increment=0.01, period=2.0, delay=4.0).phase == pytest.approx(2.0)


@pytest.mark.parametrize(
    ("values", "word"),
    [
        ({"low": 60e3, "high": 40e3}, "low"),
        ({"period": 0.0}, "period"),
        ({"increment": 0.0}, "increment"),
        ({"increment": -0.1}, "increment"),
        ({"delay": -1.0}, "delay"),
        ({"hold": -1.0}, "hold"),
        ({"limit": 0.0}, "limit"),
        ({"initiation": -10.1e3}, "initiation"),
        ({"high": float("nan")}, "high"),
    ],
)
def test_impossible_thresholds(values: dict[str, float], word: str) -> None:
    with pytest.raises(rw.InputError, match=word) as error:
        rw.ThresholdResponse(**{"low": 40e3, "high": 60e3, "increment": 0.01, **values})
    assert error.value.remedy


@pytest.mark.parametrize(
    ("values", "word"), [({"gain": 0.0}, "gain"), ({"rate": 0.0}, "rate"), ({"target": -1.0}, "target")]
)
def test_impossible_proportional(values: dict[str, float], word: str) -> None:
    with pytest.raises(rw.InputError, match=word):
        rw.ProportionalResponse(**{"gain": 1e-6, **values})


def test_unknown_precedence() -> None:
    with pytest.raises(rw.InputError, match="precedence is 'fastest first'"):
        rw.System("s", precedence="fastest first")
