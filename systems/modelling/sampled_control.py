"""Clocks: decisions of control sheaves at samples, and their delayed effects.

Every update is a CasADi function of the model's vectors, so an exported model can contain it.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import casadi as ca
import numpy as np

from ropeway.components.response import Response, response_of
from ropeway.components.variable import Kind
from ropeway.systems.modelling.rope_path import Run

Precedence = Callable[[str], tuple[str, str]]
"""Function of a component's name: its subsystem, and the precedence rule there."""


Rivals = tuple[tuple[int, bool], ...]
"""The responses that go before one: number, and whether by the larger need, else always."""


@dataclass(frozen=True, eq=False)
class Clock:
    """Ticks at `phase`, `phase + period`, ... [s]. `update(t, x, z, u, p, d)` gives new values of the `entries` of the
    discrete vector. `corrections` maps the entries that change the line's motion to their sheaves. `members`: the
    sheaves that decide, with the `rivals` of each, or, without rivals, those whose waiting corrections take effect."""

    period: float
    phase: float
    update: ca.Function
    entries: np.ndarray
    corrections: Mapping[int, str]
    members: tuple[str, ...]
    rivals: tuple[Rivals, ...] = ()


def clocks(
    responses: Mapping[str, Response],
    precedence_of: Precedence,
    outputs: ca.Function,
    index: Mapping[Kind, Mapping[str, int]],
) -> tuple[Clock, ...]:
    """The clocks of responses, in the order of their components on the rope. Delayed effects precede samples at the
    same time. `precedence_of` gives the subsystem of a sheave and its precedence rule, `index` the position of each
    variable in its vector."""
    by_period: dict[float, dict[str, Response]] = defaultdict(dict)
    by_effect: dict[tuple[float, float], dict[str, Response]] = defaultdict(dict)
    for name, response in responses.items():
        by_period[response.period][name] = response
        if response.waiting:
            by_effect[response.period, response.phase][name] = response
    point = [ca.MX.sym(name, *outputs.size_in(i)) for i, name in enumerate(("t", "x", "z", "u", "p", "d"))]
    effects = [_effect(period, phase, group, point, index) for (period, phase), group in sorted(by_effect.items())]
    samples = [
        _sample(period, group, precedence_of, point, outputs(*point), index)
        for period, group in sorted(by_period.items())
    ]
    return (*effects, *samples)


def responses_of(runs: Sequence[Run]) -> dict[str, Response]:
    """The responses along the ropes by the name of their component, without repetition."""
    found = ((node.name, response_of(node)) for run in runs for node in run.nodes)
    return {name: response for name, response in found if response is not None}


def _sample(
    period: float,
    group: Mapping[str, Response],
    precedence_of: Precedence,
    point: Sequence[ca.MX],
    y: ca.MX,
    index: Any,
) -> Clock:
    """The clock of one period: all responses decide, and those with permission act."""
    decisions = {}
    for name, response in group.items():
        function, variables = rule_of(response)
        values = [_read(f"{name}.{variable}", point, y, index) for variable, _ in variables.inputs]
        decisions[name] = variables, function.call(values)
    rivals = _rivals([precedence_of(name) for name in group])
    grants = _grants(rivals, *([results[i] for _, results in decisions.values()] for i in (0, 1)))
    entries, values, corrections = [], [], {}
    for (name, (variables, results)), grant in zip(decisions.items(), grants, strict=True):
        count = len(variables.outputs)
        for i, (variable, size) in enumerate(variables.outputs):
            values.append(ca.if_else(grant, results[2 + i], results[2 + count + i]))
            places = discrete_places(f"{name}.{variable}", size, index[Kind.DISCRETE])
            entries += places
            if variable == "correction":
                corrections[places[0]] = name
    update = ca.Function("sample", list(point), [ca.vertcat(*values)])
    return Clock(period, period, update, np.array(entries), corrections, tuple(group), rivals)


