"""A mono-cable line from a table of supports."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, TypeVar

from ropeway.components import check
from ropeway.components.anchor import Anchor
from ropeway.components.annotation_checks import Positive
from ropeway.components.argument_checks import checked
from ropeway.components.component import Node
from ropeway.components.control_sheave import ControlSheave, Speed
from ropeway.components.drive import Drive, IdealDrive
from ropeway.components.drum import Drum
from ropeway.components.errors import InputError
from ropeway.components.response import Response
from ropeway.components.rope import Rope
from ropeway.components.sheave import Sheave
from ropeway.components.table import Source
from ropeway.components.terrain import Profile
from ropeway.systems.modelling.empty_rope import support_tensions
from ropeway.systems.modelling.system import GRAVITY, System
from ropeway.systems.rigs.line_ground import ground_under
from ropeway.systems.rigs.support_table import own_values, read_supports

_Part = TypeVar("_Part", Drive, Response)


@checked
def monocable(
    rope: Rope,
    supports: Source,
    *,
    tension: float,
    speed: Speed = 1.0,
    load_mass: float | Sequence[float] | None = None,
    load_spacing: float | None = None,
    name: str = "mono-cable line",
    drive: Drive | Mapping[str, Drive] | None = None,
    response: Response | Mapping[str, Response] | None = None,
    precedence: str = "all at once",
    gravity: Positive = GRAVITY,
    crs: str | None = None,
    terrain: Profile | None = None,
    clearance: float | None = None,
) -> System:
    """A mono-cable line, from drum to drum.

    supports: a table (CSV, Excel or DataFrame) with columns name, x, y, z [m], kind (anchor, drum, idler, control,
    return) in the order of the rope, see `docs/files.md`. tension: of the empty rope at rest at the first support
    [N]; it sets how much rope there is between the control sheaves. Drums at the ends keep the tension that the
    empty rope has there. speed [m/s, from the first support to the last, or a Schedule]: of the rope at all control
    sheaves; on a line without any the first drum drives. load_mass [kg, or a sequence used in order and repeated] and
    load_spacing [m of rope]: the rope starts full of loads, more are put on at the first support at the same
    spacing, and all are taken off at the last; a mass of 0 is a missing load. Loads keep their places on the
    rope: on a line that runs backwards they leave at the first support, those taken off at the last come in again
    there, and beyond where the run started the rope comes in empty. drive and response: of the
    control sheaves, one for all or one for each name (ideal drives and no response otherwise); columns of
    the table such as drive.relief_pressure or response.increment change single values for a support;
    precedence: who acts first when several respond. crs: projected coordinate system of a table in map coordinates, see
    `docs/gis.md`. terrain: the ground under it, over the horizontal distance along the line, or, where both are on one
    map, over that of the terrain; clearance: least height over it of rope and loads [m], which `Result.events` then
    hold the line to. Raises InputError, SlackRopeError.
    """
    table, map_frame = read_supports(supports, crs=crs)
    check.positive(tension, "monocable", "tension", "N")
    if (load_mass is None) != (load_spacing is None):
        raise InputError("monocable has one of load_mass and load_spacing", "Give both, or none for an empty rope")
    controlled = bool((table["kind"] == "control").any())
    if "anchor" in set(table["kind"]) and (controlled or speed != 0.0):
        raise InputError("A rope with an anchored end cannot move", "Use drums at the ends, or speed=0 and no controls")
    points = table[["x", "y", "z"]].to_numpy(dtype=float)
    kept = support_tensions(points, rope.mass_per_length * gravity, rope.strain, tension)
    nodes: list[Node] = []
    for i, row in enumerate(table.to_dict("records")):
        about, at = {"name": row["name"], "label": row["label"]}, tuple(points[i])
        if row["kind"] == "anchor":
            nodes.append(Anchor(**about, at=at))
        elif row["kind"] == "control":
            own: Drive = _of(drive, row) or IdealDrive()
            own = replace(own, **own_values(own, row, "drive"))
            rule: Response | None = _of(response, row)
            changes = own_values(rule, row, "response")
            rule = None if rule is None else replace(rule, **changes)
            nodes.append(ControlSheave(**about, at=at, speed=speed, drive=own, response=rule))
        elif row["kind"] == "drum" and i == 0 and not controlled:
            nodes.append(Drum(**about, at=at, speed=speed))
        elif row["kind"] == "drum":
            nodes.append(Drum(**about, at=at, tension=float(kept[i])))
        else:
            nodes.append(Sheave(**about, at=at))
    controls = table[table["kind"] == "control"]
    for each in (drive, response):
        if isinstance(each, Mapping) and (unknown := set(each) - {*controls["name"], *controls["label"]}):
            raise InputError(f"{sorted(unknown)[0]!r} is not a control sheave of the line", "Name those of the table")
    line = System(name, gravity=gravity, precedence=precedence)
    line.map_frame, line.ground = map_frame, ground_under(table, terrain, map_frame, clearance)
    spans = line.string(rope, *nodes, tension=tension)
    if load_mass is not None and load_spacing is not None:
        line.feed(spans, spacing=load_spacing, masses=load_mass)
    return line


def _of(parts: _Part | Mapping[str, _Part] | None, row: Mapping[Any, Any]) -> _Part | None:
    """The part of one support: its own, by its name or label, or the one for all."""
    return parts.get(row["label"], parts.get(row["name"])) if isinstance(parts, Mapping) else parts
