"""Natural frequencies, damping and shapes of a line about its equilibrium."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.errors import InputError
from ropeway.components.inertia import Inertia
from ropeway.components.table_writer import Tabular
from ropeway.systems.interrupts import interruptible
from ropeway.systems.statics.equilibrium import Equilibrium
from ropeway.systems.statics.equilibrium_solver import still
from ropeway.systems.studies.inertia.mass_matrix import Motion, linear_motion
from ropeway.systems.studies.inertia.material_points import CutSpan, material_points
from ropeway.systems.studies.inertia.natural_modes import NaturalModes, natural_modes
from ropeway.systems.studies.inertia.wave_return import wave_return

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_UNITS = {"frequency": "Hz", "period": "s", "damping": "1", "lengthwise": "1", "sideways": "1", "vertical": "1"}
_NOISE = 1e-12
"""Shares of the kinetic energy below this are rounding."""
_MOST = 50_000
"""Largest number of points of a line."""


@checked
@dataclass(frozen=True, eq=False)
class Modes(Tabular):
    """Natural modes of a line, as `rw.modes` returns them.

    Parameters
    ----------
    equilibrium : Equilibrium
        The equilibrium about which the line vibrates.
    frame : DataFrame
        Index mode, from 1; columns frequency [Hz], period [s], damping (share of the critical damping), lengthwise,
        sideways and vertical (shares of the kinetic energy), largest (where the motion is largest).
    points : DataFrame
        Points of each span, its ends included: span, point, station (unstretched distance from end a), x, y, z [m].
    shapes : ndarray
        Displacement of each point in each mode, scaled to a largest one of 1, (modes, points, 3): x, y, z. At a sheave
        it is that of the rope that runs over it.
    wave_return : DataFrame
        Index span; columns from_a, from_b: the time [s] in which a blow on the rope beside an end returns to it from
        the nearest load, or from the other end.

    Examples
    --------
    >>> found = rw.modes(rw.equilibrium(span), nodes=4, count=3)
    >>> found.shapes.shape, found.points["point"].iloc[0], list(found.wave_return.columns)
    ((3, 6, 3), 'a', ['from_a', 'from_b'])
    """

    equilibrium: Equilibrium
    frame: pd.DataFrame
    points: pd.DataFrame
    shapes: np.ndarray
    wave_return: pd.DataFrame

    def __post_init__(self) -> None:
        expected = (len(self.frame), len(self.points), 3)
        if self.shapes.shape != expected:
            raise InputError(f"Modes: shapes has the shape {self.shapes.shape}", f"Give displacements {expected}")

    def __repr__(self) -> str:
        first = f", the first at {self.frame['frequency'].iloc[0]:.4g} Hz" if len(self.frame) else ""
        return f"<Modes of {self.equilibrium.model.name!r}: {len(self.frame)}{first}>"

    def plot(self, k: int = 1) -> Figure:
        """Plot the shape of a mode, exaggerated.

        Parameters
        ----------
        k : int, default 1
            Number of the mode, from 1.

        Returns
        -------
        matplotlib.figure.Figure
            Elevation, and plan where the mode moves sideways.

        Raises
        ------
        InputError
            There is no such mode.
        """
        if k not in self.frame.index:
            raise InputError(f"Modes.plot: k is {k}", f"Give 1 to {len(self.frame)}")
        from ropeway.systems.studies.inertia.modes_plot import mode_figure

        row = self.frame.loc[k]
        title = f"{self.equilibrium.model.name}, mode {k}: {row['frequency']:.4g} Hz"
        return mode_figure(self.equilibrium, self.points, self.shapes[k - 1], title)


@checked
@interruptible
def modes(eq: Equilibrium, nodes: int = 6, count: int = 10, *, damping: float = 5e-4) -> Modes:
    """Natural frequencies, damping and shapes of the small vibrations of a line about an equilibrium.

    Ropes, loads, carriages, joints and masts have mass; supports, drums and driven sheaves are held. The rope is cut
    into exact catenaries at its loads and nodes, so that the line is at rest as before. Loads are clamped to the rope.
    The vibrations are small: no rope goes slack, no load swings far.

    Parameters
    ----------
    eq : Equilibrium
        Of a line, a rig, a guyed spar, a net: of any system; or `result.at(t)`.
    nodes : int, default 6
        Rope nodes in each span besides its loads, spread over the pieces between them. Loaded lines need few.
    count : int, default 10
        Number of modes, from the lowest frequency on.
    damping : float, default 5e-4
        Damping of the ropes in proportion to their stiffness [s]: the damping of a mode is pi * frequency * damping.

    Returns
    -------
    Modes

    Raises
    ------
    InputError
        An invalid number, too many points, or a load that stands on a support.
    EquilibriumError
        The line does not vibrate: the equilibrium is not stable.

    Examples
    --------
    >>> rw.modes(rw.equilibrium(span), count=2).frame["frequency"].round(2).tolist()
    [0.24, 0.47]
    """
    Inertia(nodes=nodes, damping=damping)  # checks them
    check.index(count - 1, _MOST, "modes", "count - 1")
    if eq.model.inertia is not None:
        raise InputError("The line is in motion, in a run with inertia", "Give rw.equilibrium(...) of its system")
    line = still(eq)
    spans = sum(len(run.spans) for run in line.runs)
    check.count(spans * (nodes + 1) + len(line.loads), "modes", "points", _MOST)
    cut = material_points(line, nodes)
    motion = linear_motion(cut)
    found = natural_modes(motion, count)
    points = _points(cut.spans)
    shapes = (motion.rows @ found.shape).T.reshape(len(found.frequency), len(points), 3)
    largest = np.abs(shapes).max(axis=(1, 2), initial=0.0, keepdims=True)
    shapes = shapes / np.where(largest > 0.0, largest, 1.0)
    return Modes(eq, _frame(motion, found, damping, points, shapes), points, shapes, wave_return(cut))


def _points(spans: tuple[CutSpan, ...]) -> pd.DataFrame:
    parts = [
        pd.DataFrame(
            {
                "span": span.name,
                "point": span.names,
                "station": span.station,
                **{axis: span.place[:, i] for i, axis in enumerate("xyz")},
            }
        )
        for span in spans
    ]
    columns = ["span", "point", "station", "x", "y", "z"]
    points = pd.concat(parts, ignore_index=True) if parts else pd.DataFrame(columns=columns)
    points.attrs["units"] = dict.fromkeys(columns[2:], "m")
    return points


def _frame(
    motion: Motion, found: NaturalModes, damping: float, points: pd.DataFrame, shapes: np.ndarray
) -> pd.DataFrame:
    energy = np.array([np.einsum("ik,ik->k", found.shape, part @ found.shape) for part in motion.mass])
    share = energy / energy.sum(axis=0)
    share[share < _NOISE] = 0.0
    size = np.linalg.norm(shapes, axis=2)
    table = pd.DataFrame(
        {
            "frequency": found.frequency / (2.0 * np.pi),
            "period": 2.0 * np.pi / found.frequency,
            "damping": 0.5 * damping * found.frequency,
            **dict(zip(("lengthwise", "sideways", "vertical"), share, strict=True)),
            "largest": [points["point"].iloc[int(row.argmax())] for row in size],
        },
        index=pd.RangeIndex(1, len(found.frequency) + 1, name="mode"),
    )
    table.attrs["units"] = dict(_UNITS)
    return table
