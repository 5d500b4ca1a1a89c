"""Heights over the ground along a run."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import pandas as pd

from ropeway.components.errors import InputError
from ropeway.components.ground import Ground
from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.statics.equilibrium import Equilibrium

_POINTS = 33
"""Points of a span in addition to its loads and the vertices of the ground."""
_SHORT = 1e-9
"""Length that counts as zero [m]."""
_SLACK = 20.0
"""Upper bound of a piece's span over twice its catenary's parameter, at which the rope hangs straight down."""


def heights(model: Model, read: Callable[[str], np.ndarray]) -> np.ndarray:
    """Smallest height of each span with its loads above the ground, at all records of a run.

    The rope between loads is a catenary with its mean stretch, exact to about 1e-4 of its sag without wind.
    `Equilibrium.clearance` gives the exact height at the lowest record of a span.

    Parameters
    ----------
    model : Model
        The model of the run.
    read : callable
        Values of a variable at all records, shape (records,).

    Returns
    -------
    ndarray, shape (records, spans)
        Heights [m].

    Raises
    ------
    InputError
        The system has no ground.
    """
    ground = model.system.ground
    if ground is None:
        raise InputError(f"{model.name!r} has no ground", "Give its line a terrain")
    found = []
    for run in model.runs:
        for k, span in enumerate(run.spans):
            slots = range(1, _count(model, span.name) + 1)
            between = [np.array([read(f"{span.name}.slot_{axis}[{j}]") for axis in "xyz"]) for j in slots]
            nodes = np.array([run.start(k, read), *between, run.end(k, read)]).transpose(2, 0, 1)
            horizontal = read(f"{span.name}.horizontal")
            bare = read(f"{span.name}.mass_per_length") * model.system.gravity
            weight = -read(f"{span.name}.load_z") if model.weather else bare
            parameter = horizontal / weight * (1.0 + horizontal * read(f"{span.name}.compliance"))
            found.append(_span_heights(ground, nodes, parameter))
    return np.array(found).T


def _count(model: Model, span: str) -> int:
    """Load slots of a span."""
    return sum(name.startswith(f"{span}.slot_distance[") for name in model.y.names)


def _span_heights(ground: Ground, nodes: np.ndarray, parameter: np.ndarray) -> np.ndarray:
    """Smallest heights [m] of a span above the ground, (records,).

    Parameters
    ----------
    ground : Ground
        The ground.
    nodes : ndarray, shape (records, n, 3)
        Ends of the span with its loads between them, in order.
    parameter : ndarray, shape (records,)
        Parameter of the catenaries between them [m]: horizontal tension over weight.
    """
    along = np.hypot(*(nodes[..., :2] - nodes[:, :1, :2]).transpose(2, 0, 1))
    lowest = _lowest(nodes[..., 2] - ground.elevations(nodes[..., 0], nodes[..., 1]))
    if along[:, -1].min() < _SHORT:
        return lowest
    ends = nodes[0, [0, -1], :2]
    stations = ground.stations(ends[:, 0], ends[:, 1])
    vertices = (ground.profile.station - stations[0]) / (stations[1] - stations[0] or np.inf)
    share = np.union1d(np.linspace(0.0, 1.0, _POINTS), vertices[(vertices > 0.0) & (vertices < 1.0)])
    x = share * along[:, -1:]
    piece = np.clip((along[:, :, None] <= x[:, None, :]).sum(axis=1) - 1, 0, nodes.shape[1] - 2)
    first, z = np.take_along_axis(along, piece, 1), np.take_along_axis(nodes[..., 2], piece, 1)
    run = np.take_along_axis(np.diff(along), piece, 1)
    rise = np.take_along_axis(np.diff(nodes[..., 2]), piece, 1)
    a = np.maximum(parameter[:, None], run / (2.0 * _SLACK))
    half_ratio = run / (2.0 * a)
    lowest_point = half_ratio - np.arcsinh(rise / (2.0 * a * np.sinh(np.maximum(half_ratio, _SHORT))))
    z = z + a * (np.cosh((x - first) / a - lowest_point) - np.cosh(lowest_point))
    fixed_ends = np.ptp(nodes[:, [0, -1], :2], axis=0).max() < _SHORT
    at = nodes[: 1 if fixed_ends else None, :1, :2]
    at = at + share[None, :, None] * (nodes[: len(at), -1:, :2] - at)
    return np.fmin(lowest, _lowest(z - ground.elevations(at[..., 0], at[..., 1])))


def _lowest(heights: np.ndarray) -> np.ndarray:
    """The least value of each row; inf without ground."""
    return np.asarray(np.fmin.reduce(np.where(np.isnan(heights), np.inf, heights), axis=1))


def clearance(
    names: Sequence[str], heights: np.ndarray, line_at: Callable[[int], Equilibrium], times: np.ndarray
) -> pd.DataFrame:
    """As `Equilibrium.clearance`, each span at its lowest record, with the time [s].

    Parameters
    ----------
    names : sequence of str
        Names of the spans.
    heights : ndarray, shape (records, spans)
        Heights from `heights`.
    line_at : callable
        Function that returns the line at a record.
    times : ndarray, shape (records,)
        Times of the records [s].
    """
    lowest = np.argmin(heights, axis=0)
    rows: dict[str, pd.Series[float]] = {}
    for i in sorted(set(lowest.tolist())):
        frame = line_at(i).clearance.assign(time=times[i])
        rows |= {name: frame.loc[name] for name, own in zip(names, lowest, strict=True) if own == i}
    found = pd.DataFrame([rows[name] for name in names]).rename_axis("span")
    found.attrs["units"] = {**dict.fromkeys(found.columns, "m"), "time": "s"}
    return found
