"""An independent oracle for skyline rigs with their carriage: ropes by integration, balance at each node, own searches.

Each span hangs from the force at its start by Gauss quadrature of dr/ds (`oracle.Material`), nothing of the library's
closed forms. Unknowns are the forces and lengths of all spans and the places of what can move; derivatives are complex
steps. Ropes keep their length, a drum its tension, and tensions are equal over frictionless nodes; on a shoe a rope
leaves along its own direction. `judge` evaluates these laws at a state of the library; `states` finds all states of a
question on the curve that leads down from a rope drawn straight. Units: N, m; scaled by 1e4 N and 1 m.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

import ropeway as rw
from support.oracle import UP, Material, by_ode

F = 1e4
_X, _W = np.polynomial.legendre.leggauss(24)
_SHARE, _W = (_X + 1.0) / 2.0, _W / 2.0


def material(rope: rw.Rope, gravity: float) -> Material:
    """Of a rope that stretches elastically."""
    return Material(rope.mass_per_length * gravity, 1.0 / rope.axial_stiffness)


@dataclass(frozen=True)
class Line:
    """A rope over nodes, by their keys. length [m] that it keeps, or tension [N] at its start; None: free."""

    role: str
    rope: rw.Rope
    nodes: tuple[str, ...]
    length: float | None = None
    tension: float | None = None


@dataclass(frozen=True)
class Shoe:
    """An arc of a radius around a centre (x, z), outward normal at its middle (x, z)."""

    centre: np.ndarray
    radius: float
    normal: np.ndarray

    @classmethod
    def of(cls, support: rw.IntermediateSupport) -> Shoe:
        slope = support.slope or 0.0
        normal = np.array([-slope, 1.0]) / np.hypot(slope, 1.0)
        at = np.array([support.at[0], support.at[2]])
        return cls(at - support.radius * normal, support.radius, normal)

    def leave(self, force: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Where a rope with a `force` (..., 3) in its direction, towards greater x, touches the arc: the place
        (..., 2) and the angle beyond the middle (...)."""
        flat = np.sqrt(force[..., 0] ** 2 + force[..., 2] ** 2)
        normal = np.stack([-force[..., 2] / flat, force[..., 0] / flat], axis=-1)
        out = normal @ self.normal
        on = normal @ np.array([self.normal[1], -self.normal[0]])
        return self.centre + self.radius * normal, np.arctan(on / out)


@dataclass(frozen=True)
class State:
    """A solved state: scaled unknowns; height of the carriage [m]; what holds it [N]; whether it is stable and its free
    ropes are taut; highest tension over breaking load of any rope."""

    u: np.ndarray
    z: float
    hold: float
    stable: bool
    taut: bool
    loading: float


def norm(v: np.ndarray) -> np.ndarray:
    """Length of vectors (..., 3), complex parts as derivatives."""
    return np.asarray(np.sqrt((v * v).sum(axis=-1)))


def in_span(
    rig: rw.SkylineRig, span: int, *, held: str, on: int | None = None, rollers: int | None = None
) -> tuple[list[Line], dict[str, np.ndarray]]:
    """The ropes of a rig with its carriage in a span or on a shoe, and where their fixed nodes are. held: "mainline",
    "holding" or "clamp" (an ideal force along the bisector, or the carriage's own clamp)."""
    fixed: dict[str, np.ndarray] = {node.name: np.array(node.at) for node in rig.ends}
    head, tail, g = rig.headspar, rig.tailspar, rig.gravity
    kind = rig.kind.name
    lines: list[Line] = []
    for spar in (head, tail):
        for guy in spar.guylines if isinstance(spar, rw.GuyedSpar) else ():
            fixed[guy.name] = np.array(guy.at)
            reach = np.array(spar.at) - guy.at
            lines.append(Line(guy.name, guy.rope, (guy.name, spar.name), pretensioned(guy, reach, g)))
    yarder: tuple[str, ...] = (head.name,)
    if isinstance(head, rw.GuyedSpar):
        fixed["foot"] = np.array(head.foot)
        yarder = ("foot", head.name)
    car = rig.carriage.name
    if kind == "running":
        lines.append(Line("skyline", rig.skyline, (*yarder, car, tail.name, car), tension=rig.tension))
    else:
        start = (head.name,) if kind == "standing" else yarder
        over = [s.name for s in rig.supports]
        over[span : span + (on is not None)] = [car]
        ends = [tail.name] if tail.tailhold is None else [tail.name, tail.tailhold.name]
        length = float(rig.length or 0.0)
        if len(start) > 1:
            length += float(np.linalg.norm(fixed[head.name] - fixed["foot"])) / (
                1.0 + (rig.tension or 0.0) / rig.skyline.axial_stiffness
            )
        lines.append(Line("skyline", rig.skyline, (*start, *over, *ends), length))
    if held == "mainline" and rig.mainline is not None:
        passed = [s.name for s in rig.supports[: span if rollers is None else rollers]]
        lines.append(Line("mainline", rig.mainline, (*yarder, *passed, car)))
    if rig.haulback is not None and kind != "running" and not rig.carriage.clamped:
        way: tuple[str, ...] = (tail.name,)
        if rig.haulback_block is not None:
            fixed[rig.haulback_block.name] = np.array(rig.haulback_block.at)
            way = (*yarder, rig.haulback_block.name)
        lines.append(Line("haulback", rig.haulback, (*way, car), tension=rig.haulback_tension))
    if rig.turn is not None:
        lines.append(Line("dropline", rig.turn.dropline, (car, "log"), rig.turn.length))
    return lines, fixed


