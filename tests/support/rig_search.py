"""Judges solved states of rigs by the oracle's laws, and finds the oracle's own states for a question."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress

import numpy as np

import ropeway as rw
from ropeway.systems.studies.skyline.carriage_model import Solved
from support.oracle import UP
from support.rig_oracle import F, RigOracle, State, norm

SLACK = 2.4
"""A rope whose length is free must hang with less w L / H than this: on its taut branch."""


def as_unknowns(solved: Solved, station: float, payload: float, height: float | None) -> tuple[RigOracle, np.ndarray]:
    """The oracle of a state of the library, and the state in its unknowns."""
    at, rig = solved.at, solved.at.rig
    held = "mainline" if solved.held_by == "mainline" else "holding"
    drags = (
        rig.turn is not None and solved[f"{rig.turn.log.name}.ground_force"] > 1e-3 * max(payload, 1.0) * rig.gravity
    )
    law = RigOracle(
        rig, at.span, station, payload, held=held, on=at.on, rollers=at.place.rollers, height=height, drags=drags
    )
    u = np.zeros(law.size)
    for line, first in zip(law.lines, law.first[:-1], strict=True):
        r = next(
            k
            for k, run in enumerate(at.model.runs)
            if at.roles[k] == line.role or (not at.roles[k] and run.nodes[0].name == line.role)
        )
        for j, span in enumerate(at.model.runs[r].spans):
            k = int(first) + j
            u[3 * k : 3 * k + 3] = np.array(at.curve(solved.point, j, r)) / F
            u[3 * len(law.spans) + k] = solved[f"{span.name}.length"]
    for name, where in law.at.items():
        node = rig.turn.log.name if name == "log" and rig.turn else name
        u[where] = [solved[f"{node}.{axis}"] for axis in "xyz"]
    for name, k in law.scalar.items():
        if name in law.spars:
            u[k] = solved[f"{name}.compression"] / F
        elif name == "hold":
            u[k] = solved[f"{rig.carriage.name}.holding"] / F
        elif rig.turn is not None:
            u[k] = solved[f"{rig.turn.log.name}.{name}"] / (F if name == "normal" else 1.0)
    return law, u


def misses(law: RigOracle, u: np.ndarray) -> list[str]:
    """The laws that a state breaks, by DOP853: places to 1e-6 m, forces to 1e-6 of the highest tension."""
    force, end, length = law.forces(u[None])
    top = max(norm(force).max(), norm(end).max()) / F
    found = [] if length.min() > 0.0 else ["a span without rope"]
    for name, row in law.rows(u[None], law.by_ode(u)).items():
        size = top if name.endswith(("balance", "joints", "contact")) else 1.0
        if name == "log contact" and not law.drags:
            size = 1.0
        if np.abs(row).max(initial=0.0) > 2e-6 * size:
            found.append(f"{name} {np.abs(row).max():.2g}")
    return found


def described(law: RigOracle, u: np.ndarray) -> State:
    """A solved point, judged."""
    force, end, length = law.forces(u[None])
    taut = bool(length.min() > 0.0) and law.leaves_shoe(u, force, end)
    for k, (line, _, _) in enumerate(law.spans):
        if line.role in ("mainline", "haulback") or (line.role == "skyline" and law.height is not None):
            flat = float(np.hypot(*force[0, k, :2]))
            loose = np.arcsinh(end[0, k, 2] / flat) - np.arcsinh(force[0, k, 2] / flat)
            taut &= bool(loose <= SLACK)
    hold = 0.0
    if law.ideal:
        hold = F * float(u[law.scalar["hold"]])
    elif law.held == "mainline":
        hold = float(norm(end)[0, law.first[next(r for r, m in enumerate(law.lines) if m.role == "mainline") + 1] - 1])
    stable = False
    with suppress(np.linalg.LinAlgError):
        values = np.linalg.eigvals(law.stiffness(u))
        stable = bool(values.real.min() > -1e-9 * np.abs(values).max())
    turn = law.rig.turn
    if turn is not None:
        back, normal = u[law.scalar["rear_x"]], u[law.scalar["normal"]]
        rear, front = u[law.scalar["rear_z"]], u[law.at["log"]]
        floor, slope = law.ground(np.array([back]))
        if law.drags:
            trailing = -turn.log.moving or (-1.0 if slope[0] > 0.0 else 1.0)
            taut &= bool(normal >= 0.0 and trailing * (back - front[0]) > -1e-6 * turn.log.length)
        else:
            taut &= bool(rear >= floor[0] and rear < front[2])
    return State(u, float(u[law.at[law.car]][2]), hold, stable, taut, _loading(law, u))


def _loading(law: RigOracle, u: np.ndarray) -> float:
    """Highest tension over breaking load of any rope."""
    force, end, _ = law.forces(u[None])
    strength = np.array([line.rope.breaking_load for line, _, _ in law.spans])
    return float((np.maximum(norm(force), norm(end))[0] / strength).max())


def newton(law: RigOracle, u: np.ndarray, drop: int | None = None, along: np.ndarray | None = None) -> np.ndarray:
    """A root near a point; with a law dropped, the nearest on the hyperplane across `along`. Raises ArithmeticError."""
    start, before = u, np.inf
    for _ in range(40):
        row, jacobian = law.residual(u[None])[0], law.jacobian(u)
        if drop is not None and along is not None:
            row[drop], jacobian[drop] = along @ (u - start), along
        size = np.abs(row).max()
        if not np.isfinite(size):
            break
        if size < 1e-10 and size >= 0.1 * before:
            return u
        before = size
        try:
            step = -np.linalg.solve(jacobian, row)
        except np.linalg.LinAlgError:
            break
        n = len(law.spans)
        most = np.full(law.size, 4.0)
        most[: 3 * n] = 0.5 * np.repeat(norm(u[: 3 * n].reshape(n, 3)), 3) + 0.05
        most[3 * n : 4 * n] = 0.3 * u[3 * n : 4 * n]
        share = min(1.0, float((most / np.maximum(np.abs(step), 1e-300)).min()))
        if share <= 0.0:
            break
        u = u + share * step
        if np.abs(step).max() < 1e-13:
            return u
    raise ArithmeticError("no root")


def guess(law: RigOracle, z: float, pull: float) -> np.ndarray:
    """About straight ropes to a carriage at a height z [m], pulled towards the headspar with `pull` [N]."""
    rig, n = law.rig, len(law.spans)
    a, b = rig.stands[law.span].at, rig.stands[law.span + 1].at
    share = (law.station - a[0]) / (b[0] - a[0])
    here = np.array([law.station, a[1] + share * (b[1] - a[1]), z])
    places = dict(law.fixed)
    places[law.car] = here
    u = np.zeros(law.size)
    load = (rig.carriage.mass + law.payload) * rig.gravity
    left, right = (np.linalg.norm(np.array(p) - here) for p in (a, b))
    lift = (a[2] - z) / left + (b[2] - z) / right
    weight = rig.skyline.mass_per_length * rig.gravity
    sky = (load + 0.5 * weight * (left + right)) / max(lift, 1e-3)
    if rig.kind.name == "running":
        sky = law.rig.tension or sky
    if rig.turn is not None:
        front = here - rig.turn.length * UP
        u[[law.scalar["rear_x"], law.scalar["rear_z"]]] = front[0], front[2] - rig.turn.log.length
        if law.drags:
            _lay_down(law, u, front, load)
        places["log"] = front
        u[law.at["log"]] = front
    for k, (line, start, stop) in enumerate(law.spans):
        reach = places[stop] - places[start]
        chord = max(float(np.linalg.norm(reach)), 1e-3)
        tension = {"skyline": sky, "mainline": pull, "haulback": line.tension or 0.0, "dropline": load}.get(line.role)
        if tension is None:
            tension = next(g.pretension for s in law.spars.values() for g in s.guylines if g.name == line.role)
        tension = max(tension, law.weight[k] * chord)
        u[3 * n + k] = (
            line.length if line.role not in ("skyline",) and line.length else chord / (1.0 + tension * law.soft[k])
        )
        u[3 * k : 3 * k + 3] = (tension * reach / chord - 0.5 * law.weight[k] * chord * UP) / F
    u[law.at[law.car]] = here
    for name, spar in law.spars.items():
        u[law.at[name]] = spar.at
        u[law.scalar[name]] = sum(g.pretension for g in spar.guylines) / F
    if law.ideal:
        u[law.scalar["hold"]] = pull / F
    return u


def _lay_down(law: RigOracle, u: np.ndarray, front: np.ndarray, load: float) -> None:
    """Swings the rear of a log out from below its front until it comes out of the ground."""
    turn = law.rig.turn
    assert turn is not None
    way = -turn.log.moving or 1.0
    for angle in np.linspace(0.0, 2.8, 400):
        x, z = front[0] + way * turn.log.length * np.sin(angle), front[2] - turn.log.length * np.cos(angle)
        if z >= law.ground(np.array([x]))[0][0]:
            u[[law.scalar["rear_x"], law.scalar["rear_z"], law.scalar["normal"]]] = x, z, 0.4 * load / F
            return


def traced(law: RigOracle, u: np.ndarray, goal: str, way: float, count: int = 160) -> Iterator[np.ndarray]:
    """Points on the curve of states with the law `goal` left out, from a solved point on; way: sign of the carriage's
    first step in z; the points are between solved ones that the law tells apart, and solved with it."""
    sizes = {name: row.shape[1] for name, row in law.rows(u[None]).items()}
    drop = int(dict(zip(sizes, np.cumsum([0, *sizes.values()]), strict=False))[goal])
    k = law.at[law.car].start + 2
    along = -way * np.eye(law.size)[k] * -1.0
    a, b = (law.rig.stands[law.span + j].at for j in (0, 1))
    step, low = 0.1, min(a[2], b[2]) - 0.7 * (b[0] - a[0])
    value = law.residual(u[None])[0, drop]
    for _ in range(count):
        jacobian = law.jacobian(u)
        jacobian[drop] = along
        try:
            tangent = np.linalg.solve(jacobian, np.eye(law.size)[drop])
        except np.linalg.LinAlgError:
            return
        tangent /= np.linalg.norm(tangent)
        while True:
            try:
                there = newton(law, u + step * tangent, drop, tangent)
                if np.linalg.norm(there - u) > 1.5 * step:
                    raise ArithmeticError("another branch")
                break
            except ArithmeticError:
                step *= 0.4
                if step < 1e-4:
                    return
        now = law.residual(there[None])[0, drop]
        if now * value <= 0.0 and now != value:
            with suppress(ArithmeticError):
                yield newton(law, u + value / (value - now) * (there - u))
        u, value, along, step = there, now, tangent, min(1.6 * step, 6.0)
        if u[k] < low or _loading(law, u) > 12.0:
            return


def states(law: RigOracle) -> Iterator[State]:
    """The states of a question that lie on the curve from a rope drawn straight down to a slack one."""
    rig = law.rig
    a, b = rig.stands[law.span].at, rig.stands[law.span + 1].at
    share = (law.station - a[0]) / (b[0] - a[0])
    chord, width = a[2] + share * (b[2] - a[2]), b[0] - a[0]
    goal = "height" if law.height is not None else "skyline rule"
    load = (rig.carriage.mass + law.payload) * rig.gravity
    curves = 0
    for pull in (0.3 * load, 0.05 * load, load) if law.held == "mainline" else (0.0,):
        for gap in (0.03, 0.06, 0.015, 0.12, 0.007, 0.2, 0.003):
            if law.height is not None:
                with suppress(ArithmeticError):
                    yield described(law, newton(law, guess(law, law.height, pull)))
            with suppress(ArithmeticError):
                start = _on_curve(law, guess(law, chord - gap * width, pull), goal)
                for way in (-1.0, 1.0):
                    for point in traced(law, start, goal, way):
                        yield described(law, point)
                curves += 1
            if curves == 2:  # two starts of one curve, or two curves
                return


def _on_curve(law: RigOracle, u: np.ndarray, goal: str) -> np.ndarray:
    sizes = {name: row.shape[1] for name, row in law.rows(u[None]).items()}
    drop = int(dict(zip(sizes, np.cumsum([0, *sizes.values()]), strict=False))[goal])
    return newton(law, u, drop, np.eye(law.size)[law.at[law.car].start + 2])


def existing(rig: rw.SkylineRig, station: float, payload: float, height: float | None = None) -> State | None:
    """A taut and stable state for a question, below ten times the breaking loads: with the carriage on its mainline,
    held by its clamp where the mainline would have to push, or by the ideal force it has. None where the oracle has
    found none."""
    span, x = rig.span_of(station), station
    low, high = rig.stands[span].at[0], rig.stands[span + 1].at[0]
    x = min(max(x, low + 0.02), high - 0.02)
    ways = ["holding"] if rig.mainline is None or rig.carriage.clamped else ["mainline", "holding"]
    if rig.kind.name == "running":
        ways = ["mainline"]
    for held in ways:
        for drags in (False, True) if rig.turn else (False,):
            law = RigOracle(rig, span, x, payload, held=held, height=height, drags=drags)
            for state in states(law):
                if not (state.stable and state.taut and state.loading < 10.0):
                    continue
                if held == "holding" and len(ways) > 1 and state.hold > 0.0:
                    continue
                return state
    return None
