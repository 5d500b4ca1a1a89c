"""Perturbations: the parameters, inputs, states and loads that change with each quantity of a derivative."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ropeway.components.catenary import Strain
from ropeway.components.errors import InputError, UnknownNameError
from ropeway.components.variable import Kind
from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.modelling.empty_rope import pretension, tension_for_total
from ropeway.systems.modelling.rope_path import Run
from ropeway.systems.solvers.points import Point
from ropeway.systems.statics.equilibrium import Equilibrium
from ropeway.systems.statics.line_state import find

OF_ROPES = ("pretension", "axial_stiffness", "mass_per_length")
"""Quantities of a rope, named after the support where it begins."""


@dataclass(frozen=True)
class Varied:
    """Derivatives by each quantity, one column each: states at the start, inputs, parameters, and for each run the rope
    at each support, the masses and the places of the loads; `nominal` (k,): size of a usual change."""

    x: np.ndarray
    u: np.ndarray
    p: np.ndarray
    start: tuple[np.ndarray, ...]
    mass: tuple[np.ndarray, ...]
    place: tuple[np.ndarray, ...]
    nominal: np.ndarray

    @classmethod
    def of(cls, line: Equilibrium, names: Sequence[str], strung: Mapping[str, float] | None = None) -> Varied:
        """Of the named quantities. `strung`: pretensions [N] of ropes by the support where they begin, whose lengths
        change with stiffness and weight. Raises UnknownNameError, InputError."""
        m, runs, k = line.model, line.runs, len(names)
        x, u, p = (np.zeros((len(table), k)) for table in (m.x, m.u, m.p))
        mass = tuple(np.zeros((len(run.loads.mass), k)) for run in runs)
        nominal = np.ones(k)
        vectors = {Kind.STATE: x, Kind.INPUT: u, Kind.PARAMETER: p}
        for j, name in enumerate(names):
            owner, _, quantity = name.rpartition(".")
            loads = [np.array([n == owner for n in run.loads.names], dtype=bool) for run in runs]
            if quantity == "mass" and any(np.any(is_load) for is_load in loads):
                for rates, is_load in zip(mass, loads, strict=True):
                    rates[is_load, j] = 1.0
                nominal[j] = 100.0
                continue
            if quantity in OF_ROPES and name not in m.p.index:
                p[:, j] = _of_rope(line, owner, quantity, strung or {})
                nominal[j] = {"pretension": 1e4, "axial_stiffness": 1e6, "mass_per_length": 1.0}[quantity]
                continue
            kind, i = find(m, runs, line.passed, m.swaps.get(name, name))
            if kind not in vectors:
                raise InputError(f"{name} is a result", "Give to= a parameter, an input, a state or a load's mass")
            vectors[kind][i, j] = 1.0
            nominal[j] = m.tables[kind].nominals[i]
        start = tuple(np.vstack([np.zeros(k), np.cumsum(p[layout.length_start], axis=0)]) for layout in m.layouts)
        return cls(x, u, p, start, mass, tuple(np.zeros_like(rates) for rates in mass), nominal)

    def discrete(self, model: Model, runs: Sequence[Run], passed: Sequence[np.ndarray], point: Point) -> np.ndarray:
        """Directions of the discrete variables that follow from where the loads are, shape (nd, k)."""
        found = np.zeros((len(model.d), self.p.shape[1]))
        for r, (run, layout) in enumerate(zip(runs, model.layouts, strict=True)):
            flags = np.zeros(len(model.d), dtype=bool)
            for first in (layout.slots.ride, layout.slots.empty):
                for place, count in zip(first, layout.slots.count, strict=True):
                    flags[place : place + count] = True
            for j in range(found.shape[1]):
                none = np.zeros(len(run.loads.at))
                rates = replace(run.loads, mass=self.mass[r][:, j], place=self.place[r][:, j], at=none, drag=none)
                layout.slots.write(found[:, j], replace(run, loads=rates), passed[r], self.start[r][:, j])
            found[flags] = 0.0
            for k in np.flatnonzero(layout.held >= 0):
                if point.d[layout.held[k]] > 0.0:
                    here = layout.start(point.p)[k] - point.d[layout.held_travel[k]]
                    load = int(np.argmin(np.abs(run.loads.place - here)))
                    found[layout.held_travel[k]] = self.start[r][k] - self.place[r][load]
        return found


def _of_rope(line: Equilibrium, support: str, quantity: str, strung: Mapping[str, float]) -> np.ndarray:
    """Derivatives of the parameters by a quantity of the rope that begins at a support, shape (np,)."""
    r = rope_from(line.model, line.runs, support, quantity)
    rates, layout, p = np.zeros(len(line.model.p)), line.model.layouts[r], line.point.p
    if quantity == "pretension":
        return _pretension(line, r, strung.get(support))[:, 0]
    if quantity == "mass_per_length":
        rates[layout.mass_per_length] = 1.0
        return rates if support not in strung else rates + _pretension(line, r, strung[support])[:, 2] * float(p[0])
    by_compliance = -(p[layout.compliance] ** 2)
    rates[layout.compliance] = by_compliance
    more = 0.0 if support not in strung else _pretension(line, r, strung[support])[:, 1] * by_compliance[0]
    return rates + more


def rope_from(model: Model, runs: Sequence[Run], support: str, quantity: str) -> int:
    """Number of the rope that begins at a support. Raises UnknownNameError."""
    for r, run in enumerate(runs):
        if run.nodes[0].name == support:
            return r
    known = ", ".join(dict.fromkeys(f"{run.nodes[0].name}.{quantity}" for run in runs))
    raise UnknownNameError(f"No rope of {model.name!r} begins at {support!r}", f"Did you mean {known}?")


def _pretension(line: Equilibrium, r: int, tension: float | None) -> np.ndarray:
    """Derivatives of the parameters (np, 3), as `empty_rope.pretension`, by an empty rope's tension at its first
    support, which is `tension` [N], or that of the declared rope."""
    m, run, layout, rates = line.model, line.runs[r], line.model.layouts[r], np.zeros((len(line.model.p), 3))
    fixed, drums = fixed_supports(m, run)
    names = [run.spans[i].name for i in fixed[:-1]]
    points, weight, strain = line.points(r)[fixed].tolist(), *rope_of(line, r)
    if tension is None:
        # A drum with a set tension has paid out rope under the loads: the empty rope is the declared one.
        lengths = (m.tables[Kind.PARAMETER].values if drums else line.point.p)[layout.length_start]
        tension = tension_for_total(points, weight, strain, float(lengths.sum()), names)
    found = pretension(points, weight, strain, tension, names)
    rates[layout.length_start[fixed[:-1]]] = found.length
    for i in drums:
        rates[m.p.index[f"{run.nodes[i].name}.tension"]] = found.support[fixed.index(i)]
    return rates


def rope_of(line: Equilibrium, r: int) -> tuple[float, Strain]:
    """Weight per metre [N/m] and strain of a rope, by the parameters of its first span."""
    p, layout, name = line.point.p, line.model.layouts[r], line.runs[r].spans[0].name
    construction = line.model.p.index.get(f"{name}.construction")
    strain = Strain(float(p[layout.compliance[0]]), 0.0 if construction is None else float(p[construction]))
    return float(p[layout.mass_per_length[0]] * p[0]), strain


def fixed_supports(model: Model, run: Run) -> tuple[list[int], list[int]]:
    """The supports of a rope that have a fixed place, as a carriage does not, which the empty rope does not touch; and
    those of them that are drums with a set tension."""
    fixed = [i for i, node in enumerate(run.nodes) if all(f"{node.name}.{axis}" in model.p.index for axis in "xyz")]
    return fixed, [i for i in fixed if run.nodes[i].set_tension is not None]
