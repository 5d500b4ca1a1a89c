"""Random rigs of all kinds, each solved from a cold start at one station: in balance, or a typed error."""

from dataclasses import replace

import numpy as np
import pytest

import ropeway as rw
from ropeway.systems.rigs.rig_builder import with_supports

G = 9.80665


def rope(rng: np.random.Generator, low: float, high: float) -> rw.Rope:
    d = rng.uniform(low, high)
    return rw.Rope(mass_per_length=0.41e4 * d * d, axial_stiffness=43e9 * d * d, breaking_load=0.71e9 * d * d)


def random_rig(seed: int) -> tuple[rw.SkylineRig, float, float]:
    """A rig, a station, a payload. At its supports the bare rope presses down, or pulls slightly."""
    rng = np.random.default_rng(seed)
    kind = rng.choice(["standing", "standing", "standing", "live", "gravity", "running"])
    spans = int(rng.integers(1, 7)) if kind in ("standing", "live") else 1
    widths = rng.uniform(40.0, 350.0, spans)
    x = np.concatenate([[0.0], np.cumsum(widths)])
    slope = rng.uniform(-0.7, 0.4)
    z = slope * x + np.concatenate([[0.0], rng.normal(0.0, 0.03, spans) * widths])
    sky, main = rope(rng, 0.018, 0.032), rope(rng, 0.010, 0.016)
    mass, payload = rng.uniform(100.0, 800.0), rng.uniform(0.0, 5000.0)
    tension = rng.uniform(0.06, 0.3) * sky.breaking_load
    head, tail = rw.HeadSpar("head", at=(0.0, 0.0)), rw.TailSpar("tail", at=(float(x[-1]), float(z[-1])))
    station = float(rng.uniform(0.01, 0.99) * x[-1])
    carriage = rw.Carriage("carriage", mass=mass)
    if kind == "running":
        both = rope(rng, 0.014, 0.022)
        made = rw.running_skyline(
            None,
            headspar=head,
            tailspar=tail,
            haulback=both,
            mainline=both,
            tension=rng.uniform(0.1, 0.33) * both.breaking_load,
            carriage=carriage,
        )
        return made, station, payload
    if kind == "gravity":
        made = rw.gravity_skyline(
            None, headspar=head, tailspar=tail, skyline=sky, mainline=main, tension=tension, carriage=carriage
        )
        return made, station, payload
    held = rng.choice(["bisector", "horizontal", "clamp", "mainline", "haulback"])
    make = rw.standing_skyline if kind == "standing" else rw.live_skyline
    made = make(
        None,
        headspar=head,
        supports=[rw.IntermediateSupport(f"s{i}", at=(float(x[i]), float(z[i]))) for i in range(1, spans)],
        tailspar=tail,
        skyline=sky,
        tension=tension,
        carriage=rw.Carriage("carriage", mass=mass, clamped=held == "clamp"),
        mainline=main if held in ("mainline", "haulback") else None,
        haulback=main if held == "haulback" else None,
        haulback_tension=0.15 * main.breaking_load if held == "haulback" else None,
        holding="horizontal" if held == "horizontal" else "bisector",
    )
    return made, station, payload


def solve(seed: int) -> str:
    rig, station, payload = random_rig(seed)
    try:
        row = rw.load_path(rig, payload, [station]).iloc[0]
    except (rw.EquilibriumError, rw.SlackRopeError) as error:
        return f"{error.cause}: {error.remedy}"
    assert row.highest_tension >= row.skyline_tension * (1.0 - 1e-12) > 0.0
    assert row.mainline_tension >= 0.0
    if rig.length is not None and rig.carriage.clamped is False:
        # Without friction the strain potential changes by weight times height.
        c1, w = rig.skyline.strain.c1, rig.skyline.mass_per_length * G
        head, tail = (t + c1 * t * t / 2.0 for t in (row.headspar_tension, row.tailspar_tension))
        drop = rig.points[0, 2] - rig.points[rig.spans, 2]
        assert head - tail == pytest.approx(w * drop, rel=1e-7, abs=1e-3)
    return ""


def test_random_rigs() -> None:
    failed = {seed: reason for seed in range(80) if (reason := solve(seed))}
    assert len(failed) <= 1, failed
    assert all("rest point" in reason or "carries less" in reason for reason in failed.values()), failed


def near_a_shoe(seed: int) -> str | None:
    """A random rig with its carriage on or near a shoe; None for a rig without supports."""
    rig, _, payload = random_rig(seed)
    if not rig.supports:
        return None
    rng = np.random.default_rng(10_000 + seed)
    radius = float(rng.choice([0.1, 0.5, 1.5]))
    shod = with_supports(rig, [replace(support, radius=radius, slope=None) for support in rig.supports])
    station = shod.supports[int(rng.integers(len(shod.supports)))].at[0] + rng.uniform(-1.0, 1.0) * radius
    try:
        row = rw.load_path(shod, payload, [station]).iloc[0]
    except (rw.EquilibriumError, rw.SlackRopeError) as error:
        return f"{error.cause}: {error.remedy}"
    assert row.carriage_x == pytest.approx(station, abs=0.021)
    return ""


def test_random_rigs_on_and_near_their_shoes() -> None:
    found = [reason for seed in range(40) if (reason := near_a_shoe(seed)) is not None]
    assert len(found) > 16
    assert not any(found), found


@pytest.mark.slow
def test_five_hundred_random_rigs_on_and_near_their_shoes() -> None:
    found = [reason for seed in range(1000, 2000) if (reason := near_a_shoe(seed)) is not None]
    assert len(found) > 500
    assert sum(map(bool, found)) <= 0.005 * len(found), [reason for reason in found if reason]


@pytest.mark.slow
def test_a_thousand_random_rigs() -> None:
    failed = {seed: reason for seed in range(1000, 2000) if (reason := solve(seed))}
    assert len(failed) <= 5, failed
    assert all("rest point" in reason or "carries less" in reason for reason in failed.values()), failed
