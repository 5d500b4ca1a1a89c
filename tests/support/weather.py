"""Equilibria in weather, checked from the physics alone: each rope is integrated from its start.

Along a metre of rope as it was strung, with f the tension vector and g the weight with ice and the wind,

    dr/ds = (1 + alpha dT + eps(|f|)) f / |f|,   df/ds = -g,   f jumps by -F at a load with a force F.

A span has one solution, so that it is right where the integral ends at its support; nodes are right where forces
sum to zero. The wind is resolved here by angles, not as in the library.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

import ropeway as rw


@dataclass(frozen=True)
class Misses:
    """Largest misses of an equilibrium: spans' ends over chords, tensions over idlers over the highest one, and the sum
    of all forces on the system over that."""

    ends: float
    tensions: float
    sum: float


def wind_vector(environment: rw.Environment, north: float = 0.0) -> np.ndarray:
    """Direction that the wind blows, for a y axis that points `north` degrees east of north."""
    heading = np.radians(environment.wind_from - north)
    return -np.array([np.sin(heading), np.cos(heading), 0.0])


def rope_force(
    rope: rw.Rope, chord: np.ndarray, environment: rw.Environment, gravity: float, north: float = 0.0
) -> np.ndarray:
    """Force on each metre of a rope as it was strung (3,) [N/m]."""
    d, t = rope.diameter or 0.0, environment.ice_thickness
    ice = environment.ice_density * np.pi * ((d / 2.0 + t) ** 2 - (d / 2.0) ** 2)
    blows, along = wind_vector(environment, north), chord / np.linalg.norm(chord)
    angle = np.arccos(np.clip(blows @ along, -1.0, 1.0))
    across = blows - np.cos(angle) * along
    size = np.linalg.norm(across)
    normal = across / size if size > 0.0 else across
    wind = rope.drag_coefficient * environment.pressure * (d + 2.0 * t) * np.sin(angle) ** 2 * normal
    return np.array([0.0, 0.0, -(rope.mass_per_length + ice) * gravity]) + wind


def integrated(
    force: np.ndarray, pieces: list[tuple[float, np.ndarray]], rope: rw.Rope, pull: np.ndarray, expansion: float
) -> tuple[np.ndarray, np.ndarray]:
    """Reach and tension vector at the end of a rope, of pieces (length, force of the load at its end)."""
    c1, c2, _ = rope.strain

    def rate(_: float, y: np.ndarray) -> np.ndarray:
        tension = np.linalg.norm(y[3:])
        return np.concatenate([(expansion + tension * (c1 + c2 * tension)) * y[3:] / tension, -pull])

    y = np.concatenate([np.zeros(3), force])
    for length, load in pieces:
        if length > 0.0:
            run = solve_ivp(rate, (0.0, length), y, method="DOP853", rtol=1e-13, atol=1e-11)
            assert run.success, run.message
            y = run.y[:, -1]
        y[3:] -= load
    return y[:3], y[3:]


def misses(eq: rw.Equilibrium, environment: rw.Environment, north: float = 0.0) -> Misses:
    """Of an equilibrium of ropes over anchors and idlers."""
    system = eq.model.system
    gravity, wind = system.gravity, environment.pressure * wind_vector(environment, north)
    warmer = 0.0 if environment.temperature is None else environment.temperature - system.temperature
    ends, tensions, total, top = 0.0, 0.0, np.zeros(3), 0.0
    for run in eq.runs:
        before: np.ndarray | None = None
        for k, span in enumerate(run.spans):
            a, b = run.start(k, eq.__getitem__), run.end(k, eq.__getitem__)
            on = eq.loads[eq.loads["span"] == span.name]
            areas = dict(zip(run.loads.names, run.loads.drag, strict=True))
            at = [0.0, *on["distance"], eq[f"{span.name}.length"]]
            forces = [m * gravity * np.array([0.0, 0.0, -1.0]) for m in on["mass"]]
            forces = [f + areas[n] * wind for f, n in zip(forces, on["load"], strict=True)] + [np.zeros(3)]
            pull = rope_force(span.rope, b - a, environment, gravity, north)
            expansion = 1.0 + span.rope.thermal_expansion * warmer
            start = np.array([eq[f"{span.name}.force_{axis}"] for axis in "xyz"])
            pieces = list(zip(np.diff(at), forces, strict=True))
            reach, end = integrated(start, pieces, span.rope, pull, expansion)
            ends = max(ends, float(np.linalg.norm(reach - (b - a)) / np.linalg.norm(b - a)))
            top = max(top, float(np.linalg.norm(start)), float(np.linalg.norm(end)))
            if before is not None:
                tensions = max(tensions, abs(float(np.linalg.norm(start) - np.linalg.norm(before))))
            before = end
            total += end - start + at[-1] * pull + sum(forces)
    return Misses(ends, tensions / top, float(np.linalg.norm(total)) / top)
