"""Random rigs of all kinds on rolling ground, each with a clearance and a payload."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

import ropeway as rw

KINDS = ("standing", "standing", "live", "live", "gravity", "running", "log", "log", "guyed", "guyed")


@dataclass(frozen=True)
class Drawn:
    """A random rig, a clearance [m], and a payload [kg]."""

    rig: rw.SkylineRig
    clearance: float
    payload: float


def rope(rng: np.random.Generator, low: float, high: float) -> rw.Rope:
    """A steel rope of a random diameter [m]."""
    d = rng.uniform(low, high)
    return rw.Rope(mass_per_length=0.41e4 * d * d, axial_stiffness=43e9 * d * d, breaking_load=0.71e9 * d * d)


def drawn(rng: np.random.Generator) -> Drawn | None:
    """A rig of a random kind; None where its bare rope cannot be rigged."""
    kind = str(rng.choice(KINDS))
    shape = str(rng.choice(["standing", "live", "gravity", "running"])) if kind == "guyed" else kind
    spans = int(rng.integers(1, 4)) if shape in ("standing", "live", "log") else 1
    x = np.concatenate([[0.0], np.cumsum(rng.uniform(60.0, 260.0, spans))])
    ground = _ground(rng, x)
    heights = rng.uniform(8.0, 18.0, spans + 1)
    radius = float(rng.choice([0.0, 0.0, 1.5]))
    supports = [
        rw.IntermediateSupport(f"s{i}", station=float(x[i]), height=float(heights[i]), radius=radius)
        for i in range(1, spans)
    ]
    sky, line = rope(rng, 0.018, 0.03), rope(rng, 0.010, 0.016)
    ends = _spars(rng, ground, x, heights, sky, guyed=kind == "guyed", tied=shape != "running")
    carriage = rw.Carriage("car", mass=float(rng.uniform(150.0, 700.0)), depth=float(rng.uniform(0.0, 3.0)))
    tension = float(rng.uniform(0.08, 0.22)) * sky.breaking_load
    clearance, mass = float(rng.uniform(0.0, 2.0)), float(rng.uniform(0.0, 4000.0))
    try:
        if shape == "running":
            pull = float(rng.uniform(0.1, 0.3)) * line.breaking_load
            rig = rw.running_skyline(ground, **ends, haulback=line, mainline=line, carriage=carriage, tension=pull)
        elif shape == "gravity":
            rig = rw.gravity_skyline(ground, **ends, skyline=sky, mainline=line, tension=tension, carriage=carriage)
        else:
            make = rw.live_skyline if shape == "live" or (kind == "log" and rng.random() < 0.3) else rw.standing_skyline
            more = _held(rng, ends, line, carriage, kind)
            rig = make(ground, **ends, supports=supports, skyline=sky, tension=tension, **more)
    except (rw.InputError, rw.SlackRopeError, rw.EquilibriumError):
        return None
    return Drawn(rig, clearance, mass)


def _ground(rng: np.random.Generator, x: np.ndarray) -> rw.Profile:
    """A slope with a bowl under one span, with bumps under several."""
    slope = rng.uniform(-0.45, 0.45)
    at = np.unique(np.concatenate([[-40.0], rng.uniform(0.0, x[-1], 6).round(), x, [x[-1] + 40.0]]))
    bowl = 0.10 * (at - x[0]) * (at - x[-1]) / x[-1] if len(x) == 2 else rng.normal(0.0, 2.0, len(at))
    return rw.Profile(at, slope * at + bowl)


def _spars(
    rng: np.random.Generator,
    ground: rw.Profile,
    x: np.ndarray,
    heights: np.ndarray,
    sky: rw.Rope,
    *,
    guyed: bool,
    tied: bool,
) -> dict[str, Any]:
    """Headspar and tailspar, one or both of them guyed; sometimes the skyline is tied to a tailhold behind."""
    which = str(rng.choice(["head", "tail", "both"])) if guyed else ""
    behind = tied and rng.random() < 0.25
    hold = rw.Tailhold("hold", station=float(x[-1] + rng.uniform(12.0, 38.0)), height=0.0) if behind else None
    head: rw.HeadSpar = rw.HeadSpar("head", station=0.0, height=float(heights[0]))
    tail: rw.TailSpar | rw.GuyedSpar = rw.TailSpar(
        "tail", station=float(x[-1]), height=float(heights[-1]), tailhold=hold
    )
    if which in ("head", "both"):
        head = _guyed(rng, "head", ground, 0.0, float(heights[0]), sky, [(-25, -15), (-25, 15), (18, 18), (18, -18)])
    if which in ("tail", "both"):
        places = [(25, 15), (25, -15), (-18, -18), (-18, 18)]
        tail = _guyed(rng, "tail", ground, float(x[-1]), float(heights[-1]), sky, places, tailhold=hold)
    return {"headspar": head, "tailspar": tail}


def _guyed(
    rng: np.random.Generator,
    name: str,
    ground: rw.Profile,
    station: float,
    height: float,
    rope: rw.Rope,
    places: Sequence[tuple[float, float]],
    **more: Any,
) -> rw.GuyedSpar:
    """A spar with guylines to anchors (dx, dy) from its foot."""
    guys = tuple(
        rw.Guyline(
            f"{name}_g{i}", rope=rope, pretension=float(rng.uniform(5e3, 25e3)),
            at=(station + dx, float(dy), ground.elevation_at(station + dx)),
        )
        for i, (dx, dy) in enumerate(places)
    )  # fmt: skip
    return rw.GuyedSpar(name, foot=(station, ground.elevation_at(station)), height=height, guylines=guys, **more)


def _held(
    rng: np.random.Generator, ends: dict[str, Any], line: rw.Rope, carriage: rw.Carriage, kind: str
) -> dict[str, Any]:
    """What holds the carriage and its log: a mainline with or without a haulback, an ideal force, a clamp."""
    if kind not in ("log", "guyed") and rng.random() < 0.25:
        if rng.random() < 0.5:
            return {"carriage": carriage, "holding": str(rng.choice(["bisector", "horizontal"]))}
        return {"carriage": rw.Carriage("car", mass=carriage.mass, depth=carriage.depth, clamped=True)}
    found: dict[str, Any] = {"carriage": carriage, "mainline": line}
    if rng.random() < 0.5:
        found.update(haulback=line, haulback_tension=float(rng.uniform(0.05, 0.25)) * line.breaking_load)
        tail = ends["tailspar"]
        if isinstance(tail, rw.GuyedSpar) or rng.random() < 0.4:
            found["haulback_block"] = rw.Block("block", station=tail.station, height=float(rng.uniform(1.0, 6.0)))
    if kind == "log":
        log = rw.Log(
            "log", mass=500.0, length=float(rng.uniform(5.0, 14.0)), friction=float(rng.uniform(0.2, 0.8)),
            centre=float(rng.uniform(0.3, 0.6)),
        )  # fmt: skip
        found["turn"] = rw.Turn(log, line, float(rng.uniform(2.0, 8.0)))
    return found
