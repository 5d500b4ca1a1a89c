"""A line under a loading: empty, full, full on one side, every second load missing, or masses of the user."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ropeway.components import check
from ropeway.components.errors import InputError, UnknownNameError
from ropeway.systems.modelling.rope_path import Run, find_runs
from ropeway.systems.modelling.system import System

STANDARD = ("empty", "full", "one side", "every second")
"""Names of the loadings that every line has."""

Masses = float | Sequence[float] | Mapping[str, float]
"""Masses of loads [kg], 0 for a missing one: of all; in order from the foremost one and repeated; or by their names,
the others unchanged."""


def require_loadings(names: Sequence[str], own: Mapping[str, Masses]) -> None:
    """Raises UnknownNameError for a loading that is not known."""
    known = [*STANDARD, *own]
    for name in names:
        if name not in known:
            choice = f"Choose {', '.join(known)}, or give its masses"
            raise UnknownNameError(f"There is no loading {name!r}", choice)


def masses_of(run: Run, loading: str, own: Mapping[str, Masses]) -> np.ndarray:
    """Masses of a run's loads under a loading [kg]; 0 for missing ones. Raises InputError, UnknownNameError."""
    mass = run.loads.mass
    if loading in own:
        return _given(run, own[loading], loading)
    if loading == "full":
        return mass
    if loading == "empty":
        return np.zeros(len(mass))
    if loading == "one side":
        return np.where(run.loads.place < _one_side(run), mass, 0.0)
    return np.where(np.arange(len(mass)) % 2, 0.0, mass)


def loaded(system: System, loading: str, own: Mapping[str, Masses]) -> System:
    """A line under a loading. Its declarations keep the lengths of its ropes. Raises InputError, UnknownNameError."""
    return system if loading == "full" else _with(system, [masses_of(r, loading, own) for r in find_runs(system)])


def _one_side(run: Run) -> float:
    """Length of rope [m] up to the support where it turns back, or up to the middle of a rope that does not."""
    ends = np.concatenate([[0.0], np.cumsum([span.length for span in run.spans])])
    way = np.diff(run.points[:, :2], axis=0)
    back = np.flatnonzero((way[:-1] * way[1:]).sum(axis=1) < 0.0)
    return float(ends[back[0] + 1] if len(back) else ends[-1] / 2.0)


def _given(run: Run, masses: Masses, loading: str) -> np.ndarray:
    """The masses of a run's loads as the user gives them [kg]. Raises InputError, UnknownNameError."""
    loads = run.loads
    if isinstance(masses, Mapping):
        for name in masses:
            if name not in loads.names:
                raise UnknownNameError(f"Loading {loading!r}: there is no load {name!r}", f"{run.name} has others")
        found = np.array([masses.get(name, mass) for name, mass in zip(loads.names, loads.mass, strict=True)])
    else:
        some = [masses] if isinstance(masses, (int, float)) else list(masses)
        if not some:
            raise InputError(f"Loading {loading!r} has no masses", "Give one number or a sequence of numbers")
        found = np.array([some[i % len(some)] for i in range(len(loads.mass))], dtype=float)
    for mass in found.tolist():
        check.not_negative(mass, f"Loading {loading!r}", "mass", "kg")
    return found


def _with(system: System, masses: Sequence[np.ndarray]) -> System:
    """A copy with other masses of the loads of each run; those of 0 are missing."""
    other = system.copy()
    own: dict[str, float] = {}
    for run, values in zip(find_runs(system), masses, strict=True):
        if run.feed is None:
            own |= dict(zip(run.loads.names, values.tolist(), strict=True))
            continue
        k = next(i for i, feed in enumerate(other.feeds) if feed.spans[0] in run.spans)
        other.feeds[k] = replace(other.feeds[k], masses=tuple(values.tolist()))
    other.feeds = [feed for feed in other.feeds if any(feed.masses)]
    other.hung = [replace(h, load=replace(h.load, mass=own[h.load.name])) for h in other.hung if own[h.load.name] > 0.0]
    return other
