"""An endless mono-cable line: the rope goes out, around a tensioned return wheel, and back to its drive."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pandas as pd

from ropeway.components import check
from ropeway.components.annotation_checks import Positive
from ropeway.components.argument_checks import checked
from ropeway.components.component import Node
from ropeway.components.control_sheave import ControlSheave, Speed
from ropeway.components.drive import Drive, IdealDrive
from ropeway.components.errors import InputError
from ropeway.components.return_wheel import TensionedReturn
from ropeway.components.rope import Rope
from ropeway.components.sheave import Sheave
from ropeway.components.span import Span
from ropeway.components.table import Source
from ropeway.components.terrain import Profile
from ropeway.systems.modelling.system import GRAVITY, System
from ropeway.systems.rigs.line_ground import ground_under
from ropeway.systems.rigs.support_table import own_values, read_supports
from ropeway.systems.statics.equilibrium_solver import equilibrium


@checked
def endless(
    rope: Rope,
    supports: Source,
    *,
    tension: float,
    speed: Speed = 1.0,
    load_mass: float | Sequence[float] | None = None,
    load_spacing: float | None = None,
    take_up: float | None = None,
    drive: Drive | None = None,
    name: str = "endless line",
    gravity: Positive = GRAVITY,
    crs: str | None = None,
    terrain: Profile | None = None,
    clearance: float | None = None,
) -> System:
    """An endless line with loads both ways.

    supports: as for `monocable`, in the order of the rope, out and back: the first is the drive (control), at
    which the rope also ends, one is the return. tension: of the empty rope where it leaves the drive [N].
    take_up: constant force on the return wheel [N], by default what the empty rope draws with. speed [m/s or
    Schedule], drive: of the drive; any further controls follow the same speed. load_mass [kg, a number or a
    sequence used in order and repeated; 0 is a missing load; they go round either way] and load_spacing [m],
    rounded so that the loads are evenly spread around. crs, terrain, clearance: as for `monocable`; the terrain
    from the drive to the return lies under the rope's way back too. Raises InputError, SlackRopeError.
    """
    table, map_frame = read_supports(supports, endless=True, crs=crs)
    check.positive(tension, "endless", "tension", "N")
    if (load_mass is None) != (load_spacing is None):
        raise InputError("endless has one of load_mass and load_spacing", "Give both, or none for an empty rope")
    returns = np.flatnonzero(table["kind"] == "return")
    if len(returns) != 1:
        raise InputError(f"The line has {len(returns)} returns", "One support is the return, of kind return")
    if take_up is None:
        bare = table[[column for column in table if "." not in column]]  # at rest an ideal drive does
        empty, _ = _line(rope, bare, tension, 0.0, None, None, name, gravity)
        take_up = equilibrium(empty)[f"{table['name'].iloc[returns[0]]}.bearing_load"]
    line, spans = _line(rope, table, tension, speed, drive, take_up, name, gravity)
    line.map_frame, line.ground = map_frame, ground_under(table, terrain, map_frame, clearance)
    if load_mass is not None and load_spacing is not None:
        line.feed(spans, spacing=load_spacing, masses=load_mass)
    return line


def _line(
    rope: Rope,
    table: pd.DataFrame,
    tension: float,
    speed: Speed,
    drive: Drive | None,
    take_up: float | None,
    name: str,
    gravity: float,
) -> tuple[System, tuple[Span, ...]]:
    """The line with its return wheel drawn by `take_up`, or in its place for None."""
    points = table[["x", "y", "z"]].to_numpy(dtype=float)
    nodes: list[Node] = []
    for i, row in enumerate(table.to_dict("records")):
        about, at = {"name": row["name"], "label": row["label"]}, tuple(points[i])
        if row["kind"] == "control":
            own: Drive = drive or IdealDrive()
            own = replace(own, **own_values(own, row, "drive"))
            own_values(None, row, "response")  # no sheave of an endless line has one
            # The drive's wheel lies flat: it holds the rope in height from either side.
            nodes.append(ControlSheave(**about, at=at, hold_down=i == 0, speed=speed, drive=own))
        elif row["kind"] == "return" and take_up is not None:
            # It slides in the middle between its ropes, away from them.
            before, after = points[i] - points[i - 1], points[i] - points[(i + 1) % len(points)]
            way = before / np.linalg.norm(before) + after / np.linalg.norm(after)
            nodes.append(
                TensionedReturn(**about, at=at, hold_down=True, direction=tuple(way.tolist()), take_up=take_up)
            )
        else:
            nodes.append(Sheave(**about, at=at))
    line = System(name, gravity=gravity)
    return line, line.string(rope, *nodes, nodes[0], tension=tension)
