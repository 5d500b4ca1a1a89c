"""Whether the end of a line, from a support that holds the rope to a drum that keeps its tension, has a stable
equilibrium: rope is let out from taut, and the tension at the drum is followed by quadrature alone."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

import ropeway as rw
from support.oracle import Line, Material, solve_line, taut_branch

GRAVITY = 9.80665


def drum_ends(system: rw.System, spans: Sequence[rw.Span]) -> list[tuple[np.ndarray, np.ndarray, np.ndarray, float]]:
    """Both ends of a frictionless line of a feed, each as seen from the support that holds the rope: points of the
    supports, places of the loads along the rope, their weights, and the tension that the drum keeps."""
    (feed,) = system.feeds
    nodes = [system.components[name] for name in _supports(system, spans)]
    points = np.array([node.at for node in nodes], dtype=float)
    holds = [k for k, node in enumerate(nodes) if isinstance(node, rw.ControlSheave)]
    rope = np.concatenate([[0.0], np.cumsum([span.length for span in spans])])
    run = rw.assemble(system).runs[0]
    first = run.loads.place[0]
    count = int((2.0 * rope[-1] + first) / feed.spacing)
    place = first - feed.spacing * np.arange(count)
    weight = GRAVITY * np.array([feed.masses[i % len(feed.masses)] for i in range(count)])
    ends = []
    for drum, held, way in ((0, holds[0], -1.0), (len(nodes) - 1, holds[-1], 1.0)):
        at = way * (place - rope[held])
        order = np.argsort(at)
        beyond = order[at[order] > 0.0]
        support = points[held::-1] if drum == 0 else points[held:]
        ends.append((support, at[beyond], weight[beyond], nodes[drum].tension))
    return ends


def holds_tension(
    points: np.ndarray, places: np.ndarray, loads: np.ndarray, tension: float, material: Material, longest: float = 1.6
) -> bool:
    """Whether the tension at the last support comes down to `tension` as rope is let out, up to `longest` times the
    chords, before the line runs away."""
    chord = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())

    def line(length: float) -> Line:
        on = places < length
        return Line(points, length, places[on], loads[on], material)

    length, step = 1.0005 * chord, 1e-4
    now = line(length)
    solved, spans = taut_branch(now, 3.0 * tension + float(loads.sum())), None
    while length < longest * chord:
        if np.linalg.norm(solved.end[-1]) <= tension:
            return True
        further = length * (1.0 + step)
        longer = line(further)
        try:
            rope = solved.rope.copy()
            rope[-1] = further
            new = solve_line(longer, solved.start, rope)
            for _ in range(4):
                spans = longer.spans(new.rope)
                new = solve_line(longer, new.start, new.rope, spans=spans)
                if np.array_equal(longer.spans(new.rope), spans):
                    break
            else:
                raise ArithmeticError("A load stands on a support")
            if new.stiffness <= 0.0:
                raise ArithmeticError("The line runs away")
        except (ArithmeticError, np.linalg.LinAlgError):
            step /= 2.0
            if step < 1e-7:
                return False
            continue
        solved, length, step = new, further, min(1.5 * step, 2e-3)
    return False


def _supports(system: rw.System, spans: Sequence[rw.Span]) -> list[str]:
    first = system.connections[spans[0].name, "a"][0]
    return [first, *(system.connections[span.name, "b"][0] for span in spans)]
