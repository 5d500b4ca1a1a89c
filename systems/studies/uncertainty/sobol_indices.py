"""Sobol indices: which uncertain input the variance of a result comes from."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from ropeway.components.argument_checks import checked
from ropeway.components.errors import EquilibriumError, InputError, UnknownNameError
from ropeway.systems.interrupts import interruptible
from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.modelling.system import System
from ropeway.systems.studies.sweeps.sweep import Study, sweep
from ropeway.systems.studies.sweeps.workers import Workers
from ropeway.systems.studies.uncertainty.uncertain import Uncertain, even_shares

_RESAMPLES = 200


@checked
@interruptible
def sobol_indices(
    study: Study | System | Model,
    inputs: Uncertain,
    outputs: str | Sequence[str] = "value",
    *,
    samples: int = 1024,
    seed: int = 0,
    workers: Workers = None,
    progress: bool | None = None,
) -> pd.DataFrame:
    """Shares of the variance of results that come from each uncertain input.

    Parameters
    ----------
    study : System, Model or callable
        As in `rw.sweep`.
    inputs : Uncertain
        Independent inputs.
    outputs : str or sequence of str, default "value"
        Results; "value" for a function that returns a number.
    samples : int, default 1024
        A power of two; the study is solved samples * (inputs + 2) times.
    seed : int, default 0
        Of the random numbers.
    workers : int or dask.distributed.Client, optional
        As in `rw.sweep`.
    progress : bool, optional
        As in `rw.sweep`.

    Returns
    -------
    DataFrame
        A row for each output and input. Columns: `first`, the share of this input alone; `total`, with all its
        interactions; `first_low`, `first_high`, `total_low`, `total_high`, their intervals of 95 % by bootstrap.

    Raises
    ------
    InputError, UnknownNameError
        Correlated inputs, samples that are not a power of two, or a constant result.
    EquilibriumError
        Cases that fail.

    Examples
    --------
    >>> from scipy import stats
    >>> inputs = rw.Uncertain({"a": stats.norm(0.0, 1.0), "b": stats.norm(0.0, 2.0)})
    >>> rw.sobol_indices(lambda a, b: a + b, inputs, workers=1)["first"].round(1).tolist()
    [0.2, 0.8]
    """
    if not inputs.independent:
        raise InputError(
            "Sobol indices of correlated inputs have no meaning", "Use rw.reliability, or independent distributions"
        )
    names, wanted = list(inputs.names), [outputs] if isinstance(outputs, str) else list(outputs)
    if not wanted:
        raise InputError("sobol_indices has no outputs", "Name at least one")
    points = _points(len(names), samples, seed)
    from scipy.special import ndtri

    values = inputs.values(ndtri(points)).reshape(-1, len(names))
    of_line = isinstance(study, (System, Model))
    cases = pd.DataFrame(values, columns=names)
    table = sweep(study, cases, outputs=wanted if of_line else None, workers=workers, progress=progress)
    found = _results(table, wanted).reshape(len(names) + 2, samples, len(wanted))
    return _table(found, names, wanted, seed)


def _points(count: int, samples: int, seed: int) -> np.ndarray:
    """Shares of the cases A, of the cases B, and of A with each column of B, (inputs + 2, samples, inputs)."""
    both = even_shares(2 * count, samples, "sobol", seed)
    a, b = both[:, :count], both[:, count:]
    mixed = np.repeat(a[None], count, axis=0)
    for k in range(count):
        mixed[k, :, k] = b[:, k]
    return np.concatenate([a[None], b[None], mixed])


def _results(table: pd.DataFrame, wanted: Sequence[str]) -> np.ndarray:
    """Results of all cases, (cases, outputs). Raises EquilibriumError, UnknownNameError."""
    failed = table[table["error"] != ""]
    if len(failed):
        raise EquilibriumError(
            f"{len(failed)} of {len(table)} cases fail, the first by {failed['error'].iloc[0]}: "
            f"{failed['message'].iloc[0]}",
            "Narrow the distributions",
        )
    if missing := [name for name in wanted if name not in table]:
        raise UnknownNameError(f"The study does not return {missing[0]!r}", "Name a result that it returns")
    return table[list(wanted)].to_numpy(dtype=float)


def _table(found: np.ndarray, names: Sequence[str], wanted: Sequence[str], seed: int) -> pd.DataFrame:
    if constant := [name for name, spread in zip(wanted, np.ptp(found, axis=(0, 1)), strict=True) if spread == 0.0]:
        raise InputError(f"{constant[0]} is the same in all cases", "Name results that depend on the inputs")
    generator = np.random.default_rng(seed)
    parts = [pd.DataFrame(_shares(found[..., k], generator), index=list(names)) for k in range(len(wanted))]
    return pd.concat(parts, keys=list(wanted), names=["output", "input"])


def _shares(found: np.ndarray, generator: np.random.Generator) -> dict[str, np.ndarray]:
    """Shares of each input, with their intervals, of results (inputs + 2, samples)."""
    from scipy.stats import sobol_indices as of_samples

    def shares(rows: np.ndarray) -> np.ndarray:
        """First-order and total shares, (2, inputs)."""
        # The result twice: scipy drops the axes of a single result of a single input, and then fails.
        a, b, mixed = (np.repeat(part, 2, axis=-2) for part in (rows[:1], rows[1:2], rows[2:, None]))
        one = of_samples(func={"f_A": a, "f_B": b, "f_AB": mixed}, n=rows.shape[1])
        return np.array([one.first_order[0], one.total_order[0]])

    count = found.shape[1]
    again = [shares(found[:, generator.integers(count, size=count)]) for _ in range(_RESAMPLES)]
    columns = dict(zip(("first", "total"), shares(found), strict=True))
    for end, quantile in (("low", 0.025), ("high", 0.975)):
        first, total = np.quantile(again, quantile, axis=0)
        columns |= {f"first_{end}": first, f"total_{end}": total}
    return columns
