"""An independent oracle for ropes at rest, from the physics alone: the library's closed forms are not used.

Along an unstretched length s of rope, with f the tension vector, T = |f| and w the weight per unstretched metre,

    dr/ds = (1 + eps(T)) f / T,   df/ds = w z_up,   f jumps by P z_up at a load P,   eps(T) = c1 T + c2 T^2.

`by_ode` integrates these (and how they change with the force at the start) with scipy's DOP853, `by_quadrature` sums
them over Gauss points: fast, for searching. Positions are the gradient of a convex function of the start force, the
complementary energy, so that a line search on it finds the one solution of a span from any start.

An idler line shares one rope between its spans: equal tension on both sides of each support, and as unknowns the
rope X_k that lies before support k. It is stable where the tension difference out - in grows with X.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.integrate import solve_ivp

UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True)
class Material:
    """Weight [N/m, unstretched] and strain eps = c1 T + c2 T^2 of a rope."""

    weight: float
    c1: float = 0.0
    c2: float = 0.0

    def slope(self, force: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """dr/ds, shape (..., 3), and its derivative by the force, (..., 3, 3)."""
        tension = np.linalg.norm(force, axis=-1)[..., None]
        along = force / tension
        stretch = 1.0 + tension * (self.c1 + self.c2 * tension)
        steeper = (self.c1 + 2.0 * self.c2 * tension)[..., None]
        outer = along[..., :, None] * along[..., None, :]
        return stretch * along, (stretch / tension)[..., None] * (np.eye(3) - outer) + steeper * outer

    def energy(self, force: np.ndarray) -> np.ndarray:
        """Integral of 1 + eps over the tension: the complementary energy per unstretched length."""
        tension = np.linalg.norm(force, axis=-1)
        return tension * (1.0 + tension * (self.c1 / 2.0 + self.c2 * tension / 3.0))


@dataclass(frozen=True)
class Hanging:
    """Spans that hang from their start forces: `node` (n, m, 3) where each piece ends, seen from the span's start;
    `compliance` (n, 3, 3): how the last node moves with the start force; `energy` (n,); `end` (n, 3) last force."""

    node: np.ndarray
    compliance: np.ndarray
    energy: np.ndarray
    end: np.ndarray


Integrator = Callable[[np.ndarray, np.ndarray, np.ndarray, Material], Hanging]
"""Start forces (n, 3) [N], lengths of pieces (n, m) [m], load at the end of each piece (n, m) [N]."""


def by_ode(force: np.ndarray, piece: np.ndarray, load: np.ndarray, material: Material) -> Hanging:
    """With DOP853, all spans side by side, piece after piece."""
    n, m = piece.shape
    size = np.maximum(piece.sum(axis=1), 1e-300)
    top = np.linalg.norm(force, axis=1) + material.weight * size + load.sum(axis=1)
    scale = np.concatenate(
        [
            np.broadcast_to(1e-14 * a[:, None], (n, k))
            for a, k in ((size, 3), (top, 3), (size / top, 9), (size * top, 1))
        ],
        axis=1,
    )
    y = np.concatenate([np.zeros((n, 3)), force, np.zeros((n, 10))], axis=1)
    node = np.zeros((n, m, 3))
    for j in range(m):

        def rate(_: float, flat: np.ndarray, length: np.ndarray = piece[:, j, None]) -> np.ndarray:
            f = flat.reshape(n, 16)[:, 3:6]
            along, stiffness = material.slope(f)
            gain = np.broadcast_to(material.weight * UP, (n, 3))
            rates = [along, gain, stiffness.reshape(n, 9), material.energy(f)[:, None]]
            return np.asarray((length * np.concatenate(rates, axis=1)).ravel())

        if np.any(piece[:, j] != 0.0):
            run = solve_ivp(rate, (0.0, 1.0), y.ravel(), method="DOP853", rtol=1e-13, atol=scale.ravel())
            assert run.success, run.message
            y = run.y[:, -1].reshape(n, 16)
        node[:, j] = y[:, :3]
        y[:, 5] += load[:, j]
    return Hanging(node, y[:, 6:15].reshape(n, 3, 3), y[:, 15], y[:, 3:6])


_X, _W = np.polynomial.legendre.leggauss(40)


def by_quadrature(force: np.ndarray, piece: np.ndarray, load: np.ndarray, material: Material) -> Hanging:
    """With 40 Gauss points a piece: exact to rounding unless the rope folds sharply inside a piece."""
    before = np.cumsum(material.weight * piece + load, axis=1) - material.weight * piece - load
    along = before[:, :, None] + material.weight * piece[:, :, None] * (_X + 1.0) / 2.0
    f = force[:, None, None, :] + along[..., None] * UP
    share = piece[:, :, None] * _W / 2.0
    slope, stiffness = material.slope(f)
    return Hanging(
        np.cumsum(np.einsum("nmq,nmqi->nmi", share, slope), axis=1),
        np.einsum("nmq,nmqij->nij", share, stiffness),
        np.einsum("nmq,nmq->n", share, material.energy(f)),
        force + (material.weight * piece + load).sum(axis=1)[:, None] * UP,
    )


@dataclass(frozen=True)
class Hung:
    """A span between two points: `reach` (3,) from its start to its end [m], unstretched `length` [m], `loads` [N]
    at unstretched distances `at` [m] from the start, in order."""

    reach: Sequence[float]
    length: float
    at: Sequence[float] = ()
    loads: Sequence[float] = ()

    def pieces(self, count: int) -> tuple[np.ndarray, np.ndarray]:
        """Lengths and loads of `count` pieces, the last ones empty."""
        cuts = np.array([0.0, *self.at, self.length])
        piece, load = np.zeros(count), np.zeros(count)
        piece[: len(cuts) - 1] = np.diff(cuts)
        load[: len(self.loads)] = self.loads
        return piece, load


@dataclass(frozen=True)
class Solved:
    """Spans at rest, shapes (n, 3): forces at their starts and ends [N]; `loads`: for each span the positions of its
    loads seen from its start, (loads, 3) [m]."""

    start: np.ndarray
    end: np.ndarray
    loads: list[np.ndarray]


def hang(spans: Sequence[Hung], material: Material) -> Solved:
    """Each span by itself, by shooting. Raises ArithmeticError when the shooting does not converge."""
    count = max(len(s.at) for s in spans) + 1
    piece, load = (np.array(a) for a in zip(*(s.pieces(count) for s in spans), strict=True))
    reach = np.array([s.reach for s in spans], dtype=float)
    total = material.weight * piece.sum(axis=1) + load.sum(axis=1)
    chord = np.linalg.norm(reach, axis=1)
    force = total[:, None] * reach / chord[:, None] - (total / 2.0)[:, None] * UP
    with suppress(ArithmeticError):  # a sharp fold needs the integrator's own steps
        force = _shoot(force, piece, load, reach, material, by_quadrature, 1e-9, 60)
    force = _shoot(force, piece, load, reach, material, by_ode, 1e-11, 100)
    hung = by_ode(force, piece, load, material)
    return Solved(force, hung.end, [hung.node[i, : len(s.at)] for i, s in enumerate(spans)])


def _shoot(
    force: np.ndarray,
    piece: np.ndarray,
    load: np.ndarray,
    reach: np.ndarray,
    material: Material,
    integrate: Integrator,
    tolerance: float,
    iterations: int,
) -> np.ndarray:
    """Newton's method with a line search on the complementary energy less the work of the reach."""

    def value(hung: Hanging, f: np.ndarray) -> np.ndarray:
        return np.asarray(hung.energy - np.sum(f * reach, axis=1))

    hung = integrate(force, piece, load, material)
    size = np.linalg.norm(reach, axis=1)
    for _ in range(iterations):
        miss = hung.node[:, -1] - reach
        step = -np.linalg.solve(hung.compliance, miss[:, :, None])[:, :, 0]
        scale = np.maximum(np.linalg.norm(force, axis=1), np.linalg.norm(hung.end, axis=1))
        moving = np.linalg.norm(step, axis=1) > tolerance * scale
        if not moving.any() and np.all(np.linalg.norm(miss, axis=1) < 1e-9 * size):
            return np.asarray(force + step)
        slope = np.sum(miss * step, axis=1)
        share, now = np.ones(len(force)), value(hung, force)
        for _ in range(60):
            trial = force + share[:, None] * step
            hung = integrate(trial, piece, load, material)
            # Close to the solution the energy is flat to rounding: the whole step is right there.
            good = value(hung, trial) <= now + 1e-4 * share * slope + 1e-13 * np.abs(now)
            if good.all():
                break
            share = np.where(good, share, share / 2.0)
        force = trial
    raise ArithmeticError("The shooting has not converged")


