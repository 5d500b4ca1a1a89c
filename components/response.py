"""How a control sheave reacts to the tensions on its two sides.

A response samples the tensions every `period` and sets a correction to the commanded speed, which takes
effect `delay` later. Turning the sheave faster takes rope from the span before it and gives it to the span
behind: the tension coming in rises, the tension going out falls.

Turk's thesis (1988) compares response speeds, response magnitudes and precedences in chapters 4 and 5, of
which only the headings survive: the rules here are ours.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Hashable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import casadi as ca

from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.check import NOT_NEGATIVE, POSITIVE
from ropeway.components.component import Component, Kind, Variable
from ropeway.components.errors import InputError
from ropeway.components.schedule import Schedule

PRECEDENCES = ("all at once", "upstream first", "downstream first", "worst first", "neighbours locked out")
"""Who may act when several sheaves want to at one sample: all of them; the first or the last one along the
rope; the one with the greatest need; those with a greater need than their neighbours."""


def check_precedence(precedence: str) -> None:
    """Raises InputError for an unknown precedence."""
    if precedence not in PRECEDENCES:
        raise InputError(f"precedence is {precedence!r}", f"Choose from {', '.join(map(repr, PRECEDENCES))}")


class Decision(NamedTuple):
    """What a sheave wants at a sample: 1 if it wants to act, how much it needs to, and its discrete variables
    afterwards, by name, when it may and when it may not."""

    wants: Any
    need: Any
    granted: Mapping[str, Any]
    refused: Mapping[str, Any]


@checked
@dataclass(frozen=True, kw_only=True)
class Response(ABC):
    """period: between samples [s]; delay: from a sample to its effect [s]; limit: largest correction [m/s]."""

    period: float = 1.0
    delay: float = 0.0
    limit: float = 0.2

    def __post_init__(self) -> None:
        owner = type(self).__name__
        check.positive(self.period, owner, "period", "s")
        check.not_negative(self.delay, owner, "delay", "s")
        check.positive(self.limit, owner, "limit", "m/s")

    @property
    def tension_range(self) -> tuple[float, float] | None:
        """The lowest and the highest tension that it aims to keep [N]; None where it has no such range."""
        return None

    @property
    def waiting(self) -> int:
        """Samples that can be waiting to take effect."""
        return math.ceil(self.delay / self.period - 1e-9)

    @property
    def phase(self) -> float:
        """Time from a sample to when the oldest waiting one takes effect [s]; 0 without delay."""
        return self.delay - (self.waiting - 1) * self.period if self.waiting else 0.0

    @abstractmethod
    def own_variables(self) -> tuple[Variable, ...]:
        """Parameters and discrete variables of the rule."""

    def variables(self) -> tuple[Variable, ...]:
        """Variables that the response adds to its sheave."""
        dis, queue = Kind.DISCRETE, self.waiting
        return (
            Variable("response_limit", Kind.PARAMETER, "m/s", "largest correction", self.limit, range=POSITIVE),
            *self.own_variables(),
            Variable("response_target", dis, "m/s", "correction decided on"),
            *(
                (Variable("response_waiting", dis, "m/s", "decided, the oldest first", (0.0,) * queue, size=queue),)
                if queue
                else ()
            ),
        )

    @abstractmethod
    def decide(self, v: Any) -> Decision:
        """The rule on symbols: `v` has time, tension_in, tension_out and the variables."""

    def queued(self, v: Any, target: Any) -> dict[str, Any]:
        """Discrete variables after a decision: at once, or behind those that wait."""
        if not self.waiting:
            return {"response_target": target, "correction": target}
        waiting = v.response_waiting
        queue = ca.vertcat(waiting[1:], target) if self.waiting > 1 else target
        return {"response_target": target, "response_waiting": queue}


def response_of(component: Component) -> Response | None:
    """The response of a component, its attribute `response`; None where it has none. Such a component has the variables
    of its response and the discrete variable `correction` [m/s]."""
    found = getattr(component, "response", None)
    return found if isinstance(found, Response) else None


def _clean(correction: Any) -> Any:
    """Without what rounding leaves of a correction that has gone back to zero."""
    return ca.if_else(ca.fabs(correction) < 1e-12, 0.0, correction)


@checked
@dataclass(frozen=True, kw_only=True)
class ThresholdResponse(Response):
    """Keeps both tensions in a range: acts by steps when one leaves it.

    low, high: tension range [N]; increment: of speed at each action [m/s] (response magnitude); period,
    delay: response speed; initiation: how far outside the range it begins to act [N], below zero how near
    the limit already; hold: time without need after which the correction goes back, by one increment a
    sample [s]; this needs no turn. Whichever side is further outside decides.

    The rule integrates twice, as a step of speed is a rate of tension: only going back damps it. A long hold,
    or a large increment times delay, makes a line swing. Raises InputError.
    """

    low: float
    high: float
    increment: float
    initiation: float = 0.0
    hold: float = 3.0

    def __post_init__(self) -> None:
        super().__post_init__()
        owner = "ThresholdResponse"
        check.not_negative(self.low, owner, "low", "N")
        check.positive(self.high, owner, "high", "N")
        check.positive(self.increment, owner, "increment", "m/s")
        check.number(self.initiation, owner, "initiation", "N")
        check.not_negative(self.hold, owner, "hold", "s")
        if self.low >= self.high:
            raise InputError(f"{owner}: low is {self.low} N, high is {self.high} N", "Give low below high")
        if self.low - self.initiation >= self.high + self.initiation:
            raise InputError(
                f"{owner}: initiation {self.initiation} N leaves nothing of the range", "Choose it nearer to zero"
            )

    @property
    def tension_range(self) -> tuple[float, float]:
        return self.low, self.high

    @property
    def structure(self) -> Hashable:
        """What shapes the variables; see `form_of`."""
        return self.waiting

    def own_variables(self) -> tuple[Variable, ...]:
        par = Kind.PARAMETER
        return (
            Variable("response_low", par, "N", "low end of the tension range", self.low, 1e4, range=NOT_NEGATIVE),
            Variable("response_high", par, "N", "high end of the tension range", self.high, 1e4, range=POSITIVE),
            Variable(
                "response_increment", par, "m/s", "step of speed at an action", self.increment, 0.01, range=POSITIVE
            ),
            Variable("response_initiation", par, "N", "how far outside the range it acts", self.initiation, 1e3),
            Variable("response_hold", par, "s", "time without need before it goes back", self.hold, range=NOT_NEGATIVE),
            Variable("response_calm", Kind.DISCRETE, "s", "time without need"),
        )

    def decide(self, v: Any) -> Decision:
        faster = ca.fmax(v.tension_out - v.response_high, v.response_low - v.tension_in)
        slower = ca.fmax(v.tension_in - v.response_high, v.response_low - v.tension_out)
        need = ca.fmax(faster, slower) - v.response_initiation
        outside = need > 0.0
        step = ca.if_else(faster >= slower, v.response_increment, -v.response_increment)
        target = v.response_target
        moved = ca.fmin(ca.fmax(_clean(target + step), -v.response_limit), v.response_limit)
        calm = ca.if_else(outside, 0.0, v.response_calm + self.period)
        back = _clean(ca.sign(target) * ca.fmax(ca.fabs(target) - v.response_increment, 0.0))
        rest = ca.if_else(outside, target, ca.if_else(calm >= v.response_hold, back, target))
        return Decision(
            # One at its limit has nothing left to do, and leaves the turn to others.
            outside * (moved != target),
            need,
            {**self.queued(v, moved), "response_calm": calm},
            {**self.queued(v, rest), "response_calm": calm},
        )


@checked
@dataclass(frozen=True, kw_only=True)
class ProportionalResponse(Response):
    """Corrects in proportion to the tension going out less that coming in, or less a target.

    gain [m/s per N]; target of the tension going out [N], None: the tension coming in; difference: what the tension
    going out is to be above the one coming in where there is no target [N], as a Schedule whose values are newtons
    when it is planned in advance; limit and rate of the correction [m/s, m/s2]. Raises InputError.
    """

    gain: float
    target: float | None = None
    difference: float | Schedule = 0.0
    rate: float = 0.05

    def __post_init__(self) -> None:
        super().__post_init__()
        owner = "ProportionalResponse"
        check.positive(self.gain, owner, "gain", "m/s per N")
        check.positive(self.rate, owner, "rate", "m/s2")
        if not isinstance(self.difference, Schedule):
            check.number(self.difference, owner, "difference", "N")
        if self.target is not None:
            check.positive(self.target, owner, "target", "N")
            if self.difference != 0.0:
                raise InputError(f"{owner} has a target and a difference", "Give one of them")

    @property
    def structure(self) -> Hashable:
        planned = self.difference if isinstance(self.difference, Schedule) else None
        return (self.waiting, 0 if planned is None else len(planned.times))

    def own_variables(self) -> tuple[Variable, ...]:
        par, plan = Kind.PARAMETER, self.difference
        if isinstance(plan, Schedule):
            n = len(plan.times)
            aims: tuple[Variable, ...] = (
                Variable("response_times", par, "s", "times of the planned difference", plan.times, 1.0, n),
                Variable("response_planned", par, "N", "planned difference of tension", plan.speeds, 1e3, n),
            )
        else:
            aim = plan if self.target is None else self.target
            aims = (Variable("response_aim", par, "N", "tension, or difference of tension, aimed at", aim, 1e4),)
        return (
            Variable("response_gain", par, "m/(N.s)", "correction per tension", self.gain, 1e-5, range=POSITIVE),
            *aims,
            Variable("response_rate", par, "m/s2", "largest rate of the correction", self.rate, 0.01, range=POSITIVE),
        )

    def decide(self, v: Any) -> Decision:
        if isinstance(self.difference, Schedule):
            aim = _between(v.time, v.response_times, v.response_planned)
        else:
            aim = v.response_aim
        error = v.tension_out - (v.tension_in if self.target is None else 0.0) - aim
        wish = ca.fmin(ca.fmax(v.response_gain * error, -v.response_limit), v.response_limit)
        step = v.response_rate * self.period
        move = ca.fmin(ca.fmax(wish - v.response_target, -step), step)
        target = v.response_target
        return Decision(ca.fabs(move) > 1e-12, ca.fabs(error), self.queued(v, target + move), self.queued(v, target))


def _between(time: Any, times: Any, values: Any) -> Any:
    """A piecewise linear quantity at a time, constant before and after."""
    found = values[0]
    for k in range(times.numel() - 1):
        share = (time - times[k]) / (times[k + 1] - times[k])
        found = found + ca.fmin(ca.fmax(share, 0.0), 1.0) * (values[k + 1] - values[k])
    return found
