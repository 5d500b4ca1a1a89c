"""Rope tensions of a solved rig, and the loads on its spars and supports."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ropeway.components.guyed_spar import GuyedSpar
from ropeway.components.intermediate_support import IntermediateSupport
from ropeway.components.node import Node
from ropeway.components.span import Span
from ropeway.systems.results.support_rows import roller_force
from ropeway.systems.statics.equilibrium_solver import warn_overloaded
from ropeway.systems.statics.line_state import end_force
from ropeway.systems.studies.skyline.carriage_model import Solved


def highest_tension(solved: Solved, role: str) -> float:
    """Highest tension of the skyline, the mainline or the haulback, by its role in the model [N]; 0 without one."""
    runs = [run for run, its in zip(solved.at.model.runs, solved.at.roles, strict=True) if its == role]
    return max((tension for run in runs for tension in end_tensions(solved, run.spans)), default=0.0)


def warn_of_overload(solved: Sequence[Solved], stations: Sequence[float] | np.ndarray) -> None:
    """Warns, once, of the rope that is farthest above its breaking load with the carriage at the stations [m]."""
    states = zip(solved, stations, strict=True)
    spans = ((one, x, span.name) for one, x in states for run in one.at.model.runs for span in run.spans)
    used = max(((one[f"{name}.utilisation"], float(x), name) for one, x, name in spans), default=(0.0, 0.0, ""))
    if used[0] > 1.0:
        warn_overloaded(used[2], used[0], f"with the carriage at {used[1]:.6g} m")


def end_tensions(solved: Solved, spans: Sequence[Span]) -> list[float]:
    """Tensions at both ends of all spans [N]. The maximum of a span without loads is at an end."""
    return [solved[f"{span.name}.tension_{end}"] for span in spans for end in "ab"]


def anchor_tension(solved: Solved) -> float:
    """Tension at the skyline's anchor [N]."""
    return solved[f"{solved.at.model.runs[solved.at.skyline].spans[-1].name}.tension_b"]


def guyline_ends(guyline: str, spar: GuyedSpar) -> list[str]:
    """Names of the tensions at the two ends of a guyline."""
    return [f"{guyline}_{spar.name}.tension_{end}" for end in "ab"]


def guyline_tension(solved: Solved, guyline: str, spar: GuyedSpar) -> float:
    """Higher tension of the two ends of a guyline [N]."""
    return max(solved[name] for name in guyline_ends(guyline, spar))


def break_angle(solved: Solved, support: IntermediateSupport) -> float:
    """Angle by which the skyline bends down over a saddle [rad]; with the carriage on its shoe, over both."""
    run = solved.at.model.runs[solved.at.skyline]
    name = _node_at(solved, support)
    k = next(k for k, node in enumerate(run.nodes) if node.name == name)
    before, after = run.spans[k - 1].name, run.spans[k].name
    rises = solved[f"{before}.vertical_b"] / solved[f"{before}.tension_b"]
    falls = solved[f"{after}.vertical_a"] / solved[f"{after}.tension_a"]
    return float(np.arcsin(rises) + np.arcsin(falls))


def force_per_roller(solved: Solved, support: IntermediateSupport, count: int) -> float:
    """Force on each of `count` rollers under the skyline at a support [N]."""
    bearing, wrap = (np.array(solved[f"{support.name}.{name}"]) for name in ("bearing_load", "wrap"))
    return float(roller_force(bearing, wrap, count))


def _node_at(solved: Solved, support: IntermediateSupport) -> str:
    """Name of the skyline's node at a support: the carriage where it stands on the shoe."""
    rig, on = solved.at.rig, solved.at.on
    return rig.carriage.name if on is not None and rig.supports[on].name == support.name else support.name


def load_on(solved: Solved, stand: Node) -> float:
    """Load on a spar or support [N]: the resultant of all ropes at its top, the compression of a guyed spar, or the
    load on a shoe plus that of the mainline on its roller."""
    if isinstance(stand, GuyedSpar):
        return solved[f"{stand.name}.compression"]
    if isinstance(stand, IntermediateSupport) and stand.radius > 0.0:
        roller = f"{stand.name}_mainline.bearing_load"
        return solved[f"{stand.name}.bearing_load"] + (solved[roller] if solved.has(roller) else 0.0)
    total = np.zeros(3)
    for r, run in enumerate(solved.at.model.runs):
        for k, node in enumerate(run.nodes):
            if node.at != stand.at:
                continue
            if k < len(run.spans):
                total += solved.at.curve(solved.point, k, r)
            if k > 0:
                total -= end_force(solved.at.model, run, k - 1, solved.__getitem__)
    return float(np.linalg.norm(total))
