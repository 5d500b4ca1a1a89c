"""A quantity over time, known in advance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ropeway.components import table
from ropeway.components.argument_checks import checked
from ropeway.components.errors import InputError
from ropeway.components.whole_files import whole

_UNITS = {"temperature": "degC", "wind_from": "deg"}
"""Units of quantities that a model takes in other than SI units."""


@checked
@dataclass(frozen=True)
class Schedule:
    """A speed over time, piecewise linear; or another quantity, such as the values of an `Environment`.

    Before its first time it has the first speed; a run beyond its last time is an InputError. Two close times represent
    a step.

    Parameters
    ----------
    times : sequence of float
        Times [s], strictly increasing.
    speeds : sequence of float
        Speeds at these times [m/s].

    Raises
    ------
    InputError
        Unequal numbers of values, values that are not finite, or times that do not increase.

    Examples
    --------
    >>> rw.Schedule([0.0, 10.0], [0.5, 1.0]).at(4.0)
    0.7
    """

    times: tuple[float, ...]
    speeds: tuple[float, ...]

    def __init__(self, times: Sequence[float], speeds: Sequence[float]) -> None:
        object.__setattr__(self, "times", tuple(float(t) for t in times))
        object.__setattr__(self, "speeds", tuple(float(s) for s in speeds))
        if not self.times or len(self.times) != len(self.speeds):
            raise InputError(
                f"Schedule has {len(self.times)} times and {len(self.speeds)} speeds",
                "Give as many speeds as times, at least one",
            )
        if not np.all(np.isfinite(self.times + self.speeds)):
            raise InputError("Schedule holds a value that is not finite", "Remove NaN and inf")
        if np.any(np.diff(self.times) <= 0.0):
            k = int(np.argmax(np.diff(self.times) <= 0.0))
            raise InputError(
                f"Schedule times do not increase: {self.times[k + 1]} s after {self.times[k]} s", "Sort them"
            )

    def at(self, time: float) -> float:
        """Speed at a time.

        Parameters
        ----------
        time : float
            Time [s].

        Returns
        -------
        float
            Speed [m/s].
        """
        return float(np.interp(time, self.times, self.speeds))

    def to_csv(self, path: str | Path) -> Path:
        """Write the schedule with the columns time [s] and speed [m/s].

        Parameters
        ----------
        path : str or Path
            The file.

        Returns
        -------
        Path
            The file.

        Raises
        ------
        WriteError
            The file could not be written.
        """
        rows = "".join(f"{time!r},{speed!r}\n" for time, speed in zip(self.times, self.speeds, strict=True))
        with whole(path) as file:
            file.write_text(f"time,speed\n{rows}", encoding="utf-8")
        return Path(path)

    @classmethod
    def from_csv(cls, path: table.Source, column: str = "speed") -> Schedule:
        """A schedule from a table, see `docs/files.md`.

        Parameters
        ----------
        path : str, Path or DataFrame
            A table with a column time [s] and the column of the speeds.
        column : str, default "speed"
            The column of the speeds [m/s], or of another quantity in SI units, but temperature [degrees C] and
            wind_from [degrees]; a header such as "c1.speed [km/h]" or "temperature [K]" is converted.

        Returns
        -------
        Schedule
            The schedule.

        Raises
        ------
        InputError
            The table is invalid; the message has file, line and column.
        """
        unit = "m/s" if column == "speed" else _UNITS.get(column.rpartition(".")[2], "")
        layout = table.TableLayout({"time": "s", column: unit}, f"time,{column}\n0,0.5\n10,1")
        read = table.read(path, layout)
        values = read.numbers("time", column)
        read.require_increase(values[:, 0], "time", "s")
        return cls(values[:, 0].tolist(), values[:, 1].tolist())

    def breaks(self) -> np.ndarray:
        """Times of its vertices and zeros.

        Returns
        -------
        ndarray
            Times [s], increasing.
        """
        t, v = np.array(self.times), np.array(self.speeds)
        turn = np.flatnonzero(v[:-1] * v[1:] < 0.0)
        zeros = t[turn] - v[turn] * (t[turn + 1] - t[turn]) / (v[turn + 1] - v[turn])
        return np.unique(np.concatenate([t, zeros]))

    def require(self, time: float) -> None:
        """Check that the schedule covers a time.

        Parameters
        ----------
        time : float
            Time [s].

        Raises
        ------
        InputError
            The schedule ends before it.
        """
        if self.times[-1] < time - 1e-9:
            raise InputError(
                f"The schedule ends at {self.times[-1]:g} s, before {time:g} s",
                "Extend the schedule or shorten the run",
            )

    def on(self, times: Sequence[float]) -> Schedule:
        """The schedule sampled at other times.

        Parameters
        ----------
        times : sequence of float
            Times [s], strictly increasing.

        Returns
        -------
        Schedule
            Piecewise linear between these times.
        """
        return Schedule(times, [self.at(float(t)) for t in times])

    def later(self, by: float, until: float) -> Schedule:
        """The schedule shifted in time, for a run that starts later.

        Parameters
        ----------
        by : float
            Time that becomes zero [s].
        until : float
            Duration of the new schedule [s]; beyond the old one the last speed holds.

        Returns
        -------
        Schedule
            From 0 to `until`.
        """
        times = [0.0, *(t - by for t in self.times if by + 1e-9 < t < by + until - 1e-9), until]
        return Schedule(times, [self.at(by + t) for t in times])
