"""The features of a skyline rig, and of a study of one."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pandas as pd
from pandas.api.types import is_numeric_dtype

from ropeway.components.errors import InputError
from ropeway.components.guyed_spar import GuyedSpar
from ropeway.systems.exchange.gis_features import Drawing, Feature, attributes, ground_line, lows, ropes
from ropeway.systems.exchange.places import places
from ropeway.systems.rigs.bare_skyline import bare_equilibrium
from ropeway.systems.rigs.skyline_rig import SkylineRig
from ropeway.systems.statics.equilibrium import Equilibrium
from ropeway.systems.statics.equilibrium_solver import equilibrium

_STANDS = ("headspar", "support", "tailspar", "block")
"""Kinds of place that are supports; the others are anchors."""
_CARRIAGE = ("carriage_x", "carriage_y", "carriage_z")


def drawing_of_rig(rig: SkylineRig, frame: pd.DataFrame | None) -> Drawing:
    """Bare skyline, spars, supports, anchors, guylines, lows and ground of a rig, and the positions of its carriage
    with what a frame says of them. Raises InputError without a map."""
    if rig.map_frame is None:
        raise InputError(f"{rig.name} has no map coordinates", "Give it a Profile made with from_dem or from_points")
    rig.map_frame.require_crs()
    if frame is not None:
        frame = frame.reset_index(drop=frame.index.name is None)
        if missing := [c for c in _CARRIAGE if c not in frame]:
            raise InputError(
                f"The frame of {rig.name} has no column {', '.join(missing)}", "Give a load path, or a study of the rig"
            )
        if not all(is_numeric_dtype(frame[c]) for c in _CARRIAGE):
            raise InputError(f"The frame of {rig.name} has carriage positions that are no numbers", "Give metres")
    if rig.length is None:  # the rope is its haulback, which hangs with the carriage only
        line = equilibrium(rig.system())
        which = {span.name for span in line.runs[_haulback(line)].spans}
    else:
        line, spans = bare_equilibrium(rig)
        which = {span.name for span in spans}
    features = [
        *ropes(line, which if rig.length is None else None),
        *_guylines(rig),
        *_stands(rig, line, frame),
        *_positions(rig, frame),
        *lows(line, which),
        *_load_lows(rig, frame),
        *ground_line(line),
    ]
    return Drawing(rig.name, rig.map_frame, tuple(features), tuple(node.name for node in rig.stands), None)


def _haulback(line: Equilibrium) -> int:
    """The rope of a running skyline that its carriage hangs on: the one that runs through most parts."""
    return max(range(len(line.runs)), key=lambda r: len(line.runs[r].nodes))


def _guylines(rig: SkylineRig) -> Iterator[Feature]:
    """Guylines, straight from their anchors to the top of a spar."""
    for spar in (rig.headspar, rig.tailspar):
        if isinstance(spar, GuyedSpar):
            for guy in spar.guylines:
                points = np.array([guy.at, spar.at], dtype=float)
                about: dict[str, float | str] = {
                    "from": guy.name,
                    "to": spar.name,
                    "pretension": guy.pretension,
                    "slope_length": float(np.linalg.norm(points[1] - points[0])),
                    "safe_working_load": guy.rope.safe_working_load,
                    "breaking_load": guy.rope.breaking_load,
                }
                yield Feature("guylines", f"{guy.name}_{spar.name}", points, about)


def _stands(rig: SkylineRig, line: Equilibrium, frame: pd.DataFrame | None) -> Iterator[Feature]:
    """Spars, supports and anchors with their heights and forces."""
    for name, row in places(rig).iterrows():
        about = {**attributes(row), **_forces(rig, str(name), line, frame)}
        point = row[["station", "offset", "elevation"]].to_numpy(dtype=float)
        yield Feature("supports" if row["kind"] in _STANDS else "anchors", str(name), point[None], about)


def _forces(rig: SkylineRig, name: str, line: Equilibrium, frame: pd.DataFrame | None) -> dict[str, float | str]:
    """What a part carries: under the bare skyline, and the range over the stations of a frame [N]."""
    found: dict[str, float | str] = {}
    for output in ("support_force", "bearing_load", "tension", "tension_in", "tension_out"):
        key = f"{name}.{output}"
        if key in line.model.y.index:
            found[f"bare_{output}"] = line[key]
    hold = rig.tailspar.tailhold
    ends = {rig.headspar.name: "headspar_tension", rig.tailspar.name: "tailspar_tension"}
    if hold is not None:
        ends[hold.name] = "anchor_tension"
    columns = {"force": f"{name}_force", "tension": ends.get(name, f"{name}_tension")}
    for word, column in columns.items():
        if frame is not None and column in frame and frame[column].notna().any():
            found[f"least_{word}"] = float(frame[column].min())
            found[f"highest_{word}"] = float(frame[column].max())
    return found


def _positions(rig: SkylineRig, frame: pd.DataFrame | None) -> Iterator[Feature]:
    """The carriage at the stations of a frame, and its path."""
    if frame is None:
        return
    known = frame[frame[list(_CARRIAGE)].notna().all(axis=1)]
    points = known[list(_CARRIAGE)].to_numpy(dtype=float)
    for k, (_, row) in enumerate(known.iterrows()):
        yield Feature("carriage", f"{rig.carriage.name}_{k + 1}", points[k : k + 1], attributes(row))
    if len(points) > 1:
        yield Feature("carriage_path", f"{rig.carriage.name}_path", points, {})


def _load_lows(rig: SkylineRig, frame: pd.DataFrame | None) -> Iterator[Feature]:
    """Where the load is nearest to the ground, span by span."""
    if frame is None or "clearance" not in frame:
        return
    known = frame[frame["clearance"].notna()]
    for span, rows in known.groupby(known["span"] if "span" in known else np.ones(len(known), dtype=int)):
        row = rows.loc[rows["clearance"].idxmin()]
        point = row[list(_CARRIAGE)].to_numpy(dtype=float).copy()
        point[2] -= rig.carriage.depth
        about = attributes(row[[c for c in ("station", "clearance", "rope_clearance", "payload") if c in row]])
        yield Feature("clearance", f"load_low_{span}", point[None], {"span": f"load in span {span}", **about})