@dataclass(frozen=True)
class Line:
    """One rope over frictionless supports. `points` (n + 1, 3) [m]; `length`: unstretched, in all [m]; `places` of
    the `loads` [N] along the rope from the first support, in order [m]."""

    points: np.ndarray
    length: float
    places: np.ndarray
    loads: np.ndarray
    material: Material

    def spans(self, rope: np.ndarray) -> np.ndarray:
        """The span of each load for `rope` (n + 1,) before each support [m]."""
        return np.searchsorted(rope[1:-1], self.places, side="right")

    def scaled(self, share: float) -> Line:
        """With a rope shorter by this share, its loads in the same places on it."""
        return replace(self, length=share * self.length, places=share * self.places)


@dataclass(frozen=True)
class LineSolved:
    """A line at rest: `rope` (n + 1,) before each support [m]; forces at the spans' starts and ends (n, 3) [N];
    positions of the loads (loads, 3) [m]; `stiffness`: least eigenvalue of the supports' stiffness over the largest
    (1 with fewer than two spans)."""

    rope: np.ndarray
    start: np.ndarray
    end: np.ndarray
    loads: np.ndarray
    stiffness: float

    @property
    def inside(self) -> bool:
        """Whether each span has some rope."""
        return bool(np.all(np.diff(self.rope) > 0.0))


