"""The load path: the carriage moved along all spans, station by station."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from operator import itemgetter

import numpy as np
import pandas as pd

from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.clearance import Piece, above_tangents, deflection, least_height
from ropeway.components.errors import InputError
from ropeway.components.guyed_spar import GuyedSpar
from ropeway.components.span import Span
from ropeway.components.terrain import Profile
from ropeway.systems.interrupts import interruptible, keeping
from ropeway.systems.rigs.skyline_rig import RigKind, SkylineRig
from ropeway.systems.studies.skyline.carriage_model import Solved
from ropeway.systems.studies.skyline.certified_states import certified
from ropeway.systems.studies.skyline.station_solver import Stations

UNITS = {
    "station": "m",
    "carriage_x": "m",
    "carriage_y": "m",
    "carriage_z": "m",
    "carriage_easting": "",
    "carriage_northing": "",
    "skyline_tension": "N",
    "highest_tension": "N",
    "headspar_tension": "N",
    "tailspar_tension": "N",
    "anchor_tension": "N",
    "mainline_pull": "N",
    "mainline_tension": "N",
    "mainline_highest": "N",
    "haulback_pull": "N",
    "haulback_tension": "N",
    "haulback_highest": "N",
    "sag": "m",
    "deflection": "%",
    "clearance": "m",
    "rope_clearance": "m",
    "mainline_clearance": "m",
    "haulback_clearance": "m",
    "front_clearance": "m",
    "spar_compression": "N",
    "spar_lean": "m",
    "tailspar_compression": "N",
    "tailspar_lean": "m",
    "payload": "kg",
}


@checked
@interruptible
def load_path(
    rig: SkylineRig,
    payload: float,
    stations: Sequence[float] | np.ndarray | None = None,
    *,
    height: float | None = None,
) -> pd.DataFrame:
    """The carriage with a payload [kg] at `stations` [m] (by default every 5 m of all spans).

    One row a station, in SI units (`attrs["units"]`): carriage_x, carriage_y, carriage_z, on a map carriage_easting
    and carriage_northing in its unit; skyline_tension at the carriage, highest_tension of the skyline anywhere,
    headspar_tension, tailspar_tension, anchor_tension (where
    the skyline is tied); mainline_pull at the carriage (or the ideal holding force, positive towards the
    headspar), mainline_tension at its drum and mainline_highest anywhere; haulback_pull at the carriage,
    haulback_tension at its drum and haulback_highest anywhere; sag below its span's chord and deflection in
    percent of the span; clearance of the load over the ground, rope_clearance of the skyline, on a terrain
    mainline_clearance and haulback_clearance too; for each support `NAME_force`, upward on the rope, negative where
    it lifts off; span (from 1); held_by: mainline, clamp (beyond its rest point the carriage has to be held on the
    skyline) or holding.
    A guyed headspar adds spar_compression, spar_lean [m], a guyed tailspar tailspar_compression, tailspar_lean, and
    both for each guyline `NAME_tension` at the top. A log adds its suspension (partial or full), ground_force,
    dropline_tension and front_clearance, and as clearance that of its lower end, of its front where the rear drags.

    height: for a live or running skyline: the yarder lowers and raises it so that the load stays this high
    over the ground [m]; with a log, which follows, the carriage. At the own station of a support that is a point
    the carriage hangs 2 cm before it; on one with a radius it rolls over the shoe. Raises InputError,
    EquilibriumError.
    """
    check.not_negative(payload, rig.name, "payload", "kg")
    if height is not None and rig.kind is RigKind.STANDING:
        raise InputError(f"{rig.name} stands: its height cannot be set", "Leave height out, or take a live skyline")
    solver = Stations(rig, by_height=height is not None)
    where, solved = stations_of(rig, stations), list[Solved]()

    def frame() -> pd.DataFrame:
        found = pd.DataFrame([row(one, float(x)) for one, x in zip(certified(solved), where, strict=False)])
        found.attrs["units"] = units_of(found)
        return found

    with keeping(frame):
        for x in where:
            z = None if height is None else carriage_height(rig, float(x), height)
            solved.append(solver.solve(float(x), payload, z))
    return frame()


def units_of(frame: pd.DataFrame) -> dict[str, str]:
    """The unit of each column."""
    return {c: UNITS.get(c, "N" if c.endswith(("_force", "_tension")) else "") for c in frame.columns}


def default_stations(rig: SkylineRig, spacing: float = 5.0) -> np.ndarray:
    """About every `spacing` metres of all spans, supports included, the ends left out. Raises InputError."""
    check.positive(spacing, rig.name, "spacing", "m")
    x0, x1 = rig.points[0, 0], rig.points[rig.spans, 0]
    return np.linspace(x0, x1, max(4, round((x1 - x0) / spacing) + 1))[1:-1]


def stations_of(rig: SkylineRig, stations: Sequence[float] | np.ndarray | None) -> np.ndarray:
    """The stations asked for [m], by default about every 5 m of all spans. Raises InputError."""
    if stations is None:
        return default_stations(rig)
    try:
        found = np.asarray(stations, dtype=float)
    except (TypeError, ValueError):
        found = np.empty((0, 0))
    if found.ndim != 1:
        raise InputError(f"{rig.name}: stations are {stations!r}", "Give numbers in a row [m]")
    if found.size == 0:
        raise InputError(f"{rig.name}: no stations", "Give at least one station between headspar and tailspar")
    for x in found:
        check.number(float(x), rig.name, "a station", "m")
        rig.span_of(float(x))
    return found


def carriage_height(rig: SkylineRig, station: float, height: float) -> float:
    """Height z [m] of the carriage with its load `height` over the ground. Raises InputError."""
    if rig.terrain is None:
        raise InputError(f"{rig.name} has no terrain", "Give it a Profile to keep a height over the ground")
    return rig.terrain.elevation_at(station) + height + rig.carriage.depth


def row(solved: Solved, station: float, *, lines: bool = True) -> dict[str, float | str | int]:
    """The row of a load path at a solved station. lines: with the clearances of the ropes."""
    rig, model = solved.at.rig, solved.at.model
    name, head, tail = rig.carriage.name, rig.headspar, rig.tailspar
    x, y, z = (solved[f"{name}.{axis}"] for axis in "xyz")
    k = solved.at.span if solved.at.on is None else rig.span_of(x)
    a, b = rig.stands[k].at, rig.stands[k + 1].at
    sag = rig.chord(k, x) - z
    sky = model.runs[solved.at.skyline]
    ends = end_tensions(solved, sky.spans)
    from_head = next((k for k, node in enumerate(sky.nodes) if node.name == head.name), 0)
    into_tail = next(s for s, node in zip(sky.spans, sky.nodes[1:], strict=True) if node.name == tail.name)
    at_carriage = max(solved[f"{name}.tension_a"], solved[f"{name}.tension_b"])
    pull = solved[f"{name}.holding"] if solved.held_by == "holding" else 0.0
    main = 0.0
    if solved.held_by == "mainline":
        pull = solved[f"{name}.mainline_pull"]
        main = solved["mainline.rope_tension"]
    haul = solved["haulback.rope_tension"] if "haulback.rope_tension" in model.y.index else 0.0
    haulback = "skyline" if rig.kind is RigKind.RUNNING else "haulback"
    values: dict[str, float | str | int] = {
        "station": station,
        "carriage_x": x,
        "carriage_y": y,
        "carriage_z": z,
        "skyline_tension": at_carriage,
        "highest_tension": max(ends),
        "headspar_tension": ends[2 * from_head],
        "tailspar_tension": solved[f"{into_tail.name}.tension_b"],
        "anchor_tension": ends[-1],
        "mainline_pull": pull,
        "mainline_tension": main,
        "mainline_highest": highest_of(solved, "mainline"),
        "haulback_pull": solved[f"{name}.haulback_pull"],
        "haulback_tension": haul,
        "haulback_highest": highest_of(solved, haulback),
        "sag": sag,
        "deflection": deflection(sag, float(np.hypot(b[0] - a[0], b[1] - a[1]))),
        "clearance": np.nan,
        "rope_clearance": np.nan,
        **{f"{s.name}_force": solved[f"{s.name}.support_force"] for s in rig.supports},
        "span": k + 1,
        "held_by": solved.held_by,
    }
    for spar, prefix in ((head, "spar"), (tail, "tailspar")):
        if isinstance(spar, GuyedSpar):
            values[f"{prefix}_compression"] = solved[f"{spar.name}.compression"]
            values[f"{prefix}_lean"] = solved[f"{spar.name}.lean"]
            values.update({f"{g.name}_tension": solved[f"{g.name}_{spar.name}.tension_b"] for g in spar.guylines})
    if rig.turn is not None and rig.terrain is not None:
        log = rig.turn.log.name
        drags = solved[f"{log}.ground_force"] > 1.0
        end = ("x", "z") if drags else ("rear_x", "rear_z")
        values["ground_force"] = solved[f"{log}.ground_force"]
        values["dropline_tension"] = solved[f"{name}.dropline_pull"]
        values["suspension"] = "partial" if drags else "full"
        values["clearance"] = solved[f"{log}.{end[1]}"] - float(rig.terrain.elevations(solved[f"{log}.{end[0]}"]))
        values["front_clearance"] = solved[f"{log}.z"] - float(rig.terrain.elevations(solved[f"{log}.x"]))
    elif rig.terrain is not None:
        values["clearance"] = z - rig.carriage.depth - float(rig.terrain.elevations(x))
    if lines and rig.map_frame is not None:
        values["carriage_easting"], values["carriage_northing"] = (float(v) for v in rig.map_frame.to_map(x, y))
    if lines and rig.terrain is not None:
        values["rope_clearance"] = rope_clearance(solved, rig.terrain)
        ropes = {"mainline": rig.mainline, "haulback": rig.haulback}
        for role in (name for name, rope in ropes.items() if rope is not None):
            values[f"{role}_clearance"] = rope_clearance(solved, rig.terrain, role)
    return values


def highest_of(solved: Solved, role: str) -> float:
    """Highest tension of the skyline, the mainline or the haulback [N]; 0 where there is none."""
    runs = [run for run, its in zip(solved.at.model.runs, solved.at.roles, strict=True) if its == role]
    return max((tension for run in runs for tension in end_tensions(solved, run.spans)), default=0.0)


def end_tensions(solved: Solved, spans: Sequence[Span]) -> list[float]:
    """Tensions at both ends of all spans [N]; a load-free span has none higher in between."""
    return [solved[f"{span.name}.tension_{end}"] for span in spans for end in "ab"]


def rope_clearance(solved: Solved, ground: Profile, role: str = "skyline") -> float:
    """Least height of a rope over the ground [m], from the headspar's top on where it runs over that, and for the
    skyline as far as the tailspar. NaN where there is no such rope."""
    pieces = [(above_tangents(ground, piece, end), piece) for piece, end in _pieces(solved, role)]
    least = np.inf if pieces else np.nan
    for bound, piece in sorted(pieces, key=itemgetter(0)):
        if bound >= least:
            break
        least = min(least, least_height(ground, piece).height)
    return float(least)


def least_rope_clearance(solved: Solved, ground: Profile) -> float:
    """A height over the ground [m] that the skyline keeps at least: cheaper than `rope_clearance`, and below it."""
    return min((above_tangents(ground, piece, end) for piece, end in _pieces(solved, "skyline")), default=-np.inf)


def _pieces(solved: Solved, role: str) -> Iterator[tuple[Piece, tuple[float, float]]]:
    """The pieces of a rope over the corridor, towards growing x, and where each ends (x, z) [m]."""
    rig, at = solved.at.rig, solved.at
    for r, run in enumerate(at.model.runs):
        if at.roles[r] != role:
            continue
        weight, strain = run.rope.mass_per_length * rig.gravity, run.rope.strain
        first = next((k for k, node in enumerate(run.nodes) if node.name == rig.headspar.name), 0)
        for k, span in enumerate(run.spans[first:], first):
            start, end = solved.start(r, k), solved.end(r, k)
            force, length = np.array(at.curve(solved.point, k, r)), solved[f"{span.name}.length"]
            if force[0] < 0.0:  # it runs back: looked at from its other end
                start, end, force = end, start, -force - np.array([0.0, 0.0, weight * length])
            if force[0] > 0.0:
                yield Piece((start[0], start[2]), tuple(force), weight, length, strain), (end[0], end[2])
            if role == "skyline" and run.nodes[k + 1].name == rig.tailspar.name:
                break
