"""Heights of a solved rig over the ground: of the load and of the ropes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ropeway.components.clearance import Spanned, above_tangents, least_height
from ropeway.components.component import Seat
from ropeway.components.rope_piece import Piece
from ropeway.components.terrain import Profile
from ropeway.systems.modelling.dae_model import Model, kept_with_model
from ropeway.systems.modelling.rope_path import Run
from ropeway.systems.statics.line_state import span_rope
from ropeway.systems.studies.skyline.carriage_model import Solved, places_of


def load_clearance(solved: Solved, ground: Profile) -> float:
    """Height of the lowest point of the load over the ground [m]. For a log, the height of its rear, or of its front
    while the rear drags."""
    rig = solved.at.rig
    if rig.turn is None:
        x, z = (solved[f"{rig.carriage.name}.{axis}"] for axis in "xz")
        return z - rig.carriage.depth - float(ground.elevations(x))
    if drags(solved):
        return front_clearance(solved, ground)
    log = rig.turn.log.name
    return solved[f"{log}.rear_z"] - float(ground.elevations(solved[f"{log}.rear_x"]))


def front_clearance(solved: Solved, ground: Profile) -> float:
    """Height of a log's front over the ground [m]; NaN without a log."""
    turn = solved.at.rig.turn
    if turn is None:
        return float("nan")
    return solved[f"{turn.log.name}.z"] - float(ground.elevations(solved[f"{turn.log.name}.x"]))


def drags(solved: Solved) -> bool:
    """Whether a log's rear is on the ground."""
    turn = solved.at.rig.turn
    return turn is not None and solved[f"{turn.log.name}.ground_force"] > 1.0


def rope_clearance(solved: Solved, ground: Profile, role: str = "skyline") -> float:
    """Least height of a rope over the ground [m], from the top of the headspar if the rope runs over it; the skyline
    counts as far as the tailspar. NaN without such a rope."""
    rope = _rope_of(solved, role)
    if rope is None:
        return float("nan")
    bounds, least = above_tangents(ground, rope.spanned), np.inf
    for k in np.argsort(bounds, kind="stable"):
        if bounds[k] >= least:
            break
        least = min(least, least_height(ground, rope.piece(solved, int(k))).height)
    return float(least)


def least_rope_clearance(solved: Solved, ground: Profile) -> float:
    """A cheap lower bound of the skyline's `rope_clearance` [m]."""
    rope = _rope_of(solved, "skyline")
    return -np.inf if rope is None else float(above_tangents(ground, rope.spanned).min())


def rope_pieces(solved: Solved, role: str) -> list[Piece]:
    """The pieces of a rope over the corridor in the direction of increasing x."""
    rope = _rope_of(solved, role)
    return [] if rope is None else [rope.piece(solved, k) for k in range(len(rope.numbers))]


@dataclass(frozen=True, eq=False)
class _Rope:
    """The load-free pieces of a rope over the corridor: the run, the number of each span in it, and their unstretched
    lengths [m]."""

    run: Run
    numbers: np.ndarray
    spanned: Spanned
    lengths: np.ndarray

    def piece(self, solved: Solved, i: int) -> Piece:
        """One of them."""
        rope = span_rope(solved.at.model, self.run, int(self.numbers[i]), solved.__getitem__)
        (x, z), force = self.spanned.start[i].tolist(), tuple(self.spanned.force[i].tolist())
        return Piece((x, z), force, rope.weight, float(self.lengths[i]), rope.strain)


def _rope_of(solved: Solved, role: str) -> _Rope | None:
    """The pieces of the rope of a role; None without one that leads along the corridor."""
    at = solved.at
    if role not in at.roles:
        return None
    r, values = at.roles.index(role), solved.values
    places = _rope_places(at.model, r, at.rig.headspar.name, at.rig.tailspar.name if role == "skyline" else "")
    ends, lengths = values[places.ends].sum(axis=1), values[places.length]
    force, weight = values[places.force], values[places.weight]
    if not at.model.weather:  # mass per length times gravity
        weight = np.column_stack([np.zeros((len(lengths), 2)), -weight.prod(axis=1)])
    pull = np.array([force, force - weight * lengths[:, None]])  # tension vectors at both ends
    back = force[:, 0] < 0.0
    if back.any():  # a returning rope: swap its ends
        ends[:, back], pull[:, back] = ends[::-1, back], -pull[::-1, back]
    leads = pull[0, :, 0] > 0.0
    if leads.all():
        return _Rope(at.model.runs[r], places.numbers, Spanned(*ends, *pull), lengths)
    spanned = Spanned(*ends[:, leads], *pull[:, leads])
    return _Rope(at.model.runs[r], places.numbers[leads], spanned, lengths[leads]) if leads.any() else None


class _RopePlaces(NamedTuple):
    """Places of the spans of a run in `Solved.values`: `numbers` of the spans (n,); `ends` (2, 2, n, 2): of the node
    and of the rope beside it, whose sum is the start or the end (x, z); `force` (n, 3); `length` (n,); `weight` (n, 2):
    of mass per length and gravity, with weather (n, 3): of the force on a metre."""

    numbers: np.ndarray
    ends: np.ndarray
    force: np.ndarray
    length: np.ndarray
    weight: np.ndarray


@kept_with_model
def _rope_places(model: Model, r: int, head: str, tail: str) -> _RopePlaces:
    """The places of a run from node `head`, or from its start, to node `tail`, or to its end."""
    run, places = model.runs[r], places_of(model)
    names = [node.name for node in run.nodes]
    first = names.index(head) if head in names else 0
    last = names.index(tail, first) if tail in names else len(run.spans)

    def end(seat: Seat) -> list[list[int]]:
        name = seat.owner.name
        aside = (f"{name}.{seat.offset}_{axis}" for axis in "xz")
        return [[places[f"{name}.{axis}"] for axis in "xz"], [-1 if seat.offset is None else places[a] for a in aside]]

    numbers = range(first, last)
    ends = [[end(run.leaving(k)) for k in numbers], [end(run.seats[k + 1]) for k in numbers]]
    spans = [run.spans[k].name for k in numbers]
    weight = [
        [f"{span}.load_{axis}" for axis in "xyz"] if model.weather else [f"{span}.mass_per_length", "gravity"]
        for span in spans
    ]
    return _RopePlaces(
        np.array(numbers),
        np.array(ends).transpose(0, 2, 1, 3),
        np.array([[places[f"{span}.force_{axis}"] for axis in "xyz"] for span in spans]),
        np.array([places[f"{span}.length"] for span in spans]),
        np.array([[places[name] for name in names] for names in weight]),
    )
