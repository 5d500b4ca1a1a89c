"""Random lines in motion: endless ropes and mono-cables, drives of both kinds, responses, reversing schedules, steps,
interventions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import pandas as pd

import ropeway as rw

ROPE = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)


@dataclass(frozen=True)
class RandomRun:
    """A line that runs `until` [s], with interventions."""

    seed: int
    kind: str
    system: rw.System
    until: float
    speeds: Mapping[str, float | rw.Schedule]
    interventions: Sequence[rw.Intervention] = field(default_factory=tuple)

    @property
    def returns(self) -> bool:
        """Whether the line returns to its state when its drives do: ideal ones, no response, no friction."""
        sheaves = [c for c in self.system.components.values() if isinstance(c, rw.ControlSheave)]
        ideal = all(isinstance(c.drive, rw.IdealDrive) and c.response is None for c in sheaves)
        return ideal and self.kind != "rough idlers"

    @property
    def hydraulic(self) -> bool:
        """Whether its drives have states and limits of their own."""
        return any(isinstance(getattr(c, "drive", None), rw.HydraulicDrive) for c in self.system.components.values())

    def simulate(self, every: float, **more: object) -> rw.Result:
        """The whole run."""
        return rw.simulate(
            self.system,
            self.until,
            every=every,
            inputs=self.speeds,
            interventions=self.interventions,
            progress=False,
            **more,
        )

    def rest(self, result: rw.Result, time: float, every: float) -> rw.Result:
        """The run from a time on, resumed."""
        left = self.until - time
        later = [replace(i, time=max(i.time - time, 0.0)) for i in self.interventions if i.time > time]
        stopped = any(i.action == "emergency stop" and i.time <= time for i in self.interventions)
        signals = {n: s.later(time, left) if isinstance(s, rw.Schedule) else s for n, s in self.speeds.items()}
        return rw.simulate(
            self.system,
            left,
            every=every,
            inputs={} if stopped else signals,
            start=result.at(time),
            interventions=later,
            progress=False,
        )


def random_run(seed: int) -> RandomRun:
    """The run of a seed."""
    rng = np.random.default_rng(seed)
    kind = str(rng.choice(["endless", "mono-cable", "rough idlers"], p=[0.4, 0.4, 0.2]))
    until = float(rng.choice([30.0, 60.0, 90.0]))
    span, spacing = float(rng.uniform(70.0, 120.0)), float(rng.uniform(14.0, 50.0))
    masses = [float(m) for m in rng.uniform(80.0, 450.0, int(rng.integers(1, 5)))]
    if rng.random() < 0.3:
        masses.append(0.0)
    tension = float(rng.uniform(50e3, 110e3))
    drive = _drive(rng, span, max(masses))
    if kind == "endless":
        system = rw.endless(
            ROPE,
            _loop(rng, span),
            tension=tension,
            load_mass=masses,
            load_spacing=spacing,
            drive=drive,
        )
    elif kind == "mono-cable":
        response = _response(rng, tension) if rng.random() < 0.7 else None
        precedence = str(rng.choice(["all at once", "upstream first", "worst first", "neighbours locked out"]))
        system = rw.monocable(
            ROPE,
            _line(rng, span),
            tension=tension,
            load_mass=masses,
            load_spacing=spacing,
            drive=drive,
            response=response,
            precedence=precedence,
        )
    else:
        system = _rough(rng, span, tension, masses, spacing, drive)
    speed = _speed(rng, until)
    sheaves = [n for n, c in system.components.items() if isinstance(c, rw.ControlSheave)]
    speeds = {f"{n}.speed": speed for n in sheaves}
    return RandomRun(seed, kind, system, until, speeds, _interventions(rng, sheaves, drive is not None, until))


def _drive(rng: np.random.Generator, span: float, mass: float) -> rw.HydraulicDrive | None:
    if rng.random() < 0.4:
        return None
    ample = rng.random() < 0.5
    return rw.HydraulicDrive(
        displacement=float(rng.uniform(0.8e-4, 1.6e-4)),
        gear_ratio=20.0,
        sheave_radius=0.6,
        relief_pressure=3e7 if ample else float(rng.uniform(8e6, 2e7)),
        pump_flow=0.02 if ample else float(rng.uniform(3e-3, 8e-3)),
        engine_power=2e5 if ample else float(rng.uniform(8e3, 4e4)),
        inertia=float(rng.uniform(400.0, 2000.0)),
        friction=float(rng.choice([0.0, 0.01])),
        command_lag=float(rng.choice([0.0, 0.3])),
        recovers=bool(rng.random() < 0.7),
        drag=float(rng.choice([100.0, 400.0])),  # without any a drive that has lost its pressure swings for ever
    )


def _response(rng: np.random.Generator, tension: float) -> rw.Response:
    period, delay = float(rng.choice([0.5, 1.0, 0.7])), float(rng.choice([0.0, 0.4, 1.0, 2.6]))
    if rng.random() < 0.5:
        return rw.ThresholdResponse(
            low=0.9 * tension,
            high=1.2 * tension,
            increment=float(rng.choice([0.005, 0.01])),
            period=period,
            delay=delay,
            hold=float(rng.choice([0.0, 2.0, 3.0])),
        )
    more: dict[str, object] = {"target": tension} if rng.random() < 0.3 else {}
    return rw.ProportionalResponse(gain=float(rng.uniform(5e-7, 2e-6)), period=period, delay=delay, **more)


def _loop(rng: np.random.Generator, span: float) -> pd.DataFrame:
    n = int(rng.integers(2, 5))
    x = span * np.arange(n + 1)
    z = rng.uniform(-0.08, 0.08) * x + rng.uniform(-5.0, 5.0) * np.sin(np.pi * x / x[-1])
    there = [(f"o{i}", x[i], 0.0, z[i], "idler") for i in range(1, n)]
    back = [(f"b{i}", x[i], 2.0, z[i], "idler") for i in reversed(range(1, n))]
    rows = [("d", 0.0, 0.0, z[0], "control"), *there, ("r", x[n], 1.0, z[n], "return"), *back]
    return pd.DataFrame(rows, columns=["name", "x", "y", "z", "kind"])


def _line(rng: np.random.Generator, span: float) -> pd.DataFrame:
    n = int(rng.integers(4, 8))
    x = np.cumsum(np.concatenate([[0.0], span * rng.uniform(0.8, 1.2, n)]))
    z = rng.uniform(-0.1, 0.15) * x + rng.uniform(-1.5, 1.5, n + 1) + 8.0 * np.sin(np.pi * x / x[-1])
    controls = set(rng.choice(np.arange(1, n), int(rng.integers(1, 3)), replace=False).tolist())
    kind = ["drum" if i in (0, n) else "control" if i in controls else "idler" for i in range(n + 1)]
    return pd.DataFrame({"name": [f"n{i}" for i in range(n + 1)], "x": x, "y": 0.0, "z": z, "kind": kind})


def _rough(
    rng: np.random.Generator,
    span: float,
    tension: float,
    masses: Sequence[float],
    spacing: float,
    drive: rw.HydraulicDrive | None,
) -> rw.System:
    """A mono-cable with friction in its idlers, loads fed or hung."""
    table = _line(rng, span)
    system, nodes = rw.System("rough"), []
    for row in table.itertuples():
        at = (row.x, row.z)
        if row.kind == "control":
            nodes.append(rw.ControlSheave(row.name, at=at, **({} if drive is None else {"drive": drive})))
        elif row.kind == "drum":
            nodes.append(rw.Drum(row.name, at=at, tension=tension))
        else:
            nodes.append(rw.Sheave(row.name, at=at, friction=float(rng.uniform(0.005, 0.03))))
    spans = system.string(ROPE, *nodes, tension=tension)
    if rng.random() < 0.5:
        system.feed(spans, spacing=spacing, masses=masses)
    else:
        length = sum(s.length for s in spans)
        for i, mass in enumerate(m for m in masses if m > 0.0):
            system.hang(rw.Load(f"h{i}", mass=mass), spans, at=float(rng.uniform(0.05, 0.95)) * length)
    return system


def _speed(rng: np.random.Generator, until: float) -> float | rw.Schedule:
    way, fast = rng.choice([-1.0, 1.0]), float(rng.uniform(0.5, 2.0))
    shape = rng.choice(["constant", "turning", "steps", "smooth"])
    if shape == "constant":
        return float(way * fast)
    if shape == "turning":
        turn = float(rng.uniform(0.2, 0.7)) * until
        return rw.Schedule((0.0, turn, turn + 2.0, until), (way * fast, way * fast, -way * fast, -way * fast))
    if shape == "steps":
        times, speeds = [0.0], [way * fast]
        for step in np.sort(rng.uniform(1.0, until - 1.0, 3)):
            times += [float(step), float(step) + 1e-6]
            speeds += [speeds[-1], float(rng.uniform(-1.5, 1.5))]
        return rw.Schedule((*times, until), (*speeds, speeds[-1]))
    times = np.linspace(0.0, until, 6)
    return rw.Schedule(times.tolist(), (way * rng.uniform(0.0, 1.5, 6)).tolist())


def _interventions(
    rng: np.random.Generator, sheaves: Sequence[str], hydraulic: bool, until: float
) -> tuple[rw.Intervention, ...]:
    if rng.random() < 0.6:
        return ()
    at, name = np.sort(rng.uniform(1.0, until - 1.0, 2)), str(rng.choice(sheaves))
    what = rng.choice(["stop", "brake", "pressure"] if hydraulic else ["stop", "brake"])
    if what == "stop":
        return (rw.Intervention(float(at[0]), "emergency stop", deceleration=float(rng.uniform(0.3, 2.0))),)
    pair = ("brake", "release") if what == "brake" else ("pressure lost", "pressure back")
    return tuple(rw.Intervention(float(t), action, name) for t, action in zip(at, pair, strict=True))
