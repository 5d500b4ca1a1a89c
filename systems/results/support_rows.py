"""Forces of the ropes on their supports, with angles and reserves: a row for each rope at each support, and one for all
ropes of a support that has several."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd

from ropeway.components.carriage import Carriage
from ropeway.components.carriage_on_shoe import CarriageOnShoe
from ropeway.components.errors import InputError, UnknownNameError
from ropeway.components.guyed_spar import GuyedSpar
from ropeway.components.intermediate_support import IntermediateSupport
from ropeway.components.node import Node
from ropeway.components.return_wheel import TensionedReturn
from ropeway.components.sheave import Wheel
from ropeway.components.spar import Block
from ropeway.systems.modelling.dae_model import Model, kept_with_model, nearest
from ropeway.systems.modelling.rope_path import Run
from ropeway.systems.results.end_forces import EndForces

UNITS: Mapping[str, str] = {
    "angle_in": "rad", "angle_out": "rad", "deflection": "rad", "turn": "rad", "wrap": "rad", "break_angle": "rad",
    "tension_in": "N", "tension_out": "N", "differential_tension": "N", "drive_force": "N",
    "resultant_x": "N", "resultant_y": "N", "resultant_z": "N", "vertical_force": "N", "horizontal_force": "N",
    "bearing_load": "N", "roller_force": "N", "least_force": "N", "lift_off_reserve": "1",
}  # fmt: skip
"""Columns with numbers, and their units."""

OF_FORCES = ("resultant_x", "resultant_y", "resultant_z", "vertical_force", "horizontal_force", "bearing_load")
"""Columns of a sum of ropes too."""

ALL = "all"
"""Rope of the rows with the sum of all ropes at a support."""

_FLAT = 1e-12
"""Wrap angle [rad] below which rollers share the load equally."""


class RopeSeat(NamedTuple):
    """A rope at a support: numbers of its span that `arrives` and of the one that `leaves`, -1 for none, counted over
    all spans of a model; `run`: the number of the rope."""

    node: Node
    run: int
    arrives: int
    leaves: int

    @property
    def support(self) -> Node:
        """The support; where a carriage stands on a shoe, that of the shoe."""
        return self.node.support if isinstance(self.node, CarriageOnShoe) else self.node


Named = Callable[[RopeSeat, Run], tuple[str, str]]
"""Names of the support and of the rope of a row."""


@kept_with_model
def rope_seats(model: Model) -> tuple[RopeSeat, ...]:
    """The ropes at all supports, run after run. Nodes that only ropes hold, as carriages and joints, are no
    supports."""
    found, first = [], 0
    for r, run in enumerate(model.runs):
        last = len(run.spans)
        for k, node in enumerate(run.nodes):
            beside = isinstance(node, CarriageOnShoe) and run.seats[k].name != "a"  # its other ropes count with it
            if node.hangs or beside or (run.closed and k == last):
                continue
            before = first + (k - 1 if k else last - 1)
            found.append(RopeSeat(node, r, before if k or run.closed else -1, first + k if k < last else -1))
        first += last
    return tuple(found)


def by_names(seat: RopeSeat, run: Run) -> tuple[str, str]:
    """Names of a support and of its rope, which is named by its ends."""
    return seat.support.name, run.name


def support_rows(
    model: Model,
    ends: EndForces,
    outputs: np.ndarray,
    rollers: Mapping[str, int] | None = None,
    named: Named = by_names,
) -> pd.DataFrame:
    """The rows of all states.

    Parameters
    ----------
    model : Model
        The model of the states.
    ends : EndForces
        Forces at the ends of all spans in all states.
    outputs : ndarray, shape (states, ny)
        Outputs of the model.
    rollers : mapping of str to int, optional
        Number of rollers at supports; 1 by default.
    named : callable, optional
        Names of the support and of the rope of a row.

    Returns
    -------
    DataFrame
        Columns state (its number), support, kind, rope, and those of `UNITS`.
    """
    seats = rope_seats(model)
    names = [named(seat, model.runs[seat.run]) for seat in seats]
    count = np.array([(rollers or {}).get(support, 1) for support, _ in names], dtype=float)
    total, columns = _columns(model, seats, ends, outputs, count)
    groups: dict[str, list[int]] = {}
    for i, (support, _) in enumerate(names):
        groups.setdefault(support, []).append(i)
    several = {support: rows for support, rows in groups.items() if len(rows) > 1}
    if several:
        sums = np.stack([total[:, :, rows].sum(axis=2) for rows in several.values()], axis=2)
        more = _forces(sums)
        none = np.full(sums.shape[1:], np.nan)
        columns = {name: np.hstack([values, more.get(name, none)]) for name, values in columns.items()}
        names += [(support, ALL) for support in several]
    kinds = [type(seat.support).__name__ for seat in seats] + [
        type(seats[rows[0]].support).__name__ for rows in several.values()
    ]
    states = total.shape[1]
    frame = pd.DataFrame(
        {
            "state": np.repeat(np.arange(states), len(names)),
            "support": [support for support, _ in names] * states,
            "kind": kinds * states,
            "rope": [rope for _, rope in names] * states,
            **{name: columns[name].ravel() for name in UNITS},
        }
    )
    frame.attrs["units"] = dict(UNITS)
    return frame


def _columns(
    model: Model, seats: Sequence[RopeSeat], ends: EndForces, outputs: np.ndarray, count: np.ndarray
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Forces on the supports (3, states, rows), and the columns (states, rows)."""
    n = ends.chord.shape[2]
    arrives, leaves = (np.array([getattr(seat, side) for seat in seats], dtype=int) for side in ("arrives", "leaves"))
    first, last = arrives < 0, leaves < 0
    pull_in = ends.pulls[:, :, np.where(first, 2 * n, arrives + n)]
    pull_out = ends.pulls[:, :, np.where(last, 2 * n, leaves)]
    total = pull_in + pull_out
    for i, seat in enumerate(seats):
        if isinstance(seat.node, CarriageOnShoe):  # its weight and its other ropes rest on the shoe too
            total[:, :, i] = [outputs[:, model.y.index[f"{seat.node.name}.pull_{axis}"]] for axis in "xyz"]
    tension_in, tension_out = np.where(first, np.nan, _size(pull_in)), np.where(last, np.nan, _size(pull_out))
    angles = _angles(pull_in, pull_out, first, last)
    wrap = np.where(first | last, np.nan, _between(-pull_in, pull_out))
    forces, none = _forces(total), np.where(first | last, np.nan, 0.0)
    saddles = np.array([_is_saddle(seat, model.runs[seat.run]) for seat in seats], dtype=bool)
    return total, {
        **angles,
        "wrap": wrap,
        "break_angle": np.where(saddles, angles["deflection"], np.nan),
        "tension_in": tension_in,
        "tension_out": tension_out,
        "differential_tension": tension_out - tension_in,
        "drive_force": _drive_forces(model, seats, outputs),
        **forces,
        "roller_force": roller_force(forces["bearing_load"], wrap, count),
        "least_force": none + forces["vertical_force"] * _press(seats),
        "lift_off_reserve": none + _reserve(seats, ends.chord, pull_in, pull_out),
    }


