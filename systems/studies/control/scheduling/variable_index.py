"""Numbers of the variables of a schedule's problem."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ropeway.systems.studies.control.scheduling.section_equations import Constraint


@dataclass
class Numbers:
    """Numbers of the problem's variables, given in order, with start and bounds."""

    start: list[float] = field(default_factory=list)
    low: list[float] = field(default_factory=list)
    high: list[float] = field(default_factory=list)

    def add(
        self, start: np.ndarray | float, low: np.ndarray | float = -np.inf, high: np.ndarray | float = np.inf
    ) -> np.ndarray:
        """Numbers of new variables, by their starts."""
        values = np.atleast_1d(np.asarray(start, dtype=float))
        first = len(self.start)
        for to, what in ((self.start, values), (self.low, low), (self.high, high)):
            to += np.broadcast_to(np.asarray(what, dtype=float), values.shape).tolist()
        return first + np.arange(len(values))


@dataclass(frozen=True)
class Sample:
    """A section at a moment: the numbers of its algebraic variables, and the record they start from."""

    moment: int
    record: int
    numbers: np.ndarray


@dataclass(frozen=True)
class Label:
    """Of each place of a term: the moment; and the rows after its equations."""

    moments: tuple[int, ...]
    rows: tuple[Constraint, ...]
