"""Faults in the results of a random rig, by station and kind."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

import ropeway as rw
from ropeway.systems.studies.skyline.station_solver import Stations
from support.random_rigs import Drawn
from support.rig_search import as_unknowns, existing, misses

HELD = ("mainline", "holding", "clamp")
COLUMNS = ("carriage_z", "highest_tension", "mainline_pull", "haulback_pull", "clearance")
Row = dict[str, Any]


@dataclass
class Verdict:
    """Numbers of load path rows and payloads of a random rig, and its faults.

    Rows requested, rejected, and rejected although the oracle has a state; payloads requested; `faults`.
    """

    asked: int = 0
    refused: int = 0
    payloads: int = 0
    refused_wrongly: list[tuple[Any, ...]] = field(default_factory=list)
    faults: list[tuple[Any, ...]] = field(default_factory=list)

    def add(self, other: Verdict) -> None:
        self.asked += other.asked
        self.refused += other.refused
        self.payloads += other.payloads
        self.refused_wrongly += other.refused_wrongly
        self.faults += other.faults


def alike(a: Row, b: Row) -> bool:
    """Whether two rows of one station give one answer."""
    words = [[row.get(name) for name in ("limited_by", "held_by", "suspension")] for row in (a, b)]
    if not all(
        one == other or {type(one), type(other)} <= {float, type(None)} for one, other in zip(*words, strict=True)
    ):
        return False
    for name, room in (("payload", 1e-5), *((column, 1e-6) for column in COLUMNS)):
        one, other = float(a.get(name, np.nan)), float(b.get(name, np.nan))
        if np.isnan(one) != np.isnan(other) or abs(one - other) > room * (1.0 + abs(one)):
            return False
    return True


def path_row(rig: rw.SkylineRig, payload: float, station: float, height: float | None = None) -> Row:
    """The row of a load path, or the refusal as `refusal` and as what holds the carriage."""
    try:
        return dict(rw.load_path(rig, payload, [station], height=height).iloc[0])
    except rw.EquilibriumError as error:
        return {"held_by": type(error).__name__, "refusal": error.cause}


def judge(case: Drawn, rng: np.random.Generator) -> Verdict:
    """All checks of one rig."""
    found = Verdict()
    low, high = case.rig.points[[0, case.rig.spans], 0]
    x = np.linspace(low, high, 9)[1:-1]
    stations = np.unique(np.append(x, x[3] + 1.0))
    by_height = case.rig.kind.sets_height and case.rig.turn is None
    rows = {s: path_row(case.rig, case.payload, float(s)) for s in stations}
    for s, r in rows.items():
        _judge_row(found, case.rig, float(s), case.payload, None, r)
    if by_height:
        for s in rng.choice(stations, 3, replace=False):
            h = case.clearance + float(rng.uniform(0.0, 4.0))
            _judge_row(found, case.rig, float(s), case.payload, h, path_row(case.rig, case.payload, float(s), h))
    known = [s for s in rng.permutation(stations) if rows[s]["held_by"] in HELD]
    if known:
        for r in rw.load_path(case.rig, case.payload, known).to_dict("records"):
            if not alike(r, rows[r["station"]]):
                found.faults.append(("path by order", float(r["station"])))
    _judge_payloads(found, case, stations, rng)
    judge_curve(found, case, float(rng.uniform(low + 3.0, high - 16.0)))
    return found


def _judge_row(
    found: Verdict, rig: rw.SkylineRig, station: float, payload: float, height: float | None, row: Row
) -> None:
    """A row must obey the oracle's laws; a refusal must not have a state of the oracle's."""
    z = None
    if height is not None:
        assert rig.terrain is not None
        z = rig.terrain.elevation_at(station) + height + rig.carriage.depth
        if z >= rig.chord(rig.span_of(station), station):
            return
    found.asked += 1
    if row["held_by"] not in HELD:
        found.refused += 1
        if (state := existing(rig, station, payload, z)) is not None:
            found.refused_wrongly.append((station, payload, height, row["refusal"], state.z, state.hold))
        return
    solved = Stations(rig, by_height=z is not None).solve(station, payload, z)
    law, u = as_unknowns(solved, float(row["carriage_x"]), payload, z)
    for miss in misses(law, u):
        found.faults.append(("law", station, height, miss))
    for miss in _differences(law, u, row):
        found.faults.append(("column", station, height, miss))
    if law.on is None:
        values = np.linalg.eigvals(law.stiffness(u))
        near = rig.shoe_near(station) is not None
        if values.real.min() < -1e-6 * np.abs(values).max() and not near:
            found.faults.append(("unstable", station, height, float(values.real.min())))


def _differences(law: Any, u: np.ndarray, row: Row) -> list[str]:
    """Columns of a row that are not those of the state in the oracle's unknowns."""
    force, end, _ = law.forces(u[None])
    found: dict[str, float] = {"carriage_x": float(u[law.at[law.car]][0]), "carriage_z": float(u[law.at[law.car]][2])}
    for r, line in enumerate(law.lines):
        first, last = law.first[r], law.first[r + 1]
        ends = np.concatenate([force[0, first:last], end[0, first:last]])
        top = float(np.linalg.norm(ends, axis=1).max())
        if line.role == "skyline":
            found["highest_tension"] = top
            found["anchor_tension"] = float(np.linalg.norm(end[0, last - 1]))
        elif line.role in ("mainline", "haulback"):
            found[f"{line.role}_highest"] = top
            found[f"{line.role}_tension"] = float(np.linalg.norm(force[0, first]))
            found[f"{line.role}_pull"] = float(np.linalg.norm(end[0, last - 1]))
        elif line.role == "dropline":
            found["dropline_tension"] = float(np.linalg.norm(force[0, first]))
        else:
            found[f"{line.role}_tension"] = top
    return [
        f"{name} {row[name]} not {value}"
        for name, value in found.items()
        if name in row and abs(float(row[name]) - value) > 1e-6 * (1.0 + abs(value))
    ]


