"""Random systems with a known stable equilibrium, built backwards, and an oracle that judges any answer.

From the tension at the first support each span's length follows, and with it the tension at the next support: equal
over an idler, in a ratio by friction, another one behind a sheave that holds the rope. The ends are anchors, springs,
or drums that hold the rope or keep its tension. The judge integrates spans by quadrature and takes differences for the
stiffness; nothing of the library's closed forms is used.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

import ropeway as rw
from support.lines import GRAVITY, _span, _supports, _tension
from support.oracle import UP, Material, by_ode, by_quadrature


@dataclass
class Known:
    """A system as a user declares it, and its equilibrium: `force` at the spans' starts (n, 3) [N], `length` (n,) [m],
    loads as (name, span, distance, weight, pinned); `friction` at each support; `free`: supports whose travel balances
    tensions; `kept` tensions and `springs` (place without pull, stiffness) by their support; `sections` between
    supports that hold the rope: first, last, and the rope in it where that is fixed."""

    seed: int
    kind: str
    system: rw.System
    material: Material
    points: np.ndarray
    force: np.ndarray
    length: np.ndarray
    loads: list[tuple[str, int, float, float, bool]]
    friction: np.ndarray
    free: list[int]
    kept: dict[int, float]
    springs: dict[int, tuple[np.ndarray, float]]
    sections: list[tuple[int, int, float | None]]
    given: dict[str, float] = field(default_factory=dict)
    solve_for: list[str] = field(default_factory=list)
    direction: float = 1.0

    @property
    def spans(self) -> list[str]:
        return [f"s{k}_s{k + 1}" for k in range(len(self.length))]

    def solve(self) -> rw.Equilibrium:
        return rw.equilibrium(self.system, given=self.given, solve_for=self.solve_for)


def _wrap(coming: np.ndarray, going: np.ndarray) -> float:
    return float(np.arctan2(np.linalg.norm(np.cross(coming, going)), coming @ going))


def known_system(seed: int) -> Known:
    """Raises ArithmeticError where no tension makes the random line hang as asked."""
    rng = np.random.default_rng([31415, seed])
    n = int(rng.integers(1, 9))
    scale = float(10.0 ** rng.uniform(-1.5, 1.2)) if rng.random() < 0.2 else 1.0
    mass = float(10.0 ** rng.uniform(-2.0, 1.5)) if rng.random() < 0.2 else float(rng.uniform(0.5, 4.0))
    points = scale * _supports(rng, n)
    if rng.random() < 0.1:
        points = points + np.array([2.6e6, 1.2e6, 1500.0])
    stiff = np.inf if rng.random() < 0.12 else max(mass * 1e7 * float(10.0 ** rng.uniform(-0.7, 0.7)), 1e5)
    weight = mass * GRAVITY
    at, loads = [], []
    for chord in np.linalg.norm(np.diff(points, axis=0), axis=1):
        count = int(rng.integers(0, 4))
        at.append(chord * np.sort(rng.uniform(0.03, 0.97, count)))
        loads.append(weight * chord * np.exp(rng.uniform(np.log(0.03), np.log(3.0), count)))
    holds = [bool(k not in (0, n) and rng.random() < 0.15) for k in range(n + 1)]
    rough = np.array(
        [0.0 if holds[k] or k in (0, n) or rng.random() < 0.75 else rng.uniform(0.01, 0.1) for k in range(n + 1)]
    )
    ends = [str(rng.choice(["anchor", "drum", "spring", "kept"], p=[0.35, 0.15, 0.2, 0.3])) for _ in range(2)]
    if ends == ["kept", "kept"] and not any(holds):
        ends[int(rng.integers(2))] = "anchor"
    speed = 0.0
    if rough.any():
        ends[0], speed = "drum", float(rng.choice([-1.0, 1.0]))
    direction = speed
    material = Material(weight, 0.0 if stiff == np.inf else 1.0 / stiff)
    sag = float(np.exp(rng.uniform(np.log(2e-3), np.log(0.12))))
    tension = _tension(points, material, at, loads, sag)
    jump = [float(rng.uniform(0.8, 1.3)) if holds[k] else 1.0 for k in range(n + 1)]
    for _ in range(60):
        try:
            force, length, end = _hung(points, material, at, loads, tension, jump, direction * rough)
            break
        except ArithmeticError:
            tension *= 1.15
    else:
        raise ArithmeticError("No tension makes this line hang")
    return _declared(
        rng, seed, points, material, mass, stiff, at, loads, holds, rough, ends, direction, force, length, end
    )


def _hung(
    points: np.ndarray, material: Material, at: list, loads: list, tension: float, jump: list, rough: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Start forces, lengths and end forces of all spans, from the tension at the first support."""
    forces, lengths, ends = [], [], []
    for k, reach in enumerate(np.diff(points, axis=0)):
        first = tension * jump[k]
        force, length = _span(reach, material, at[k], loads[k], first)
        for _ in range(40 if rough[k] else 0):
            ratio = np.exp(rough[k] * _wrap(ends[-1], force))
            force, length = _span(reach, material, at[k], loads[k], tension * ratio)
        if length <= 0.0 or (len(at[k]) and at[k][-1] >= 0.999 * length):
            raise ArithmeticError("A load does not fit in its span")
        end = force + (material.weight * length + loads[k].sum()) * UP
        forces.append(force)
        lengths.append(length)
        ends.append(end)
        tension = float(np.linalg.norm(end))
    return np.array(forces), np.array(lengths), np.array(ends)


