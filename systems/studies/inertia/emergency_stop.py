"""Emergency stops of a line at several decelerations, for the choice of a brake."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.errors import InputError
from ropeway.components.inertia import Inertia
from ropeway.components.table_writer import Tabular
from ropeway.systems.dynamics.result import Result
from ropeway.systems.dynamics.simulation import simulate
from ropeway.systems.interrupts import interruptible
from ropeway.systems.modelling.assembly import assemble
from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.modelling.intervention import Intervention
from ropeway.systems.modelling.system import System
from ropeway.systems.progress_bar import bar
from ropeway.systems.results.summary import each_node
from ropeway.systems.statics.equilibrium import Equilibrium
from ropeway.systems.statics.equilibrium_solver import equilibrium

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_UNITS = {
    "stopping_time": "s", "stopping_distance": "m", "highest_tension": "N", "at": "s", "share_of_SWL": "1",
    "dynamic_factor": "1", "support_factor": "1", "lowest_tension": "N", "brake_force": "N", "swing": "m",
}  # fmt: skip
_TOLERANCE = 1e-5
"""Of the simulations, at which peaks are accurate to some newtons."""
_LONGEST = 3600.0
"""Longest time for which a line is watched after a stop [s]."""
_MOST = 100
"""Largest number of decelerations."""


@checked
@dataclass(frozen=True, eq=False)
class EmergencyStops(Tabular):
    """Emergency stops of a line, as `rw.emergency_stop` returns them.

    Parameters
    ----------
    frame : DataFrame
        Index deceleration [m/s2]; columns stopping_time (over which the fastest drive is ramped down) [s],
        stopping_distance (the largest of a drive, which can lag behind its command) [m],
        highest_tension [N], in_span, at [s], share_of_SWL, dynamic_factor (the largest of a rope), support_factor (the
        largest of a support), at_support, lowest_tension [N], brake_force (the largest force of a drive on its rope)
        [N], swing (the largest of a load, from where it hangs in equilibrium) [m], slack (whether a rope goes slack:
        tensions then count until that time).
    results : tuple of Result
        The runs, in the order of the frame.

    Examples
    --------
    >>> rw.emergency_stop(line, decelerations=[2.0], settle=0.5)
    <EmergencyStops of 'mono-cable line': 1 decelerations>
    """

    frame: pd.DataFrame
    results: tuple[Result, ...]

    def __repr__(self) -> str:
        name = self.results[0].model.name if self.results else "a line"
        return f"<EmergencyStops of {name!r}: {len(self.frame)} decelerations>"

    def plot(self) -> Figure:
        """Plot the highest tension over time in each stop; peak, stopping distance and swing by deceleration.

        Returns
        -------
        matplotlib.figure.Figure
        """
        from ropeway.systems.studies.inertia.emergency_plot import stops_figure

        return stops_figure(self.frame, self.results)


@checked
@interruptible
def emergency_stop(
    line: System | Model,
    decelerations: Sequence[float] = (0.5, 1.0, 2.0, 4.0),
    *,
    settle: float = 10.0,
    every: float = 0.05,
    start: Equilibrium | None = None,
    inputs: Mapping[str, float] | None = None,
    inertia: Inertia | None = None,
    progress: bool | None = None,
    compiled: bool = False,
) -> EmergencyStops:
    """Stop a running line at several decelerations: peaks of tension, stopping distance, swing.

    All drives are ramped down to rest together, from the speeds at which they run, with the inertia of ropes, loads and
    wheels. A short stop swings the loads and raises the tension; a long one takes distance.

    Parameters
    ----------
    line : System or Model
        A line that a drive moves.
    decelerations : sequence of float, default (0.5, 1, 2, 4)
        Decelerations of the drives [m/s2].
    settle : float, default 10.0
        Time of the run after the line has stopped [s]; the peak can come seconds after the stop.
    every : float, default 0.05
        Interval of the records [s]; peaks of tension between them are found too.
    start : Equilibrium, optional
        Where the loads are at the stop, such as `result.at(t)`; by default the line's equilibrium.
    inputs : mapping of str to float, optional
        Speeds in place of those of the drives (`{"c1.speed": 2.5}`).
    inertia : Inertia, optional
        By default `Inertia()`.
    progress : bool, optional
        Whether to show a progress bar; by default on a terminal only.
    compiled : bool, default False
        Whether to run in compiled code, which needs a C compiler at first use.

    Returns
    -------
    EmergencyStops
        With a frame and a picture.

    Raises
    ------
    InputError
        No deceleration, one that is not positive, or a line that no drive moves.
    EquilibriumError
        The line has no equilibrium.
    SimulationError
        A run cannot continue.
    CompiledError, CompilerError, WriteError
        Of `compiled`: the core has no such line, has no compiler, or its cache cannot be written.

    Examples
    --------
    >>> stops = rw.emergency_stop(line, decelerations=[2.0], settle=1.0)
    >>> stops.frame["stopping_distance"].round(2).tolist()
    [0.25]
    """
    chosen = sorted({float(a) for a in decelerations})
    if not chosen:
        raise InputError("emergency_stop has no deceleration", "Give one or more [m/s2]")
    check.count(len(chosen), "emergency_stop", "decelerations", _MOST)
    for a in chosen:
        check.positive(a, "emergency_stop", "a deceleration", "m/s2")
    check.not_negative(settle, "emergency_stop", "settle", "s")
    check.positive(every, "emergency_stop", "every", "s")
    if max(settle, every) > _LONGEST:
        raise InputError(
            f"emergency_stop would watch the line for {max(settle, every):g} s after a stop",
            f"Give at most {_LONGEST:g} s",
        )
    model = line if isinstance(line, Model) else assemble(line)
    rest = equilibrium(model) if start is None else start
    speed = max((abs(v) for v in _speeds(model, rest, inputs or {}).values()), default=0.0)
    if speed == 0.0:
        raise InputError(f"No drive moves {model.name!r}", "Give a drive a speed, or inputs=")
    results = []
    with bar("emergency stop", float(len(chosen)), progress) as advance:
        for number, a in enumerate(chosen, 1):
            stop = [Intervention(0.0, "emergency stop", deceleration=a)]
            results.append(
                simulate(
                    model,
                    speed / a + max(settle, every),
                    every=every,
                    inputs=dict(inputs or {}),
                    start=rest,
                    tolerance=_TOLERANCE,
                    interventions=stop,
                    progress=False,
                    inertia=inertia or Inertia(),
                    compiled=compiled,
                )
            )
            advance(float(number))
    frame = pd.DataFrame([_row(r, speed / a) for r, a in zip(results, chosen, strict=True)])
    frame.index = pd.Index(chosen, name="deceleration")
    frame.attrs["units"] = {"deceleration": "m/s2", **_UNITS}
    return EmergencyStops(frame, tuple(results))


def _speeds(model: Model, rest: Equilibrium, inputs: Mapping[str, float]) -> dict[str, float]:
    """Commanded speeds of the drives [m/s] by their input."""
    commanded = dict(zip(rest.model.u.names, rest.point.u.tolist(), strict=True))
    commanded |= {name: signal for name, signal in zip(model.u.names, model.signals, strict=True) if _number(signal)}
    return {name: v for name, v in {**commanded, **inputs}.items() if name.rpartition(".")[2] == "speed"}


def _number(signal: object) -> bool:
    return isinstance(signal, (int, float))


def _row(result: Result, stopping_time: float) -> dict[str, object]:
    """A row of the table."""
    factors, frame = result.dynamic_factor(), result.full_frame
    slack = result.slack_time
    ropes, supports = (factors[factors["kind"] == kind] for kind in ("rope", "support"))
    highest, span = float(ropes["highest"].max()), str(ropes["highest"].idxmax())
    limits = {s.name: s.rope.safe_working_load for run in result.runs for s in run.spans}
    share = pd.Series({name: value / limits[name] for name, value in ropes["highest"].items()})
    until = frame[frame.index <= slack]
    ends = until.filter([f"{name}.tension_{end}" for name in limits for end in "ab"])
    drives = [n.name for n in each_node(result.runs) if n.drive_speed is not None and n.set_tension is None]
    ways = [np.ptp(frame[f"{name}.travel"]) for name in drives if f"{name}.travel" in frame]
    forces = until.filter([f"{name}.{force}" for name in drives for force in ("drive_force", "rope_tension")])
    swings = result.swing()["swing"]
    return {
        "stopping_time": stopping_time,
        "stopping_distance": float(max(ways, default=0.0)),
        "highest_tension": highest,
        "in_span": span,
        "at": float(ropes.loc[span, "at"]),
        "share_of_SWL": float(share.max()),
        "dynamic_factor": float(ropes["factor"].max()),
        "support_factor": float(supports["factor"].max()),
        "at_support": str(supports["factor"].idxmax()),
        "lowest_tension": float(ends.min(axis=None)),
        "brake_force": float(forces.abs().max(axis=None)) if forces.size else np.nan,
        "swing": float(swings.max()) if len(swings) else 0.0,
        "slack": bool(np.isfinite(slack)),
    }
