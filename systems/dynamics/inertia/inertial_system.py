"""The declarations of a system with inertia: its components with the inertia of ropes, loads and wheels."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ropeway.components.errors import InputError
from ropeway.components.inertia import Inertia
from ropeway.components.span import Span
from ropeway.systems.modelling.rope_path import Run
from ropeway.systems.modelling.system import System


def with_inertia(system: System, inertia: Inertia) -> System:
    """A copy of a system whose components have inertia."""
    found = system.copy()
    found.components = {name: c.with_inertia(inertia) for name, c in system.components.items()}
    spans = {name: c for name, c in found.components.items() if isinstance(c, Span)}
    found.hung = [replace(h, spans=tuple(spans[s.name] for s in h.spans)) for h in system.hung]
    found.feeds = [replace(f, spans=tuple(spans[s.name] for s in f.spans)) for f in system.feeds]
    return found


def carries_loads(run: Run) -> bool:
    """Whether a rope moves and carries loads over its supports."""
    return run.moves and bool(len(run.loads.place) or run.feed)


def require_fitting(run: Run, inertia: Inertia) -> None:
    """Raises InputError where a rope that carries loads over supports does not fit the inertia asked for."""
    if not carries_loads(run):
        return
    if inertia.nodes:
        raise InputError(
            f"Inertia(nodes={inertia.nodes}): the rope {run.name} carries loads over its supports",
            "Rope nodes cannot pass a support: use nodes=0, which is accurate on a loaded line",
        )
    short = min(run.spans, key=lambda span: span.length)
    if inertia.zone > short.length / 2.0:
        raise InputError(
            f"Inertia(zone={inertia.zone:g}): more than half of span {short.name!r}, {short.length:.6g} m",
            f"Choose a zone of at most {short.length / 2.0:.6g} m",
        )


def rope_nodes(run: Run, lengths: np.ndarray, distances: list[np.ndarray], count: int) -> list[np.ndarray]:
    """Distances of `count` rope nodes from end a of each span [m], spread over the pieces between its loads in
    proportion to their `lengths` (spans,), and evenly in each. `distances`: of the loads in each span."""
    found = []
    for length, loads in zip(lengths.tolist(), distances, strict=True):
        cuts = np.concatenate([[0.0], np.sort(loads), [length]])
        pieces = np.diff(cuts)
        exact = count * pieces / pieces.sum()
        own = np.floor(exact + 1e-9).astype(int)
        for k in np.argsort(own - exact, kind="stable")[: count - own.sum()]:
            own[k] += 1
        found.append(
            np.concatenate(
                [a + d * np.arange(1, n + 1) / (n + 1) for a, d, n in zip(cuts[:-1], pieces, own, strict=True)]
            )
        )
    return found
