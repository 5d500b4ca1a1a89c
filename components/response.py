"""How a control sheave responds to the tensions on its two sides.

A response samples the tensions every `period` and sets a correction of the commanded speed, which takes effect after
`delay`. A faster sheave takes rope from the span before it and adds it to the span behind: the incoming tension rises,
the outgoing tension falls.

Chapters 4 and 5 of Turk's thesis (1988) compare response speeds, response magnitudes and precedences. Only their
headings are available: the rules here are our own.
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
from ropeway.components.component import Component
from ropeway.components.errors import InputError
from ropeway.components.schedule import Schedule
from ropeway.components.variable import Kind, Variable

PRECEDENCES = ("all at once", "upstream first", "downstream first", "worst first", "neighbours locked out")
"""Which sheaves may act if several request it at one sample: all; the first or the last along the rope; the one with
the largest deviation; those with a larger deviation than their neighbours."""


def check_precedence(precedence: str) -> None:
    """Raises InputError for an unknown precedence."""
    if precedence not in PRECEDENCES:
        raise InputError(f"precedence is {precedence!r}", f"Choose from {', '.join(map(repr, PRECEDENCES))}")


class Decision(NamedTuple):
    """Decision of a response at a sample.

    `wants`: 1 if it requests to act; `need`: its deviation, by which precedence is decided; `granted` and `refused`:
    values of its discrete variables, by name, if it may act and if not.
    """

    wants: Any
    need: Any
    granted: Mapping[str, Any]
    refused: Mapping[str, Any]


@checked
@dataclass(frozen=True, kw_only=True)
class Response(ABC):
    """Base class of responses.

    Parameters
    ----------
    period : float, default 1
        Time between samples [s].
    delay : float, default 0
        Time from a sample to its effect [s].
    limit : float, default 0.2
        Largest correction of the speed [m/s].
    """

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
        """Lowest and highest tension that it maintains [N]; None if it has no range."""
        return None

    @property
    def waiting(self) -> int:
        """Number of samples that wait to take effect."""
        return math.ceil(self.delay / self.period - 1e-9)

    @property
    def phase(self) -> float:
        """Time from a sample to the effect of the oldest waiting one [s]; 0 without delay."""
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
            Variable("response_target", dis, "m/s", "latest correction"),
            *(
                (
                    Variable(
                        "response_waiting",
                        dis,
                        "m/s",
                        "waiting corrections, the oldest first",
                        (0.0,) * queue,
                        size=queue,
                    ),
                )
                if queue
                else ()
            ),
        )

    @abstractmethod
    def decide(self, v: Any) -> Decision:
        """The rule on symbols: `v` has time, tension_in, tension_out and the variables."""

    def queued(self, v: Any, target: Any) -> dict[str, Any]:
        """Discrete variables after a decision, which takes effect at once or joins the queue."""
        if not self.waiting:
            return {"response_target": target, "correction": target}
        waiting = v.response_waiting
        queue = ca.vertcat(waiting[1:], target) if self.waiting > 1 else target
        return {"response_target": target, "response_waiting": queue}


def response_of(component: Component) -> Response | None:
    """The response of a component, its attribute `response`; None if it has none.

    Such a component has the variables of its response and the discrete variable `correction` [m/s].
    """
    found = getattr(component, "response", None)
    return found if isinstance(found, Response) else None


def _clean(correction: Any) -> Any:
    """A correction without the rounding error of a return to zero."""
    return ca.if_else(ca.fabs(correction) < 1e-12, 0.0, correction)


@checked
@dataclass(frozen=True, kw_only=True)
class ThresholdResponse(Response):
    """Keeps both tensions in a range: changes the speed in steps when one is outside.

    The side that is further outside the range decides. The rule integrates twice, as a step of speed is a rate of
    tension; only the return of the correction damps it. A long hold, or a large increment times delay, makes a line
    oscillate.

    Parameters
    ----------
    period : float, default 1
        Time between samples [s].
    delay : float, default 0
        Time from a sample to its effect [s].
    limit : float, default 0.2
        Largest correction of the speed [m/s].
    low, high : float
        Range of the tensions [N].
    increment : float
        Step of speed at each action [m/s].
    initiation : float, default 0
        Distance outside the range at which it acts [N]; negative: inside the range.
    hold : float, default 3
        Time within the range after which the correction returns, by one increment at each sample [s]. The return needs
        no precedence.

    Raises
    ------
    InputError
        A value out of its range, or an initiation that exceeds the range.

    Examples
    --------
    >>> rw.ThresholdResponse(low=44e3, high=66e3, increment=0.02, delay=1.0).hold
    3.0
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
                f"{owner}: initiation {self.initiation} N is larger than the range", "Choose it closer to zero"
            )

    @property
    def tension_range(self) -> tuple[float, float]:
        return self.low, self.high

    @property
    def structure(self) -> Hashable:
        """What determines the variables; see `form_of`."""
        return self.waiting

    def own_variables(self) -> tuple[Variable, ...]:
        par = Kind.PARAMETER
        return (
            Variable("response_low", par, "N", "low end of the tension range", self.low, 1e4, range=NOT_NEGATIVE),
            Variable("response_high", par, "N", "high end of the tension range", self.high, 1e4, range=POSITIVE),
            Variable(
                "response_increment", par, "m/s", "step of speed at an action", self.increment, 0.01, range=POSITIVE
            ),
            Variable(
                "response_initiation", par, "N", "distance outside the range at which it acts", self.initiation, 1e3
            ),
            Variable(
                "response_hold", par, "s", "time within the range before it returns", self.hold, range=NOT_NEGATIVE
            ),
            Variable("response_calm", Kind.DISCRETE, "s", "time within the range"),
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
            # A sheave at its limit cannot act and does not block others.
            outside * (moved != target),
            need,
            {**self.queued(v, moved), "response_calm": calm},
            {**self.queued(v, rest), "response_calm": calm},
        )


