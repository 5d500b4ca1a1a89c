"""Mono-cable lines for the tests of schedules."""

import math

import numpy as np
import pandas as pd

import ropeway as rw

ROPE = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)


def supports(spans: int, every: int) -> pd.DataFrame:
    """Spans of about 100 m over a hump, a control sheave at every few supports."""
    rows = []
    for k in range(spans + 1):
        kind = "drum" if k in (0, spans) else "idler" if k % every else "control"
        name = {"drum": "end" if k else "start", "idler": f"s{k}", "control": f"c{k // every}"}[kind]
        height = 30.0 * math.sin(math.pi * k / spans) + 2.0 * math.sin(0.9 * k)
        rows.append((name, 100.0 * k + 4.0 * math.sin(1.7 * k), 5.0 * (-1) ** k, height, kind))
    return pd.DataFrame(rows, columns=["name", "x", "y", "z", "kind"])


def line(
    spans: int = 8,
    every: int = 2,
    *,
    drive: rw.HydraulicDrive | None = None,
    response: rw.ThresholdResponse | None = None,
    tension: float = 40e3,
    **given: object,
) -> rw.System:
    """A line full of loads of 100 to 500 kg."""
    masses = np.random.default_rng(7).uniform(100.0, 500.0, 60).round().tolist()
    return rw.monocable(
        ROPE, supports(spans, every), tension=tension, load_mass=masses, load_spacing=51.0, drive=drive,
        response=response, **given,
    )  # fmt: skip
