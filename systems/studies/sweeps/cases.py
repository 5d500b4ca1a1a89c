"""Cases of a sweep: a grid, a Latin hypercube, or a table of the user."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from ropeway.components import check, table
from ropeway.components.argument_checks import checked
from ropeway.components.errors import InputError
from ropeway.components.table_file import name_and_unit
from ropeway.components.table_numbers import WHOLE, is_number
from ropeway.components.units import conversion, to_si


@checked
def latin_hypercube(bounds: Mapping[str, tuple[float, float]], samples: int, *, seed: int = 0) -> pd.DataFrame:
    """Cases evenly spread between bounds: each of `samples` equal parts of a parameter's range has one.

    Parameters
    ----------
    bounds : mapping of str to (float, float)
        Lowest and highest value of each parameter.
    samples : int
        Number of cases.
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
    >>> rw.latin_hypercube({"l7.mass": (100.0, 500.0), "s3.z": (40.0, 44.0)}, 4).shape
    (4, 2)
    """
    if not bounds or samples < 1:
        raise InputError("latin_hypercube has no bounds or no samples", "Give bounds and at least one sample")
    for name, ends_of in bounds.items():
        low, high = ends_of
        if low >= high:
            raise InputError(f"Bounds of {name!r} are {low:g} and {high:g}", "Give the low one first")
    check.not_negative(seed, "latin_hypercube", "seed")
    check.count(samples * len(bounds), "latin_hypercube", "values", 1_000_000)
    ends = np.array(list(bounds.values()), dtype=float)
    from scipy.stats.qmc import LatinHypercube  # a second's import in itself

    share = LatinHypercube(len(bounds), rng=np.random.default_rng(seed)).random(samples)
    return pd.DataFrame(ends[:, 0] + share * (ends[:, 1] - ends[:, 0]), columns=list(bounds))


_INDEX = re.compile(r"[0-9, ]+")
_ANY = table.TableLayout({}, "c1.speed,l1.mass\n0.5,300\n1.0,450")


Units = Callable[[str], str]
"""The unit of a parameter by its name, "" where any will do. Raises UnknownNameError."""


def any_unit(name: str) -> str:
    """Any unit of a parameter will do."""
    return ""


def table_of(
    parameters: Mapping[str, Iterable[Any]] | pd.DataFrame | str | Path, unit_of: Units = any_unit
) -> pd.DataFrame:
    """One row a case, numbered from 0.

    Parameters
    ----------
    parameters : mapping of str to values, DataFrame, str or Path
        Every combination of the values of a mapping, the last parameter changing fastest; or a table, or its file. A
        name may have a unit in brackets, as `c1.speed [km/h]`.
    unit_of : function, optional
        The unit that a parameter is wanted in; "" for SI.

    Returns
    -------
    DataFrame
        The columns are named without units.

    Raises
    ------
    InputError, UnknownNameError
    """
    if isinstance(parameters, str | Path):
        cases = _from_file(parameters)
    elif isinstance(parameters, pd.DataFrame):
        cases = parameters.reset_index(drop=True)
    else:
        for name, values in parameters.items():
            if isinstance(values, np.ndarray) and values.ndim != 1:
                raise InputError(f"Parameter {name!r} has an array of {values.ndim} dimensions", "Give a row of values")
        cases = pd.DataFrame(list(product(*parameters.values())), columns=list(parameters))
    if cases.empty or cases.columns.has_duplicates:
        raise InputError("The sweep has no cases, or two parameters of one name", "Give each parameter its values")
    if not all(map(_is_plain, cases.columns, cases.dtypes)):
        cases = pd.concat([_in_unit(cases.iloc[:, i], unit_of) for i in range(cases.shape[1])], axis=1)
    if cases.columns.has_duplicates:
        raise InputError(
            f"Two parameters are named {cases.columns[cases.columns.duplicated()][0]!r}", "Give each parameter once"
        )
    return cases.rename_axis("case")


def _is_plain(name: Any, kind: Any) -> bool:
    """Whether a column has its parameter's name, and real numbers: it stays as it is."""
    return isinstance(name, str) and not name_and_unit(name)[1] and kind.kind in "biuf"


def _in_unit(column: pd.Series, unit_of: Units) -> pd.Series:
    """A column under its parameter's name, its values in the parameter's unit. Brackets in the name of an element
    (`v[2]`), and in that of a column of other things than numbers, are no unit. Raises InputError."""
    name, unit = name_and_unit(str(column.name))
    mixed = column.dtype == object  # only then its elements have types of their own
    if column.dtype.kind == "c" or (mixed and any(isinstance(v, complex | np.complexfloating) for v in column)):
        raise InputError(f"Parameter {column.name!r} has complex values", "Give real numbers")
    values = pd.to_numeric(column, errors="coerce")
    if not unit or _INDEX.fullmatch(unit) or (values.isna() & column.notna()).any():
        return column.rename(str(column.name))
    try:
        factor, offset = conversion(unit, unit_of(name) or to_si(unit)[0])
    except InputError as error:
        raise InputError(f"Parameter {column.name!r}: {error.cause}", error.remedy) from error
    return (factor * values + offset).rename(name)


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
