"""The result of a simulation: its data, reports, pictures and files."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.errors import InputError
from ropeway.components.schedule import Schedule
from ropeway.components.terrain import Profile
from ropeway.systems.dynamics.steppers import stepper_of
from ropeway.systems.interrupts import interruptible
from ropeway.systems.reporting.blocks import Section
from ropeway.systems.reporting.reported import Reported
from ropeway.systems.reporting.style import Style
from ropeway.systems.results.dynamic_factor import dynamic_factor, swing
from ropeway.systems.results.energy_balance import energy, power
from ropeway.systems.results.quasi_static import QuasiStatic
from ropeway.systems.results.run_data import RunData
from ropeway.systems.results.summary import Summary, summary
from ropeway.systems.statics.equilibrium import Equilibrium

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@checked
@dataclass(frozen=True, eq=False)
class Result(RunData, Reported):
    """A simulation: states at many times, and what follows from them by the model.

    Attributes
    ----------
    model : Model
    runs : tuple of Run
        The ropes with their loads.
    parameters : ndarray
        The model's parameter vector of the run, shape (np,).
    records : sequence of Record
        All states, on both sides of every event too; with inertia also those between the rows at which tensions are
        highest or lowest.
    on_grid : ndarray of bool
        Which records belong to `frame`, shape (records,).
    exact : ndarray of bool
        Records in which every section of the line was solved; the others are solved when they are read.
    noted : tuple of Event
        Crossings, responses and interventions; `events` has the limits reached too.
    tolerance : float
        Of the integration.
    compiled : bool
        Whether the run was compiled: then its quantities are too.

    Examples
    --------
    >>> result = rw.simulate(line, 10.0, every=1.0)
    >>> result.frame.shape[0], result.frame.attrs["units"]["c1.tension_in"]
    (11, 'N')
    """

    def __repr__(self) -> str:
        end = self.records[-1].time if self.records else 0.0
        return f"<Result of {self.model.name!r}: {end:g} s, {len(self.records)} records>"

    def at(self, time: float) -> Equilibrium:
        """The line at a time, after an event at that time.

        `simulate(start=...)` continues from it as the run did.

        Parameters
        ----------
        time : float
            Within the run [s].

        Returns
        -------
        Equilibrium

        Raises
        ------
        InputError
            Outside the run.
        SimulationError
            Where the state fails its certificate.
        """
        times = self.times
        if not times[0] <= time <= times[-1]:
            raise InputError(f"{time} s is outside the run", f"Choose from {times[0]:g} to {times[-1]:g} s")
        last = int(np.searchsorted(times, time, side="right")) - 1
        # With inertia a state between two stops of the run is interpolated.
        solved = np.flatnonzero(self.exact[: last + 1]) if self.model.inertia is not None else np.array([last])
        i = int(solved[-1]) if len(solved) else last
        state = self.state(i)
        if times[i] != time:
            a, b = self.records[i], self.records[last + 1]
            signals = [
                Schedule((a.time, b.time), (u, v)) if u != v else float(u) for u, v in zip(a.u, b.u, strict=True)
            ]
            stepper = stepper_of(state, signals, self.tolerance)
            stepper.run_to(time)
            state = stepper.state
        return self._line(state, i)

    def summary(self) -> Summary:
        """Safety report: tensions against SWL and MBL, sag, lift-off, grip, relief valves, loads held.

        Of a run with inertia also the dynamic factors. Its tensions count until a rope goes slack.

        Returns
        -------
        Summary

        Raises
        ------
        InputError
            Without a rope.
        """
        self._require_rope()
        return summary(self, None if self.model.inertia is None else self.dynamic_factor())

    def _require_rope(self) -> None:
        if not self.runs:
            raise InputError(f"System {self.model.name!r} has no rope", "Look at its frame")

    def power(self) -> pd.DataFrame:
        """Mean, highest and lowest power [W], energy supplied and recovered [J] of each drive and of the line.

        Returns
        -------
        DataFrame
        """
        return power(self)

    def dynamic_factor(self) -> pd.DataFrame:
        """How far inertia raises the tensions of ropes and the loads of supports.

        The peaks of the run over those of the line in equilibrium at each time, with the rope that the drives have
        moved until then and the loads that hang on it then; until a rope breaks. After a rope has gone slack (event
        "slack rope") tensions are not counted: the snap of a rope that tightens again is not resolved.

        Returns
        -------
        DataFrame
            Index component: spans and supports; columns kind ("rope" or "support"), highest [N], at [s], quasi_static
            [N], factor.

        Raises
        ------
        InputError
            The run is without inertia.
        """
        return dynamic_factor(self, self._quasi_static)

    def swing(self) -> pd.DataFrame:
        """How far loads swing in a run with inertia.

        Returns
        -------
        DataFrame
            Index load; columns swing: the largest distance from where it would hang in equilibrium [m], at [s].

        Raises
        ------
        InputError
            The run is without inertia.
        """
        return swing(self, self._quasi_static)

    @cached_property
    @interruptible
    def _quasi_static(self) -> QuasiStatic:
        return QuasiStatic.of(self)

    def energy(self) -> pd.Series:
        """The energy balance of the run [J].

        Returns
        -------
        Series
        """
        return energy(self)

    def _report_title(self, style: Style) -> str:
        return self.model.name

    def _report_sections(self, style: Style) -> Sequence[Section]:
        from ropeway.systems.results.result_report import sections_of

        self._require_rope()
        return sections_of(self, self.summary(), style)

    def animate(self, path: str | Path, *, frames: int = 120, rate: int = 12) -> Path:
        """Write the line with its loads as a moving picture.

        Parameters
        ----------
        path : str or Path
            Ends with .gif, .mp4 (needs ffmpeg) or .html (a page with a player, extra `report`).
        frames : int, default 120
            Most pictures of a GIF or MP4.
        rate : int, default 12
            Pictures a second.

        Returns
        -------
        Path

        Raises
        ------
        InputError
            An unknown format, a number that is not above zero, or a missing package.
        WriteError
            The file could not be written.
        """
        from ropeway.systems.results.animation import animate

        self._require_rope()
        check.count(frames, "animate", "frames", 10_000)
        check.positive(float(rate), "animate", "rate", "1/s")
        return animate(self, path, max(frames, 2), rate)

    def plot(self, components: Sequence[str] | None = None) -> Figure:
        """Plot tensions over time, with SWL and MBL.

        Parameters
        ----------
        components : sequence of str, optional
            By default the control sheaves, or the first idlers where there are none.

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        InputError
            Without a rope.
        UnknownNameError
        """
        from ropeway.systems.results.plots import tensions_over_time

        self._require_rope()
        return tensions_over_time(self, components)

    def plot_power(self) -> Figure:
        """Plot the power of the drives over time, and the energy supplied and recovered.

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        UnknownNameError
            Without a drive.
        """
        from ropeway.systems.results.plots import power_over_time

        return power_over_time(self)

    def plot_line(self, time: float | None = None, *, ground: Profile | None = None) -> Figure:
        """Plot the line at a time: profile, loads, supports, tensions.

        Parameters
        ----------
        time : float, optional
            [s]; by default the end.
        ground : Profile, optional
            The ground over the horizontal distance along the line.

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        InputError
            Without a rope, outside the run, and for a ground that ends before the line.
        """
        from ropeway.systems.results.line_plot import line_profile

        self._require_rope()
        return line_profile(self.at(self.times[-1] if time is None else time), ground)
