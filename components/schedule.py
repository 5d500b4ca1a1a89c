"""A quantity over time, given in advance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ropeway.components import table
from ropeway.components.argument_checks import checked
from ropeway.components.errors import InputError
from ropeway.components.whole_files import whole


@checked
@dataclass(frozen=True)
class Schedule:
    """Piecewise linear over time: `times` [s], strictly increasing, and as many `speeds` [m/s].

    Before its first time it keeps the first speed; a run beyond its last time is an InputError. A steep
    pair of times stands for a step. Raises InputError.
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
        """Speed at a time [s]."""
        return float(np.interp(time, self.times, self.speeds))

    def to_csv(self, path: str | Path) -> Path:
        """Writes columns time [s] and speed [m/s]; returns the path. Raises WriteError."""
        rows = "".join(f"{time!r},{speed!r}\n" for time, speed in zip(self.times, self.speeds, strict=True))
        with whole(path) as file:
            file.write_text(f"time,speed\n{rows}", encoding="utf-8")
        return Path(path)

    @classmethod
    def from_csv(cls, path: table.Source, column: str = "speed") -> Schedule:
        """From a table, see `docs/files.md`.

        Parameters
        ----------
        path : str, Path or DataFrame
            With a column time [s] and the column of the speeds.
        column : str, default "speed"
            The column of the speeds [m/s], or of another quantity in SI units; a header such as "c1.speed [km/h]" is
            converted.

        Raises
        ------
        InputError
            With file, line and column.
        """
        layout = table.TableLayout(
            {"time": "s", column: "m/s" if column == "speed" else ""}, f"time,{column}\n0,0.5\n10,1"
        )
        read = table.read(path, layout)
        values = read.numbers("time", column)
        read.require_increase(values[:, 0], "time", "s")
        return cls(values[:, 0].tolist(), values[:, 1].tolist())

    def breaks(self) -> np.ndarray:
        """Times where it bends, and where it passes through zero [s]."""
        t, v = np.array(self.times), np.array(self.speeds)
        turn = np.flatnonzero(v[:-1] * v[1:] < 0.0)
        zeros = t[turn] - v[turn] * (t[turn + 1] - t[turn]) / (v[turn + 1] - v[turn])
        return np.unique(np.concatenate([t, zeros]))

    def require(self, time: float) -> None:
        """Raises InputError when it ends before a time [s]."""
        if self.times[-1] < time - 1e-9:
            raise InputError(
                f"The schedule ends at {self.times[-1]:g} s, before {time:g} s", "Make it longer or ask for less"
            )

    def on(self, times: Sequence[float]) -> Schedule:
        """The schedule with its speeds at other times [s] only."""
        return Schedule(times, [self.at(float(t)) for t in times])

    def later(self, by: float, until: float) -> Schedule:
        """The schedule as it is `by` seconds later: from there on, for `until` seconds; it keeps its last speed."""
        times = [0.0, *(t - by for t in self.times if by + 1e-9 < t < by + until - 1e-9), until]
        return Schedule(times, [self.at(by + t) for t in times])
