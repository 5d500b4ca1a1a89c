"""Figure of a declared system: supports and the straight lines between them. matplotlib is imported on use."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ropeway.components.errors import InputError
from ropeway.components.node import Node
from ropeway.components.notebook_figure import new_figure
from ropeway.systems.modelling.declarations import Declarations

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_NAMED = 40
"""Largest number of supports with names."""


def system_figure(system: Declarations, view: str) -> Figure:
    """Supports by role, and straight spans, in elevation or in 3-D. Raises InputError."""
    nodes = {name: c for name, c in system.components.items() if isinstance(c, Node) and c.at}
    if not nodes:
        raise InputError(f"System {system.name!r} has no supports", "String a rope")
    if view not in ("elevation", "3d"):
        raise InputError(f"There is no view {view!r}", 'Choose "elevation" or "3d"')
    flat = view == "elevation"
    figure = new_figure(figsize=(10.0, 4.5 if flat else 7.0), layout="constrained")
    axis: Any = figure.subplots(subplot_kw={} if flat else {"projection": "3d"})
    shown = (0, 2) if flat else (0, 1, 2)
    ends: dict[str, list[str]] = {}
    for (span, _), (node, _) in system.connections.items():
        ends.setdefault(span, []).append(node)
    for pair in ends.values():
        points = np.array([nodes[name].at for name in pair if name in nodes])
        if len(points) == 2:
            axis.plot(*points[:, shown].T, color="tab:blue", lw=1.0, zorder=1)
    for role in dict.fromkeys(node.role for node in nodes.values()):
        points = np.array([node.at for node in nodes.values() if node.role == role])
        axis.plot(*points[:, shown].T, ls="", marker="o", ms=5, label=role)
    if len(nodes) <= _NAMED:
        slanted = {"rotation": 60} if flat else {}
        for support in nodes.values():
            place = np.array(support.at)[list(shown)].tolist()
            axis.text(*place, f" {support.label}", fontsize="small", va="bottom", **slanted)
    labels = ("x [m]", "z [m]") if flat else ("x [m]", "y [m]", "z [m]")
    for letter, label in zip("xyz", labels, strict=False):
        getattr(axis, f"set_{letter}label")(label)
    axis.set_title(f"{system.name}: as declared, spans straight")
    axis.legend(fontsize="small")
    if flat:
        axis.grid(alpha=0.3)
    return figure
