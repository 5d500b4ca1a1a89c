"""Readings: values that a measuring device or a table shows, as functions of the quantities of a solved state."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ropeway.systems.studies.sensitivity.linearisation import LinearState

_STEP = 1e-30
"""Complex step of derivatives, relative to the value."""


def _itself(values: np.ndarray) -> Any:
    return values[:1]


@dataclass(frozen=True)
class Reading:
    """One or several values that follow from quantities of a state by a function `of` their values (n,), which also
    takes complex numbers and returns (m,); by default the one quantity itself."""

    names: tuple[str, ...]
    of: Callable[[np.ndarray], Any] = _itself

    def at(self, state: LinearState) -> tuple[np.ndarray, np.ndarray]:
        """Its values (m,) at a state, and their derivatives (m, k). Raises UnknownNameError."""
        values = np.array([state.read(name) for name in self.names])
        rates = np.array([state.rates(name) for name in self.names])
        if self.of is _itself:
            return values, rates
        partial = []
        for i, value in enumerate(values):
            step = _STEP * max(1.0, abs(value))
            moved = values.astype(complex)
            moved[i] += 1j * step
            partial.append(np.asarray(self.of(moved)).imag / step)
        return np.asarray(self.of(values), dtype=float), np.array(partial).T @ rates
