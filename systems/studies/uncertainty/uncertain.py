"""Uncertain inputs of a study: their distributions, their correlation, and samples of them.

Correlated inputs are a Gaussian copula: each value x = quantile(cdf(z)) follows its own distribution, and the normal
scores z have the correlation. Independent standard normal numbers u give z = L u, with L the Cholesky factor.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
import pandas as pd

from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.errors import InputError

Sampling = Literal["latin hypercube", "sobol", "random"]

_LEAST = 2.0**-40
"""Least share of a sample, at which no quantile is infinite."""


@checked
@dataclass(frozen=True, eq=False)
class Uncertain:
    """Uncertain inputs of a study: a distribution of each, and their correlation.

    Parameters
    ----------
    distributions : mapping of str to frozen distribution
        By the name of the input, as in `rw.sweep`: `scipy.stats.norm(300.0, 30.0)`, `scipy.stats.uniform(44e3, 4e3)`
        and all other continuous distributions of `scipy.stats`, in the unit of the input.
    correlation : mapping of (str, str) to float, or array of shape (n, n), optional
        Between the normal scores of two inputs (Gaussian copula), by their names or as a matrix in the order of
        `distributions`; by default all inputs are independent. For two normal distributions it is their correlation; a
        rank correlation r of Spearman is 2 sin(pi r / 6) here.

    Examples
    --------
    >>> from scipy import stats
    >>> inputs = rw.Uncertain(
    ...     {"l1.mass": stats.norm(300.0, 30.0), "l2.mass": stats.norm(250.0, 25.0)}, {("l1.mass", "l2.mass"): 0.6}
    ... )
    >>> inputs.cases(2000).corr().round(1).loc["l1.mass", "l2.mass"]
    np.float64(0.6)
    """

    distributions: Mapping[str, Any]
    correlation: Mapping[tuple[str, str], float] | Sequence[Sequence[float]] | np.ndarray | None = None
    factor: np.ndarray = field(init=False, repr=False)
    """Lower Cholesky factor of the correlation, (n, n)."""

    def __post_init__(self) -> None:
        if not self.distributions:
            raise InputError("Uncertain has no inputs", "Give at least one distribution")
        for name, distribution in self.distributions.items():
            _require_continuous(name, distribution)
        object.__setattr__(self, "distributions", dict(self.distributions))
        object.__setattr__(self, "factor", _factor(self.names, self.correlation))

    @classmethod
    def normal(
        cls, means: Mapping[str, float] | pd.Series, covariance: Sequence[Sequence[float]] | np.ndarray | pd.DataFrame
    ) -> Uncertain:
        """Normal distributions by their means and their covariance, as a fit has them.

        Parameters
        ----------
        means : mapping of str to float, or Series
            By the name of the input, in its unit.
        covariance : array of shape (n, n), or DataFrame
            In the order of `means`, or with their names.

        Returns
        -------
        Uncertain

        Raises
        ------
        InputError
            The covariance is not symmetric and positive definite, or of another size.

        Examples
        --------
        >>> rw.Uncertain.normal({"l1.mass": 300.0, "l2.mass": 250.0}, [[900.0, 450.0], [450.0, 625.0]]).names
        ('l1.mass', 'l2.mass')
        """
        from scipy.stats import norm

        names = list(means.keys())
        if isinstance(covariance, pd.DataFrame):
            if missing := set(names) - set(covariance.index) | set(names) - set(covariance.columns):
                raise InputError(f"The covariance has no {missing.pop()!r}", "Give it the names of the means")
            try:
                covariance = covariance.loc[names, names].to_numpy(dtype=float)
            except (TypeError, ValueError) as error:
                raise InputError(f"The covariance is not of numbers: {error}", "Give numbers") from error
        matrix = np.asarray(covariance, dtype=float)
        if matrix.shape != (len(names), len(names)) or not np.all(np.diag(matrix) > 0.0):
            raise InputError(
                f"The covariance has the shape {matrix.shape}, or a variance of zero",
                f"Give {len(names)} rows and columns, with variances above zero",
            )
        deviations = np.sqrt(np.diag(matrix))
        distributions = {name: norm(means[name], s) for name, s in zip(names, deviations, strict=True)}
        return cls(distributions, matrix / np.outer(deviations, deviations))

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the inputs."""
        return tuple(self.distributions)

    @property
    def independent(self) -> bool:
        """Whether no inputs are correlated."""
        return bool(np.array_equal(self.factor, np.eye(len(self.names))))

    def cases(self, samples: int, *, method: Sampling = "latin hypercube", seed: int = 0) -> pd.DataFrame:
        """Random cases for `rw.sweep`.

        Parameters
        ----------
        samples : int
            Number of cases; a power of two for "sobol".
        method : {"latin hypercube", "sobol", "random"}, default "latin hypercube"
            A Latin hypercube and a Sobol sequence cover the distributions more evenly than random numbers.
        seed : int, default 0
            Of the random numbers; the cases are the same for the same seed.

        Returns
        -------
        DataFrame
            A row a case.

        Raises
        ------
        InputError

        Examples
        --------
        >>> from scipy import stats
        >>> rw.Uncertain({"l1.mass": stats.norm(300.0, 30.0)}).cases(4, method="sobol").shape
        (4, 1)
        """
        shares = even_shares(len(self.names), samples, method, seed)
        from scipy.special import ndtri

        return pd.DataFrame(self.values(ndtri(shares) @ self.factor.T), columns=list(self.names))

    def values(self, scores: np.ndarray) -> np.ndarray:
        """The inputs for their normal scores.

        Parameters
        ----------
        scores : array of shape (..., n)
            Standard normal numbers with the correlation of the inputs; 0 is the median.

        Returns
        -------
        ndarray of shape (..., n)

        Raises
        ------
        InputError
            Another size of the last dimension.
        """
        from scipy.special import ndtr

        scores = np.asarray(scores, dtype=float)
        if scores.shape[-1:] != (len(self.names),):
            raise InputError(
                f"Normal scores have the shape {scores.shape}", f"Give {len(self.names)} in the last dimension"
            )
        found = np.empty(scores.shape)
        for i, distribution in enumerate(self.distributions.values()):
            z = scores[..., i]  # each tail by its own small share, which keeps its digits
            found[..., i] = np.where(z < 0.0, distribution.ppf(ndtr(z)), distribution.isf(ndtr(-z)))
        return found