def _declared(
    rng: np.random.Generator, seed: int, points: np.ndarray, material: Material, mass: float, stiff: float,
    at: list, loads: list, holds: list, rough: np.ndarray, ends: list, direction: float,
    force: np.ndarray, length: np.ndarray, end: np.ndarray,
) -> Known:  # fmt: skip
    n = len(length)
    top = float(max(np.linalg.norm(force, axis=1).max(), np.linalg.norm(end, axis=1).max()))
    rope = rw.Rope(mass_per_length=mass, axial_stiffness=stiff, breaking_load=max(20.0 * top, 2e3))
    springs: dict[int, tuple[np.ndarray, float]] = {}
    kept: dict[int, float] = {}
    nodes = []
    for k, place in enumerate(points):
        side = ends[0] if k == 0 else ends[1] if k == n else ""
        pull = force[0] if k == 0 else -end[-1]
        if side == "anchor":
            node = rw.Anchor(f"s{k}", at=tuple(place))
        elif side == "drum":
            node = rw.Drum(f"s{k}", at=tuple(place), speed=direction)
        elif side == "kept":
            kept[k] = float(np.linalg.norm(pull))
            node = rw.Drum(f"s{k}", at=tuple(place), tension=kept[k])
        elif side == "spring":
            stiffness = float(
                np.linalg.norm(pull) / np.linalg.norm(np.diff(points, axis=0)[0]) * 10.0 ** rng.uniform(1.5, 5.0)
            )
            springs[k] = (place - pull / stiffness, stiffness)
            node = rw.SpringAnchor(f"s{k}", at=tuple(springs[k][0]), stiffness=stiffness)
        elif holds[k]:
            node = rw.ControlSheave(f"s{k}", at=tuple(place), speed=direction)
        else:
            node = rw.Sheave(f"s{k}", at=tuple(place), friction=float(rough[k]))
        nodes.append(node)
    system = rw.System(f"seed {seed}")
    for node in nodes:
        system.add(node)
    cuts = [0, *(k for k in range(1, n) if holds[k]), n]
    declared, sections = length.copy(), []
    for first, last in pairwise(cuts):
        part = slice(first, last)
        chord = np.linalg.norm(np.diff(points, axis=0), axis=1)[part]
        loose = (first == 0 and ends[0] == "kept") or (last == n and ends[1] == "kept")
        own = float(length[part].sum())
        declared[part] = chord / chord.sum() * own * (float(rng.uniform(0.97, 1.05)) if loose else 1.0)
        sections.append((first, last, None if loose else own))
    spans = []
    for k in range(n):
        span = system.add(rw.Span(f"s{k}_s{k + 1}", rope=rope, length=float(declared[k])))
        system.connect(span.a, nodes[k].leaving)
        system.connect(span.b, nodes[k + 1].arriving)
        spans.append(span)
    hung = []
    # The rope that stands at each support, counted along the declared rope: where it is held it is as declared.
    zero = np.concatenate([[0.0], np.cumsum(declared)])
    along = np.zeros(n + 1)
    for first, last, _ in sections:
        if first == 0 and ends[0] == "kept":
            along[first : last + 1] = zero[last] - np.concatenate([np.cumsum(length[first:last][::-1])[::-1], [0.0]])
        else:
            along[first : last + 1] = zero[first] + np.concatenate([[0.0], np.cumsum(length[first:last])])
    number = 0
    for k in range(n):
        for distance, load in zip(at[k], loads[k], strict=True):
            name = f"l{number}"
            number += 1
            place = along[k] + distance
            pinned = n == 1 or (bool(rng.random() < 0.3) and distance < declared[k])
            if not pinned and not 0.0 <= place <= zero[-1]:
                pinned = True
            if pinned and distance > declared[k]:
                raise ArithmeticError("The load cannot be declared")
            system.hang(
                rw.Load(name, mass=float(load / GRAVITY)),
                spans[k] if pinned else spans,
                at=float(distance if pinned else place),
            )
            hung.append((name, k, float(distance), float(load), pinned))
    free = [k for k in range(1, n) if not holds[k]] + list(kept)
    case = Known(
        seed, "/".join(ends), system, material, points, force, length, hung, rough, sorted(free), kept, springs,
        sections, direction=direction,
    )  # fmt: skip
    if not holds.count(True) and not kept and not rough.any() and rng.random() < 0.3:
        _freed(case, rng, rope, nodes, declared, spans)
    return case


