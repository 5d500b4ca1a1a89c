"""An extended Kalman filter of constants, some of which come and go."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


class KalmanFilter:
    """Estimates of named constants: `state` (n,) and their `covariance` (n, n), in the order of `names`."""

    def __init__(self) -> None:
        self.names: list[str] = []
        self.state = np.zeros(0)
        self.covariance = np.zeros((0, 0))

    def add(self, name: str, value: float, sigma: float) -> None:
        """Adds a constant that is known to a standard deviation, independently of the others."""
        n = len(self.names)
        self.names.append(name)
        self.state = np.append(self.state, value)
        covariance = np.zeros((n + 1, n + 1))
        covariance[:n, :n] = self.covariance
        covariance[n, n] = sigma**2
        self.covariance = covariance

    def drop(self, names: Sequence[str]) -> None:
        """Drops constants that no longer matter."""
        kept = [i for i, name in enumerate(self.names) if name not in names]
        self.names = [self.names[i] for i in kept]
        self.state, self.covariance = self.state[kept], self.covariance[np.ix_(kept, kept)]

    def drift(self, sigma: np.ndarray) -> None:
        """Adds independent random changes with standard deviations (n,)."""
        self.covariance[np.diag_indices(len(sigma))] += sigma**2

    def correct(self, off: np.ndarray, rates: np.ndarray, sigma: np.ndarray) -> np.ndarray:
        """Corrects the estimates by measured minus predicted values (m,), whose predictions change by `rates` (m, n),
        with standard deviations (m,). Returns `off` over its standard deviation."""
        spread = rates @ self.covariance @ rates.T + np.diag(sigma**2)
        gain = np.linalg.solve(spread, rates @ self.covariance).T
        self.state = self.state + gain @ off
        rest = np.eye(len(self.state)) - gain @ rates
        self.covariance = rest @ self.covariance @ rest.T + (gain * sigma**2) @ gain.T
        return np.asarray(off / np.sqrt(np.diag(spread)))
