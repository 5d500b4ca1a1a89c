"""Estimates while a line runs: masses of its loads, and the reserve of its ropes against the safe working load."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from functools import cached_property
from typing import Any

import numpy as np
import pandas as pd

from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.errors import InputError, UnknownNameError
from ropeway.components.table_file import name_and_unit
from ropeway.components.table_numbers import NumberError, numbers
from ropeway.components.table_writer import Tabular
from ropeway.components.units import conversion
from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.modelling.system import System
from ropeway.systems.statics.equilibrium import Equilibrium
from ropeway.systems.studies.fitting.kalman_filter import KalmanFilter
from ropeway.systems.studies.fitting.line_source import LineSource
from ropeway.systems.studies.fitting.measured import GIVEN, MISSING, TIME, Column, unit_in
from ropeway.systems.studies.fitting.moving_line import MovingLine, require_parameter
from ropeway.systems.studies.sensitivity.linearisation import LinearState
from ropeway.systems.studies.sensitivity.perturbations import Varied
from ropeway.systems.studies.sensitivity.sensitivities import linearised

_KNOWN_TO = 0.5
"""Standard deviation of a free quantity without a prior, relative to its declared value."""


@checked
@dataclass(frozen=True)
class Estimate:
    """What a monitor knows after a row.

    Attributes
    ----------
    time : float
        [s].
    value, standard_error : dict of str to float
        Free quantities on the line now, in SI units.
    reserve, reserve_error : float
        Safe working load minus the highest tension of all ropes, and its standard error [N].
    span : str
        Where the reserve is smallest.
    misses : dict of str to float
        Measured minus predicted value of each column, over its standard deviation.

    Examples
    --------
    >>> watch = rw.monitor(line, columns={"time": "time", "A": "c1.tension_in"}, free="*.mass", sigma=100.0)
    >>> sorted(watch.update({"time": 1.0, "A": 46.9e3}).misses)
    ['A']
    """

    time: float
    value: Mapping[str, float]
    standard_error: Mapping[str, float]
    reserve: float
    reserve_error: float
    span: str
    misses: Mapping[str, float]


@checked
def monitor(
    line: System | Model,
    *,
    columns: Mapping[str, str],
    free: str | Sequence[str],
    sigma: float | Mapping[str, float],
    prior: Mapping[str, tuple[float, float]] | None = None,
    drift: Mapping[str, float] | None = None,
) -> Monitor:
    """Estimate masses of loads and the reserve of the ropes while a line runs.

    The line starts at rest as declared at time 0, and follows the rows: measured inputs, such as speeds, move it; after
    each row an extended Kalman filter with exact derivatives corrects the free quantities by the measured values.

    Parameters
    ----------
    line : System or Model
        Its declarations, with the expected masses of its loads.
    columns : mapping of str to str
        The quantity of each column, as for `fit`: one is "time", results are measured, inputs are given.
    free : str or sequence of str
        Masses of loads ("l7.mass"; `"*.mass"` for all, as they come on the line), which stay above zero, and parameters
        ("s3.friction"), which stay in their ranges.
    sigma : float or mapping of str to float
        Standard deviation of the measured values, in SI units; by column.
    prior : mapping of str to (float, float), optional
        Expected value and standard deviation of free quantities, by name or pattern; by default the declared value,
        known to 50 %.
    drift : mapping of str to float, optional
        By how much free quantities may change: standard deviation after one second, in SI units, by name or pattern.

    Returns
    -------
    Monitor
        `update(row)` takes a row, `follow(rows)` an iterator of rows.

    Raises
    ------
    InputError, UnknownNameError
        An unknown quantity, a missing time, a prior or drift of what is not free, or a responding control sheave whose
        speed is not given.
    EquilibriumError
        The line has no equilibrium to start from.

    Examples
    --------
    >>> watch = rw.monitor(line, columns={"time": "time", "A": "c1.tension_in"}, free="*.mass", sigma=100.0)
    >>> now = watch.update({"time": 1.0, "A": 46.9e3})
    >>> now.time
    1.0
    """
    return Monitor(line, columns, free, sigma, prior, drift)


@checked
class Monitor(Tabular):
    """Estimates while a line runs, as `rw.monitor` makes it.

    Parameters
    ----------
    line : System or Model
        The line, with the expected masses of its loads.
    columns : mapping of str to str
        The quantity of each column.
    free : str or sequence of str
        Masses of loads, and parameters.
    sigma : float or mapping of str to float
        Standard deviation of the measured values, in SI units.
    prior : mapping of str to (float, float), optional
        Expected value and standard deviation of free quantities.
    drift : mapping of str to float, optional
        Standard deviation of their changes after one second.

    Attributes
    ----------
    name : str
        Name of the line.
    estimates : list of Estimate
        All estimates so far.

    Examples
    --------
    >>> watch = rw.monitor(line, columns={"time": "time", "A": "c1.tension_in"}, free="*.mass", sigma=100.0)
    >>> now = next(iter(watch.follow([{"time": 1.0, "A": 46.9e3}])))
    >>> now.reserve > 0.0
    True
    """

    def __init__(
        self,
        line: System | Model,
        columns: Mapping[str, str],
        free: str | Sequence[str],
        sigma: float | Mapping[str, float],
        prior: Mapping[str, tuple[float, float]] | None = None,
        drift: Mapping[str, float] | None = None,
    ) -> None:
        names = [free] if isinstance(free, str) else list(free)
        if not names:
            raise InputError("free is empty", "Name at least one quantity, such as '*.mass'")
        source = LineSource(line)
        self.name = source.name
        self._columns = _columns(source, columns)
        self._measured = [c for c in self._columns.values() if c.role not in (GIVEN, TIME)]
        given = [c.target for c in self._columns.values() if c.role == GIVEN]
        if unknown := [name for name in given if name not in source.model.u.index]:
            raise InputError(f"{unknown[0]} cannot be given over time", "Only inputs, such as speeds, vary in a run")
        self._sigma = _sigmas(self._measured, sigma)
        self._prior, self._drift = dict(prior or {}), dict(drift or {})
        for what, keys in (("prior", self._prior), ("drift", self._drift)):
            if unused := [k for k in keys if not any(fnmatchcase(k, n) or fnmatchcase(n, k) for n in names)]:
                raise UnknownNameError(f"{what} has {unused[0]!r}, which is not free", f"Free are {', '.join(names)}")
        for key, value in self._drift.items():
            check.not_negative(value, "monitor", f"drift of {key}")
        self._line = MovingLine(source.rest, given)
        self._patterns = [name for name in names if "*" in name or name.endswith(".mass")]
        self._filter = KalmanFilter()
        loads = {f"{load}.mass" for run in source.rest.runs for load in run.loads.names}
        fed = any(run.feed is not None for run in source.rest.runs)
        for name in names:
            if name not in self._patterns:
                self._add(name, require_parameter(source.rest.model, name))
            elif not fed and not any(fnmatchcase(load, name) for load in loads):
                raise UnknownNameError(f"No load is named {name!r}", f"Loads are {', '.join(sorted(loads)) or 'none'}")
        self.estimates: list[Estimate] = []

    def __repr__(self) -> str:
        return f"<Monitor of {self.name!r}: {len(self.estimates)} rows>"

    def follow(self, rows: Iterable[Mapping[str, Any]] | pd.DataFrame) -> Iterator[Estimate]:
        """Estimates row by row, as rows come.

        Parameters
        ----------
        rows : iterable of mapping, or DataFrame
            Each with a value for each column; a missing or blank measured value is skipped.

        Returns
        -------
        iterator of Estimate

        Raises
        ------
        InputError
            A row without its time, or before the last one.
        SimulationError
            The line cannot be followed.
        """
        if isinstance(rows, pd.DataFrame):
            named = rows.reset_index() if rows.index.name is not None else rows
            rows = named.to_dict("records")
        listed = isinstance(rows, Collection) and not isinstance(rows, np.ndarray)
        if isinstance(rows, np.ndarray) or (listed and not all(isinstance(row, Mapping) for row in rows)):
            raise InputError("A row is not a mapping", "Give rows with a value for each column, by name")
        return (self.update(row) for row in rows)

    def update(self, row: Mapping[str, Any]) -> Estimate:
        """Take a row: advance the line to its time, and correct the estimates.

        Parameters
        ----------
        row : mapping of str to float
            A value for each column; a missing or blank measured value is skipped.

        Returns
        -------
        Estimate

        Raises
        ------
        InputError
            The row has no time, or is before the last one; or deviations are further apart than numbers resolve.
        SimulationError
            The line cannot be followed.
        """
        values = {c.target: _read(row, key, c) for key, c in self._columns.items()}
        time = values.pop(TIME)
        if not np.isfinite(time):
            raise InputError("A row has no time", "Leave it out")
        before = self._line.time
        inputs = {n: values[n] for n in self._line.given if np.isfinite(values[n])}
        line = self._line.advance(time, inputs)
        self._follow_loads()
        state = linearised(line, Varied.of(line, self._filter.names))
        sigma = np.array([_of(self._drift, name, 0.0) for name in self._filter.names])
        self._filter.drift(sigma * np.sqrt(time - before))
        old = self._filter.state.copy()
        misses = self._correct(state, values)
        moved = self._filter.state - old
        self._line.set(dict(zip(self._filter.names, self._filter.state.tolist(), strict=True)))
        found = self._estimate(time, line, state, moved, misses)
        self.estimates.append(found)
        self.__dict__.pop("frame", None)
        return found

    def _correct(self, state: LinearState, values: Mapping[str, float]) -> dict[str, float]:
        """Corrects the estimates by a row; returns what each column is off by, in standard deviations."""
        used = [i for i, c in enumerate(self._measured) if np.isfinite(values[c.target])]
        if not used:
            return {}
        off = np.array([values[self._measured[i].target] - state.read(self._measured[i].target) for i in used])
        rates = np.array([state.rates(self._measured[i].target) for i in used])
        misses = self._filter.correct(off, rates, self._sigma[used])
        return {self._measured[i].name: float(miss) for i, miss in zip(used, misses, strict=True)}

    def _follow_loads(self) -> None:
        """Adds loads that have come on the line, and drops those that have left it."""
        there = self._line.on_line()
        names = [f"{load}.mass" for load in there]
        free = [name for name in names if any(fnmatchcase(name, pattern) for pattern in self._patterns)]
        known = [name for name in self._filter.names if name.endswith(".mass")]
        self._filter.drop([name for name in known if name not in free])
        masses = {
            name: float(mass)
            for run in self._line.state.runs
            for name, mass in zip(run.loads.names, run.loads.mass, strict=True)
        }
        for name in free:
            if name not in known:
                self._add(name, masses[name.removesuffix(".mass")])
        self._line.set(dict(zip(self._filter.names, self._filter.state.tolist(), strict=True)))

    def _add(self, name: str, declared: float) -> None:
        """Adds a free quantity with its prior. Raises InputError."""
        value, sigma = _of(self._prior, name, (declared, _KNOWN_TO * abs(declared)))
        check.positive(sigma, "monitor", f"standard deviation of {name}")
        self._filter.add(name, value, sigma, *self._line.bounds_of(name, value))

    def _estimate(
        self, time: float, line: Equilibrium, state: LinearState, moved: np.ndarray, misses: Mapping[str, float]
    ) -> Estimate:
        """The estimate after a row; tensions follow a correction to first order."""
        least, place, rates = np.inf, "", np.zeros(len(moved))
        for run in line.runs:
            for span in run.spans:
                for end in "ab":
                    name = f"{span.name}.tension_{end}"
                    slope = state.rates(name)
                    reserve = run.rope.safe_working_load - state.read(name) - float(slope @ moved)
                    if reserve < least:
                        least, place, rates = reserve, span.name, slope
        errors = np.sqrt(np.diag(self._filter.covariance))
        return Estimate(
            time,
            dict(zip(self._filter.names, self._filter.state.tolist(), strict=True)),
            dict(zip(self._filter.names, errors.tolist(), strict=True)),
            float(least),
            float(np.sqrt(rates @ self._filter.covariance @ rates)),
            place,
            misses,
        )

    @cached_property
    def frame(self) -> pd.DataFrame:
        """All estimates: index time [s]; columns (quantity, value or standard_error); NaN where a load is not on the
        line."""
        rows = []
        for one in self.estimates:
            row: dict[tuple[str, str], Any] = {
                ("reserve", "value"): one.reserve, ("reserve", "standard_error"): one.reserve_error,
            }  # fmt: skip
            for name, value in one.value.items():
                row[name, "value"], row[name, "standard_error"] = value, one.standard_error[name]
            rows.append(row)
        frame = pd.DataFrame(rows, index=pd.Index([one.time for one in self.estimates], name="time"))
        if len(frame.columns):
            frame.columns = pd.MultiIndex.from_tuples(frame.columns, names=["quantity", ""])
        return frame


def _columns(source: LineSource, columns: Mapping[str, str]) -> dict[str, Column]:
    """The columns by their names in a row. Raises InputError, UnknownNameError."""
    found = dict[str, Column]()
    for key, target in columns.items():
        role = TIME if target == TIME else source.role(target)
        found[key] = Column(name_and_unit(key)[0], target, "s" if target == TIME else source.unit(target), role)
        _conversion(key, found[key])
    targets = [column.target for column in found.values()]
    if targets.count(TIME) != 1:
        raise InputError("columns has no time", 'Map the column of the time: {"t": "time"}')
    if all(column.role in (GIVEN, TIME) for column in found.values()):
        raise InputError("No column is measured", "Name at least one that holds a result, such as a tension")
    return found


def _conversion(key: str, column: Column) -> tuple[float, float]:
    """Factor and offset to the SI unit of a column. Raises InputError."""
    try:
        return conversion(name_and_unit(key)[1] or unit_in(column), column.unit)
    except InputError as error:
        raise InputError(f"Column {key!r}: {error.cause}", error.remedy) from error


def _read(row: Mapping[str, Any], key: str, column: Column) -> float:
    """A value of a row in SI units; NaN where it is missing or blank. Raises InputError."""
    value = row.get(key, row.get(column.name))
    if value is None or value is pd.NA or (isinstance(value, str) and value.strip().casefold() in {"", *MISSING}):
        return np.nan
    number = value
    if isinstance(value, str):
        try:
            (number,) = numbers([value], [False], points=True)
        except NumberError as error:
            raise InputError(f"{key} is {value!r}: {error.cause}", error.remedy) from error
    if isinstance(number, bool) or not isinstance(number, (int, float, np.integer, np.floating)):
        raise InputError(f"{key} is {value!r}", "Give a number, or leave it blank")
    factor, offset = _conversion(key, column)
    return float(factor * number + offset)


def _sigmas(columns: Sequence[Column], sigma: float | Mapping[str, float]) -> np.ndarray:
    """Standard deviations of the measured columns. Raises InputError."""
    found = []
    for column in columns:
        value = sigma if not isinstance(sigma, Mapping) else sigma.get(column.name, sigma.get(column.target))
        if value is None:
            raise InputError(f"sigma has no value for {column.name}", "Give one for each measured column")
        check.positive(value, "monitor", f"sigma of {column.name}")
        found.append(value)
    return np.array(found)


def _of(given: Mapping[str, Any], name: str, otherwise: Any) -> Any:
    """The value for a name, or for the first pattern that it matches."""
    if name in given:
        return given[name]
    return next((value for pattern, value in given.items() if fnmatchcase(name, pattern)), otherwise)