def _is_saddle(seat: RopeSeat, run: Run) -> bool:
    """Whether a rope lies in a saddle. Ropes that end at a carriage, as a mainline, run on rollers instead."""
    return isinstance(seat.support, IntermediateSupport) and not isinstance(run.nodes[-1], Carriage)


def _forces(total: np.ndarray) -> dict[str, np.ndarray]:
    """Columns of forces (3, states, rows) on supports."""
    return {
        "resultant_x": total[0],
        "resultant_y": total[1],
        "resultant_z": total[2],
        "vertical_force": -total[2],
        "horizontal_force": np.hypot(total[0], total[1]),
        "bearing_load": _size(total),
    }


def _drive_forces(model: Model, seats: Sequence[RopeSeat], outputs: np.ndarray) -> np.ndarray:
    """Forces of the drives on the rope; NaN without a drive."""
    found = np.full((len(outputs), len(seats)), np.nan)
    for i, seat in enumerate(seats):
        k = model.y.index.get(f"{seat.node.name}.drive_force")
        if k is not None:
            found[:, i] = outputs[:, k]
    return found


def roller_force(bearing: np.ndarray, wrap: np.ndarray, count: np.ndarray | float) -> np.ndarray:
    """Force on each of `count` rollers that share the wrap angle equally [N]: 2 T sin(wrap / 2 count) for equal
    tensions T, which is the bearing load for one roller."""
    level = np.abs(np.nan_to_num(wrap)) < _FLAT
    half = np.where(level, 1.0, wrap / 2.0)
    share = np.where(level, 1.0 / count, np.sin(half / count) / np.sin(half))
    return np.asarray(np.where(np.isnan(wrap), np.nan, bearing * share))


