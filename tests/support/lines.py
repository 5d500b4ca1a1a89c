"""Random lines with a stable equilibrium, built backwards: from the tension to the rope that gives it.

Each section between supports that hold the rope gets a tension from the sag wanted in its slackest span. From its
first support on each span's length follows from the tension there, and the next span starts with the tension at the
end of the last one. So the equilibrium is known before the line is, with its loads in their spans; a section counts
when its supports' stiffness, from the same integrals, is positive, else its tension is raised.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

import ropeway as rw
from support.oracle import UP, Line, LineSolved, Material, beam, by_quadrature, solve_line, taut_branch

GRAVITY = 9.80665


@dataclass(frozen=True)
class Section:
    """Spans first .. first + n - 1 of a line, which share one rope, and their equilibrium."""

    first: int
    line: Line
    solved: LineSolved
    sag: float


@dataclass(frozen=True)
class Case:
    """A random line: support `points` (n + 1, 3), the supports that hold the rope, and the sections between them."""

    seed: int
    rope: rw.Rope
    points: np.ndarray
    sections: tuple[Section, ...]

    @property
    def held(self) -> set[int]:
        """Supports that hold the rope."""
        return {0, len(self.points) - 1, *(s.first for s in self.sections)}

    @property
    def start(self) -> np.ndarray:
        """Forces at the spans' starts (n, 3) [N]."""
        return np.concatenate([s.solved.start for s in self.sections])

    @property
    def end(self) -> np.ndarray:
        """Forces at the spans' ends (n, 3) [N]."""
        return np.concatenate([s.solved.end for s in self.sections])

    @property
    def loads(self) -> np.ndarray:
        """Positions of the loads, in order along the rope (loads, 3) [m]."""
        return np.concatenate([s.solved.loads for s in self.sections])

    @property
    def sag(self) -> float:
        """Largest sag below a chord over its horizontal span."""
        return max(s.sag for s in self.sections)

    @property
    def stiffness(self) -> float:
        """Least stiffness of a section's supports."""
        return min(s.solved.stiffness for s in self.sections)

    def taut(self, found: np.ndarray) -> Case:
        """This line with, where `found` (n, 3) [N] is not a section's known equilibrium, the one to which the oracle
        comes from a taut rope: a slack line with loads near its supports can have several stable ones."""
        sections = []
        for s in self.sections:
            own = found[s.first : s.first + len(s.solved.start)]
            tension = float(np.linalg.norm(s.solved.start, axis=1).max())
            known = np.abs(own - s.solved.start).max() <= 1e-6 * tension
            sections.append(s if known else replace(s, solved=taut_branch(s.line, tension)))
        return replace(self, sections=tuple(sections))

    def system(self) -> rw.System:
        """The line as a user declares it. The rope of a section is shared out by the chords, or, where no inner
        support holds it, by `string`: which load is in which span is for the equilibrium to find."""
        last = len(self.points) - 1
        nodes: list[rw.Anchor | rw.Drum | rw.Sheave | rw.ControlSheave] = []
        for k, at in enumerate(self.points):
            ends = rw.Anchor if (self.seed + k) % 2 else rw.Drum
            kind = ends if k in (0, last) else rw.ControlSheave if k in self.held else rw.Sheave
            nodes.append(kind(f"s{k}", at=tuple(at)))
        system = rw.System(f"seed {self.seed}")
        if len(self.sections) == 1:
            spans = system.string(self.rope, *nodes, length=self.sections[0].line.length)
        else:
            for node in nodes:
                system.add(node)
            made = []
            for s in self.sections:
                chord = np.linalg.norm(np.diff(s.line.points, axis=0), axis=1)
                for k, share in enumerate(chord / chord.sum(), s.first):
                    span = system.add(rw.Span(f"s{k}_s{k + 1}", rope=self.rope, length=float(share * s.line.length)))
                    system.connect(span.a, nodes[k].leaving)
                    system.connect(span.b, nodes[k + 1].arriving)
                    made.append(span)
            spans = tuple(made)
        before, number = 0.0, 0
        for s in self.sections:
            for place, load in zip(s.line.places, s.line.loads, strict=True):
                system.hang(rw.Load(f"l{number}", mass=float(load / GRAVITY)), spans, at=float(before + place))
                number += 1
            before += s.line.length
        return system