def pretensioned(guy: rw.Guyline, reach: np.ndarray, gravity: float) -> float:
    """Length [m] of a guyline with its pretension at its anchor, its top end `reach` (3,) away."""
    rope = material(guy.rope, gravity)
    flat = np.array([np.hypot(reach[0], reach[1]), reach[2]])
    angle, length = float(np.arctan2(flat[1], flat[0])) - 0.02, float(np.linalg.norm(reach))
    for _ in range(60):
        way = np.array([np.cos(angle), 0.0, np.sin(angle)])
        turn = np.array([-np.sin(angle), 0.0, np.cos(angle)])
        force = guy.pretension * way + rope.weight * length * _SHARE[:, None] * UP
        slope, stiffness = rope.slope(force)
        miss = length * (_W @ slope)[[0, 2]] - flat
        by_angle = length * np.einsum("q,qij,j->i", _W, stiffness, guy.pretension * turn)[[0, 2]]
        end, _ = rope.slope(guy.pretension * way + rope.weight * length * UP)
        step = np.linalg.solve(np.array([by_angle, end[[0, 2]]]).T, miss)
        angle, length = angle - step[0], length - step[1]
        if np.abs(step).max() < 1e-14 * length:
            break
    return float(length)


class RigOracle:
    """The laws of a rig with its carriage at a station [m] with a payload [kg], at a height z [m] where the yarder sets
    that. drags: whether its log drags on the ground or hangs free."""

    def __init__(
        self,
        rig: rw.SkylineRig,
        span: int,
        station: float,
        payload: float,
        *,
        held: str,
        on: int | None = None,
        rollers: int | None = None,
        height: float | None = None,
        drags: bool = False,
    ) -> None:
        self.rig, self.span, self.station, self.payload = rig, span, station, payload
        self.held, self.on, self.height, self.drags = held, on, height, drags
        self.lines, self.fixed = in_span(rig, span, held=held, on=on, rollers=rollers)
        self.car = rig.carriage.name
        self.spars = {s.name: s for s in (rig.headspar, rig.tailspar) if isinstance(s, rw.GuyedSpar)}
        self.shoes = {s.name: Shoe.of(s) for s in rig.supports if s.radius > 0.0}
        self.under = None if on is None else self.shoes[rig.supports[on].name]
        self.ideal = held != "mainline" and not rig.carriage.clamped
        self.spans = [(line, a, b) for line in self.lines for a, b in pairwise(line.nodes)]
        self.first = np.cumsum([0, *(len(line.nodes) - 1 for line in self.lines)])
        self.moving = [self.car, *self.spars, *(["log"] if rig.turn else [])]
        n = len(self.spans)
        self.at = {name: slice(4 * n + 3 * k, 4 * n + 3 * k + 3) for k, name in enumerate(self.moving)}
        names = [*self.spars, *(["rear_x", "rear_z", "normal"] if rig.turn else []), *(["hold"] if self.ideal else [])]
        self.scalar = {name: 4 * n + 3 * len(self.moving) + k for k, name in enumerate(names)}
        self.size = 4 * n + 3 * len(self.moving) + len(names)
        self.weight = np.array([line.rope.mass_per_length * rig.gravity for line, _, _ in self.spans])
        self.soft = np.array([1.0 / line.rope.axial_stiffness for line, _, _ in self.spans])

    # The laws

    def forces(self, u: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Forces at starts and ends of the spans (b, n, 3) [N], and lengths (b, n) [m], for unknowns (b, size)."""
        n = len(self.spans)
        force, length = F * u[:, : 3 * n].reshape(-1, n, 3), u[:, 3 * n : 4 * n]
        return force, force + (self.weight * length)[..., None] * UP, length

    def reach(self, force: np.ndarray, length: np.ndarray) -> np.ndarray:
        """From the start to the end of each span (b, n, 3) [m], by quadrature."""
        along = force[:, :, None, :] + (self.weight * length)[..., None, None] * _SHARE[:, None] * UP
        tension = norm(along)
        slope = along * ((1.0 + self.soft[:, None] * tension) / tension)[..., None]
        return np.asarray(length[..., None] * np.einsum("q,bnqi->bni", _W, slope))

    def rows(self, u: np.ndarray, reach: np.ndarray | None = None) -> dict[str, np.ndarray]:
        """All laws by name, each (b, k), zero at rest. reach: of the spans, where it is known better."""
        return self._laws(u, reach)[0]

    def _laws(self, u: np.ndarray, reach: np.ndarray | None = None) -> tuple[dict[str, np.ndarray], np.ndarray]:
        """All laws, and the rope of each span with what of it lies on shoes (b, n) [m]."""
        force, end, length = self.forces(u)
        miss = self.reach(force, length) if reach is None else reach.astype(u.dtype)
        laid = np.zeros_like(length)  # rope on shoes, counted with the span beside it
        pulls: dict[str, Any] = dict.fromkeys(self.moving, 0.0)
        rows: dict[str, np.ndarray] = {}
        for k, (line, a, b) in enumerate(self.spans):
            for name, pull, sign in ((a, force[:, k], 1.0), (b, end[:, k], -1.0)):
                place, arc, acting = self._attached(u, name, pull, sign, hangs=line.role == "dropline")
                miss[:, k] += sign * place
                laid[:, k] += arc / (1.0 + self.soft[k] * norm(pull))
                if name in pulls:
                    pulls[name] = pulls[name] + acting
        rows["closure"] = miss.reshape(len(u), -1)
        for line, k in zip(self.lines, self.first[:-1], strict=True):
            m = len(line.nodes) - 1
            if m > 1:
                rows[f"{line.role} joints"] = (norm(force[:, k + 1 : k + m]) - norm(end[:, k : k + m - 1])) / F
            if line.role == "skyline" and self.height is not None:
                continue
            if line.length is not None:
                rows[f"{line.role} rule"] = ((length + laid)[:, k : k + m].sum(axis=1) - line.length)[:, None]
            elif line.tension is not None:
                rows[f"{line.role} rule"] = ((norm(force[:, k]) - line.tension) / F)[:, None]
        if self.rig.carriage.clamped:  # its place on the rope is free, for its station
            k = list(self.lines[self._sky].nodes).index(self.car) - 1
            rows["skyline joints"] = np.delete(rows["skyline joints"], k, axis=1)
        rows["station"] = u[:, self.at[self.car]][:, :1] - self.station
        if self.height is not None:
            rows["height"] = u[:, self.at[self.car]][:, 2:] - self.height
        self._balances(rows, u, pulls, force, end)
        return rows, length + laid

    @property
    def _sky(self) -> int:
        return next(r for r, line in enumerate(self.lines) if line.role == "skyline")

    def _attached(
        self, u: np.ndarray, name: str, pull: np.ndarray, sign: float, *, hangs: bool = False
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Where a span begins (sign 1) or ends (-1) (b, 3), rope on the shoe there [m], force on the node (b, 3). What
        `hangs` from the carriage lies on no shoe."""
        none, acting = np.zeros(len(u)), sign * pull
        if name == self.car and self.under is not None and not hangs and (sign > 0.0 or self._on_roller(pull)):
            return self._on_shoe(u, pull, sign)
        if name in self.at:
            return u[:, self.at[name]], none, acting
        if name not in self.shoes:
            return np.broadcast_to(self.fixed[name], (len(u), 3)).astype(u.dtype), none, acting
        (place, angle), shoe = self.shoes[name].leave(pull), self.shoes[name]
        y = np.full(len(u), self.fixed[name][1])
        return np.stack([place[:, 0], y, place[:, 1]], axis=1), sign * shoe.radius * angle, acting

    def _on_roller(self, pull: np.ndarray) -> bool:
        """Whether a rope that ends at the carriage comes from smaller x: skyline and mainline do, a haulback not."""
        return bool(pull[0, 0].real > 0.0)

    def leaves_shoe(self, u: np.ndarray, force: np.ndarray, end: np.ndarray) -> bool:
        """Whether the skyline pulls the carriage on a shoe to its own side at both of its ends."""
        if self.under is None:
            return True
        away = (u[self.at[self.car]][[0, 2]] - self.under.centre) / self.under.radius
        along = np.array([away[1], -away[0]])
        k = int(self.first[self._sky]) + list(self.lines[self._sky].nodes).index(self.car)
        return bool(force[0, k, [0, 2]] @ along > 0.0 and end[0, k - 1, [0, 2]] @ along > 0.0)

    def _on_shoe(self, u: np.ndarray, pull: np.ndarray, sign: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        shoe = self.under
        assert shoe is not None
        here = u[:, self.at[self.car]]
        normal = (here[:, [0, 2]] - shoe.centre) / shoe.radius
        along = sign * np.stack([normal[:, 1], -normal[:, 0]], axis=1)  # away from the carriage, on the shoe
        flat = sign * pull[:, [0, 2]]
        below = np.arctan(-(flat * normal).sum(axis=1) / (flat * along).sum(axis=1))
        if below[0].real <= 0.0:
            return here, np.zeros(len(u)), sign * pull
        size = norm(pull)
        aside = shoe.radius * (np.sin(below)[:, None] * along + (np.cos(below) - 1.0)[:, None] * normal)
        acting = size[:, None] * along
        zero = np.zeros(len(u))
        return (
            here + np.stack([aside[:, 0], zero, aside[:, 1]], axis=1),
            shoe.radius * below,
            np.stack([acting[:, 0], zero, acting[:, 1]], axis=1),
        )

    def _balances(
        self, rows: dict[str, np.ndarray], u: np.ndarray, pulls: dict[str, Any], force: np.ndarray, end: np.ndarray
    ) -> None:
        rig = self.rig
        mass = rig.carriage.mass + (0.0 if rig.turn else self.payload)
        total = pulls[self.car] - mass * rig.gravity * UP
        if self.ideal:
            k = int(self.first[self._sky]) + list(self.lines[self._sky].nodes).index(self.car)
            # As the skyline pulls at the carriage: where it lies on the shoe, along it.
            before, behind = (
                self._attached(u, self.car, pull, sign)[2] for pull, sign in ((end[:, k - 1], -1.0), (force[:, k], 1.0))
            )
            way = behind / norm(behind)[:, None] - before / norm(before)[:, None]
            if rig.carriage.holding == "horizontal":
                way = way * np.array([1.0, 1.0, 0.0])
            total = total - (F * u[:, self.scalar["hold"]] / norm(way))[:, None] * way
        if self.under is None:
            rows[f"{self.car} balance"] = total / F
        else:
            away = u[:, self.at[self.car]][:, [0, 2]] - self.under.centre
            rows["contact"] = (np.sqrt((away * away).sum(axis=1)) - self.under.radius)[:, None]
            rows["aside"] = u[:, self.at[self.car]][:, 1:2]
            along = (total[:, 0] * away[:, 1] - total[:, 2] * away[:, 0]) / self.under.radius
            rows[f"{self.car} balance"] = along[:, None] / F
        for name, spar in self.spars.items():
            mast = u[:, self.at[name]] - np.array(spar.foot)
            axial = F * u[:, self.scalar[name]]
            rows[f"{name} balance"] = (
                pulls[name] + (axial / spar.height)[:, None] * mast - 0.5 * spar.mass * rig.gravity * UP
            ) / F
            rows[f"{name} length"] = (norm(mast) - spar.height)[:, None]
        if rig.turn is not None:
            self._log(rows, u, pulls["log"])

    def ground(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Height [m] and slope of the ground, its vertices rounded, near real stations."""
        assert self.rig.turn is not None
        assert self.rig.terrain is not None
        at, z, before, after, room = self.rig.terrain.vertex_at(float(x.flat[0].real))
        r, away = min(self.rig.turn.log.rounding, room), x - at
        if abs(away.flat[0].real) >= r:
            slope = before if away.flat[0].real < 0.0 else after
            return z + slope * away, slope + 0.0 * away
        bend = (after - before) / (4.0 * r)
        return z + 0.5 * (before + after) * away + bend * (away**2 + r * r), 0.5 * (before + after) + 2.0 * bend * away

    def _log(self, rows: dict[str, np.ndarray], u: np.ndarray, pull: np.ndarray) -> None:
        turn, rig = self.rig.turn, self.rig
        assert turn is not None
        log, weight = turn.log, max(self.payload, 1.0) * rig.gravity
        back_x, back_z, normal = (u[:, self.scalar[name]] for name in ("rear_x", "rear_z", "normal"))
        front = u[:, self.at["log"]]
        floor, slope = self.ground(back_x)
        steep = np.arctan(slope)
        drag = -log.moving * log.friction
        gx = F * normal * (drag * np.cos(steep) - np.sin(steep))
        gz = F * normal * (np.cos(steep) + drag * np.sin(steep))
        rows["log balance"] = np.stack([pull[:, 0] + gx, pull[:, 1], pull[:, 2] + gz - weight], axis=1) / F
        dx, dz = back_x - front[:, 0], back_z - front[:, 2]
        moment = dx * gz - dz * gx - log.centre * dx * weight
        rows["log moment"] = moment[:, None] / (F * log.length)
        rows["log length"] = (np.sqrt(dx * dx + dz * dz) - log.length)[:, None]
        rows["log contact"] = (back_z - floor if self.drags else normal)[:, None]

    def residual(self, u: np.ndarray) -> np.ndarray:
        """All laws in a row (b, size)."""
        return np.concatenate(list(self.rows(u).values()), axis=1)

    def jacobian(self, u: np.ndarray) -> np.ndarray:
        """Of `residual` at one point (size,), by complex steps."""
        steps = u + 1e-30j * np.eye(self.size)
        return np.asarray(self.residual(steps).imag.T / 1e-30)

    def by_ode(self, u: np.ndarray) -> np.ndarray:
        """`reach` of one point with DOP853."""
        force, _, length = self.forces(u[None])
        found = np.empty_like(force)
        for k, (line, _, _) in enumerate(self.spans):
            one = length[:, k : k + 1]
            run = by_ode(force[:, k], one, 0.0 * one, material(line.rope, self.rig.gravity))
            found[:, k] = run.node[:, -1]
        return found

    # Stability

    def stiffness(self, u: np.ndarray) -> np.ndarray:
        """Of all that can move with drums at rest or at their tensions: rope over its joints, nodes across their
        constraints; a log pulls as it does."""
        n, steps = len(self.spans), u + 1e-30j * np.eye(self.size)
        laws, rope = self._laws(steps)
        jacobian = np.concatenate([*laws.values(), rope], axis=1).imag.T / 1e-30
        sizes = {name: row.shape[1] for name, row in self.rows(u[None]).items()}
        starts = dict(zip(sizes, np.cumsum([0, *sizes.values()]), strict=False))
        force, *_ = self.forces(u[None])
        kept = [k for k, (line, _, _) in enumerate(self.spans) if line.role != "dropline"]
        # Forces and hanging lengths follow from what moves: each span reaches its end with the rope that it has.
        f = np.array([3 * k + i for k in kept for i in range(3)])
        inner = np.append(f, 3 * n + np.array(kept))
        held = np.append(f, self.size + np.array(kept))
        ways, rows = [], []

        def free(way: dict[int, float], row: np.ndarray) -> None:
            ways.append(np.bincount(list(way), weights=list(way.values()), minlength=self.size))
            rows.append(row)

        for line, k in zip(self.lines, self.first[:-1], strict=True):
            m = len(line.nodes) - 1
            joint = starts.get(f"{line.role} joints", 0)
            for j in range(m - 1):
                if line.role == "skyline" and self.rig.carriage.clamped and line.nodes[j + 1] == self.car:
                    continue
                grown = 1.0 + self.soft[k] * float(norm(force)[0, k + j + 1])
                free({3 * n + k + j: 1.0, 3 * n + k + j + 1: -1.0}, grown * jacobian[joint])
                joint += 1
            if line.tension is not None and not (line.role == "skyline" and self.height is not None):
                grown = 1.0 + self.soft[k] * line.tension
                free({3 * n + k: 1.0}, -grown * jacobian[starts[f"{line.role} rule"]])
        balance, at = starts[f"{self.car} balance"], self.at[self.car].start
        for i in range(3):
            if not (self.ideal and i == 0):
                free({at + i: 1.0}, -jacobian[balance + i])
        for name, spar in self.spars.items():
            mast = (u[self.at[name]] - np.array(spar.foot)) / (spar.height or 1.0)
            tangents = np.linalg.svd(mast[None])[2][1:]
            start, place = starts[f"{name} balance"], self.at[name].start
            for t in tangents:
                free({place + i: t[i] for i in range(3)}, -t @ jacobian[start : start + 3])
        way, row = np.array(ways).T, np.array(rows)
        shares, places = way[3 * n + np.array(kept)], way.copy()
        places[3 * n : 4 * n] = 0.0
        by_way = jacobian[held] @ places
        by_way[len(f) :] -= shares
        moved = np.linalg.solve(jacobian[np.ix_(held, inner)], by_way)
        return np.asarray(row @ places - row[:, inner] @ moved)