def _angles(pull_in: np.ndarray, pull_out: np.ndarray, first: np.ndarray, last: np.ndarray) -> dict[str, np.ndarray]:
    """Slope angles of the rope before and after the support in its direction, their difference, and the turn in plan
    to the left."""
    before, after = -pull_in, pull_out
    angle_in = np.where(first, np.nan, np.arctan2(before[2], np.hypot(before[0], before[1])))
    angle_out = np.where(last, np.nan, np.arctan2(after[2], np.hypot(after[0], after[1])))
    across = before[0] * after[1] - before[1] * after[0]
    turn = np.arctan2(across, before[0] * after[0] + before[1] * after[1])
    return {
        "angle_in": angle_in,
        "angle_out": angle_out,
        "deflection": angle_in - angle_out,
        "turn": np.where(first | last, np.nan, turn),
    }


def _press(seats: Sequence[RopeSeat]) -> np.ndarray:
    """1 where the rope presses its support down, -1 where a hold-down presses the rope down; NaN where it is held in
    all directions: in blocks, on return wheels and on the drive of an endless rope."""
    found = []
    for seat in seats:
        closes = 0 <= seat.leaves < seat.arrives
        if closes or isinstance(seat.node, (Block, GuyedSpar, TensionedReturn)):
            found.append(np.nan)
        else:
            found.append(-1.0 if isinstance(seat.node, Wheel) and seat.node.hold_down else 1.0)
    return np.array(found)


def _reserve(seats: Sequence[RopeSeat], chord: np.ndarray, pull_in: np.ndarray, pull_out: np.ndarray) -> np.ndarray:
    """Factor by which the rope's horizontal tension can grow (of a hold-down: fall) until it leaves the support, the
    weights unchanged; inf where it never does.

    The force on a support is Q + H (slope of the chord before it - slope of the chord after it): weights give Q, which
    does not depend on the tension, as on simple beams.
    """
    way = chord.transpose(1, 0, 2)
    arrives, leaves = (np.array([getattr(s, side) for s in seats], dtype=int) for side in ("arrives", "leaves"))
    with np.errstate(all="ignore"):  # vertical chords
        slope = way[2] / np.hypot(way[0], way[1])
        along = np.hypot(pull_in[0], pull_in[1]) * slope[:, arrives]
        along = along - np.hypot(pull_out[0], pull_out[1]) * slope[:, leaves]
        weights = -(pull_in[2] + pull_out[2]) - along
        grow = np.where(along < 0.0, weights / -along, np.inf)
        fall = np.where(along < 0.0, np.where(weights > 0.0, -along / weights, np.inf), 0.0)
    press = _press(seats)
    return np.asarray(np.where(press > 0.0, grow, np.where(press < 0.0, fall, np.nan)))


def _size(vectors: np.ndarray) -> np.ndarray:
    return np.asarray(np.sqrt((vectors * vectors).sum(axis=0)))


def _between(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Angle between vectors (3, ...) [rad], accurate for small ones too."""
    across = np.cross(one, other, axis=0)
    return np.asarray(np.arctan2(_size(across), (one * other).sum(axis=0)))


def require_rollers(rollers: Mapping[str, int] | None, names: Sequence[str]) -> None:
    """Raises InputError, UnknownNameError for numbers of rollers at `names` of supports."""
    for name, count in (rollers or {}).items():
        if name not in names:
            raise UnknownNameError(f"rollers: there is no support {name!r}", nearest(name, list(names)))
        if count < 1:
            raise InputError(f"rollers: {name!r} has {count}", "Give 1 or more")
