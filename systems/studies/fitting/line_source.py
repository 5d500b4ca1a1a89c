"""A system at rest as the source of a fit: an equilibrium for each state."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

import numpy as np

from ropeway.components.errors import InputError
from ropeway.components.variable import Kind
from ropeway.systems.modelling.assembly import assemble
from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.modelling.empty_rope import lengths_for_tension, support_tensions, tension_for_total
from ropeway.systems.modelling.system import System
from ropeway.systems.statics.equilibrium import Equilibrium
from ropeway.systems.statics.equilibrium_solver import equilibrium, still
from ropeway.systems.statics.line_state import LineState
from ropeway.systems.statics.variants import LineVariants, line_variants
from ropeway.systems.studies.fitting.measured import GIVEN, MEASURED
from ropeway.systems.studies.fitting.rope_points import RETURN_TIME, ROPE_X, ROPE_Y, ROPE_Z, return_time, rope_points
from ropeway.systems.studies.fitting.sources import Source, States
from ropeway.systems.studies.sensitivity.linearisation import LinearState
from ropeway.systems.studies.sensitivity.perturbations import OF_ROPES, Varied, fixed_supports, rope_from, rope_of
from ropeway.systems.studies.sensitivity.reading import Reading
from ropeway.systems.studies.sensitivity.sensitivities import linearised, unit_of

_MEASURABLE = re.compile(r"(.*tension(_in|_out|_[ab])?|.*_pull|support_force|bearing_load|pressure|compression|lean)")
"""Outputs that a device can measure."""


class LineSource(Source):
    """A system by the names of its quantities."""

    def __init__(self, system: System | Model) -> None:
        self.model = system if isinstance(system, Model) else assemble(system)
        self.name = self.model.name
        self.rest = equilibrium(self.model)
        self._empty: dict[int, np.ndarray] = {}

    def role(self, name: str) -> str:
        owner, _, quantity = name.rpartition(".")
        if quantity in (ROPE_X, ROPE_Y, ROPE_Z):
            rope_points(self.rest.model, self.rest.runs, owner, np.zeros((1, 2)))
            return MEASURED if quantity == ROPE_Z else GIVEN
        if quantity == RETURN_TIME:
            return_time(self.rest.model, self.rest.runs, owner)
            return MEASURED
        if quantity in OF_ROPES and name not in self.rest.model.p.index:
            rope_from(self.rest.model, self.rest.runs, owner, quantity)
            return GIVEN
        kind, _ = LineState(self.rest.model, self.rest.point, self.rest.runs, self.rest.passed).find(name)
        result = kind in (Kind.OUTPUT, Kind.ALGEBRAIC) and name not in self.rest.model.swaps
        return MEASURED if result else GIVEN

    def unit(self, name: str) -> str:
        own = {ROPE_X: "m", ROPE_Y: "m", ROPE_Z: "m", RETURN_TIME: "s"}
        return own.get(name.rpartition(".")[2]) or unit_of(self.rest.model, name)

    def declared(self, name: str) -> float:
        if self.role(name) == MEASURED:
            raise InputError(f"{name} is a result and cannot be free", "Free a parameter, a length, an input or a mass")
        owner, _, quantity = name.rpartition(".")
        if quantity not in OF_ROPES or name in self.rest.model.p.index:
            return self.rest[name]
        r = rope_from(self.rest.model, self.rest.runs, owner, quantity)
        span = self.rest.runs[r].spans[0].name
        if quantity == "axial_stiffness":
            return float(1.0 / self.rest[f"{span}.compliance"])
        return self.rest[f"{span}.mass_per_length"] if quantity == "mass_per_length" else self._pretension(r)

    def _pretension(self, r: int) -> float:
        """Declared tension of an empty rope at its first support [N]."""
        run, m = self.rest.runs[r], self.rest.model
        fixed, drums = fixed_supports(m, run)
        if 0 in drums:
            return self.rest[f"{run.nodes[0].name}.tension"]
        lengths = (m.p.values if drums else self.rest.point.p)[m.layouts[r].length_start]
        names = [run.spans[i].name for i in fixed[:-1]]
        points, (weight, strain) = self.rest.points(r)[fixed].tolist(), rope_of(self.rest, r)
        return tension_for_total(points, weight, strain, float(lengths.sum()), names)

    def spread(self, values: Mapping[str, float]) -> dict[str, float]:
        """Values of the model's own quantities: those of a rope for each of its spans. Raises InputError,
        SlackRopeError."""
        found, of_ropes = dict[str, float](), dict[int, dict[str, float]]()
        for name, value in values.items():
            owner, _, quantity = name.rpartition(".")
            if quantity not in OF_ROPES or name in self.rest.model.p.index:
                found[name] = value
                continue
            if not value > 0.0:
                raise InputError(f"{name} is {value:g}", "Give bounds above zero")
            of_ropes.setdefault(rope_from(self.rest.model, self.rest.runs, owner, quantity), {})[quantity] = value
        for r, known in of_ropes.items():
            spans = [span.name for span in self.rest.runs[r].spans]
            if "axial_stiffness" in known:
                found |= {f"{span}.compliance": 1.0 / known["axial_stiffness"] for span in spans}
            if "mass_per_length" in known:
                found |= {f"{span}.mass_per_length": known["mass_per_length"] for span in spans}
            if "pretension" in known:
                found |= self._strung(r, known)
        return found

    def _strung(self, r: int, known: Mapping[str, float]) -> dict[str, float]:
        """Lengths of the spans and tensions of drums for a pretension [N] of a rope: those at rest change as those of
        the empty rope do. Raises SlackRopeError."""
        run, m = self.rest.runs[r], self.rest.model
        fixed, drums = fixed_supports(m, run)
        points, (weight, strain) = self.rest.points(r)[fixed], rope_of(self.rest, r)
        names = [run.spans[i].name for i in fixed[:-1]]
        if r not in self._empty:
            self._empty[r] = lengths_for_tension(points.tolist(), weight, strain, self._pretension(r), names)
        if "axial_stiffness" in known:
            strain = strain._replace(c1=1.0 / known["axial_stiffness"])
        if "mass_per_length" in known:
            weight = known["mass_per_length"] * float(self.rest.point.p[0])
        lengths = lengths_for_tension(points.tolist(), weight, strain, known["pretension"], names) - self._empty[r]
        supports = support_tensions(points, weight, strain, known["pretension"])
        lengths += self.rest.point.p[m.layouts[r].length_start[fixed[:-1]]]
        found = {f"{name}.length": float(length) for name, length in zip(names, lengths, strict=True)}
        return found | {f"{run.nodes[i].name}.tension": float(supports[fixed.index(i)]) for i in drums}

    def states(self, free: Sequence[str], given: Sequence[str], values: np.ndarray, time: np.ndarray | None) -> States:
        return LineStates(self, free, given, values)


def pretensions(values: Mapping[str, float]) -> dict[str, float]:
    """The pretensions among some values, by the support where their rope begins."""
    return {name.rpartition(".")[0]: value for name, value in values.items() if name.endswith(".pretension")}


class LineStates(States):
    """Equilibria of a line, with other values of the free quantities in all and of the given ones in each."""

    def __init__(self, source: LineSource, free: Sequence[str], given: Sequence[str], values: np.ndarray) -> None:
        self.source, self.free, self.given, self.values = source, list(free), list(given), values
        self._many: tuple[list[str], LineVariants | None] | None = None
        self._lines: list[Equilibrium] = []

    def predict(self, values: Mapping[str, float]) -> list[LinearState]:
        rows, of_rope = [dict(zip(self.given, row, strict=True)) for row in self.values.tolist()], pretensions(values)
        if any(name.rpartition(".")[2] in OF_ROPES for name in self.given):
            cases = [self.source.spread({**values, **row}) for row in rows]
        else:
            own = self.source.spread(values)
            cases = [{**own, **row} for row in rows]
        self._lines = self._solved(cases)
        # With the same parameters, and loads in the same spans, states change alike.
        parameters, alike = self.source.rest.model.p.index, dict[object, Varied]()
        found = []
        for line, row in zip(self._lines, rows, strict=True):
            own_values = [row[name] for name in self.given if name in parameters or name in line.model.swaps]
            key = (id(line.model), b"".join(passed.tobytes() for passed in line.passed), *own_values)
            if key not in alike:
                alike[key] = Varied.of(line, self.free, of_rope | pretensions(row))
            found.append(linearised(line, alike[key]))
        return found

    def _solved(self, cases: Sequence[Mapping[str, float]]) -> list[Equilibrium]:
        """Equilibria with values of the model's quantities. Raises EquilibriumError, InputError."""
        rest, names = self.source.rest, list(cases[0])
        if self._many is None:
            state = LineState(rest.model, rest.point, rest.runs, rest.passed)
            self._many = names, line_variants(state, names) if names else None
        solver = self._many[1]
        lines: list[Equilibrium | None] = [None] * len(cases)
        if solver is not None:
            good, found = solver.solve(np.array([list(case.values()) for case in cases]))
            for i in np.flatnonzero(good).tolist():
                lines[i] = Equilibrium(rest.model, found[i].copy(), rest.runs, rest.passed, ())
        return [
            still(equilibrium(self.source.model, start=rest, parameters=case)) if line is None else line
            for line, case in zip(lines, cases, strict=True)
        ]

    def reading(self, state: int, name: str) -> Reading:
        owner, _, quantity = name.rpartition(".")
        if quantity == RETURN_TIME:
            return return_time(self._lines[state].model, self._lines[state].runs, owner)
        return Reading((name,))

    def points(self, state: int, span: str, at: np.ndarray) -> Reading:
        line = self._lines[state]
        return rope_points(line.model, line.runs, span, at)

    def candidates(self, state: int) -> Sequence[str]:
        line = self._lines[state]
        return [*measurable(line), *(f"{span.name}.{RETURN_TIME}" for run in line.runs for span in run.spans)]

    def label(self, state: int) -> str:
        if not self.given:
            return f"{self.source.name!r} at rest"
        return ", ".join(f"{n} = {v:g}" for n, v in zip(self.given, self.values[state], strict=True))


def measurable(line: Equilibrium) -> list[str]:
    """Quantities of a line that a device can measure: tensions, forces, pressures, places of loads and free nodes."""
    m = line.model
    found = [m.y.names[i] for i in m.y.shown if _MEASURABLE.fullmatch(m.y.names[i].rpartition(".")[2])]
    found += [name for name in m.z.names if name.rpartition(".")[2] in ("x", "z")]
    return found + [f"{load}.z" for load in line.loads["load"]]
