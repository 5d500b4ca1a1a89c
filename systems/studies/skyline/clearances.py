"""Heights of a solved rig over the ground: of the load and of the ropes."""

from __future__ import annotations

from collections.abc import Iterator
from operator import itemgetter

import numpy as np

from ropeway.components.catenary import end_of
from ropeway.components.clearance import above_tangents, least_height
from ropeway.components.rope_piece import Piece
from ropeway.components.terrain import Profile
from ropeway.systems.statics.line_state import span_rope
from ropeway.systems.studies.skyline.carriage_model import Solved


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
    pieces = [(above_tangents(ground, piece, end), piece) for piece, end in _pieces(solved, role)]
    least = np.inf if pieces else np.nan
    for bound, piece in sorted(pieces, key=itemgetter(0)):
        if bound >= least:
            break
        least = min(least, least_height(ground, piece).height)
    return float(least)


def least_rope_clearance(solved: Solved, ground: Profile) -> float:
    """A cheap lower bound of the skyline's `rope_clearance` [m]."""
    return min((above_tangents(ground, piece, end) for piece, end in _pieces(solved, "skyline")), default=-np.inf)


def _pieces(solved: Solved, role: str) -> Iterator[tuple[Piece, tuple[float, float]]]:
    """The pieces of a rope over the corridor in the direction of increasing x, each with its end (x, z) [m]."""
    rig, at = solved.at.rig, solved.at
    for r, run in enumerate(at.model.runs):
        if at.roles[r] != role:
            continue
        first = next((k for k, node in enumerate(run.nodes) if node.name == rig.headspar.name), 0)
        for k, span in enumerate(run.spans[first:], first):
            start, end = solved.start(r, k), solved.end(r, k)
            force, length = np.array(at.curve(solved.point, k, r)), solved[f"{span.name}.length"]
            rope = span_rope(at.model, run, k, solved.__getitem__)
            if force[0] < 0.0:  # a returning rope: swap its ends
                start, end = end, start
                force = -np.array(end_of(tuple(force), rope.weight, length))
            if force[0] > 0.0:
                yield Piece((start[0], start[2]), tuple(force), rope.weight, length, rope.strain), (end[0], end[2])
            if role == "skyline" and run.nodes[k + 1].name == rig.tailspar.name:
                break
