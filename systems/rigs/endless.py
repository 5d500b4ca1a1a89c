"""An endless mono-cable line: the rope runs out, around a tensioned return wheel, and back to its drive."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pandas as pd

from ropeway.components import check
from ropeway.components.annotation_checks import Positive
from ropeway.components.argument_checks import checked
from ropeway.components.control_sheave import ControlSheave, Speed
from ropeway.components.drive import Drive, IdealDrive
from ropeway.components.errors import InputError
from ropeway.components.node import Node
from ropeway.components.return_wheel import TensionedReturn
from ropeway.components.rope import Rope, rope_of
from ropeway.components.sheave import Sheave
from ropeway.components.table import Source
from ropeway.components.terrain import ProfileSource, profile_of
from ropeway.systems.modelling.system import GRAVITY, STRUNG, System
from ropeway.systems.rigs.line_ground import ground_under
from ropeway.systems.rigs.support_table import own_values, read_supports
from ropeway.systems.statics.equilibrium_solver import equilibrium


@checked
def endless(
    rope: Rope | str,
    supports: Source,
    *,
    tension: float,
    speed: Speed = 1.0,
    load_mass: float | Sequence[float] | None = None,
    load_spacing: float | None = None,
    load_drag_area: float = 0.0,
    take_up: float | None = None,
    drive: Drive | None = None,
    name: str = "endless line",
    gravity: Positive = GRAVITY,
    temperature: float = STRUNG,
    crs: str | None = None,
    terrain: ProfileSource | None = None,
    clearance: float | None = None,
) -> System:
    """An endless line with loads in both directions.

    Parameters
    ----------
    rope : Rope or str
        A rope, or a name from `rw.ropes()`.
    supports : str, Path or DataFrame
        Table as for `rw.monocable`, in the order of the rope, out and back. The first support is the drive (kind
        control); the rope ends there too. One support is the return.
    tension : float
        Tension of the empty rope where it leaves the drive [N].
    speed : float or Schedule, default 1.0
        Rope speed at the drive and at all other control sheaves [m/s].
    load_mass : float or sequence of float, optional
        Masses of the loads [kg], in order and repeated; 0 is a missing load. Loads circulate in either direction.
    load_spacing : float, optional
        Spacing of the loads along the rope [m], rounded so that loads are evenly spaced around the loop.
    load_drag_area : float, default 0
        Drag coefficient times area of each load in the wind [m2].
    take_up : float, optional
        Constant force on the return wheel [N]; by default the force that the empty rope exerts on it.
    drive : Drive, optional
        Drive of all control sheaves; an ideal drive by default.
    name : str, default "endless line"
        Name of the line in results and messages.
    gravity : float, default 9.80665
        Gravitational acceleration [m/s2].
    temperature : float, default 15
        Temperature at which the rope is strung [degrees C].
    crs : str, optional
        Projected coordinate system of supports in map coordinates, such as "EPSG:2056", see `docs/gis.md`.
    terrain : Profile, str, Path or DataFrame, optional
        Ground below the line. Its stations are distances along the line; if line and terrain lie on one map, the map
        places them. The returning rope has the same ground below it.
    clearance : float, optional
        Least height of rope and loads above the terrain [m]. `Result.events` lists where a run falls below it.

    Returns
    -------
    System
        The line, its rope full of loads.

    Raises
    ------
    InputError
        A value of the table is invalid (with file, line and column), or the number of returns is not one.
    SlackRopeError
        The empty rope does not hang taut at its tension.

    Examples
    --------
    >>> import pandas as pd
    >>> supports = pd.DataFrame(
    ...     [("drive", 0, 0, 0, "control"), ("out", 80, 1, 9, "idler"), ("wheel", 160, 0, 9, "return"),
    ...      ("back", 80, -1, 9, "idler")],
    ...     columns=["name", "x", "y", "z", "kind"],
    ... )
    >>> rw.endless("RHOL-IWRC 29", supports, tension=45e3).name
    'endless line'
    """
    rope = rope_of(rope)
    table, map_frame = read_supports(supports, endless=True, crs=crs)
    check.positive(tension, "endless", "tension", "N")
    if (load_mass is None) != (load_spacing is None):
        raise InputError("endless has only one of load_mass and load_spacing", "Give both, or neither")
    returns = np.flatnonzero(table["kind"] == "return")
    if len(returns) != 1:
        raise InputError(f"The line has {len(returns)} returns", "Give exactly one support the kind return")
    line = System(name, gravity=gravity, temperature=temperature)
    line.map_frame, line.ground = map_frame, ground_under(table, profile_of(terrain), map_frame, clearance)
    if take_up is None:
        at_rest = table[[column for column in table if "." not in column]]  # an ideal drive serves at rest
        empty = System(name, gravity=gravity)
        empty.string(rope, *_around(_supports(at_rest, 0.0, None, None)), tension=tension)
        take_up = equilibrium(empty)[f"{table['name'].iloc[returns[0]]}.bearing_load"]
    spans = line.string(rope, *_around(_supports(table, speed, drive, take_up)), tension=tension)
    if load_mass is not None and load_spacing is not None:
        line.feed(spans, spacing=load_spacing, masses=load_mass, drag_area=load_drag_area)
    return line


def _around(nodes: Sequence[Node]) -> Sequence[Node]:
    """Supports in the order of an endless rope, which ends at its first support."""
    return (*nodes, nodes[0])


def _supports(table: pd.DataFrame, speed: Speed, drive: Drive | None, take_up: float | None) -> list[Node]:
    """The supports of a table. `take_up` is the force on the return wheel [N]; None fixes the wheel."""
    points = table[["x", "y", "z"]].to_numpy(dtype=float)
    nodes: list[Node] = []
    for i, row in enumerate(table.to_dict("records")):
        common = {"name": row["name"], "label": row["label"], "at": tuple(points[i])}
        if row["kind"] == "control":
            own: Drive = drive or IdealDrive()
            own = replace(own, **own_values(own, row, "drive"))
            own_values(None, row, "response")  # no sheave of an endless line has a response
            # The drive's wheel is horizontal: it supports the rope vertically on both sides.
            nodes.append(ControlSheave(**common, hold_down=i == 0, speed=speed, drive=own))
        elif row["kind"] == "return" and take_up is not None:
            # It slides along the bisector of its two ropes.
            before, after = points[i] - points[i - 1], points[i] - points[(i + 1) % len(points)]
            axis = before / np.linalg.norm(before) + after / np.linalg.norm(after)
            nodes.append(TensionedReturn(**common, hold_down=True, direction=tuple(axis.tolist()), take_up=take_up))
        else:
            nodes.append(Sheave(**common))
    return nodes