def random_line(seed: int, *, most: int = 20, controlled: bool = True) -> Case:
    """1 to `most` spans, 0 to 4 loads a span, each up to twice its span's rope, sag 0.1 % to 20 % of the span, slopes
    to 100 %. controlled: every second line has supports inside that hold the rope."""
    rng = np.random.default_rng([2718, seed])
    n = int(rng.integers(1, most + 1))
    mass = float(rng.uniform(0.5, 4.0))
    rope = rw.Rope(
        mass_per_length=mass,
        axial_stiffness=np.inf if rng.random() < 0.1 else float(mass * 1e7 * rng.uniform(0.5, 1.2)),
        breaking_load=mass * 1.8e5,
        stretch=rw.ConstructionStretch() if rng.random() < 0.1 else rw.Elastic(),
    )
    points = _supports(rng, n)
    weight = mass * GRAVITY
    material = Material(weight, *rope.strain[:2])
    cuts = [k for k in range(1, n) if rng.random() < 0.25] if controlled and rng.random() < 0.5 else []
    sections = []
    for first, last in zip([0, *cuts], [*cuts, n], strict=True):
        at, loads = [], []
        for chord in np.linalg.norm(np.diff(points[first : last + 1], axis=0), axis=1):
            count = int(rng.integers(0, 5))
            at.append(chord * np.sort(rng.uniform(0.03, 0.97, count)))
            loads.append(weight * chord * np.exp(rng.uniform(np.log(0.03), np.log(2.0), count)))
        sag = float(np.exp(rng.uniform(np.log(1e-3), np.log(0.2))))
        sections.append(_section(first, points[first : last + 1], material, at, loads, sag))
    return Case(seed, rope, points, tuple(sections))


def unknown_line(seed: int) -> tuple[rw.System, Line]:
    """2 to 12 spans over idlers, rope 0.0003 % to 17 % longer than its chords, loads anywhere and up to twenty times
    a span's rope: they may have several stable equilibria, or none."""
    rng = np.random.default_rng([1618, seed])
    n = int(rng.integers(2, 13))
    points = _supports(rng, n)
    mass = float(rng.uniform(0.5, 4.0))
    made = rw.Rope(mass_per_length=mass, axial_stiffness=mass * 1e7, breaking_load=mass * 1.8e5)
    chord = np.linalg.norm(np.diff(points, axis=0), axis=1)
    length = float(chord.sum() * (1.0 + 8.0 / 3.0 * np.exp(2.0 * rng.uniform(np.log(1e-3), np.log(0.25)))))
    count = int(rng.integers(0, 2 * n))
    places = np.sort(rng.uniform(0.01, 0.99, count)) * length
    loads = mass * GRAVITY * chord.mean() * np.exp(rng.uniform(np.log(0.03), np.log(20.0), count))
    system = rw.System(f"seed {seed}")
    nodes = [(rw.Anchor if k in (0, n) else rw.Sheave)(f"s{k}", at=tuple(at)) for k, at in enumerate(points)]
    spans = system.string(made, *nodes, length=length)
    for k, (place, load) in enumerate(zip(places, loads, strict=True)):
        system.hang(rw.Load(f"l{k}", mass=float(load / GRAVITY)), spans, at=float(place))
    return system, Line(points, length, places, loads, Material(mass * GRAVITY, *made.strain[:2]))


def _supports(rng: np.random.Generator, n: int) -> np.ndarray:
    """Uphill, downhill, in waves or level; straight in plan or with bends."""
    steepest = np.exp(rng.uniform(np.log(0.02), 0.0))
    slope = rng.uniform(0.0, steepest, n)
    kind = rng.integers(4)
    if kind == 0:
        slope = -slope
    elif kind == 1:
        slope *= (-1.0) ** np.arange(n)
    elif kind == 2:
        slope *= rng.choice([-1.0, 1.0], n)
    across = rng.uniform(20.0, 250.0, n)
    heading = np.cumsum(rng.uniform(-0.5, 0.5, n)) if rng.random() < 0.5 else np.zeros(n)
    steps = across[:, None] * np.column_stack([np.cos(heading), np.sin(heading), slope])
    return np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])


def _section(
    first: int,
    points: np.ndarray,
    material: Material,
    at: Sequence[np.ndarray],
    loads: Sequence[np.ndarray],
    sag: float,
) -> Section:
    tension = _tension(points, material, at, loads, sag)
    for _ in range(40):  # no more than a rope can bear
        if np.linalg.norm(material.slope(tension * UP)[0]) < 1.03:
            break
        loads, sag = [0.5 * load for load in loads], 1.1 * sag
        tension = _tension(points, material, at, loads, sag)
    for _ in range(100):
        try:
            section = _built(first, points, material, at, loads, tension)
        except ArithmeticError:
            pass
        else:
            if section.solved.stiffness > 1e-6 and section.sag <= 0.2:
                return section
        tension *= 1.1
    raise AssertionError("No tension makes this line stable")


