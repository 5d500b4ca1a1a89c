"""Random rigs of all kinds: each answer depends on its question alone, and payload curves have no holes or peaks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from conftest import Campaign

import ropeway as rw


def rope(rng: np.random.Generator, low: float, high: float) -> rw.Rope:
    """A steel rope of a random diameter [m]."""
    d = rng.uniform(low, high)
    return rw.Rope(mass_per_length=0.41e4 * d * d, axial_stiffness=43e9 * d * d, breaking_load=0.71e9 * d * d)


@dataclass(frozen=True)
class Drawn:
    """A random rig, the clearance asked for, and a payload [kg]."""

    rig: rw.SkylineRig
    clearance: float
    payload: float


def drawn(rng: np.random.Generator) -> Drawn | None:
    """A rig of a random kind on rolling ground; None where its bare rope cannot be rigged."""
    kind = str(rng.choice(["standing", "standing", "live", "gravity", "running", "log", "guyed"]))
    spans = int(rng.integers(1, 4)) if kind in ("standing", "live") else 1
    widths = rng.uniform(60.0, 260.0, spans)
    x = np.concatenate([[0.0], np.cumsum(widths)])
    slope = rng.uniform(-0.45, 0.45)
    at = np.unique(np.concatenate([[-40.0], rng.uniform(0.0, x[-1], 6).round(), x, [x[-1] + 40.0]]))
    bowl = 0.10 * (at - x[0]) * (at - x[-1]) / x[-1] if spans == 1 else rng.normal(0.0, 2.0, len(at))
    ground = rw.Profile(at, slope * at + bowl)
    sky, line = rope(rng, 0.018, 0.03), rope(rng, 0.010, 0.016)
    radius = float(rng.choice([0.0, 0.0, 1.5]))
    heights = rng.uniform(8.0, 18.0, spans + 1)
    supports = [
        rw.IntermediateSupport(f"s{i}", station=float(x[i]), height=float(heights[i]), radius=radius)
        for i in range(1, spans)
    ]
    tail = rw.TailSpar("tail", station=float(x[-1]), height=float(heights[-1]))
    head: rw.HeadSpar = rw.HeadSpar("head", station=0.0, height=float(heights[0]))
    carriage = rw.Carriage("car", mass=float(rng.uniform(150.0, 700.0)), depth=float(rng.uniform(0.0, 3.0)))
    tension = float(rng.uniform(0.08, 0.22)) * sky.breaking_load
    mass = float(rng.uniform(0.0, 4000.0))
    clearance = float(rng.uniform(0.0, 2.0))
    back = {}
    if rng.random() < 0.5:
        back = {"haulback": line, "haulback_tension": float(rng.uniform(0.05, 0.25)) * line.breaking_load}
    try:
        if kind == "running":
            rig = rw.running_skyline(
                ground, headspar=head, tailspar=tail, haulback=line, mainline=line, carriage=carriage,
                tension=float(rng.uniform(0.1, 0.3)) * line.breaking_load,
            )  # fmt: skip
            return Drawn(rig, clearance, mass)
        if kind == "gravity":
            rig = rw.gravity_skyline(
                ground, headspar=head, tailspar=tail, skyline=sky, mainline=line, tension=tension, carriage=carriage
            )
            return Drawn(rig, clearance, mass)
        more: dict[str, object] = {"mainline": line, **back}
        if kind == "log":
            log = rw.Log(
                "log", mass=500.0, length=float(rng.uniform(5.0, 14.0)), friction=float(rng.uniform(0.2, 0.8)),
                centre=float(rng.uniform(0.3, 0.6)),
            )  # fmt: skip
            more["turn"] = rw.Turn(log, line, float(rng.uniform(2.0, 8.0)))
        elif kind == "guyed":
            base = float(ground.elevation_at(0.0))
            guys = tuple(
                rw.Guyline(f"g{i}", rope=sky, at=(dx, dy, base), pretension=float(rng.uniform(5e3, 25e3)))
                for i, (dx, dy) in enumerate([(-25.0, -15.0), (-25.0, 15.0), (18.0, 18.0), (18.0, -18.0)])
            )
            head = rw.GuyedSpar("head", foot=(0.0, base), height=float(heights[0]), guylines=guys)
        elif rng.random() < 0.3:
            more = {"mainline": None} if rng.random() < 0.5 else {}
            if not more:
                carriage = rw.Carriage("car", mass=carriage.mass, clamped=True)
        make = rw.live_skyline if kind == "live" else rw.standing_skyline
        rig = make(
            ground, headspar=head, supports=supports, tailspar=tail, skyline=sky, tension=tension, carriage=carriage,
            **more,  # type: ignore[arg-type]
        )  # fmt: skip
        return Drawn(rig, clearance, mass)
    except (rw.InputError, rw.SlackRopeError, rw.EquilibriumError):
        return None


COLUMNS = ["carriage_z", "highest_tension", "mainline_pull"]


def alike(a: dict[str, object], b: dict[str, object]) -> bool:
    """Whether two rows of one station give one answer."""
    if any(a.get(name) != b.get(name) for name in ("limited_by", "held_by", "suspension")):
        return False
    for name, room in (("payload", 1e-5), *((column, 1e-6) for column in COLUMNS)):
        one, other = float(a.get(name, np.nan)), float(b.get(name, np.nan))  # type: ignore[arg-type]
        if np.isnan(one) != np.isnan(other) or abs(one - other) > room * (1.0 + abs(one)):
            return False
    return True


def path_row(rig: rw.SkylineRig, payload: float, station: float) -> dict[str, object]:
    try:
        return dict(rw.load_path(rig, payload, [station]).iloc[0])
    except rw.EquilibriumError as error:
        return {"held_by": type(error).__name__}


@pytest.mark.slow
def test_answers_depend_on_their_question_alone(campaign: Campaign) -> None:
    """In order, in reverse, shuffled and each alone: payloads and load paths are the same."""
    wrong = []
    for i in range(campaign.size(12)):
        rng = np.random.default_rng([campaign.seed, i])
        if (case := drawn(rng)) is None:
            continue
        rig = case.rig
        x = np.linspace(*rig.points[[0, rig.spans], 0], 9)[1:-1]
        stations = np.unique(np.append(x, x[3] + 1.0))
        orders = [stations, stations[::-1], rng.permutation(stations)]
        frames = [rw.payload(rig, clearance=case.clearance, stations=order).frame for order in orders]
        rows = [{r["station"]: r for r in frame.to_dict("records")} for frame in frames]
        for s in stations:
            alone = rw.payload(rig, clearance=case.clearance, stations=[float(s)]).frame.to_dict("records")[0]
            wrong += [(i, "payload", s, n) for n, found in enumerate(rows) if not alike(found[s], alone)]
        alone_path = {s: path_row(rig, case.payload, float(s)) for s in stations}
        known = [s for s in rng.permutation(stations) if alone_path[s]["held_by"] in ("mainline", "holding", "clamp")]
        if known:
            for r in rw.load_path(rig, case.payload, known).to_dict("records"):
                wrong += [] if alike(r, alone_path[r["station"]]) else [(i, "path", r["station"])]
    assert not wrong, wrong


@pytest.mark.slow
def test_payload_curves_have_no_isolated_zero_or_peak(campaign: Campaign) -> None:
    """Stations 1 m apart: no station carries nothing, or much more or less than both its neighbours, unnamed."""
    wrong = []
    for i in range(campaign.size(12)):
        rng = np.random.default_rng([campaign.seed, i])
        if (case := drawn(rng)) is None:
            continue
        rig = case.rig
        low, high = rig.points[[0, rig.spans], 0]
        first = rng.uniform(low + 3.0, high - 16.0)
        frame = rw.payload(rig, clearance=case.clearance, stations=first + np.arange(12.0)).frame
        mass, limit = frame.payload.to_numpy(), frame.limited_by.to_numpy()
        for k in range(1, len(mass) - 1):
            around = (mass[k - 1], mass[k + 1])
            hole = mass[k] < 0.5 * min(around) - 50.0 and limit[k] == "no equilibrium"
            # Over a support the pull jumps, and with it what limits.
            over = min(abs(frame.station[k] - node.at[0]) for node in rig.stands) < 1.5
            peak = mass[k] > 1.5 * max(around) + 50.0 and not over
            if hole or peak:
                wrong.append((i, float(frame.station[k]), mass[k - 1 : k + 2].tolist(), limit[k - 1 : k + 2].tolist()))
    assert not wrong, wrong


@pytest.mark.slow
def test_states_are_physical(campaign: Campaign) -> None:
    """Taut, below absurd tensions, no log on its head; no refusal where a heavier and a lighter carriage have one."""
    wrong, refused, asked = [], [], 0
    for i in range(campaign.size(30)):
        rng = np.random.default_rng([campaign.seed, i])
        if (case := drawn(rng)) is None:
            continue
        rig = case.rig
        low, high = rig.points[[0, rig.spans], 0]
        for s in rng.uniform(low + 1.0, high - 1.0, 6):
            found = path_row(rig, case.payload, float(s))
            asked += 1
            if found["held_by"] not in ("mainline", "holding", "clamp"):
                near = [path_row(rig, m, float(s)).get("carriage_z") for m in (0.8 * case.payload, 1.25 * case.payload)]
                refused += [(i, float(s))] if None not in near else []
                continue
            if float(found["highest_tension"]) > 10.0 * rig.skyline.breaking_load:  # type: ignore[arg-type]
                wrong.append((i, float(s), "tension"))
            if found.get("suspension") == "full" and float(found["clearance"]) > float(found["front_clearance"]):  # type: ignore[arg-type]
                wrong.append((i, float(s), "log on its head"))
    assert not wrong, wrong
    assert len(refused) <= 0.005 * asked, refused
