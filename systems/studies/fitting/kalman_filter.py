"""An extended Kalman filter of constants, some of which come and go."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ropeway.components.errors import InputError

_MOST = 1e12
"""Largest condition number of the correlation of the measured values."""


class KalmanFilter:
    """Estimates of named constants: `state` (n,), from `low` to `high`, and their `covariance` (n, n), in the order of
    `names`."""

    def __init__(self) -> None:
        self.names: list[str] = []
        self.state, self.low, self.high = np.zeros(0), np.zeros(0), np.zeros(0)
        self.covariance = np.zeros((0, 0))

    def add(self, name: str, value: float, sigma: float, low: float, high: float) -> None:
        """Adds a constant that is known to a standard deviation, independently of the others."""
        n = len(self.names)
        self.names.append(name)
        self.state, self.low, self.high = (
            np.append(own, new) for own, new in ((self.state, value), (self.low, low), (self.high, high))
        )
        covariance = np.zeros((n + 1, n + 1))
        covariance[:n, :n] = self.covariance
        covariance[n, n] = sigma**2
        self.covariance = covariance

    def drop(self, names: Sequence[str]) -> None:
        """Drops constants that no longer matter."""
        kept = [i for i, name in enumerate(self.names) if name not in names]
        self.names = [self.names[i] for i in kept]
        self.state, self.low, self.high = self.state[kept], self.low[kept], self.high[kept]
        self.covariance = self.covariance[np.ix_(kept, kept)]

    def drift(self, sigma: np.ndarray) -> None:
        """Adds independent random changes with standard deviations (n,)."""
        with np.errstate(over="ignore"):  # `correct` refuses it
            self.covariance[np.diag_indices(len(sigma))] += sigma**2

    def correct(self, off: np.ndarray, rates: np.ndarray, sigma: np.ndarray) -> np.ndarray:
        """Corrects the estimates by measured minus predicted values (m,), whose predictions change by `rates` (m, n),
        with standard deviations (m,). Returns `off` over its standard deviation. Raises InputError."""
        with np.errstate(all="ignore"):  # of numbers that are refused below
            spread = rates @ self.covariance @ rates.T + np.diag(sigma**2)
            deviation = np.sqrt(np.diag(spread))
            unit, moved = spread / np.outer(deviation, deviation), rates @ self.covariance / deviation[:, None]
        if not (np.isfinite(unit).all() and np.linalg.cond(unit) < _MOST):
            raise InputError(
                f"Measured values are known to {sigma.min():g}, but expected to {deviation.max():g}: more apart than "
                "numbers resolve",
                "Give sigma, prior and drift the standard deviations that gauges and loads have, in SI units",
            )
        gain = np.linalg.solve(unit, moved).T / deviation
        self.state = np.clip(self.state + gain @ off, self.low, self.high)
        rest = np.eye(len(self.state)) - gain @ rates
        self.covariance = rest @ self.covariance @ rest.T + (gain * sigma**2) @ gain.T
        return np.asarray(off / deviation)
