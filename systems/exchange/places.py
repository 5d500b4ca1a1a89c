"""Where the parts of a line or rig stand: the list for staking out."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, NamedTuple, Protocol

import numpy as np
import pandas as pd

from ropeway.components.argument_checks import checked
from ropeway.components.errors import InputError
from ropeway.components.ground import Ground
from ropeway.components.guyed_spar import GuyedSpar
from ropeway.components.map_frame import MapFrame
from ropeway.components.node import Node
from ropeway.components.spar import HeadSpar, TailSpar
from ropeway.systems.modelling.system import System
from ropeway.systems.results.run_data import RunData
from ropeway.systems.rigs.skyline_rig import SkylineRig
from ropeway.systems.statics.equilibrium import Equilibrium


class OfRig(Protocol):
    """A study of a rig, or a plan for one."""

    @property
    def rig(self) -> SkylineRig:
        """The rig."""


class Place(NamedTuple):
    """A part at a `point` (x, y, z) [m]. `base`: elevation of the ground there [m], None where only a terrain knows
    it; `seen_from`: the part from whose foot it is staked out."""

    name: str
    label: str
    kind: str
    point: tuple[float, ...]
    base: float | None = None
    seen_from: Place | None = None


@checked
def places(of: SkylineRig | System | Equilibrium | RunData | OfRig) -> pd.DataFrame:
    """Where spars, supports and anchors stand, for staking out.

    Parameters
    ----------
    of : SkylineRig, System, Equilibrium, Result, or a study with a rig
        A line or a rig.

    Returns
    -------
    DataFrame
        Index name; columns label, kind, station and offset to the left along the line's axis, elevation, ground below
        and height over it [m]; on a map easting and northing in its unit; seen_from (the headspar, a guyed spar, or the
        first support) and from there azimuth [degrees clockwise from grid north, without a map from the line's axis],
        distance (horizontal) and slope_distance between the two on the ground, or between their points where the
        ground is unknown [m].

    Raises
    ------
    InputError
        A system without a rope.

    Examples
    --------
    >>> rw.places(rig)[["easting", "northing"]].round(1).to_numpy().tolist()
    [[2600010.0, 1200000.0], [2600310.0, 1200000.0]]
    """
    if not isinstance(of, SkylineRig | System | Equilibrium | RunData):
        of = of.rig
    if isinstance(of, SkylineRig):
        found = list(_of_rig(of))
        ground, frame = None if of.terrain is None else Ground(of.terrain), of.map_frame
    else:
        system = of if isinstance(of, System) else of.model.system
        found, ground, frame = list(_of_system(system)), system.ground, system.map_frame
    frames = [_row(place, ground, frame) for place in found]
    table = pd.DataFrame(frames).set_index("name")
    lengths = dict.fromkeys(("station", "offset", "elevation", "ground", "height", "distance", "slope_distance"), "m")
    units = {**lengths, "azimuth": "deg"}
    table.attrs["units"] = {c: units.get(c, "") for c in table.columns}
    return table


def _of_rig(rig: SkylineRig) -> Iterator[Place]:
    head = _spar(rig.headspar, "headspar", None)
    tail = _spar(rig.tailspar, "tailspar", head)
    yield head
    for support in rig.supports:
        yield Place(support.name, support.label, "support", support.at, None, head)
    yield tail
    hold, block = rig.tailspar.tailhold, rig.haulback_block
    if hold is not None:
        yield Place(hold.name, hold.label, "tailhold", hold.at, _height(hold.at), tail)
    if block is not None:
        yield Place(block.name, block.label, "block", block.at, None, tail)
    for spar, place in ((rig.headspar, head), (rig.tailspar, tail)):
        if isinstance(spar, GuyedSpar):
            for guy in spar.guylines:
                yield Place(guy.name, guy.name, "guyline anchor", guy.at, _height(guy.at), place)


def _spar(spar: HeadSpar | TailSpar, kind: str, seen_from: Place | None) -> Place:
    base = _height(spar.foot) if isinstance(spar, GuyedSpar) else None
    return Place(spar.name, spar.label, kind, spar.at, base, seen_from)


def _height(point: tuple[float, ...]) -> float:
    return float(point[-1])


def _of_system(system: System) -> Iterator[Place]:
    nodes = [c for c in system.components.values() if isinstance(c, Node) and c.at]
    if not nodes:
        raise InputError(f"System {system.name!r} has no supports", "String a rope")
    first = Place(nodes[0].name, nodes[0].label, _words(type(nodes[0]).__name__), nodes[0].at)
    yield first
    for node in nodes[1:]:
        yield Place(node.name, node.label, _words(type(node).__name__), node.at, None, first)


def _words(name: str) -> str:
    """The name of a class in words."""
    return "".join(f" {c.lower()}" if c.isupper() else c for c in name).strip()


def _row(place: Place, ground: Ground | None, frame: MapFrame | None) -> dict[str, Any]:
    x, y, z = place.point
    below = _level(place, ground)
    row: dict[str, Any] = {
        "name": place.name,
        "label": place.label,
        "kind": place.kind,
        "station": x,
        "offset": y,
        "elevation": z,
        "ground": below,
        "height": z - below,
    }
    if frame is not None:
        row["easting"], row["northing"] = (float(v) for v in frame.to_map(x, y))
    seen = place.seen_from
    if seen is None:
        return {**row, "seen_from": "", **dict.fromkeys(("azimuth", "distance", "slope_distance"), math.nan)}
    ends = np.array([seen.point[:2], place.point[:2]])
    east, north = np.diff(np.array(ends.T if frame is None else frame.to_map(*ends.T)))[:, 0]
    rise = below - _level(seen, ground)
    rise = z - seen.point[2] if math.isnan(rise) else rise
    distance = float(np.hypot(*np.diff(ends, axis=0)[0]))
    return {
        **row,
        "seen_from": seen.name,
        # Without a map from the line's own axis, whose left is y.
        "azimuth": math.degrees(math.atan2(east, north) if frame else math.atan2(-north, east)) % 360.0,
        "distance": distance,
        "slope_distance": math.hypot(distance, rise),
    }


def _level(place: Place, ground: Ground | None) -> float:
    """Elevation of the ground at a place [m], NaN where it is unknown."""
    if place.base is not None:
        return place.base
    return math.nan if ground is None else float(ground.elevations(*place.point[:2]))
