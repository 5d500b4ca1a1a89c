"""How often limits are passed in the cases of a sweep."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd

from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.errors import InputError, UnknownNameError

ANY = "any"
"""Row of the cases that pass at least one limit."""


@checked
def exceedance(
    table: pd.DataFrame,
    above: Mapping[str, float] | None = None,
    below: Mapping[str, float] | None = None,
    *,
    confidence: float = 0.95,
) -> pd.DataFrame:
    """Probability that limits are passed, from the cases of a sweep.

    Parameters
    ----------
    table : DataFrame
        A row a case, as `rw.sweep` returns it for the cases of `rw.Uncertain`.
    above : mapping of str to float, optional
        Upper limits by column, in its unit: a safe working load.
    below : mapping of str to float, optional
        Lower limits by column: a clearance.
    confidence : float, default 0.95
        Of the interval of each probability.

    Returns
    -------
    DataFrame
        A row a limit, and "any" for the cases that pass at least one. Columns: `probability` and its
        `standard_error` from the solved cases; `low` and `high`, the exact binomial interval (Clopper and Pearson), in
        which failed cases count as safe in `low` and as passed in `high`; `passed`, `solved` and `failed` cases. For a
        Latin hypercube or a Sobol sequence the error is smaller than stated.

    Raises
    ------
    InputError, UnknownNameError
        No limit, no solved case, an unknown column, or one that has text.

    Examples
    --------
    >>> from scipy import stats
    >>> inputs = rw.Uncertain({"load": stats.norm(10.0, 2.0)})
    >>> table = rw.sweep(lambda load: {"tension": 3.0 * load}, inputs.cases(1000), workers=1)
    >>> rw.exceedance(table, above={"tension": 36.0}).loc["tension", ["probability", "low", "high"]].round(2).tolist()
    [0.16, 0.14, 0.18]
    """
    if not 0.0 < confidence < 1.0:
        raise InputError(f"confidence is {confidence:g}", "Give a number between 0 and 1")
    passed = dict[str, np.ndarray]()
    solved = (table["error"] == "").to_numpy() if "error" in table else np.ones(len(table), dtype=bool)
    for given, sign, words in ((above or {}, 1.0, "above"), (below or {}, -1.0, "below")):
        for name, limit in given.items():
            check.number(limit, "exceedance", f"the limit of {name}")
            values = _numbers(table, name)
            key = name if name not in passed else f"{name} {words}"
            passed[key] = sign * (values - limit) > 0.0
            solved = solved & np.isfinite(values)
    if not passed:
        raise InputError("exceedance has no limit", "Give above= or below=, by column")
    if not solved.any():
        raise InputError("The table has no solved case", "Read its column `message`")
    passed[ANY] = np.logical_or.reduce(list(passed.values()))
    failed = int((~solved).sum())
    rows = [_row(which[solved], failed, confidence) for which in passed.values()]
    return pd.DataFrame(rows, index=pd.Index(list(passed), name="quantity"))


def _numbers(table: pd.DataFrame, name: str) -> np.ndarray:
    """A column of numbers. Raises InputError, UnknownNameError."""
    if name not in table:
        raise UnknownNameError(f"The table has no column {name!r}", f"It has {', '.join(map(str, table.columns))}")
    try:
        return table[name].to_numpy(dtype=float)
    except (TypeError, ValueError) as error:
        raise InputError(f"Column {name!r} has text", "Give a column of numbers") from error


def _row(passed: np.ndarray, failed: int, confidence: float) -> dict[str, float]:
    from scipy.stats import binomtest

    count, solved = int(passed.sum()), len(passed)
    share = count / solved
    low = binomtest(count, solved + failed).proportion_ci(confidence).low
    high = binomtest(count + failed, solved + failed).proportion_ci(confidence).high
    return {
        "probability": share,
        "standard_error": float(np.sqrt(share * (1.0 - share) / solved)),
        "low": low,
        "high": high,
        "passed": count,
        "solved": solved,
        "failed": failed,
    }
