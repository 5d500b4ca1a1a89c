"""Nonlinear least squares with exact derivatives, robust losses, bounds and priors."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ropeway.components.errors import EquilibriumError, FitError, InputError, SimulationError
from ropeway.systems.studies.fitting.observations import Observations, Prediction

Loss = Literal["linear", "huber", "soft_l1", "cauchy"]

_CLOSE = 0.02
"""Distance from the minimum, in standard errors, from which a fit has failed."""
_HELD = 1e-9
"""Weight of the declared values, relative to the largest one of the measured values."""
_MOST = 100
"""Largest number of predictions."""
_HUGE = 1e100
"""Numbers whose squares, and sums of them, are far from the largest and the smallest one."""
_ACCURACY = 1e-8
"""Relative change of the quantities, and of the sum of squares, at which the iteration ends."""


@dataclass(frozen=True)
class Prior:
    """What is known of the free quantities besides: `low` and `high` bounds, `mean` and standard deviation `sigma`
    (inf where there is none), and `scale`, the size of a usual change; shapes (free,)."""

    low: np.ndarray
    high: np.ndarray
    mean: np.ndarray
    sigma: np.ndarray
    scale: np.ndarray


@dataclass(frozen=True)
class Solution:
    """The least-squares solution: `fitted` (free,), the `prediction` there; `jacobian` (residuals, free) of the
    residuals over their standard deviations, priors last, each row multiplied by the root of its weight; `weights`
    (residuals,) of the loss; `residuals` (residuals,); `count`: measured values; `variance`: factor by which the
    squares of sigma are multiplied, 1 where sigma is given."""

    fitted: np.ndarray
    prediction: Prediction
    jacobian: np.ndarray
    weights: np.ndarray
    residuals: np.ndarray
    count: int
    variance: float


def _require_finite_squares(off: np.ndarray, rates: np.ndarray) -> None:
    """Raises InputError where residuals over their standard deviations, or the derivatives of these, have squares that
    no number holds."""
    largest = np.abs(rates).max(initial=0.0)
    if not (np.abs(off).max(initial=0.0) < _HUGE and largest < _HUGE) or 0.0 < largest < 1.0 / _HUGE:
        raise InputError(
            "Deviations over their sigma or that of their prior are outside the floating-point range",
            "Check their units; one value is far too large or too small",
        )


class Problem:
    """Residuals of a fit over their standard deviations, and their derivatives; priors are the last residuals."""

    def __init__(self, observations: Observations, sigma: np.ndarray, prior: Prior) -> None:
        self.observations, self.prior = observations, prior
        self.there = np.isfinite(observations.measured.cells)
        self.sigma = sigma[self.there]
        self.measured = observations.measured.cells[self.there]
        self.known = np.flatnonzero(np.isfinite(prior.sigma))
        self._last: tuple[np.ndarray, np.ndarray, np.ndarray, Prediction] | None = None

    def at(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray, Prediction]:
        """Residuals, derivatives and prediction. Raises EquilibriumError, SimulationError, InputError."""
        if self._last is None or not np.array_equal(self._last[0], values):
            found = self.observations.predict(values)
            off = (values - self.prior.mean)[self.known] / self.prior.sigma[self.known]
            residuals = np.concatenate([(found.shown[self.there] - self.measured) / self.sigma, off])
            priors = np.zeros((len(self.known), len(values)))
            priors[np.arange(len(self.known)), self.known] = 1.0 / self.prior.sigma[self.known]
            rates = np.vstack([found.rates[self.there] / self.sigma[:, None], priors])
            self._last = values.copy(), residuals, rates, found
        return self._last[1:]

    def solve(self, start: np.ndarray, loss: Loss, *, known_sigma: bool) -> Solution:
        """The solution from a start. Raises FitError, and the errors of the start."""
        from scipy.optimize import least_squares

        inner = self._inside(start)
        off, rates, _ = self.at(inner)  # the errors of the start are those of the user's declarations
        _require_finite_squares(off, rates)
        count, lost = len(self.measured), list[str]()
        # Combinations that change nothing measured stay as declared.
        held = _HELD * np.linalg.norm(rates * self.prior.scale, 2) / self.prior.scale

        def residuals(values: np.ndarray) -> np.ndarray:
            try:
                return np.concatenate([self.at(values)[0], held * (values - inner)])
            except (EquilibriumError, SimulationError, InputError) as error:
                lost.append(str(error))
                return np.full(count + len(self.known) + len(values), np.inf)  # the step is shortened

        found = least_squares(
            residuals,
            inner,
            lambda values: np.vstack([self.at(values)[1], np.diag(held)]),
            (self.prior.low, self.prior.high),
            x_scale=self.prior.scale,
            loss=_LOSSES[loss](count),
            ftol=_ACCURACY,
            xtol=_ACCURACY,
            gtol=_ACCURACY,
            max_nfev=_MOST,
        )
        if not found.success:
            raise FitError(
                f"The fit did not converge in {_MOST} predictions" + (f": {lost[-1]}" if lost else ""),
                "Fit fewer quantities, or give bounds, a prior, or declarations nearer to the measured values",
            )
        values, (off, rates, prediction) = np.asarray(found.x), self.at(found.x)
        weights = np.array(_LOSSES[loss](count)(off**2)[1])
        degrees = count + len(self.known) - len(values)
        variance = 1.0
        if not known_sigma:
            squares = float((weights[:count] * off[:count] ** 2).sum())
            variance = squares / degrees if degrees > 0 else np.nan
        weighted = rates * np.sqrt(weights)[:, None]
        self._require_minimum(values, weighted, off * np.sqrt(weights), variance, lost)
        return Solution(values, prediction, weighted, weights, off, count, variance)

    def _require_minimum(
        self, values: np.ndarray, rates: np.ndarray, off: np.ndarray, variance: float, lost: Sequence[str]
    ) -> None:
        """Raises FitError where the quantities that are at no bound are not at the minimum, to a part of their
        standard errors, as where the iteration is stopped by states without an equilibrium."""
        near = 1e-6 * self.prior.scale
        inner = (values - self.prior.low > near) & (self.prior.high - values > near)
        scaled = (rates * self.prior.scale)[:, inner]
        step = np.linalg.lstsq(scaled, off, rcond=1e-8)[0]
        spread = np.sqrt(variance) if np.isfinite(variance) else 1.0
        rounding = _ACCURACY * np.linalg.norm(self.measured / self.sigma)  # all that is left of values without noise
        if np.linalg.norm(scaled @ step) > _CLOSE * spread + 1e-6 * np.linalg.norm(off) + rounding:
            raise FitError(
                "The fit stopped before its minimum" + (f": {lost[-1]}" if lost else ""),
                "Give bounds within which the system has an equilibrium, or declarations nearer to the measured values",
            )

    def _inside(self, start: np.ndarray) -> np.ndarray:
        """The start strictly between the bounds."""
        low, high = self.prior.low, self.prior.high
        room = np.where(np.isfinite(high - low), 1e-3 * (high - low), 1e-3 * self.prior.scale)
        return np.asarray(np.clip(start, low + room, high - room))


Evaluated = Callable[[np.ndarray], np.ndarray]


def _losses() -> Mapping[str, Callable[[int], Evaluated]]:
    """Losses rho(z) of squared residuals z with two derivatives, (3, residuals); priors after the first `count`
    residuals keep their squares."""

    def of(robust: Callable[[np.ndarray], list[np.ndarray]]) -> Callable[[int], Evaluated]:
        def for_count(count: int) -> Evaluated:
            def rho(z: np.ndarray) -> np.ndarray:
                found = np.stack([z, np.ones_like(z), np.zeros_like(z)])
                found[:, :count] = robust(z[:count])
                return found

            return rho

        return for_count

    def huber(z: np.ndarray) -> list[np.ndarray]:
        root = np.sqrt(np.maximum(z, 1.0))
        beyond = z > 1.0
        return [np.where(beyond, 2.0 * root - 1.0, z), 1.0 / root, np.where(beyond, -0.5 / root**3, 0.0)]

    def soft_l1(z: np.ndarray) -> list[np.ndarray]:
        root = np.sqrt(1.0 + z)
        return [2.0 * (root - 1.0), 1.0 / root, -0.5 / root**3]

    def cauchy(z: np.ndarray) -> list[np.ndarray]:
        return [np.log1p(z), 1.0 / (1.0 + z), -1.0 / (1.0 + z) ** 2]

    def linear(z: np.ndarray) -> list[np.ndarray]:
        return [z, np.ones_like(z), np.zeros_like(z)]

    return {"linear": of(linear), "huber": of(huber), "soft_l1": of(soft_l1), "cauchy": of(cauchy)}


_LOSSES = _losses()