def _judge_payloads(found: Verdict, case: Drawn, stations: np.ndarray, rng: np.random.Generator) -> None:
    """Each station alone and all shuffled give one payload; it is the greatest."""
    rig = case.rig
    frame = rw.payload(rig, clearance=case.clearance, stations=rng.permutation(stations)).frame
    rows = {r["station"]: r for r in frame.to_dict("records")}
    for s in stations:
        found.payloads += 1
        alone = rw.payload(rig, clearance=case.clearance, stations=[float(s)]).frame.to_dict("records")[0]
        if not alike(rows[s], alone):
            found.faults.append(("payload by order", float(s), rows[s]["payload"], alone["payload"]))
        wrong = [("payload", float(s), why) for why in _not_greatest(case, float(s), alone)]
        # Where no equilibrium limits it, one of the oracle's is a refusal: it may be none that is reached from empty.
        (found.refused_wrongly if alone["limited_by"] == "no equilibrium" else found.faults).extend(wrong)


def _margins(case: Drawn, row: Row) -> dict[str, float]:
    """How far a load path's row is from each limit, in parts of it, of 10 m for clearances."""
    rig = case.rig
    sky = rig.skyline.breaking_load / 3.0
    running = rig.kind.name == "running"
    found = {f"{'haulback' if running else 'skyline'} tension": 1.0 - row["highest_tension"] / sky}
    if rig.mainline is not None:
        found["mainline tension"] = 1.0 - row["mainline_highest"] / (rig.mainline.breaking_load / 3.0)
    if rig.haulback is not None and not running:
        found["haulback tension"] = 1.0 - row["haulback_highest"] / (rig.haulback.breaking_load / 3.0)
    if rig.turn is not None:
        found["dropline tension"] = 1.0 - row["dropline_tension"] / (rig.turn.dropline.breaking_load / 3.0)
        found["clearance"] = (row["front_clearance"] - case.clearance) / 10.0
    else:
        found["clearance"] = (row["clearance"] - case.clearance) / 10.0
    found["rope clearance"] = row["rope_clearance"] / 10.0
    for support in rig.supports:
        found[f"lift-off at {support.name}"] = row[f"{support.name}_force"] / sky
    for spar, prefix in ((rig.headspar, "spar"), (rig.tailspar, "tailspar")):
        if isinstance(spar, rw.GuyedSpar):
            found[f"lift-off of {spar.name}"] = row[f"{prefix}_compression"] / sky
            for guy in spar.guylines:
                found[f"guyline {guy.name}"] = 1.0 - row[f"{guy.name}_tension"] / (guy.rope.breaking_load / 3.0)
    return found