def even_shares(inputs: int, samples: int, method: Sampling, seed: int) -> np.ndarray:
    """Samples between 0 and 1, (samples, inputs). Raises InputError."""
    check.positive(samples, "Uncertain", "samples")
    check.not_negative(seed, "Uncertain", "seed")
    check.count(samples * inputs, "Uncertain", "values")
    generator = np.random.default_rng(seed)
    if method == "random":
        return np.clip(generator.random((samples, inputs)), _LEAST, 1.0 - _LEAST)
    from scipy.stats import qmc  # a second's import in itself

    if method == "sobol":
        if samples & (samples - 1):
            raise InputError(
                f"A Sobol sequence of {samples} cases is not balanced",
                f"Give a power of two, such as {2 ** samples.bit_length()}",
            )
        found = qmc.Sobol(inputs, rng=generator).random(samples)
    else:
        found = qmc.LatinHypercube(inputs, rng=generator).random(samples)
    return np.clip(found, _LEAST, 1.0 - _LEAST)


def _require_continuous(name: str, distribution: Any) -> None:
    if not all(callable(getattr(distribution, method, None)) for method in ("ppf", "isf", "pdf", "std")):
        raise InputError(
            f"The distribution of {name!r} is {distribution!r}",
            "Give a continuous frozen distribution, such as scipy.stats.norm(300.0, 30.0)",
        )
    quartiles = np.asarray(distribution.ppf([0.25, 0.75]), dtype=float)
    if quartiles.shape != (2,) or not np.isfinite(quartiles).all() or quartiles[0] >= quartiles[1]:
        raise InputError(
            f"The distribution of {name!r} has the quartiles {quartiles.tolist()}",
            "Give its parameters one finite value each, and a scale above zero",
        )


def _factor(
    names: Sequence[str], correlation: Mapping[tuple[str, str], float] | Sequence[Sequence[float]] | np.ndarray | None
) -> np.ndarray:
    """Cholesky factor of a correlation. Raises InputError."""
    count = len(names)
    matrix = np.eye(count)
    if isinstance(correlation, Mapping):
        place = {name: i for i, name in enumerate(names)}
        for pair, value in correlation.items():
            if unknown := [name for name in pair if name not in place]:
                raise InputError(f"The correlation names {unknown[0]!r}", f"Inputs are {', '.join(names)}")
            i, j = (place[name] for name in pair)
            if i == j:
                raise InputError(f"{pair[0]!r} is correlated with itself", "Name two inputs")
            if pair[::-1] in correlation:
                raise InputError(f"The correlation of {pair[0]!r} and {pair[1]!r} is given twice", "Give it once")
            matrix[i, j] = matrix[j, i] = value
    elif correlation is not None:
        matrix = np.array(correlation, dtype=float)
        if matrix.shape != (count, count):
            raise InputError(
                f"The correlation has the shape {matrix.shape}", f"Give {count} rows and columns, one for each input"
            )
    unit = np.allclose(np.diag(matrix), 1.0, rtol=0.0, atol=1e-9) and np.allclose(matrix, matrix.T, rtol=0.0, atol=1e-9)
    try:
        if not unit or not np.isfinite(matrix).all():
            raise np.linalg.LinAlgError
        return np.linalg.cholesky(matrix)
    except np.linalg.LinAlgError as error:
        raise InputError(
            "The correlation is not positive definite, symmetric and one on its diagonal",
            "Give values between -1 and 1 that can hold together; a value of 1 means one input, not two",
        ) from error
