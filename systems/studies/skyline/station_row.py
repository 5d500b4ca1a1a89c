"""The row of a load path: quantities of a solved rig at a station, with units."""

from __future__ import annotations

import numpy as np
import pandas as pd

from ropeway.components.clearance import deflection
from ropeway.components.guyed_spar import GuyedSpar
from ropeway.systems.studies.skyline.carriage_model import Solved
from ropeway.systems.studies.skyline.clearances import drags, front_clearance, load_clearance, rope_clearance
from ropeway.systems.studies.skyline.rope_tensions import (
    anchor_tension,
    break_angle,
    end_tensions,
    guyline_tension,
    highest_tension,
)

StationRow = dict[str, float | str | int]

_METRES = (
    "station carriage_x carriage_y carriage_z sag clearance rope_clearance mainline_clearance haulback_clearance "
    "front_clearance spar_lean tailspar_lean"
)
_NEWTONS = (
    "skyline_tension highest_tension headspar_tension tailspar_tension anchor_tension mainline_pull mainline_tension "
    "mainline_highest haulback_pull haulback_tension haulback_highest spar_compression tailspar_compression"
)
UNITS = {
    **dict.fromkeys(_METRES.split(), "m"),
    **dict.fromkeys(_NEWTONS.split(), "N"),
    "deflection": "%",
    "payload": "kg",
}
"""Units of the columns; those of supports, guylines and logs end in _force, _tension [N] or _angle [rad]."""
_ENDINGS = {"_force": "N", "_tension": "N", "_angle": "rad"}


def units_of(frame: pd.DataFrame) -> dict[str, str]:
    """The unit of each column."""
    return {c: UNITS.get(c, next((u for end, u in _ENDINGS.items() if c.endswith(end)), "")) for c in frame.columns}


def station_row(solved: Solved, station: float) -> StationRow:
    """All columns of a solved station."""
    return {
        "station": station,
        **_carriage(solved),
        **_skyline(solved),
        **_lines(solved),
        **sag_columns(solved),
        **_clearances(solved),
        **_supports(solved),
        **_guyed_spars(solved),
        **_log(solved),
        **_line_clearances(solved),
    }


def _carriage(solved: Solved) -> StationRow:
    """Position of the carriage, and on a map its easting and northing."""
    name, frame = solved.at.rig.carriage.name, solved.at.rig.map_frame
    place: StationRow = {f"carriage_{axis}": solved[f"{name}.{axis}"] for axis in "xyz"}
    if frame is not None:
        easting, northing = frame.to_map(solved[f"{name}.x"], solved[f"{name}.y"])
        place |= {"carriage_easting": float(easting), "carriage_northing": float(northing)}
    return place


def _skyline(solved: Solved) -> StationRow:
    """Tensions of the skyline: at the carriage, the highest one, at the spars and at its anchor."""
    rig, run = solved.at.rig, solved.at.model.runs[solved.at.skyline]
    name, ends = rig.carriage.name, end_tensions(solved, run.spans)
    from_head = next((k for k, node in enumerate(run.nodes) if node.name == rig.headspar.name), 0)
    into_tail = next(s for s, node in zip(run.spans, run.nodes[1:], strict=True) if node.name == rig.tailspar.name)
    return {
        "skyline_tension": max(solved[f"{name}.tension_a"], solved[f"{name}.tension_b"]),
        "highest_tension": max(ends),
        "headspar_tension": ends[2 * from_head],
        "tailspar_tension": solved[f"{into_tail.name}.tension_b"],
        "anchor_tension": anchor_tension(solved),
    }


def _lines(solved: Solved) -> StationRow:
    """Tensions of mainline (or ideal holding force) and haulback: at the carriage, at the drum, highest."""
    rig, name = solved.at.rig, solved.at.rig.carriage.name
    pull, at_drum = 0.0, 0.0
    if solved.held_by == "holding":
        pull = solved[f"{name}.holding"]
    elif solved.held_by == "mainline":
        pull, at_drum = solved[f"{name}.mainline_pull"], solved["mainline.rope_tension"]
    return {
        "mainline_pull": pull,
        "mainline_tension": at_drum,
        "mainline_highest": highest_tension(solved, "mainline"),
        "haulback_pull": solved[f"{name}.haulback_pull"],
        "haulback_tension": solved["haulback.rope_tension"] if solved.has("haulback.rope_tension") else 0.0,
        "haulback_highest": highest_tension(solved, rig.kind.haulback_role),
    }


def _span(solved: Solved) -> int:
    """The span of the carriage, counted from 0."""
    x = solved[f"{solved.at.rig.carriage.name}.x"]
    return solved.at.span if solved.at.on is None else solved.at.rig.span_of(x)


def sag_columns(solved: Solved) -> dict[str, float]:
    """Sag of the carriage below the chord of its span, and its ratio to the span."""
    rig, name, k = solved.at.rig, solved.at.rig.carriage.name, _span(solved)
    sag = rig.chord(k, solved[f"{name}.x"]) - solved[f"{name}.z"]
    a, b = rig.stands[k].at, rig.stands[k + 1].at
    return {"sag": sag, "deflection": deflection(sag, float(np.hypot(b[0] - a[0], b[1] - a[1])))}


def _clearances(solved: Solved) -> StationRow:
    """Clearances of the load and of the skyline; NaN without a terrain."""
    ground = solved.at.rig.terrain
    if ground is None:
        return {"clearance": np.nan, "rope_clearance": np.nan}
    return {"clearance": load_clearance(solved, ground), "rope_clearance": rope_clearance(solved, ground)}


def _supports(solved: Solved) -> StationRow:
    supports = solved.at.rig.supports
    return {
        **{f"{s.name}_force": solved[f"{s.name}.support_force"] for s in supports},
        **{f"{s.name}_break_angle": break_angle(solved, s) for s in supports},
        "span": _span(solved) + 1,
        "held_by": solved.held_by,
    }


def _guyed_spars(solved: Solved) -> StationRow:
    rig, columns = solved.at.rig, StationRow()
    for spar, prefix in ((rig.headspar, "spar"), (rig.tailspar, "tailspar")):
        if isinstance(spar, GuyedSpar):
            columns[f"{prefix}_compression"] = solved[f"{spar.name}.compression"]
            columns[f"{prefix}_lean"] = solved[f"{spar.name}.lean"]
            columns |= {f"{g.name}_tension": guyline_tension(solved, g.name, spar) for g in spar.guylines}
    return columns


def _log(solved: Solved) -> StationRow:
    rig = solved.at.rig
    if rig.turn is None or rig.terrain is None:
        return {}
    return {
        "ground_force": solved[f"{rig.turn.log.name}.ground_force"],
        "dropline_tension": solved[f"{rig.carriage.name}.dropline_pull"],
        "suspension": "partial" if drags(solved) else "full",
        "front_clearance": front_clearance(solved, rig.terrain),
    }


def _line_clearances(solved: Solved) -> StationRow:
    rig, ground = solved.at.rig, solved.at.rig.terrain
    if ground is None:
        return {}
    ropes = {"mainline": rig.mainline, "haulback": rig.haulback}
    roles = [role for role, rope in ropes.items() if rope is not None]
    return {f"{role}_clearance": rope_clearance(solved, ground, role) for role in roles}
