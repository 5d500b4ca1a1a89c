"""Random lines with inertia whose loads cross supports: none fails, none is lost, the energy is accounted for.

pytest tests/campaigns/test_inertia.py -m slow --campaign-seed 7 --campaign-count 100
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

import ropeway as rw

ROPE = rw.Rope(mass_per_length=2.4, axial_stiffness=24.026e6, breaking_load=900e3)
UNTIL = 12.0


@dataclass(frozen=True)
class Case:
    """A random line of two to five spans at 1 to 3 m/s, in the plane or in space: it runs, starts, reverses or stops,
    and may lose a load, so that the others swing."""

    system: rw.System
    inertia: rw.Inertia
    interventions: list[rw.Intervention]


def random_line(seed: int) -> Case:
    rng = np.random.default_rng([19, seed])
    n = int(rng.integers(2, 6))
    x = np.cumsum([0.0, *rng.uniform(60.0, 140.0, n)])
    z = 0.3 * np.cumsum([0.0, *rng.uniform(-8.0, 8.0, n)]) - 0.0004 * (x - x.mean()) ** 2
    y = np.array([0.0, *rng.uniform(-4.0, 4.0, n)]) * (rng.random() < 0.5)
    points = [tuple(map(float, p)) for p in zip(x, y, z, strict=True)]
    speed, turn = float(rng.uniform(1.0, 3.0)), 3.0 + float(rng.uniform(1.0, 4.0))
    motions: list[Any] = [
        speed,
        rw.Schedule((0.0, 4.0, 40.0), (0.0, speed, speed)),
        rw.Schedule((0.0, 3.0, turn, 40.0), (speed, speed, -speed, -speed)),
    ]
    motion = motions[int(rng.integers(3))]
    friction = float(rng.choice([0.0, 0.01]))
    idlers = [
        rw.Sheave(f"s{k}", at=points[k], inertia=float(rng.choice([0.0, 100.0])), friction=friction)
        for k in range(1, n)
    ]
    tension = float(rng.uniform(60e3, 120e3))
    last = rw.Drum("e", at=points[-1], speed=motion)
    if rng.random() < 0.5:
        last = rw.Drum("e", at=points[-1], tension=tension, inertia=100.0)
    chords = sum(float(np.linalg.norm(np.subtract(b, a))) for a, b in pairwise(points))
    system = rw.System(f"random {seed}")
    spans = system.string(ROPE, rw.Drum("d", at=points[0], speed=motion), *idlers, last, length=0.9985 * chords)
    system.feed(spans, spacing=float(rng.uniform(25.0, 60.0)), masses=rng.uniform(200.0, 500.0, 5).tolist())
    inertia = rw.Inertia(damping=float(rng.choice([0.0, 5e-4, 2e-3])), zone=float(rng.choice([0.5, 1.0])))
    acts = []
    if rng.random() < 0.4:
        acts.append(
            rw.Intervention(float(rng.uniform(2.0, 6.0)), "emergency stop", deceleration=float(rng.uniform(1, 5)))
        )
    if rng.random() < 0.5:
        acts.append(rw.Intervention(float(rng.uniform(0.5, 3.0)), "load lost", "l2"))
    return Case(system, inertia, acts)


def require_loads(result: rw.Result) -> None:
    """The loads at the end are those of the start, with those put on and without those taken off."""
    expected = Counter(result.at(0.0).loads["load"])
    for event in result.noted:
        expected[event.load] += {"load put on": 1, "load taken off": -1}.get(event.event, 0)
    assert Counter(result.at(UNTIL).loads["load"]) == +expected


@pytest.mark.slow
def test_random_lines_with_inertia(campaign: Any) -> None:
    for seed in range(1000 * campaign.seed, 1000 * campaign.seed + campaign.size(4)):
        case = random_line(seed)
        try:
            result = rw.simulate(
                case.system,
                UNTIL,
                every=2.0,
                inertia=case.inertia,
                interventions=case.interventions,
                tolerance=1e-4,
                progress=False,
            )
            require_loads(result)
            energy = result.energy()
            work = result.full_frame.filter(regex="work$").diff().abs().sum().sum()
            assert abs(energy["residual"]) < 1e-3 * work
            assert energy["damping"] > -1e-3 * work
        except Exception as error:
            error.add_note(f"seed {seed}")
            raise
