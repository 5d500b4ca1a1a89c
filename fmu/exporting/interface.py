"""Variables of an FMU, with value references, causalities and dependencies."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ropeway.components.errors import InputError, UnknownNameError
from ropeway.components.schedule import Schedule
from ropeway.fmu.exporting.equations import Dependencies, ModelEquations
from ropeway.systems.modelling.dae_model import nearest
from ropeway.systems.modelling.model_tables import VariableTable


@dataclass(frozen=True)
class FmuVariable:
    """A variable of an exported FMU.

    `knowns`: bit mask of its dependencies (see `Dependencies`); `state`: of a derivative, the name of its state.
    """

    name: str
    reference: int
    kind: str  # Real, Integer, Boolean
    causality: str
    variability: str
    description: str
    unit: str = "1"
    initial: str | None = None
    start: float | bool | None = None
    nominal: float | None = None
    state: str | None = None
    knowns: int = 0


@dataclass(frozen=True)
class References:
    """First value reference of each group of variables, as in ropeway_instance.c."""

    x: int
    dx: int
    z: int
    u: int
    p: int
    mass: int
    y: int
    indicator: int
    limit: int
    passed: int
    switch: int
    stop: int
    end: int


class Interface:
    """The variables of an FMU.

    `inputs`, `outputs`, `parameters`: their names; None: all inputs without a Schedule; all outputs, states, travels
    and coordinates; all parameters and load masses. `stops`: an emergency stop is an input too. Switches (`c1.brake`,
    `c1.pressure_lost`) can be inputs: Booleans.
    Raises InputError, UnknownNameError.
    """

    def __init__(
        self,
        equations: ModelEquations,
        inputs: Sequence[str] | None,
        outputs: Sequence[str] | None,
        parameters: Sequence[str] | None,
        *,
        stops: bool = False,
    ) -> None:
        m = equations.model
        self.equations, self.stops = equations, stops
        if stops and not equations.commanded:
            raise InputError(f"{m.name!r} has no drive with a commanded speed", "Omit emergency_stop")
        self.supports = [(r, k) for r, run in enumerate(equations.state.runs) for k in range(len(run.nodes))]
        sizes = [1, len(m.x), len(m.x), len(m.z), len(m.u), len(m.p), len(equations.masses), len(m.y)]
        sizes += [len(self.supports) + len(m.limits.output) + equations.borders]
        sizes += [len(m.limits.output), len(self.supports)]
        sizes += [len(equations.switches), int(stops)]
        self.first = References(*(int(n) for n in np.cumsum(sizes)))
        self.mass_names = [name for names in equations.mass_names for name in names]
        self.limit_names = [_limit_name(c, e) for c, e in zip(m.limits.components, m.limits.events, strict=True)]
        self.passed_names = self._passed_names()
        self.inputs = self._inputs(inputs)
        self.outputs = self._outputs(outputs)
        self.parameters = self._parameters(parameters)

    def _inputs(self, names: Sequence[str] | None) -> tuple[str, ...]:
        m = self.equations.model
        own = [n for i, n in enumerate(m.u.names) if i not in self.equations.followed]
        chosen = [n for n in own if not isinstance(m.signals[m.u.index[n]], Schedule)]
        if names is not None:
            chosen = _known(names, (*own, *self.equations.switches), "an input")
        for name, signal in zip(m.u.names, m.signals, strict=True):
            if signal is None and name not in chosen:
                raise InputError(f"Input {name!r} is open and not an input of the FMU", "Add it to inputs")
        return tuple(chosen)

    def _outputs(self, names: Sequence[str] | None) -> tuple[str, ...]:
        m = self.equations.model
        local = frozenset() if self.equations.corridor is None else self.equations.corridor.united.local
        everywhere = [n for n in m.z.names if n not in local]
        places = [n for n, unit in zip(m.z.names, m.z.units, strict=True) if unit == "m" and n not in local]
        discrete = [*self.limit_names, *self.passed_names.values()]
        if names is None:
            return (*(n for n in m.y.names if n not in m.y.hidden), *m.x.names, *places, *discrete)
        return tuple(_known(names, (*m.y.names, *everywhere, *m.x.names, *discrete), "an output"))

    def _parameters(self, names: Sequence[str] | None) -> tuple[str, ...]:
        every = (*self.equations.model.p.names, *self.mass_names)
        return every if names is None else tuple(_known(names, every, "a parameter"))

    def _passed_names(self) -> dict[int, str]:
        """Names of the counts of passed loads, for supports that loads can pass."""
        names: dict[int, str] = {}
        for i, (r, k) in enumerate(self.supports):
            run, layout = self.equations.state.runs[r], self.equations.model.layouts[r]
            moves = layout.travel.state[k] >= 0 or layout.travel.algebraic[k] >= 0
            name = f"{run.nodes[k].name}.loads_passed"
            if moves and len(run.loads.place) and name not in names.values():
                names[i] = name
        return names

    @cached_property
    def variables(self) -> tuple[FmuVariable, ...]:
        """All variables, in the order of their value references."""
        return (
            FmuVariable("time", 0, "Real", "independent", "continuous", "time", "s"),
            *self._states(),
            *self._algebraic(),
            *self._given(),
            *self._results(),
            *self._indicators(),
            *self._discrete(),
        )

    @cached_property
    def _dependencies(self) -> Dependencies:
        return Dependencies(self.equations)

    def _states(self) -> list[FmuVariable]:
        m, start, first, masks = self.equations.model, self.equations.state.point.x, self.first, self._dependencies
        states, rates = [], []
        for i, v in enumerate(_rows(m.x)):
            causality = "output" if v.name in self.outputs else "local"
            states.append(
                replace(
                    v,
                    reference=first.x + i,
                    causality=causality,
                    initial="exact",
                    start=float(start[i]),
                    knowns=1 << i,
                )
            )
            rates.append(
                replace(
                    v,
                    name=f"der({v.name})",
                    reference=first.dx + i,
                    unit=_rate_unit(v.unit),
                    description=f"rate of {v.name}",
                    initial="calculated",
                    nominal=None,
                    state=v.name,
                    knowns=masks.rates[i],
                )
            )
        return [*states, *rates]

    def _algebraic(self) -> list[FmuVariable]:
        return [
            replace(v, reference=self.first.z + i, causality="output", initial="calculated", knowns=mask)
            for i, (v, mask) in enumerate(zip(_rows(self.equations.model.z), self._dependencies.z, strict=True))
            if v.name in self.outputs
        ]

    def _given(self) -> list[FmuVariable]:
        m, point, first = self.equations.model, self.equations.state.point, self.first
        inputs = [
            replace(
                v,
                reference=first.u + i,
                causality="input",
                start=float(point.u[i]),
                description=v.description if signal is not None else f"{v.description} (open: requires a value)",
            )
            for i, (v, signal) in enumerate(zip(_rows(m.u), m.signals, strict=True))
            if v.name in self.inputs
        ]
        known = FmuVariable("", -1, "Real", "parameter", "tunable", "mass of the load", "kg", initial="exact")
        parameters = [
            replace(
                known,
                name=v.name,
                reference=first.p + i,
                description=v.description,
                unit=v.unit,
                nominal=v.nominal,
                start=float(point.p[i]),
                variability="tunable" if self.is_tunable(v.name) else "fixed",
            )
            for i, v in enumerate(_rows(m.p))
            if v.name in self.parameters
        ]
        masses = [
            replace(known, name=name, reference=first.mass + i, start=float(mass))
            for i, (name, mass) in enumerate(zip(self.mass_names, self.equations.masses, strict=True))
            if name in self.parameters
        ]
        return [*inputs, *parameters, *masses]

    def is_tunable(self, parameter: str) -> bool:
        """Whether a parameter may change during a run: all but the unstretched lengths, which place the loads."""
        m = self.equations.model
        i = m.p.index.get(parameter)
        return i is None or not any(i in layout.length_start for layout in m.layouts)

    def _results(self) -> list[FmuVariable]:
        return [
            replace(v, reference=self.first.y + i, causality="output", initial="calculated", knowns=mask)
            for i, (v, mask) in enumerate(zip(_rows(self.equations.model.y), self._dependencies.outputs, strict=True))
            if v.name in self.outputs
        ]

    def travel_of(self, support: int) -> int:
        """Index of a support's travel in (x, z), -1 if it has none."""
        r, k = self.supports[support]
        travel = self.equations.model.layouts[r].travel
        if travel.state[k] >= 0:
            return int(travel.state[k])
        return len(self.equations.model.x) + int(travel.algebraic[k]) if travel.algebraic[k] >= 0 else -1

    def _travel_mask(self, support: int) -> int:
        place, nx = self.travel_of(support), len(self.equations.model.x)
        if place < 0:
            return 0
        return 1 << place if place < nx else self._dependencies.z[place - nx]

    def _indicators(self) -> list[FmuVariable]:
        """The event indicators: FMI 3.0 lists them as variables."""
        m, first = self.equations.model, self.first.indicator
        names, masks = [], []
        for i, (r, k) in enumerate(self.supports):
            run, layout = self.equations.state.runs[r], m.layouts[r]
            names.append((f"event_indicator[{i + 1}]", f"margin to the next load that crosses {run.nodes[k].name}"))
            sides = [int(layout.force[j]) + a for j in (k - 1, k) for a in range(3)] if layout.held[k] >= 0 else []
            mask = self._travel_mask(i)
            for z in sides:
                mask |= self._dependencies.z[z]
            masks.append(mask)
        for j, name in enumerate(self.limit_names):
            names.append((f"event_indicator[{len(self.supports) + j + 1}]", f"margin to {name}"))
            masks.append(self._dependencies.outputs[int(m.limits.output[j])])
        for j in range(self.equations.borders):
            names.append((f"event_indicator[{len(names) + 1}]", f"transition {j + 1} of the carriage"))
            masks.append(self._dependencies.margins)
        return [
            FmuVariable(n, first + i, "Real", "local", "continuous", d, initial="calculated", knowns=mask)
            for i, ((n, d), mask) in enumerate(zip(names, masks, strict=True))
        ]

    def _discrete(self) -> list[FmuVariable]:
        m, masks = self.equations.model, self._dependencies
        limits = [
            FmuVariable(
                name,
                self.first.limit + i,
                "Boolean",
                "output",
                "discrete",
                f"{m.limits.events[i]} at {m.limits.components[i]}",
                initial="calculated",
                knowns=masks.outputs[int(m.limits.output[i])],
            )
            for i, name in enumerate(self.limit_names)
            if name in self.outputs
        ]
        passed = [
            FmuVariable(
                name,
                self.first.passed + i,
                "Integer",
                "output",
                "discrete",
                "number of loads that have passed the support",
                initial="calculated",
                knowns=self._travel_mask(i),
            )
            for i, name in self.passed_names.items()
            if name in self.outputs
        ]
        switches = [
            FmuVariable(
                name,
                self.first.switch + i,
                "Boolean",
                "input",
                "discrete",
                m.d.descriptions[entry].removeprefix("1: "),
                start=bool(self.equations.state.point.d[entry]),
            )
            for i, (name, entry) in enumerate(self.equations.switches.items())
            if name in self.inputs
        ]
        return [*limits, *passed, *switches, *self._emergency_stop()]

    def _emergency_stop(self) -> list[FmuVariable]:
        """It has no direct effect: speeds go down from their present values."""
        if not self.stops:
            return []
        what = "true: ramps all commanded speeds down to zero, and stops all responses"
        return [FmuVariable("emergency_stop", self.first.stop, "Boolean", "input", "discrete", what, start=False)]

    @cached_property
    def known_references(self) -> list[int]:
        """Value references of the knowns of `Dependencies`, -1 if not exported."""
        shown = {v.reference for v in self.variables}
        m, f = self.equations.model, self.first
        groups = [(f.x, len(m.x)), (f.u, len(m.u)), (f.switch, len(self.equations.switches)), (f.p, len(m.p))]
        groups += [(f.mass, len(self.equations.masses))]
        references = [first + i for first, n in groups for i in range(n)]
        return [r if r in shown else -1 for r in references]

    def depends_on(self, variable: FmuVariable, *, parameters: bool) -> list[int]:
        """Value references of the knowns that a variable depends on."""
        masks = self._dependencies
        last = masks.count if parameters else masks.first_parameter
        references = [self.known_references[i] for i in masks.bits(variable.knowns) if i < last]
        return [r for r in references if r >= 0]


def _known(names: Sequence[str], every: Sequence[str], what: str) -> list[str]:
    known = set(every)
    for name in names:
        if name not in known:
            raise UnknownNameError(f"{name!r} is not {what} of the system", nearest(name, tuple(every)))
    return list(names)


def _rows(table: VariableTable) -> list[FmuVariable]:
    """Incomplete variables of a table."""
    return [
        FmuVariable(name, -1, "Real", "local", "continuous", description, unit, nominal=float(abs(nominal)))
        for name, unit, description, nominal in zip(
            table.names, table.units, table.descriptions, table.nominals, strict=True
        )
    ]


def _rate_unit(unit: str) -> str:
    if unit == "1":
        return "1/s"
    head, slash, tail = unit.partition("/")
    return f"{head}/{tail}.s" if slash and tail != "s" else f"{head}/s2" if slash else f"{unit}/s"


def _limit_name(component: str, event: str) -> str:
    return f"{component}.{re.sub(r'[^A-Za-z0-9]+', '_', event)}"
