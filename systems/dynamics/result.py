"""A simulation, ready to ask: its data, its reports, its pictures and files."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Unpack

import numpy as np
import pandas as pd

from ropeway.components.argument_checks import checked
from ropeway.components.errors import InputError
from ropeway.components.schedule import Schedule
from ropeway.components.terrain import Profile
from ropeway.systems.dynamics.event_stepper import EventStepper
from ropeway.systems.reporting.document import ReportOptions, style_of, write_report
from ropeway.systems.results.energy_balance import energy, power
from ropeway.systems.results.run_data import RunData
from ropeway.systems.results.summary import Summary, summary
from ropeway.systems.statics.equilibrium import Equilibrium

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@checked
@dataclass(frozen=True, eq=False)
class Result(RunData):
    """A simulation. `records` are all states written down, both sides of every event among them; `on_grid`
    marks those of the frame, `exact` those in which every section of the line was solved: the others are
    solved when they are asked for. `parameters` is the model's parameter vector of the run; `noted` is what was
    written down as it happened, `events` that and the limits reached; `tolerance` is that of the integration."""

    def __repr__(self) -> str:
        end = self.records[-1].time if self.records else 0.0
        return f"<Result of {self.model.name!r}: {end:g} s, {len(self.records)} records>"

    def at(self, time: float) -> Equilibrium:
        """The line at a time [s], after an event at that time: `simulate(start=...)` goes on from it as the run did.
        Raises InputError outside the run, SimulationError where its certificate fails."""
        times = self.times
        if not times[0] <= time <= times[-1]:
            raise InputError(f"{time} s is outside the run", f"Choose from {times[0]:g} to {times[-1]:g} s")
        i = int(np.searchsorted(times, time, side="right")) - 1
        state = self._state(i)
        if times[i] != time:
            a, b = self.records[i], self.records[i + 1]
            signals = [
                Schedule((a.time, b.time), (u, v)) if u != v else float(u) for u, v in zip(a.u, b.u, strict=True)
            ]
            stepper = EventStepper(state, signals, self.tolerance)
            stepper.run_to(time)
            state = stepper.state
        return self._line(state, i)

    def summary(self) -> Summary:
        """Safety report: tensions against SWL and MBL, sag, lift-off, grip, relief valves, loads held. Raises
        InputError without a rope."""
        self._require_rope()
        return summary(self)

    def _require_rope(self) -> None:
        if not self.runs:
            raise InputError(f"System {self.model.name!r} has no rope", "Look at its frame")

    def power(self) -> pd.DataFrame:
        """Mean, highest and lowest power [W], energy pulled and recovered [J] of each control sheave and the line."""
        return power(self)

    def energy(self) -> pd.Series:
        """The energy balance of the run [J]."""
        return energy(self)

    def report(self, path: str | Path, **options: Unpack[ReportOptions]) -> Path:
        """Write the report of the run: the moving line, tensions, supports, spans, drives and events.

        Parameters
        ----------
        path : str or Path
            HTML, or PDF by a browser's print; needs the extra `report`.
        **options
            `project`, `units`, `labels`, `more`, see `docs/reports.md`.

        Returns
        -------
        Path

        Raises
        ------
        InputError, WriteError
        """
        from ropeway.systems.results.result_report import sections_of

        self._require_rope()
        style = style_of(options)
        return write_report(path, self.model.name, sections_of(self, self.summary(), style), options)

    def plot(self, components: Sequence[str] | None = None) -> Figure:
        """Tensions over time at the control sheaves (or the first idlers, where there are none), or at `components`,
        with SWL and MBL. Raises InputError without a rope, UnknownNameError."""
        from ropeway.systems.results.plots import tensions_over_time

        self._require_rope()
        return tensions_over_time(self, components)

    def plot_power(self) -> Figure:
        """Power of the control sheaves over time, and energy pulled and recovered. Raises UnknownNameError where there
        is none."""
        from ropeway.systems.results.plots import power_over_time

        return power_over_time(self)

    def plot_line(self, time: float | None = None, *, ground: Profile | None = None) -> Figure:
        """The line at a time [s], by default the last: profile, loads, supports, tensions.

        ground: the ground under it, a `rw.Profile` over the horizontal distance along the line. Raises InputError
        without a rope, and for a ground that ends before the line."""
        from ropeway.systems.results.line_plot import line_profile

        self._require_rope()
        return line_profile(self.at(self.times[-1] if time is None else time), ground)