def _freed(
    case: Known, rng: np.random.Generator, rope: rw.Rope, nodes: list, declared: np.ndarray, spans: list
) -> None:
    """Frees the length of one span and gives a tension instead: the declared one is wrong by up to 3 %."""
    k = int(rng.integers(len(declared)))
    other = rw.System(case.system.name)
    for node in nodes:
        other.add(node)
    made = []
    for j in range(len(declared)):
        length = float(declared[j] * (rng.uniform(0.995, 1.03) if j == k else 1.0))
        span = other.add(rw.Span(f"s{j}_s{j + 1}", rope=rope, length=length))
        other.connect(span.a, nodes[j].leaving)
        other.connect(span.b, nodes[j + 1].arriving)
        made.append(span)
    for hung in case.system.hung:
        on = tuple(made[spans.index(span)] for span in hung.spans)
        if hung.at > sum(span.length for span in on):
            return
        other.hang(hung.load, on[0] if len(on) == 1 else on, at=hung.at)
    case.system, case.kind = other, case.kind + " freed"
    case.sections = [(first, last, None) for first, last, _ in case.sections]
    case.given = {"s0_s1.tension_a": float(np.linalg.norm(case.force[0]))}
    case.solve_for = [f"s{k}_s{k + 1}.length"]


@dataclass(frozen=True)
class Verdict:
    """Verdict of the oracle: `faults`, and whether it is the known equilibrium."""

    faults: tuple[str, ...]
    known: bool


