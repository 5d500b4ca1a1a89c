"""Algebraic loops of connections with direct feedthrough: which there are, and whether they have one solution."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components, shortest_path

from ropeway.fmu.cosimulation.connections import Connection
from ropeway.fmu.errors import FmuRunError
from ropeway.fmu.importing.participant import OpenFmu

_SINGULAR = 1e-8
"""Smallest singular value of a regular loop; finite differences have errors of 1e-10."""


def loops(slaves: Mapping[str, OpenFmu], connections: Sequence[Connection]) -> list[list[Connection]]:
    """Connections of each loop, by declared dependencies; without these an output depends on all inputs.

    A loop comes after those on which it depends.
    """
    sources = [c.source.partition(".")[::2] for c in connections]
    targets = [c.target.partition(".")[::2] for c in connections]
    depends = {name: _dependencies(slave) for name, slave in slaves.items()}
    follows = np.zeros((len(connections), len(connections)), dtype=bool)
    for i, (owner, entry) in enumerate(targets):
        for j, (other, output) in enumerate(sources):
            if owner == other:
                known = depends[owner].get(output, depends[owner].get(_whole(output)))
                follows[i, j] = known is None or entry in known or _whole(entry) in known
    if not follows.any():
        return []
    count, labels = connected_components(csr_array(follows), directed=True, connection="strong")
    groups = [np.flatnonzero(labels == k).tolist() for k in range(count)]
    found = [own for own in groups if len(own) > 1 or follows[own[0], own[0]]]
    before = np.isfinite(shortest_path(csr_array(follows), unweighted=True)).sum(axis=0)
    found.sort(key=lambda own: before[own[0]])
    return [[connections[i] for i in own] for own in found]


def _whole(name: str) -> str:
    """Name of the array of an element."""
    return name.partition("[")[0]


def _dependencies(slave: OpenFmu) -> dict[str, set[str]]:
    """Inputs on which outputs depend, where they are declared."""
    return {
        unknown.variable.name: {v.name for v in unknown.dependencies}
        for unknown in slave.fmu.description.outputs
        if unknown.dependencies is not None
    }


def require_one_solution(
    loop: Sequence[Connection], matrix: np.ndarray, connections: Sequence[Connection], time: float
) -> None:
    """Raises FmuRunError if the equations of a loop are singular. `matrix`: scaled derivatives of all residuals."""
    places = [i for i, c in enumerate(connections) if c in loop]
    own = matrix[np.ix_(places, places)]
    if not np.all(np.isfinite(own)) or np.linalg.svd(own, compute_uv=False)[-1] <= _SINGULAR:
        raise ambiguous(loop, time)


def ambiguous(loop: Sequence[Connection], time: float) -> FmuRunError:
    """The error of a loop that many values satisfy."""
    return FmuRunError(
        f"The algebraic loop {named(loop)} is singular at t = {time:.9g} s: many values satisfy it",
        "Open the loop, or connect an input that determines its values",
        time=time,
    )


def named(loop: Sequence[Connection]) -> str:
    """The connections of a loop."""
    return ", ".join(f"{c.source} -> {c.target}" for c in loop)