def _rivals(lines: Sequence[tuple[str, str]]) -> tuple[Rivals, ...]:
    """The rivals of each response, from the subsystem and the precedence rule of each. Only those of one subsystem
    are rivals."""
    found = []
    for k, line in enumerate(lines):
        own = [j for j, other in enumerate(lines) if other == line]
        place = own.index(k)
        rivals = {
            "upstream first": [(j, False) for j in own[:place]],
            "downstream first": [(j, False) for j in own[place + 1 :]],
            "worst first": [(j, True) for j in own if j != k],
            "neighbours locked out": [(j, True) for j in (*own[:place][-1:], *own[place + 1 :][:1])],
        }
        found.append(tuple(rivals.get(line[1], [])))
    return tuple(found)


def _grants(rivals: Sequence[Rivals], wants: Sequence[ca.MX], needs: Sequence[ca.MX]) -> list[ca.MX]:
    """Permissions of the sheaves that want to act. The first on the rope wins a tie of needs."""
    need, grants = [ca.if_else(w, r, -1e30) for w, r in zip(wants, needs, strict=True)], []
    for k, own in enumerate(rivals):
        grant = wants[k]
        for j, by_need in own:
            larger = need[k] >= need[j] if k < j else need[k] > need[j]
            grant = grant * (larger if by_need else 1 - wants[j])
        grants.append(grant)
    return grants


@dataclass(frozen=True)
class RuleVariables:
    """Variables (name, size) that a rule reads and sets."""

    inputs: tuple[tuple[str, int], ...]
    outputs: tuple[tuple[str, int], ...]


def rule_of(response: Response) -> tuple[ca.Function, RuleVariables]:
    """A response's rule as a function: inputs -> wants, need, values if granted..., values if refused..."""
    inputs = (("time", 1), ("tension_in", 1), ("tension_out", 1), *((v.name, v.size) for v in response.variables()))
    symbols = [ca.SX.sym(name, size) for name, size in inputs]
    decision = response.decide(SimpleNamespace(**dict(zip((n for n, _ in inputs), symbols, strict=True))))
    outputs = tuple((name, ca.SX(value).numel()) for name, value in decision.granted.items())
    results = [
        decision.wants,
        decision.need,
        *(decision.granted[name] for name, _ in outputs),
        *(decision.refused[name] for name, _ in outputs),
    ]
    return ca.Function("rule", symbols, results), RuleVariables(inputs, outputs)


def _effect(period: float, phase: float, group: Mapping[str, Response], point: Sequence[ca.MX], index: Any) -> Clock:
    """The clock of a delay: the oldest queued decision of each response becomes its correction."""
    entries, values, corrections = [], [], {}
    for name, response in group.items():
        oldest = discrete_places(f"{name}.response_waiting", response.waiting, index[Kind.DISCRETE])[0]
        entry = index[Kind.DISCRETE][f"{name}.correction"]
        entries.append(entry)
        corrections[entry] = name
        values.append(point[5][oldest])
    # The queue is empty before the first sample; the first effect is one phase after it.
    return Clock(
        period,
        period + phase,
        ca.Function("effect", list(point), [ca.vertcat(*values)]),
        np.array(entries),
        corrections,
        tuple(group),
    )


def discrete_places(name: str, size: int, index: Mapping[str, int]) -> list[int]:
    """Places of a variable in its vector."""
    if name in index:
        return [index[name]]
    return [index[f"{name}[{i + 1}]"] for i in range(size)]


def _read(name: str, point: Sequence[ca.MX], y: ca.MX, index: Any) -> ca.MX:
    if name.endswith(".time"):
        return point[0]
    for kind, vector in ((Kind.OUTPUT, y), (Kind.PARAMETER, point[4]), (Kind.DISCRETE, point[5])):
        if name in index[kind]:
            return vector[index[kind][name]]
        if f"{name}[1]" in index[kind]:
            size = sum(1 for n in index[kind] if n.startswith(f"{name}["))
            return vector[discrete_places(name, size, index[kind])]
    raise KeyError(name)