def judged(case: Known, eq: rw.Equilibrium) -> Verdict:
    """Checks an answer against the physics alone."""
    faults, n = [], len(case.length)
    force = np.array([[eq[f"{name}.force_{axis}"] for axis in "xyz"] for name in case.spans])
    length = np.array([eq[f"{name}.length"] for name in case.spans])
    points = np.array([[eq[f"s{k}.{axis}"] for axis in "xyz"] for k in range(n + 1)])
    chord = np.linalg.norm(np.diff(points, axis=0), axis=1)
    table = eq.loads.set_index("load")
    rope = np.concatenate([[0.0], np.cumsum(length)])
    on = {
        name: (case.spans.index(table.at[name, "span"]), float(table.at[name, "distance"])) for name, *_ in case.loads
    }
    weight = {name: load for name, _, _, load, _ in case.loads}
    if sorted(table.index) != sorted(on):
        faults.append("loads are missing")
    if np.any(length <= 0.0):
        return Verdict((*faults, "a span has no rope"), False)
    pieces = [_pieces(k, length[k], on, weight) for k in range(n)]
    if np.any([np.any(piece < -1e-9 * case.length.mean()) for piece, _ in pieces]):
        faults.append("a load hangs outside its span")
    ends = np.empty((n, 3))
    for k, (piece, load) in enumerate(pieces):
        reach = points[k + 1] - points[k]
        for integrate in (by_quadrature, by_ode):
            hung = integrate(force[None, k], piece[None], load[None], case.material)
            ends[k], off = hung.end[0], float(np.linalg.norm(hung.node[0, -1] - reach))
            if off <= 1e-8 * chord[k]:
                break
        else:
            faults.append(f"span {k} ends {off:.3g} m from its support")
    faults += _laws(case, eq, force, ends, points)
    faults += _rope(case, rope, on)
    for name, value in case.given.items():
        if abs(eq[name] - value) > 1e-7 * abs(value):
            faults.append(f"{name} is {eq[name]}, asked {value}")
    same = (
        np.abs(force - case.force).max() <= 1e-6 * np.abs(case.force).max()
        and np.abs(length - case.length).max() <= 1e-6 * chord.max()
    )
    if not same and stiffness(case, points, force, pieces, on, weight) <= 0.0:
        faults.append("it is unstable")
    return Verdict(tuple(faults), bool(same))


def _pieces(k: int, length: float, on: dict, weight: dict) -> tuple[np.ndarray, np.ndarray]:
    own = sorted((distance, weight[name]) for name, (span, distance) in on.items() if span == k)
    cuts = np.array([0.0, *(d for d, _ in own), length])
    return np.diff(cuts), np.array([*(w for _, w in own), 0.0])


def _laws(case: Known, eq: rw.Equilibrium, force: np.ndarray, ends: np.ndarray, points: np.ndarray) -> list[str]:
    faults, n = [], len(force)
    for k in range(n + 1):
        pull = force[0] if k == 0 else -ends[-1] if k == n else None
        if pull is not None:
            if k in case.kept and abs(np.linalg.norm(pull) / case.kept[k] - 1.0) > 1e-8:
                faults.append(f"drum {k} does not keep its tension")
            if k in case.springs:
                rest, stiffness = case.springs[k]
                off = np.linalg.norm(stiffness * (points[k] - rest) - pull)
                if off > 1e-7 * np.linalg.norm(pull) + stiffness * 1e-14 * np.abs(points[k]).max():
                    faults.append(f"spring {k} is not in balance")
            elif np.any(points[k] != case.points[k]):
                faults.append(f"support {k} has moved")
        elif k in case.free and f"s{k}" not in eq.held:
            ratio = np.exp(case.direction * case.friction[k] * _wrap(ends[k - 1], force[k]))
            off = np.linalg.norm(force[k]) / np.linalg.norm(ends[k - 1]) / ratio - 1.0
            if abs(off) > 1e-7:
                faults.append(f"tensions at {k} differ by {off:.3g}")
    return faults


