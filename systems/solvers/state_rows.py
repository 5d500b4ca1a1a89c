"""States of a model as the rows of one array."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import overload

import numpy as np

from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.solvers.points import VECTORS, Point, Vectors


class StateRows(Sequence[Point]):
    """Many states: `values` has their vectors and a zero behind them (states, all + 1), `time` (states,) [s], `passed`
    for each run the loads passed at its supports (states, supports), `alike` whether all have the same parameters. As a
    sequence it has their points, which are views."""

    def __init__(
        self,
        model: Model,
        values: np.ndarray,
        time: np.ndarray | None = None,
        passed: Sequence[np.ndarray] = (),
        *,
        alike: bool = False,
    ) -> None:
        self.values, self.passed, self.alike, self._model = values, passed, alike, model
        self.time = np.zeros(len(values)) if time is None else time
        self._ends = np.cumsum([len(model.tables[kind]) for kind in VECTORS])

    def __len__(self) -> int:
        return len(self.values)

    def __iter__(self) -> Iterator[Point]:
        return (self[i] for i in range(len(self)))

    @overload
    def __getitem__(self, i: int) -> Point: ...
    @overload
    def __getitem__(self, i: slice) -> Sequence[Point]: ...
    def __getitem__(self, i: int | slice) -> Point | Sequence[Point]:
        if isinstance(i, slice):
            return [self[k] for k in range(*i.indices(len(self)))]
        x, z, u, p, d = np.split(self.values[i][: self._ends[-1]], self._ends[:-1])
        return Point(x, z, u, p, d, float(self.time[i]))

    @property
    def z(self) -> np.ndarray:
        """Algebraic variables (states, nz); a view."""
        return self.values[:, self._ends[0] : self._ends[1]]

    @property
    def columns(self) -> Vectors:
        """The vectors as columns; views."""
        return Vectors(*(part.T for part in np.split(self.values[:, : self._ends[-1]], self._ends[:-1], axis=1)))

    def some(self, which: np.ndarray) -> StateRows:
        """Some of the states, by their numbers or by booleans; copied, unless all are meant."""
        if which.dtype == bool and which.all():
            return self
        passed = [p[which] for p in self.passed]
        return StateRows(self._model, self.values[which], self.time[which], passed, alike=self.alike)
