"""Measured tables: which column holds which quantity, in SI units, with blanks skipped and counted."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from ropeway.components import table
from ropeway.components.errors import InputError, UnknownNameError
from ropeway.components.table_file import name_and_unit
from ropeway.components.units import conversion, parse

Sigma = float | Mapping[str, float | Sequence[float]]
TIME = "time"
"""Target of the column with the time [s] of a series."""
GIVEN, MEASURED = "given", "measured"
_ROUNDING = 1e-12
"""Least standard deviation, as a share of the largest value of its column."""
MISSING = {"nan", "na", "n/a", "null", "-"}
"""Words for a missing number."""


@dataclass(frozen=True)
class Column:
    """A column of a measured table: its name, the quantity it holds, the SI unit of that, and whether it is measured or
    given."""

    name: str
    target: str
    unit: str
    role: str


@dataclass(frozen=True)
class Measured:
    """A measured table in SI units. `cells` (rows, columns) of the measured `columns`, NaN where skipped; `given`
    (rows, givens) of the columns that are known in each row; `time` (rows,) of a series; `rows`: the number of each
    row in the table; `blank`: measured cells that are blank; `dropped`: rows that are left out, as a given value is
    blank."""

    columns: tuple[Column, ...]
    cells: np.ndarray
    givens: tuple[Column, ...]
    given: np.ndarray
    time: np.ndarray | None
    rows: np.ndarray
    blank: int
    dropped: int

    def column(self, name: str) -> int:
        """Place of a measured column by its name or target. Raises UnknownNameError."""
        for i, column in enumerate(self.columns):
            if name in (column.name, column.target):
                return i
        known = ", ".join(column.name for column in self.columns)
        raise UnknownNameError(f"No measured column {name!r}", f"The measured columns are {known}")

    def sigmas(self, sigma: Sigma | None) -> np.ndarray:
        """Standard deviations (rows, columns); ones where none are given. Raises InputError."""
        found = np.ones(self.cells.shape)
        if sigma is None:
            units = sorted({column.unit for column in self.columns})
            if len(units) > 1:
                raise InputError(
                    f"The measured columns have different units ({', '.join(units)}) and no sigma",
                    "Give sigma, the standard deviation of each column, such as {'A': 500.0}",
                )
            return found
        if not isinstance(sigma, Mapping):
            found[:] = _positive(sigma, "sigma")
            return self._above_rounding(found)
        for name, value in sigma.items():
            values = np.asarray(value, dtype=float)
            if values.ndim and len(values) <= self.rows.max(initial=-1):
                raise InputError(f"sigma of {name!r} has {len(values)} values", "Give one for each row of the table")
            found[:, self.column(name)] = _positive(values[self.rows] if values.ndim else values, f"sigma of {name!r}")
        missing = [c.name for c in self.columns if not {c.name, c.target} & set(sigma)]
        if missing:
            raise InputError(f"sigma has no value for {', '.join(missing)}", "Give one for each measured column")
        return self._above_rounding(found)

    def _above_rounding(self, sigma: np.ndarray) -> np.ndarray:
        """Standard deviations that a number of the column's size can resolve. Raises InputError."""
        largest = np.where(np.isfinite(self.cells), np.abs(self.cells), 0.0).max(axis=0, initial=0.0)
        if (sigma < _ROUNDING * largest).any():
            raise InputError(
                f"sigma is {sigma.min():g}, less than the rounding of the measured values",
                "Give the standard deviation of the measurement, in SI units",
            )
        return sigma


def _positive(value: float | np.ndarray, what: str) -> np.ndarray:
    values = np.asarray(value, dtype=float)
    if not (np.isfinite(values).all() and (values > 0.0).all()):
        raise InputError(f"{what} is not above zero", "Give standard deviations above zero, in SI units")
    return values