def _rope(case: Known, rope: np.ndarray, on: dict) -> list[str]:
    """Rope is kept, and loads hang at their places on it."""
    faults, size = [], float(np.mean(np.diff(rope)))
    for first, last, total in case.sections:
        if total is not None and abs(rope[last] - rope[first] - total) > 1e-9 * total:
            faults.append(f"rope from {first} to {last} is {rope[last] - rope[first]}, declared {total}")
    zero = np.concatenate([[0.0], np.cumsum([case.system.components[name].length for name in case.spans])])
    for name, k, distance, _, pinned in case.loads:
        span, found = on[name]
        if pinned:
            if span != k or abs(found - distance) > 1e-8 * size:
                faults.append(f"{name} hangs at {found} on span {span}, pinned at {distance} on {k}")
            continue
        asked = next(h.at for h in case.system.hung if h.load.name == name)
        first, last = next((a, b) for a, b, _ in case.sections if a <= span < b)
        if (last == len(rope) - 1 and last in case.kept) or (last not in case.kept and first not in case.kept):
            place = zero[first] + rope[span] - rope[first] + found
        else:
            place = zero[last] - (rope[last] - rope[span]) + found
        if case.solve_for:
            place = rope[span] + found
        if abs(place - asked) > 1e-8 * size:
            faults.append(f"{name} is at {place} along the rope, asked {asked}")
    return faults


def stiffness(case: Known, points: np.ndarray, force: np.ndarray, pieces: list, on: dict, weight: dict) -> float:
    """Least eigenvalue of the stiffness of all free travels over its largest entry, by differences."""
    free = case.free
    if not free:
        return 1.0
    n = len(pieces)
    # Moves of the rope that change the tension by a ten-thousandth.
    small = []
    for k, (piece, load) in enumerate(pieces):
        along = force[k] / np.linalg.norm(force[k])
        hung = by_quadrature(force[None, k], piece[None], load[None], case.material)
        small.append(1e-4 * np.linalg.norm(force[k]) / (along @ np.linalg.solve(hung.compliance[0], along)))

    def out_of_balance(move: np.ndarray) -> np.ndarray:
        starts, ends = np.empty((n, 3)), np.empty((n, 3))
        for k, (piece, load) in enumerate(pieces):
            own = piece.copy()
            own[0] += move[k]  # loads are clamped: rope comes in before the first
            own[-1] -= move[k + 1]
            starts[k], ends[k] = _shot(force[k], own, load, points[k + 1] - points[k], case.material)
        found = np.empty(len(free))
        for i, k in enumerate(free):
            t_out = 0.0 if k == n else np.linalg.norm(starts[k])
            t_in = 0.0 if k == 0 else np.linalg.norm(ends[k - 1])
            ratio = 1.0
            if 0 < k < n and case.friction[k]:
                ratio = np.exp(case.direction * case.friction[k] * _wrap(ends[k - 1], starts[k]))
            found[i] = t_out - ratio * t_in
        return found

    matrix = np.empty((len(free), len(free)))
    for j, k in enumerate(free):
        h = min(small[max(k - 1, 0)], small[min(k, n - 1)])
        move = np.zeros(n + 1)
        move[k] = h
        matrix[:, j] = -(out_of_balance(move) - out_of_balance(-move)) / (2.0 * h)
    if not np.all(np.isfinite(matrix)):  # no span hangs there at all
        return -1.0
    return float(np.linalg.eigvals(matrix).real.min() / np.abs(matrix).max())


def _shot(
    force: np.ndarray, piece: np.ndarray, load: np.ndarray, reach: np.ndarray, material: Material
) -> tuple[np.ndarray, np.ndarray]:
    """Start and end force of a span near a known one."""
    f = force.copy()
    for _ in range(30):
        hung = by_quadrature(f[None], piece[None], load[None], material)
        if not np.all(np.isfinite(hung.compliance)) or abs(np.linalg.det(hung.compliance[0])) == 0.0:
            break
        step = np.linalg.solve(hung.compliance[0], hung.node[0, -1] - reach)
        f = f - step
        if np.linalg.norm(step) <= 1e-12 * np.linalg.norm(f):
            break
    else:
        f = np.full(3, np.nan)
    return f, f + (material.weight * piece.sum() + load.sum()) * UP