@dataclass
class _Balance:
    """Residual and Jacobian of a line for its forces and ropes."""

    line: Line
    integrate: Integrator
    of_span: list[np.ndarray] = field(init=False)

    def assign(self, spans: np.ndarray) -> None:
        """Puts each load into a span."""
        self.of_span = [np.flatnonzero(spans == k) for k in range(len(self.line.points) - 1)]

    def hanging(self, force: np.ndarray, rope: np.ndarray) -> tuple[Hanging, np.ndarray]:
        line, n = self.line, len(rope) - 1
        count = max(len(i) for i in self.of_span) + 1
        parts = [
            Hung(UP, rope[k + 1] - rope[k], line.places[i] - rope[k], line.loads[i]).pieces(count)
            for k, i in zip(range(n), self.of_span, strict=True)
        ]
        piece, load = (np.array(a) for a in zip(*parts, strict=True))
        return self.integrate(force, piece, load, line.material), load

    def system(self, force: np.ndarray, rope: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Miss of the spans' ends (3n), tension differences at the inner supports (n - 1), and the Jacobian."""
        line, n = self.line, len(rope) - 1
        hung, _ = self.hanging(force, rope)
        reach = np.diff(line.points, axis=0)
        t_a, t_b = np.linalg.norm(force, axis=1), np.linalg.norm(hung.end, axis=1)
        residual = np.concatenate([(hung.node[:, -1] - reach).ravel(), t_a[1:] - t_b[:-1]])
        jacobian = np.zeros((4 * n - 1, 4 * n - 1))
        slope_a, slope_b = line.material.slope(force)[0], line.material.slope(hung.end)[0]
        u_a, u_b = force / t_a[:, None], hung.end / t_b[:, None]
        w = line.material.weight
        for k in range(n):
            rows, own = slice(3 * k, 3 * k + 3), slice(3 * k, 3 * k + 3)
            jacobian[rows, own] = hung.compliance[k]
            if k > 0:  # more rope before the span: it begins later
                jacobian[rows, 3 * n + k - 1] = -slope_a[k] - w * hung.compliance[k] @ UP
                jacobian[3 * n + k - 1, own] = u_a[k]
            if k < n - 1:  # more rope before the next support: the span ends later
                jacobian[rows, 3 * n + k] = slope_b[k]
                jacobian[3 * n + k, own] = -u_b[k]
                jacobian[3 * n + k, 3 * n + k] -= w * u_b[k, 2]
                if k > 0:
                    jacobian[3 * n + k, 3 * n + k - 1] += w * u_b[k, 2]
        return residual, jacobian


def solve_line(
    line: Line,
    force: np.ndarray,
    rope: np.ndarray,
    integrate: Integrator = by_quadrature,
    *,
    spans: np.ndarray | None = None,
) -> LineSolved:
    """A line at rest near `force` (n, 3) and `rope` (n + 1,), each load in its span of `spans` (loads,), by default
    where `rope` puts it.

    Newton's method without a search: for polishing a good start. Raises ArithmeticError.
    """
    balance = _Balance(line, integrate)
    balance.assign(line.spans(rope) if spans is None else spans)
    n = len(rope) - 1
    force, rope, last = force.copy(), rope.copy(), np.inf
    for _ in range(40):
        residual, jacobian = balance.system(force, rope)
        step = -np.linalg.solve(jacobian, residual)
        far = np.abs(step[: 3 * n]).max() / np.abs(force).max()
        if far > 1e3 or np.any(np.abs(step[3 * n :]) > line.length):
            break
        step *= min(1.0, 0.5 / far) if far > 0.0 else 1.0
        force += step[: 3 * n].reshape(n, 3)
        rope[1:-1] += step[3 * n :]
        # Taut inextensible ropes magnify the integrator's rounding: then the steps stop getting smaller.
        if far <= 1e-12 or (far <= 1e-9 and far > 0.1 * last):
            return _solved(balance, force, rope)
        last = far
    raise ArithmeticError("The line has not converged")


def _solved(balance: _Balance, force: np.ndarray, rope: np.ndarray) -> LineSolved:
    line = balance.line
    hung, _ = balance.hanging(force, rope)
    loads = np.zeros((len(line.places), 3))
    for k, i in enumerate(balance.of_span):
        loads[i] = line.points[k] + hung.node[k, : len(i)]
    return LineSolved(rope, force, hung.end, loads, _stiffness(balance, force, rope))


def _stiffness(balance: _Balance, force: np.ndarray, rope: np.ndarray) -> float:
    n = len(rope) - 1
    if n == 1:
        return 1.0
    _, jacobian = balance.system(force, rope)
    inner = jacobian[3 * n :, 3 * n :] - jacobian[3 * n :, : 3 * n] @ np.linalg.solve(
        jacobian[: 3 * n, : 3 * n], jacobian[: 3 * n, 3 * n :]
    )
    # The energy's second derivative: tension differences weighed by the strain potential's slope.
    tension = np.linalg.norm(force[1:], axis=1)
    material = balance.line.material
    inner = (1.0 + tension * (material.c1 + material.c2 * tension))[:, None] * inner
    values = np.linalg.eigvalsh((inner + inner.T) / 2.0)
    assert np.abs(inner - inner.T).max() < 1e-6 * np.abs(values).max()
    return float(values[0] / values[-1])


def beam(reach: np.ndarray, weight: float, at: np.ndarray, load: np.ndarray) -> tuple[float, float, float]:
    """A span as a simple beam: upward reaction at its start [N], largest moment [N m], and the integral of the
    squared shear along the chord [N2 m]. For starts and sags."""
    chord, across = float(np.linalg.norm(reach)), float(np.hypot(reach[0], reach[1]))
    x = np.union1d(np.linspace(0.0, 1.0, 65), at / chord)
    own = weight * chord
    reaction = own / 2.0 + float(np.sum(load * (1.0 - at / chord)))
    carried = np.sum(load * np.maximum(x[:, None] - at / chord, 0.0), axis=1)
    moment = across * (reaction * x - own * x**2 / 2.0 - carried)
    middle = (x[1:] + x[:-1]) / 2.0
    shear = reaction - own * middle - np.sum(load * (middle[:, None] > at / chord), axis=1)
    return reaction, float(moment.max()), float(np.sum(shear**2 * np.diff(x)) * chord)


def taut_branch(line: Line, tension: float) -> LineSolved:
    """The equilibrium to which a line comes from a rope drawn straight: all its unstretched lengths are let out in
    proportion, from a rope at three times `tension` [N] on, the loads changing spans where the rope takes them.

    Raises ArithmeticError where the way is lost.
    """
    reach = np.diff(line.points, axis=0)
    chord = np.linalg.norm(reach, axis=1)
    tensions = 3.0 * tension + line.material.weight * (line.points[:-1, 2] - line.points[0, 2])
    spans = line.scaled(chord.sum() / line.length).spans(np.concatenate([[0.0], np.cumsum(chord)]))
    force, lengths, before = np.zeros((len(chord), 3)), np.zeros(len(chord)), 0.0
    for k, (there, high) in enumerate(zip(reach, tensions, strict=True)):
        at = line.places[spans == k] * (chord.sum() / line.length) - before
        reaction, _, shear = beam(there, line.material.weight, at, line.loads[spans == k])
        force[k] = high * there / chord[k] - reaction * UP
        flat = 1.0 - (there[2] / chord[k]) ** 2
        stretch = np.linalg.norm(line.material.slope(high * UP)[0])
        lengths[k] = (chord[k] + shear * flat / (2.0 * high**2)) / stretch
        before += chord[k]
    rope = np.concatenate([[0.0], np.cumsum(lengths)])
    share = float(rope[-1] / line.length)
    drawn = line.scaled(share)
    solved, step = solve_line(drawn, force, rope, spans=spans), 1e-4
    while share < 1.0:
        further = min(1.0, share * (1.0 + step))
        longer = line.scaled(further)
        try:
            new = solve_line(longer, solved.start, solved.rope * (further / share), spans=spans)
            if new.stiffness <= 0.0:
                raise ArithmeticError("The line runs away")
            there = longer.spans(new.rope)
            if np.any(there != spans) and step <= 1e-7:
                new = solve_line(longer, new.start, new.rope, spans=there)
                if np.any(longer.spans(new.rope) != there) or new.stiffness <= 0.0:
                    raise ArithmeticError("A load stands on a support")
                spans = there
            elif np.any(there != spans):
                raise ArithmeticError("A load arrives at a support: smaller steps")
        except ArithmeticError:
            step /= 2.0
            if step < 1e-8:
                raise
            continue
        solved, share, step = new, further, min(1.7 * step, 0.01)
    return solved