def read_measured(
    source: table.Source,
    columns: Mapping[str, str] | None,
    role_of: Callable[[str], str],
    unit_of: Callable[[str], str],
) -> Measured:
    """A measured table. `role_of` and `unit_of` give the role and the SI unit of a quantity, and raise
    UnknownNameError. Raises InputError."""
    if isinstance(source, pd.DataFrame) and source.index.name is not None:
        source = source.reset_index()
    wanted = _all_columns(source, role_of) if columns is None else dict(columns)
    if not wanted:
        raise InputError("columns is empty", 'Give the quantity of each column, such as {"A": "c2.tension_in"}')
    chosen, given_units = list[Column](), dict[str, str]()
    for key, target in wanted.items():
        name, given_units[key] = name_and_unit(key)
        role = GIVEN if target == TIME else role_of(target)
        chosen.append(Column(name, target, "s" if target == TIME else unit_of(target), role))
    targets = [column.target for column in chosen if column.role == GIVEN]
    if twice := {t for t in targets if targets.count(t) > 1}:
        raise InputError(f"Two columns give {min(twice)!r}", "Keep one of them")
    layout = table.TableLayout({c.name: c.unit for c in chosen}, ",".join(c.name for c in chosen) + "\n1.0")
    read = _without_missing(table.read(source, layout))
    values = read.numbers(optional=[column.name for column in chosen])
    for i, (column, unit) in enumerate(zip(chosen, given_units.values(), strict=True)):
        if read.units[read.keys.index(column.name)]:
            continue
        unit = unit or unit_in(column)
        try:
            factor, offset = conversion(unit, column.unit)
        except InputError as error:
            raise InputError(
                f"Column {column.name!r} of {column.target!r}: {error.cause}",
                f"Rename the column, or give its unit: columns={{'{column.name} [{column.unit}]': ...}}",
            ) from error
        values[:, i] = factor * values[:, i] + offset
    return _sorted_out(chosen, values)


def _sorted_out(chosen: Sequence[Column], values: np.ndarray) -> Measured:
    """Measured and given columns apart, without rows that lack a given value. Raises InputError."""
    measured = [i for i, c in enumerate(chosen) if c.role == MEASURED]
    given = [i for i, c in enumerate(chosen) if c.role == GIVEN and c.target != TIME]
    when = [i for i, c in enumerate(chosen) if c.target == TIME]
    if not measured:
        raise InputError("No column is measured", "Name at least one that holds a result, such as a tension")
    kept = np.flatnonzero(np.isfinite(values[:, given + when]).all(axis=1))
    found = values[kept][:, measured]
    return Measured(
        tuple(chosen[i] for i in measured),
        found,
        tuple(chosen[i] for i in given),
        values[kept][:, given],
        values[kept, when[0]] if when else None,
        kept,
        int(np.isnan(found).sum()),
        len(values) - len(kept),
    )


def _all_columns(source: table.Source, role_of: Callable[[str], str]) -> dict[str, str]:
    """All columns that are named after a quantity. Raises InputError."""
    read = table.read(source, table.TableLayout({}, "c2.tension_in\n50000"))
    found = dict[str, str]()
    for header in read.columns:
        name = name_and_unit(header)[0]
        try:
            if name != TIME:
                role_of(name)
        except UnknownNameError:
            continue
        found[name] = name
    if not any(name != TIME for name in found):
        raise InputError(
            f"{read.source}: no column is named after a quantity", 'Give columns, such as {"A": "c2.tension_in"}'
        )
    return found


def unit_in(column: Column) -> str:
    """Unit at the end of a column's name, as in `skyline_kN`; "" where it has none, as in `tension_in`."""
    name = column.name.replace(".", "_")
    if "_" not in name or name.endswith(column.target.rpartition(".")[2]):
        return ""
    unit = name.rpartition("_")[2]
    return unit if parse(unit) is not None else ""


def _without_missing(read: table.Table) -> table.Table:
    """The table with words for a missing number as blanks."""
    rows = [["" if str(cell).strip().casefold() in MISSING else cell for cell in row] for row in read.rows]
    return replace(read, rows=rows)