def _tension(
    points: np.ndarray, material: Material, at: Sequence[np.ndarray], loads: Sequence[np.ndarray], sag: float
) -> float:
    """Tension at the first support that gives the slackest span about this sag."""
    need = []
    for k, reach in enumerate(np.diff(points, axis=0)):
        across = np.hypot(reach[0], reach[1])
        horizontal = beam(reach, material.weight, at[k], loads[k])[1] / (sag * across)
        middle = (points[k, 2] + points[k + 1, 2]) / 2.0 - points[0, 2]
        need.append(horizontal * np.linalg.norm(reach) / across - material.weight * middle)
    lowest = points[:, 2].min() - points[0, 2]
    return max(*need, -material.weight * lowest * 1.01, 1e-3 * material.weight * np.abs(points).max())


def _built(
    first: int,
    points: np.ndarray,
    material: Material,
    at: Sequence[np.ndarray],
    loads: Sequence[np.ndarray],
    tension: float,
) -> Section:
    """A section from the tension at its first support. Raises ArithmeticError where that is too low."""
    rope, forces = [0.0], []
    for k, reach in enumerate(np.diff(points, axis=0)):
        force, length = _span(reach, material, at[k], loads[k], tension)
        forces.append(force)
        rope.append(rope[-1] + length)
        tension = float(np.linalg.norm(force + (material.weight * length + loads[k].sum()) * UP))
    places = np.concatenate([r + a for r, a in zip(rope[:-1], at, strict=True)])
    line = Line(points, rope[-1], places, np.concatenate(loads), material)
    solved = solve_line(line, np.array(forces), np.array(rope))
    sag = max(
        _sag(reach, material, solved.rope[k + 1] - solved.rope[k], at[k], loads[k], solved.start[k])
        for k, reach in enumerate(np.diff(points, axis=0))
    )
    return Section(first, line, solved, sag)


def _span(
    reach: np.ndarray, material: Material, at: np.ndarray, load: np.ndarray, tension: float
) -> tuple[np.ndarray, float]:
    """Start force and length of a span with its loads, for a tension at its start; taut."""
    across, chord = float(np.hypot(reach[0], reach[1])), float(np.linalg.norm(reach))
    reaction, _, shear = beam(reach, material.weight, at, load)
    slope = reach[2] / across
    root = tension**2 * (1.0 + slope**2) - reaction**2
    if root <= 0.0:
        raise ArithmeticError("The tension is too low")
    h = (slope * reaction + np.sqrt(root)) / (1.0 + slope**2)
    if h <= 0.0:
        raise ArithmeticError("The tension is too low")
    plane = np.array([reach[0] / across, reach[1] / across, 0.0])
    basis = np.column_stack([plane, UP])
    length = chord / material.slope(tension * UP)[0][2] + shear / (2.0 * h**2) * (across / chord) ** 2
    unknown = np.array([h, h * slope - reaction, max(length, at[-1] if len(at) else 0.0)])
    goal = np.array([across, reach[2], tension])
    for _ in range(50):
        force = basis @ unknown[:2]
        cuts = np.array([0.0, *at, unknown[2]])
        hung = by_quadrature(force[None], np.diff(cuts)[None], np.append(load, 0.0)[None], material)
        miss = np.append(basis.T @ hung.node[0, -1], np.linalg.norm(force)) - goal
        jacobian = np.zeros((3, 3))
        jacobian[:2, :2] = basis.T @ hung.compliance[0] @ basis
        jacobian[:2, 2] = basis.T @ material.slope(hung.end[0])[0]
        jacobian[2, :2] = basis.T @ force / np.linalg.norm(force)
        step = -np.linalg.solve(jacobian, miss)
        share = 1.0 / max(1.0, -2.0 * step[0] / unknown[0], 5.0 * abs(step[2]) / unknown[2])
        unknown = unknown + share * step
        if not np.all(np.isfinite(unknown)) or unknown[2] > 3.0 * chord:
            break
        if np.abs(step[:2]).max() < 1e-10 * tension:
            if unknown[2] <= (at[-1] if len(at) else 0.0):
                break
            return basis @ unknown[:2], float(unknown[2])
    raise ArithmeticError("No taut span has this tension")


def _sag(
    reach: np.ndarray, material: Material, length: float, at: np.ndarray, load: np.ndarray, force: np.ndarray
) -> float:
    """Largest vertical distance below the chord over the horizontal span."""
    cuts = np.union1d(np.linspace(0.0, length, 33), at)[1:]
    jumps = np.zeros(len(cuts))
    np.add.at(jumps, np.searchsorted(cuts, at), load)
    node = by_quadrature(force[None], np.diff(cuts, prepend=0.0)[None], jumps[None], material).node[0]
    across = np.hypot(reach[0], reach[1])
    return float(np.max(reach[2] * np.hypot(node[:, 0], node[:, 1]) / across - node[:, 2]) / across)