@checked
@dataclass(frozen=True, kw_only=True)
class ProportionalResponse(Response):
    """Corrects in proportion to the difference of the tensions, or to the deviation from a target.

    Parameters
    ----------
    period : float, default 1
        Time between samples [s].
    delay : float, default 0
        Time from a sample to its effect [s].
    limit : float, default 0.2
        Largest correction of the speed [m/s].
    gain : float
        Correction per tension [m/s per N].
    target : float, optional
        Target of the outgoing tension [N]; by default the incoming tension.
    difference : float or Schedule, default 0
        Outgoing minus incoming tension without a target [N]; a Schedule has it over time, with values in newtons.
    rate : float, default 0.05
        Largest rate of the correction [m/s2].

    Raises
    ------
    InputError
        A value out of its range, or both target and difference.

    Examples
    --------
    >>> rw.ProportionalResponse(gain=1e-5, limit=0.1).period
    1.0
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
        """What determines the form of the equations; see `form_of`."""
        planned = self.difference if isinstance(self.difference, Schedule) else None
        return (self.waiting, 0 if planned is None else len(planned.times))

    def own_variables(self) -> tuple[Variable, ...]:
        par, plan = Kind.PARAMETER, self.difference
        if isinstance(plan, Schedule):
            n = len(plan.times)
            aims: tuple[Variable, ...] = (
                Variable("response_times", par, "s", "times of the planned difference", plan.times, 1.0, n),
                Variable("response_planned", par, "N", "planned tension difference", plan.speeds, 1e3, n),
            )
        else:
            aim = plan if self.target is None else self.target
            aims = (
                Variable("response_aim", par, "N", "target of the tension, or of the tension difference", aim, 1e4),
            )
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
        demanded = ca.fmin(ca.fmax(v.response_gain * error, -v.response_limit), v.response_limit)
        step = v.response_rate * self.period
        move = ca.fmin(ca.fmax(demanded - v.response_target, -step), step)
        target = v.response_target
        return Decision(ca.fabs(move) > 1e-12, ca.fabs(error), self.queued(v, target + move), self.queued(v, target))


def _between(time: Any, times: Any, values: Any) -> Any:
    """A piecewise linear quantity at a time, constant before and after."""
    found = values[0]
    for k in range(times.numel() - 1):
        share = (time - times[k]) / (times[k + 1] - times[k])
        found = found + ca.fmin(ca.fmax(share, 0.0), 1.0) * (values[k + 1] - values[k])
    return found
