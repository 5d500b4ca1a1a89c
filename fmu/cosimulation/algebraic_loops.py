"""Algebraic loops of connections with direct feedthrough: which there are, and whether they have one solution."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from ropeway.fmu.cosimulation.discrete_exchange import Connection
from ropeway.fmu.errors import FmuRunError
from ropeway.fmu.importing.participant import OpenFmu

_SINGULAR = 1e-8
"""Smallest singular value of a regular loop; finite differences have errors of 1e-10."""


def loops(slaves: Mapping[str, OpenFmu], connections: Sequence[Connection]) -> list[list[int]]:
    """Connections of each loop, by declared dependencies; without these an output depends on all inputs."""
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
    return [own for own in groups if len(own) > 1 or follows[own[0], own[0]]]


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
    loop: Sequence[int], matrix: np.ndarray, connections: Sequence[Connection], time: float
) -> None:
    """Raises FmuRunError if the equations of a loop are singular. `matrix`: scaled derivatives of all residuals."""
    own = matrix[np.ix_(loop, loop)]
    if np.all(np.isfinite(own)) and np.linalg.svd(own, compute_uv=False)[-1] > _SINGULAR:
        return
    named = ", ".join(f"{connections[i].source} -> {connections[i].target}" for i in loop)
    raise FmuRunError(
        f"The algebraic loop {named} is singular at t = {time:.9g} s: many values satisfy it",
        "Open the loop, or connect an input that determines its values",
        time=time,
    )
