"""Perturbations: the parameters, inputs, states and loads that change with each quantity of a derivative."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ropeway.components.errors import InputError, UnknownNameError
from ropeway.components.variable import Kind
from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.modelling.empty_rope import pretension
from ropeway.systems.modelling.rope_path import Run
from ropeway.systems.solvers.newton import Point
from ropeway.systems.statics.equilibrium import Equilibrium
from ropeway.systems.statics.line_state import find


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
    def of(cls, line: Equilibrium, names: Sequence[str]) -> Varied:
        """Of the named quantities. Raises UnknownNameError, InputError."""
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
            if quantity == "pretension":
                p[:, j] = _pretension(line, owner)
                nominal[j] = 1e4
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


def _pretension(line: Equilibrium, support: str) -> np.ndarray:
    """Derivatives of the parameters by the tension of the empty rope at its first support, shape (np,)."""
    m, rates = line.model, np.zeros(len(line.model.p))
    for r, (run, layout) in enumerate(zip(line.runs, m.layouts, strict=True)):
        if run.nodes[0].name != support:
            continue
        # A carriage has no fixed place: the empty rope does not touch it.
        fixed = [i for i, node in enumerate(run.nodes) if all(f"{node.name}.{axis}" in m.p.index for axis in "xyz")]
        drums = [i for i in fixed if run.nodes[i].set_tension is not None]
        # A drum with a set tension has paid out rope under the loads: the empty rope is the declared one.
        declared = m.tables[Kind.PARAMETER].values
        lengths = (declared if drums else line.point.p)[layout.length_start]
        weight = run.rope.mass_per_length * float(line.point.p[0])
        at = line.points(r)[fixed]
        names = [run.spans[i].name for i in fixed[:-1]]
        found = pretension(at.tolist(), weight, run.rope.strain, float(lengths.sum()), names)
        for i, rate in zip(fixed[:-1], found.length, strict=True):
            rates[layout.length_start[i]] = rate
        for i in drums:
            rates[m.p.index[f"{run.nodes[i].name}.tension"]] = found.support[fixed.index(i)]
        return rates
    known = ", ".join(dict.fromkeys(f"{run.nodes[0].name}.pretension" for run in line.runs))
    raise UnknownNameError(f"No rope begins at {support!r}", f"Did you mean {known}?")
