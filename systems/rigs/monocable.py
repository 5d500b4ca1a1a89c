"""A mono-cable line from a table of supports."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, TypeVar

import pandas as pd

from ropeway.components import check
from ropeway.components.anchor import Anchor
from ropeway.components.annotation_checks import Positive
from ropeway.components.argument_checks import checked
from ropeway.components.control_sheave import ControlSheave, Speed
from ropeway.components.drive import Drive, IdealDrive
from ropeway.components.drum import Drum
from ropeway.components.errors import InputError
from ropeway.components.node import Node
from ropeway.components.response import Response
from ropeway.components.rope import Rope, rope_of
from ropeway.components.sheave import Sheave
from ropeway.components.table import Source
from ropeway.components.terrain import ProfileSource, profile_of
from ropeway.systems.modelling.empty_rope import support_tensions
from ropeway.systems.modelling.system import GRAVITY, STRUNG, System
from ropeway.systems.rigs.line_ground import ground_under
from ropeway.systems.rigs.support_table import own_values, read_supports

_Part = TypeVar("_Part", Drive, Response)


@checked
def monocable(
    rope: Rope | str,
    supports: Source,
    *,
    tension: float,
    speed: Speed = 1.0,
    load_mass: float | Sequence[float] | None = None,
    load_spacing: float | None = None,
    load_drag_area: float = 0.0,
    name: str = "mono-cable line",
    drive: Drive | Mapping[str, Drive] | None = None,
    response: Response | Mapping[str, Response] | None = None,
    precedence: str = "all at once",
    gravity: Positive = GRAVITY,
    temperature: float = STRUNG,
    crs: str | None = None,
    terrain: ProfileSource | None = None,
    clearance: float | None = None,
) -> System:
    """A mono-cable line, from drum to drum.

    Parameters
    ----------
    rope : Rope or str
        A rope, or a name from `rw.ropes()`.
    supports : str, Path or DataFrame
        Table in the order of the rope with columns name, x, y, z [m], kind (anchor, drum, idler, control, return), see
        `docs/files.md`. Columns such as drive.relief_pressure or response.increment change single values of a control
        sheave.
    tension : float
        Tension of the empty rope at rest at the first support [N]. It sets the length of rope between the control
        sheaves. Drums at the ends keep the tension of the empty rope there.
    speed : float or Schedule, default 1.0
        Rope speed at all control sheaves, from the first support to the last [m/s]. On a line without control sheaves
        the first drum drives.
    load_mass : float or sequence of float, optional
        Masses of the loads [kg], in order and repeated; 0 is a missing load. The rope starts full of loads. Loads are
        put on at the first support and taken off at the last. On a line that runs backwards, loads leave at the first
        support. Loads taken off at the last support enter there again; after them the rope enters empty.
    load_spacing : float, optional
        Spacing of the loads along the rope [m].
    load_drag_area : float, default 0
        Drag coefficient times area of each load in the wind [m2].
    name : str, default "mono-cable line"
        Name of the line in results and messages.
    drive : Drive or mapping of str to Drive, optional
        Drive of all control sheaves, or one for each name; ideal drives by default.
    response : Response or mapping of str to Response, optional
        Response of all control sheaves, or one for each name; no response by default.
    precedence : str, default "all at once"
        Rule that selects the control sheave to act first when several respond.
    gravity : float, default 9.80665
        Gravitational acceleration [m/s2].
    temperature : float, default 15
        Temperature at which the rope is strung [degrees C].
    crs : str, optional
        Projected coordinate system of supports in map coordinates, such as "EPSG:2056", see `docs/gis.md`.
    terrain : Profile, str, Path or DataFrame, optional
        Ground below the line. Its stations are distances along the line; if line and terrain lie on one map, the map
        places them.
    clearance : float, optional
        Least height of rope and loads above the terrain [m]. `Result.events` lists where a run falls below it.

    Returns
    -------
    System
        The line, its rope full of loads.

    Raises
    ------
    InputError
        A value of the table is invalid (with file, line and column), or arguments contradict each other.
    SlackRopeError
        The empty rope does not hang taut at its tension.

    Examples
    --------
    >>> import pandas as pd
    >>> supports = pd.DataFrame(
    ...     [("valley", 0, 0, 0, "drum"), ("s1", 100, 0, 9, "control"), ("mountain", 200, 0, 15, "drum")],
    ...     columns=["name", "x", "y", "z", "kind"],
    ... )
    >>> line = rw.monocable("RHOL-IWRC 29", supports, tension=45e3, load_mass=300.0, load_spacing=50.0)
    >>> round(rw.equilibrium(line)["valley_s1.tension_a"])
    45000
    """
    rope = rope_of(rope)
    table, map_frame = read_supports(supports, crs=crs)
    check.positive(tension, "monocable", "tension", "N")
    if (load_mass is None) != (load_spacing is None):
        raise InputError("monocable has only one of load_mass and load_spacing", "Give both, or neither")
    controlled = bool((table["kind"] == "control").any())
    if "anchor" in set(table["kind"]) and (controlled or speed != 0.0):
        raise InputError("A rope with an anchored end cannot move", "Use drums at the ends, or speed=0 and no controls")
    for parts in (drive, response):
        _require_control_sheaves(parts, table)
    line = System(name, gravity=gravity, precedence=precedence, temperature=temperature)
    line.map_frame, line.ground = map_frame, ground_under(table, profile_of(terrain), map_frame, clearance)
    points = table[["x", "y", "z"]].to_numpy(dtype=float)
    tensions = support_tensions(points, rope.mass_per_length * gravity, rope.strain, tension)
    nodes: list[Node] = []
    for i, row in enumerate(table.to_dict("records")):
        common = {"name": row["name"], "label": row["label"], "at": tuple(points[i])}
        if row["kind"] == "anchor":
            nodes.append(Anchor(**common))
        elif row["kind"] == "control":
            nodes.append(_control_sheave(common, row, speed, drive, response))
        elif row["kind"] == "drum" and i == 0 and not controlled:
            nodes.append(Drum(**common, speed=speed))
        elif row["kind"] == "drum":
            nodes.append(Drum(**common, tension=float(tensions[i])))
        else:
            nodes.append(Sheave(**common))
    spans = line.string(rope, *nodes, tension=tension)
    if load_mass is not None and load_spacing is not None:
        line.feed(spans, spacing=load_spacing, masses=load_mass, drag_area=load_drag_area)
    return line


def _control_sheave(
    common: Mapping[str, Any],
    row: Mapping[Any, Any],
    speed: Speed,
    drives: Drive | Mapping[str, Drive] | None,
    responses: Response | Mapping[str, Response] | None,
) -> ControlSheave:
    """A control sheave with its drive and response; values of its row replace theirs."""
    drive: Drive = _part_for(drives, row) or IdealDrive()
    drive = replace(drive, **own_values(drive, row, "drive"))
    response = _part_for(responses, row)
    changes = own_values(response, row, "response")
    response = None if response is None else replace(response, **changes)
    return ControlSheave(**common, speed=speed, drive=drive, response=response)


def _require_control_sheaves(parts: object, table: pd.DataFrame) -> None:
    """Raises InputError for a key that is not a control sheave of a table of supports."""
    controls = table[table["kind"] == "control"]
    if isinstance(parts, Mapping) and (unknown := set(parts) - {*controls["name"], *controls["label"]}):
        raise InputError(f"{sorted(unknown)[0]!r} is not a control sheave of the line", "Use a name from the table")


def _part_for(parts: _Part | Mapping[str, _Part] | None, row: Mapping[Any, Any]) -> _Part | None:
    """The part of one support: by its name or label, or the common one."""
    return parts.get(row["label"], parts.get(row["name"])) if isinstance(parts, Mapping) else parts
