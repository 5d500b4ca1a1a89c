"""Which case sets the extreme of each support, rope and clearance, and by how much."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pandas as pd

from ropeway.systems.results.support_rows import ALL
from ropeway.systems.studies.load_cases.case_tables import with_units

_OF_SUPPORTS = (
    ("bearing_load", "highest", "N"), ("vertical_force", "highest", "N"), ("horizontal_force", "highest", "N"),
    ("least_force", "lowest", "N"), ("lift_off_reserve", "lowest", "1"), ("deflection", "highest", "rad"),
)  # fmt: skip
_OF_ROPES = (("utilisation", "highest", "1"), ("highest_tension", "highest", "N"), ("lowest_tension", "lowest", "N"))
_OF_SPANS = (("rope_clearance", "lowest", "m"), ("load_clearance", "lowest", "m"))


def governing(ropes: pd.DataFrame, supports: pd.DataFrame, clearances: pd.DataFrame | None) -> pd.DataFrame:
    """A row for each quantity of each rope, support and span that differs between cases.

    Columns subject (rope, support or clearance), name, rope, quantity, extreme (highest or lowest), case, value, unit,
    next_case, next_value, by (the difference of the two), share (of the next value).
    """
    rows = [
        *_rows("rope", ropes, ["rope"], _OF_ROPES),
        *_rows("support", supports, ["support", "rope"], _OF_SUPPORTS),
        *(() if clearances is None else _rows("clearance", clearances, ["span"], _OF_SPANS)),
    ]
    return with_units(pd.DataFrame(rows))


def _rows(
    subject: str, table: pd.DataFrame, keys: list[str], quantities: tuple[tuple[str, str, str], ...]
) -> Iterator[dict[str, object]]:
    cases = table["case"].unique()
    number = {case: i for i, case in enumerate(cases)}
    column = table["case"].map(number).to_numpy()
    groups = table.groupby(keys, sort=False).indices
    for quantity, extreme, unit in quantities:
        values = table[quantity].to_numpy(float)
        sign = 1.0 if extreme == "highest" else -1.0
        for key, places in groups.items():
            names = key if isinstance(key, tuple) else (key,)
            best = np.full(len(cases), -np.inf)  # of each case its own extreme, over the stations of a rig
            own = np.nan_to_num(sign * values[places], nan=-np.inf, posinf=np.inf, neginf=-np.inf)
            np.maximum.at(best, column[places], own)
            if not np.isfinite(best).any():
                continue
            order = np.argsort(-_rounded(best), kind="stable")  # of equal cases the first
            row: dict[str, object] = {
                "subject": subject,
                "name": names[0],
                "rope": names[1] if len(names) > 1 else "",
                "quantity": quantity,
                "extreme": extreme,
                "case": cases[order[0]],
                "value": sign * best[order[0]],
                "unit": unit,
                **_next(best, order, cases, sign),
            }
            yield row


def _rounded(values: np.ndarray) -> np.ndarray:
    """Values without the rounding errors of a solution."""
    size = np.abs(values[np.isfinite(values)]).max()
    return np.asarray(np.round(values / (size or 1.0), 9))


def _next(best: np.ndarray, order: np.ndarray, cases: np.ndarray, sign: float) -> dict[str, object]:
    """The second case, and the difference to it."""
    if len(order) < 2 or not np.isfinite(best[order[1]]):
        return {"next_case": "", "next_value": np.nan, "by": np.nan, "share": np.nan}
    first, second = best[order[0]], best[order[1]]
    by = float(first - second)
    share = by / abs(second) if second != 0.0 else np.nan
    return {"next_case": cases[order[1]], "next_value": sign * second, "by": by, "share": share}


def of_all_ropes(frame: pd.DataFrame) -> pd.DataFrame:
    """The rows that stand for a support as a whole: those of all its ropes where it has several."""
    several = set(frame.loc[frame["rope"] == ALL, "support"])
    return frame[(frame["rope"] == ALL) | ~frame["support"].isin(several)]
