"""A load case: an environment with a loading and a safety factor; from arguments, or from a table."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, TypeAlias

import pandas as pd

from ropeway.components import check, table
from ropeway.components.argument_checks import checked
from ropeway.components.environment import Environment
from ropeway.components.errors import InputError

MOST = 10_000
"""Largest number of cases."""


@checked
@dataclass(frozen=True)
class LoadCase:
    """An environment with a loading.

    Parameters
    ----------
    name : str
        Any text; unique among the cases of a study.
    environment : Environment, optional
        By default calm, at the temperature at which the ropes were strung.
    loading : str, default "full"
        "empty", "full", "one side", "every second", or a name of the loadings given to `rw.load_cases`.
    safety_factor : float, optional
        Least ratio of minimum breaking load to highest tension in this case; by default that of each rope.

    Raises
    ------
    InputError
        A blank name, or a safety factor that is not positive.

    Examples
    --------
    >>> rw.LoadCase("storm, out of operation", rw.Environment("storm", wind_pressure=800.0), "empty", 2.5).name
    'storm, out of operation'
    """

    name: str
    environment: Environment = field(default_factory=lambda: Environment("calm"))
    loading: str = "full"
    safety_factor: float | None = None

    def __post_init__(self) -> None:
        if not self.name.strip():
            raise InputError("A load case has no name", "Name it")
        if self.safety_factor is not None:
            check.positive(self.safety_factor, f"Load case {self.name!r}", "safety_factor")


Cases: TypeAlias = Sequence[Environment | LoadCase] | pd.DataFrame | str | Path
"""Environments, which are combined with all loadings, and load cases; or a table of them."""

_TEXTS = ("name", "loading")
_NUMBERS = {
    "temperature": "degC", "ice_thickness": "m", "ice_density": "kg/m3", "wind_pressure": "Pa", "wind_speed": "m/s",
    "wind_from": "deg", "air_density": "kg/m3", "safety_factor": "1",
}  # fmt: skip
_EXAMPLE = "name,temperature,ice_thickness,wind_pressure,wind_from\ncalm,,,,\niced,-20,0.01,250,270"
_NAMED = table.TableLayout({"name": None}, _EXAMPLE)
_WHOLE = table.TableLayout({**dict.fromkeys(_TEXTS), **_NUMBERS}, _EXAMPLE)


def resolved(cases: Cases, loadings: Sequence[str], safety_factor: float | None) -> tuple[LoadCase, ...]:
    """All cases: each environment with each of the `loadings`. Raises InputError for two of one name."""
    given = read_cases(cases) if isinstance(cases, (pd.DataFrame, str, Path)) else list(cases)
    if not given:
        raise InputError("There is no load case", "Give environments or load cases")
    found: list[LoadCase] = []
    for one in given:
        if isinstance(one, LoadCase):
            found.append(one)
            continue
        found += [
            LoadCase(one.name if len(loadings) == 1 else f"{one.name}, {loading}", one, loading) for loading in loadings
        ]
    check.count(len(found), "load_cases", "cases", MOST)
    names = [case.name for case in found]
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"Two load cases are named {name!r}", "Give each its own name")
    return tuple(c if c.safety_factor is not None else replace(c, safety_factor=safety_factor) for c in found)


def read_cases(source: table.Source) -> list[Environment | LoadCase]:
    """Environments and load cases of a table.

    Parameters
    ----------
    source : str, Path or DataFrame
        Columns name and, where a value is not the default one, those of `Environment`, loading and safety_factor. A row
        with a loading or a safety factor is a load case, the others are environments.

    Returns
    -------
    list of Environment or LoadCase

    Raises
    ------
    InputError
        With file, line and column.
    """
    read = replace(table.read(source, _NAMED, _WHOLE), layout=_WHOLE)
    known = [*_TEXTS, *_NUMBERS]
    for key, column in zip(read.keys, read.columns, strict=True):
        if key not in known:
            raise read.error(f"there is no quantity {column!r}", f"Columns are {', '.join(known)}", table.HEADER)
    numbers = [key for key in _NUMBERS if key in read.keys]
    values = read.numbers(optional=numbers)
    loadings = read.texts("loading") if "loading" in read.keys else [""] * len(read)
    found: list[Environment | LoadCase] = []
    for i, (name, loading, row) in enumerate(zip(read.texts("name"), loadings, values.tolist(), strict=True)):
        own = {key: value for key, value in zip(numbers, row, strict=True) if not math.isnan(value)}
        try:
            found.append(_case(name, loading, own))
        except InputError as error:
            raise read.error(error.cause, error.remedy, i) from error
    return found


def _case(name: str, loading: str, values: dict[str, Any]) -> Environment | LoadCase:
    """The case of a row. Raises InputError."""
    factor = values.pop("safety_factor", None)
    if not name:
        raise InputError("a case has no name", "Name each case")
    environment = Environment(name, **values)
    if not loading and factor is None:
        return environment
    return LoadCase(name, environment, loading or "full", factor)