def _not_greatest(case: Drawn, station: float, row: Row) -> list[str]:
    """Why a payload is not the greatest one within all limits."""
    rig, mass, limit = case.rig, float(row["payload"]), str(row["limited_by"])
    lowered = rig.kind.sets_height and rig.turn is None
    height = float(row.get("clearance", case.clearance)) if lowered else None
    height = case.clearance if height is not None and not np.isfinite(height) else height
    label = f"{mass:.6g} kg by {limit!r} at clearance {height}"
    at = path_row(rig, mass, station, height)
    if limit == "nothing":  # on a support's shoe, which has no capacity here
        return [] if rig.shoe_near(station) is not None else [f"unlimited: {label}"]
    if mass == 0.0:
        return [] if _explained(case, station, 0.0, height, at, limit) else [f"zero unexplained: {label}"]
    if at["held_by"] not in HELD:
        return [f"no state at {label}: {at['refusal']}"]
    if beyond := {name: m for name, m in _margins(case, at).items() if m < -2e-7}:
        return [f"beyond {beyond}: {label}"]
    more = 1.002 * mass + 0.01
    if not _explained(case, station, more, height, path_row(rig, more, station, height), limit):
        return [f"more is possible: {label}"]
    return []


def _explained(case: Drawn, station: float, mass: float, height: float | None, row: Row, limit: str) -> bool:
    """Whether a payload is too much by the limit that is named, or has no state by the oracle either."""
    rig = case.rig
    if row["held_by"] in HELD:
        if limit == "does not run out by gravity":
            return bool(row["held_by"] == "clamp")
        beyond = {name for name, margin in _margins(case, row).items() if margin < 0.0}
        return limit in beyond or (height is not None and limit == "rope clearance" and len(beyond) > 0)
    z = None
    if height is not None:
        assert rig.terrain is not None
        z = rig.terrain.elevation_at(station) + height + rig.carriage.depth
        if z >= rig.chord(rig.span_of(station), station):
            return True
    return existing(rig, station, mass, z) is None


def judge_curve(found: Verdict, case: Drawn, first: float) -> None:
    """Twelve stations 1 m apart: none carries much more or much less than both its neighbours, and none nothing between
    two that carry something, unless the limit that is named is reached there without a payload."""
    rig = case.rig
    frame = rw.payload(rig, clearance=case.clearance, stations=first + np.arange(12.0)).frame
    mass, limit = frame.payload.to_numpy(), frame.limited_by.to_numpy()
    found.payloads += len(mass)
    for k in range(1, len(mass) - 1):
        around = (mass[k - 1], mass[k + 1])
        over = min(abs(frame.station[k] - node.at[0]) for node in rig.stands) < 1.5  # there the pull jumps
        hole = mass[k] < 0.5 * min(around) - 50.0 and not over
        peak = mass[k] > 1.5 * max(around) + 50.0 and not over
        zero = mass[k] == 0.0 < min(around) and not hole
        if hole or peak or (zero and _not_greatest(case, float(frame.station[k]), dict(frame.iloc[k]))):
            three, kind = slice(k - 1, k + 2), "hole" if hole else "peak" if peak else "zero"
            found.faults.append((kind, float(frame.station[k]), mass[three].tolist(), limit[three].tolist()))
