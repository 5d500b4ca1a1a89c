"""Cases of a sweep: a grid, a Latin hypercube, or a table of one's own."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy.stats.qmc import LatinHypercube

from ropeway.components import check, table
from ropeway.components.checked import checked
from ropeway.components.errors import InputError
from ropeway.components.table_numbers import WHOLE, is_number


@checked
def latin_hypercube(bounds: Mapping[str, tuple[float, float]], samples: int, *, seed: int = 0) -> pd.DataFrame:
    """Cases spread evenly between the `bounds` (low, high) of each parameter: in each of `samples` equal parts of
    a parameter's range there is one. One row a case, the same for the same seed. Raises InputError."""
    if not bounds or samples < 1:
        raise InputError("latin_hypercube has nothing to spread", "Give bounds and at least one sample")
    for name, ends_of in bounds.items():
        low, high = ends_of
        if low >= high:
            raise InputError(f"Bounds of {name!r} are {low:g} and {high:g}", "Give the low one first")
    check.not_negative(seed, "latin_hypercube", "seed")
    check.count(samples * len(bounds), "latin_hypercube", "values", 1_000_000)
    ends = np.array(list(bounds.values()), dtype=float)
    share = LatinHypercube(len(bounds), rng=np.random.default_rng(seed)).random(samples)
    return pd.DataFrame(ends[:, 0] + share * (ends[:, 1] - ends[:, 0]), columns=list(bounds))


_ANY = table.Layout({}, "c1.speed,l1.mass\n0.5,300\n1.0,450")


def table_of(parameters: Mapping[str, Iterable[Any]] | pd.DataFrame | str | Path) -> pd.DataFrame:
    """One row a case, numbered from 0: a table as it is, or every combination of the values of a mapping, the last
    parameter changing fastest. Raises InputError."""
    if isinstance(parameters, str | Path):
        cases = _from_file(parameters)
    elif isinstance(parameters, pd.DataFrame):
        cases = parameters.reset_index(drop=True)
    else:
        cases = pd.DataFrame(list(product(*parameters.values())), columns=list(parameters))
    if cases.empty or cases.columns.has_duplicates:
        raise InputError("The sweep has no cases, or two parameters of one name", "Give each parameter its values")
    cases.columns = [str(name) for name in cases.columns]
    return cases.rename_axis("case")


def _from_file(path: str | Path) -> pd.DataFrame:
    """Cases from a file: a column whose first value is a number holds numbers, whole ones where all are whole."""
    read = table.read(path, _ANY)
    cases = {key: read.texts(key) for key in read.keys}
    held = [key for key, texts in cases.items() if is_number(texts[0])]
    values = pd.DataFrame(read.numbers(*held), columns=held)
    for key, texts in cases.items():
        if key not in held and "" in texts:
            raise read.error("the cell is blank", "Give each case a value", texts.index(""), key)
    frame = pd.DataFrame({key: values[key] if key in held else texts for key, texts in cases.items()})
    whole = [key for key in held if all(WHOLE.fullmatch(text) for text in cases[key])]
    return frame.astype(dict.fromkeys(whole, int))
