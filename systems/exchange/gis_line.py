"""The features of a line at rest."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ropeway.components.anchor import Anchor
from ropeway.components.drum import Drum
from ropeway.components.errors import InputError
from ropeway.systems.exchange.gis_features import Drawing, Feature, attributes, ground_line, lows, ropes
from ropeway.systems.exchange.places import places
from ropeway.systems.statics.equilibrium import Equilibrium


def drawing_of_line(line: Equilibrium) -> Drawing:
    """Ropes, supports, anchors, loads, lows and ground of a line at rest. Raises InputError without a map."""
    system = line.model.system
    if system.map_frame is None:
        raise InputError(
            f"{system.name!r} has no map coordinates",
            "Make the line from supports in map coordinates with crs=, or give its system a terrain with a map",
        )
    system.map_frame.require_crs()
    features = [*ropes(line), *_supports(line), *_loads(line), *lows(line), *ground_line(line)]
    route = tuple(node.name for node in line.runs[0].nodes) if line.runs else ()
    return Drawing(system.name, system.map_frame, tuple(features), route, system.ground)


def _supports(line: Equilibrium) -> Iterator[Feature]:
    """Supports where they stand, with the outputs that results show of each; the ends of ropes are anchors."""
    outputs = line.model.y
    table = places(line)
    for name, row in table.iterrows():
        shown = [i for i in outputs.shown if outputs.names[i].rpartition(".")[0] == name]
        forces = {outputs.names[i].rpartition(".")[2]: float(line.outputs[i]) for i in shown}
        end = isinstance(line.model.system.components[str(name)], Anchor | Drum)
        at = _point(line, str(name), row[["station", "offset", "elevation"]].to_numpy(dtype=float))
        yield Feature("anchors" if end else "supports", str(name), at, {**attributes(row), **forces})


def _point(line: Equilibrium, name: str, at: np.ndarray) -> np.ndarray:
    """Where a node is at rest: some move."""
    for r, run in enumerate(line.runs):
        for k, node in enumerate(run.nodes):
            if node.name == name:
                return line.points(r)[k : k + 1]
    return at[None]


def _loads(line: Equilibrium) -> Iterator[Feature]:
    ground = line.model.system.ground
    for _, row in line.loads.iterrows():
        x, y, z = (float(row[axis]) for axis in "xyz")
        about: dict[str, float | str] = {"span": str(row["span"]), "mass": float(row["mass"])}
        if ground is not None and np.isfinite(level := float(ground.elevations(x, y))):
            about["clearance"] = z - level
        yield Feature("loads", str(row["load"]), np.array([[x, y, z]]), about)
