"""A synthetic line of any length, for the benchmarks."""

from __future__ import annotations

import math

import ropeway as rw
from ropeway.components.node import Node

ROPE = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3, diameter=0.0286)
TENSION = 45e3
"""Tension of the empty rope at the first support [N]."""
SPACING = 50.0
"""Rope between two loads [m], which gives two loads a span."""
MASSES = (250.0, 300.0, 350.0)
"""Masses of the loads [kg], in turn."""


def points(spans: int) -> list[tuple[float, float, float]]:
    """Supports about 100 m apart in a slight zig-zag, with gentle rises and falls."""
    return [
        (100.0 * k + 4.0 * math.sin(1.7 * k), 5.0 * (-1) ** k, 15.0 * math.sin(0.15 * k) + math.sin(0.9 * k))
        for k in range(spans + 1)
    ]


def driven(
    spans: int,
    speed: float = 1.0,
    drive: rw.HydraulicDrive | None = None,
    response: rw.ThresholdResponse | None = None,
) -> rw.System:
    """A drive drum, a control sheave at every fifth support, idlers between, and a constant-tension drum at the end.
    The rope is full of loads, two a span, with more fed at the start. The control sheaves have ideal drives, or a given
    hydraulic drive and response."""
    at = points(spans)
    nodes: list[Node] = [rw.Drum("start", at=at[0], speed=speed)]
    for k in range(1, spans):
        if k % 5:
            nodes.append(rw.Sheave(f"s{k}", at=at[k]))
            continue
        own = drive or rw.IdealDrive()
        nodes.append(rw.ControlSheave(f"c{k}", at=at[k], speed=speed, drive=own, response=response))
    nodes.append(rw.Drum("end", at=at[-1], tension=TENSION))
    line = rw.System(f"driven line of {spans} spans")
    line.feed(line.string(ROPE, *nodes, tension=TENSION), spacing=SPACING, masses=MASSES)
    return line


def given(spans: int) -> rw.System:
    """The same supports and loads on a rope of given length, anchored at both ends, over idlers only."""
    at = points(spans)
    nodes = [rw.Anchor("start", at=at[0]), *(rw.Sheave(f"s{k}", at=at[k]) for k in range(1, spans))]
    line = rw.System(f"anchored line of {spans} spans")
    rope = line.string(ROPE, *nodes, rw.Anchor("end", at=at[-1]), tension=TENSION)
    for i in range(int(sum(span.length for span in rope) / SPACING + 0.5)):
        line.hang(rw.Load(f"l{i + 1}", mass=MASSES[i % len(MASSES)]), rope, at=(i + 0.5) * SPACING)
    return line
