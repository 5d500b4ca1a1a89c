"""Cable nets with published answers."""

from __future__ import annotations

import math

import ropeway as rw

FOOT, KIP = 0.3048, 4448.2216152605
BAY, SAG = 100.0 * FOOT, 30.0 * FOOT


def published_net() -> rw.System:
    """SAP2000 software verification, example 7-003: twelve cables between eight supports and four nodes n11 ... n22,
    8 kip at each; printed displacements -0.1328, -0.1328, -1.4745 ft (Tibert 1999, elastic catenaries: -1.4764)."""
    stiffness = 0.227 * 0.0254**2 * 12e6 * 6894.757293168
    rope = rw.Rope(mass_per_length=0.1e-3 * KIP / FOOT / 9.80665, axial_stiffness=stiffness, breaking_load=300e3)
    s = rw.System("net")
    nodes = {
        (i, j): s.add(rw.Joint(f"n{i}{j}", at=(i * BAY, j * BAY, -SAG), mass=8.0 * KIP / 9.80665))
        for i in (1, 2)
        for j in (1, 2)
    }
    ends = [((i, j), (i, 3 * (j == 2))) for i, j in nodes] + [((i, j), (3 * (i == 2), j)) for i, j in nodes]
    for k, (inner, outer) in enumerate(ends):
        anchor = rw.Anchor(f"a{k}", at=(outer[0] * BAY, outer[1] * BAY, 0.0))
        chord = math.hypot(BAY, SAG)
        s.string(rope, anchor, nodes[inner], length=chord / (1.0 + 5.325 * KIP / stiffness))
    for one, other in (((1, 1), (2, 1)), ((1, 2), (2, 2)), ((1, 1), (1, 2)), ((2, 1), (2, 2))):
        s.string(rope, nodes[one], nodes[other], length=BAY / (1.0 + 5.459 * KIP / stiffness))
    return s
