"""A point of a model: the values of its vectors, and where in them an entry is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ropeway.components.variable import Kind

Slot = tuple[Kind, int]
"""An entry of one of the model's vectors."""

VECTORS = {
    Kind.STATE: "x",
    Kind.ALGEBRAIC: "z",
    Kind.INPUT: "u",
    Kind.PARAMETER: "p",
    Kind.DISCRETE: "d",
}
"""The vectors of a model in the order of its functions' arguments, and what each is called."""


@dataclass(frozen=True)
class Vectors:
    """One array for each vector of a model."""

    x: np.ndarray
    z: np.ndarray
    u: np.ndarray
    p: np.ndarray
    d: np.ndarray

    def vector(self, kind: Kind) -> np.ndarray:
        """The array of a kind."""
        return np.asarray(getattr(self, VECTORS[kind]))

    @property
    def vectors(self) -> tuple[np.ndarray, ...]:
        """All of them, in the order of `VECTORS`."""
        return (self.x, self.z, self.u, self.p, self.d)


@dataclass(frozen=True)
class Point(Vectors):
    """A point of the model: the values of all vectors, and the time [s]."""

    t: float = 0.0

    @property
    def arguments(self) -> tuple[np.ndarray, ...]:
        """Arguments of the model's functions."""
        return (np.array([self.t]), self.x, self.z, self.u, self.p, self.d)

    def copy(self) -> Point:
        """With vectors of its own."""
        x, z, u, p, d = (vector.copy() for vector in self.vectors)
        return Point(x, z, u, p, d, self.t)
