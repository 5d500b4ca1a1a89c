"""What a map of a line or rig shows: features by layer, in the line's own axes, with where those lie."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pandas as pd

from ropeway.components.ground import Ground
from ropeway.components.map_frame import WGS84, MapFrame, transformed
from ropeway.components.map_lengths import as_pyproj, horizontal
from ropeway.systems.statics.equilibrium import Equilibrium

CURVE = 41
"""Points of a span's curve."""


class Feature(NamedTuple):
    """A point, or a line through `points`, shape (n, 3), x, y, z in the line's own axes [m]; its attributes are in SI
    units."""

    layer: str
    name: str
    points: np.ndarray
    attributes: dict[str, float | str]

    @property
    def is_point(self) -> bool:
        """Whether it is a point."""
        return len(self.points) == 1


@dataclass(frozen=True, eq=False)
class Drawing:
    """The features of a line or rig named `name`, and where its axes lie on a map whose coordinate system is known.
    `route`: names of what stands along it, in order; `ground`: gives the stations of a profile, by default x."""

    name: str
    frame: MapFrame
    features: tuple[Feature, ...]
    route: tuple[str, ...]
    ground: Ground | None

    @property
    def layers(self) -> dict[str, list[Feature]]:
        """Features by layer: each has points or lines only."""
        found: dict[str, list[Feature]] = {}
        for feature in self.features:
            found.setdefault(feature.layer, []).append(feature)
        return found

    @property
    def unit(self) -> float:
        """The unit of the map's coordinates [m]."""
        return float(horizontal(self.name, self.frame.crs).axis_info[0].unit_conversion_factor)

    @property
    def system(self) -> str:
        """Name of the coordinate system."""
        return str(as_pyproj(self.name, self.frame.crs).name)

    def in_profile(self, feature: Feature) -> np.ndarray:
        """Stations along the line and elevations [m], shape (n, 2)."""
        x, y, z = feature.points.T
        return np.column_stack([x if self.ground is None else self.ground.stations(x, y), z])

    def on_map(self, feature: Feature) -> np.ndarray:
        """Easting and northing in the unit of the map, elevation [m], shape (n, 3)."""
        east, north = self.frame.to_map(*feature.points[:, :2].T)
        return np.column_stack([east, north, feature.points[:, 2]])

    def in_degrees(self, feature: Feature) -> np.ndarray:
        """Longitude and latitude (WGS 84) [degrees], elevation [m], shape (n, 3)."""
        at = self.on_map(feature)
        return np.column_stack([*transformed(self.frame.crs, WGS84, at[:, 0], at[:, 1]), at[:, 2]])


def attributes(row: pd.Series) -> dict[str, float | str]:
    """The values of a row of a table: numbers that are known, and words."""
    found: dict[str, float | str] = {}
    for key, value in row.items():
        if isinstance(value, str):
            if value:
                found[str(key)] = value
        elif isinstance(value, bool | np.bool_):
            found[str(key)] = str(bool(value)).lower()
        elif pd.notna(value):
            found[str(key)] = float(value)
    return found


def ropes(line: Equilibrium, which: set[str] | None = None) -> list[Feature]:
    """The spans of a line at rest, or some of them, along their curves."""
    found = []
    for run in line.runs:
        for k, span in enumerate(run.spans):
            if which is not None and span.name not in which:
                continue
            curve = line.profile(span.name, CURVE)
            rope = run.rope
            about: dict[str, float | str] = {
                "run": run.name,
                "from": run.nodes[k].name,
                "to": run.nodes[k + 1].name,
                "length": line[f"{span.name}.length"],
                "tension_a": line[f"{span.name}.tension_a"],
                "tension_b": line[f"{span.name}.tension_b"],
                "highest_tension": float(curve["tension"].max()),
                "safe_working_load": rope.safe_working_load,
                "breaking_load": rope.breaking_load,
            }
            found.append(Feature("rope", span.name, curve[["x", "y", "z"]].to_numpy(), about))
    return found


def lows(line: Equilibrium, which: set[str] | None = None) -> list[Feature]:
    """Where the spans of a line at rest, or some of them, are nearest to the ground; none where that is unknown."""
    ground = line.model.system.ground
    if ground is None:
        return []
    found = []
    for name, low in line.clearance.iterrows():
        if not np.isfinite(low["rope_clearance"]) or (which is not None and name not in which):
            continue
        curve = line.profile(str(name), CURVE)[["x", "y", "z"]].to_numpy()
        station = ground.stations(curve[:, 0], curve[:, 1])
        order = np.argsort(station, kind="stable")
        point = np.array([[np.interp(low["station"], station[order], curve[order, i]) for i in range(3)]])
        found.append(Feature("clearance", f"{name}_low", point, {"span": str(name), **attributes(low)}))
    return found


def ground_line(line: Equilibrium) -> list[Feature]:
    """The profile of the ground under a line, along its axis; none where that is unknown."""
    ground = line.model.system.ground
    if ground is None:
        return []
    terrain, axis = ground.profile, ground.axis
    x, y = (terrain.station, np.zeros(len(terrain.station))) if axis is None else axis.place(terrain.station)
    return [Feature("ground", "ground", np.column_stack([x, y, terrain.elevation]), {})]
