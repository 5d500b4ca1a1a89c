"""Cases of a sweep: a grid, a Latin hypercube, or a table of one's own."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import product
from typing import Any

import numpy as np
import pandas as pd
from scipy.stats.qmc import LatinHypercube

from ropeway.components import check
from ropeway.components.checked import checked
from ropeway.components.errors import InputError


@checked
def latin_hypercube(bounds: Mapping[str, tuple[float, float]], samples: int, *, seed: int = 0) -> pd.DataFrame:
    """Cases spread evenly between the `bounds` (low, high) of each parameter: in each of `samples` equal parts of
    a parameter's range there is one. One row a case, the same for the same seed. Raises InputError."""
    if not bounds or not isinstance(samples, int) or samples < 1:
        raise InputError("latin_hypercube has nothing to spread", "Give bounds and at least one sample")
    for name, ends_of in bounds.items():
        if not isinstance(ends_of, Sequence) or len(ends_of) != 2:
            raise InputError(f"Bounds of {name!r} are {ends_of!r}", "Give (low, high)")
        low, high = ends_of
        check.number(low, "latin_hypercube", f"low end of {name}")
        check.number(high, "latin_hypercube", f"high end of {name}")
        if low >= high:
            raise InputError(f"Bounds of {name!r} are {low:g} and {high:g}", "Give the low one first")
    ends = np.array(list(bounds.values()), dtype=float)
    share = LatinHypercube(len(bounds), rng=np.random.default_rng(seed)).random(samples)
    return pd.DataFrame(ends[:, 0] + share * (ends[:, 1] - ends[:, 0]), columns=list(bounds))


def table_of(parameters: Mapping[str, Iterable[Any]] | pd.DataFrame) -> pd.DataFrame:
    """One row a case, numbered from 0: a table as it is, or every combination of the values of a mapping, the last
    parameter changing fastest. Raises InputError."""
    if isinstance(parameters, pd.DataFrame):
        cases = parameters.reset_index(drop=True)
    elif not isinstance(parameters, Mapping):
        raise InputError(f"The cases are a {type(parameters).__name__}", "Give a table, or values by parameter")
    else:
        for name, values in parameters.items():
            if isinstance(values, str) or not isinstance(values, Iterable):
                raise InputError(f"Parameter {name!r} is {values!r}", "Give a list of its values")
        cases = pd.DataFrame(list(product(*parameters.values())), columns=list(parameters))
    if cases.empty or cases.columns.has_duplicates:
        raise InputError("The sweep has no cases, or two parameters of one name", "Give each parameter its values")
    cases.columns = [str(name) for name in cases.columns]
    return cases.rename_axis("case")
