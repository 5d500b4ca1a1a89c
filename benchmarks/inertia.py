"""A dropped load: ropeway, MoorDyn and a fine chain of springs in one run.

    python benchmarks/inertia.py

A level span of 240 m carries 2950 kg at its middle and loses 1000 kg. Rows have equal numbers of pieces on each side of
the load: exact catenaries in ropeway, springs in MoorDyn (explicit, without damping, as here). Errors are those of the
rest position, of the rebound's highest point and of the least tension at an end; the reference is a chain of 400
springs, integrated in NumPy from a rest position by Newton's method. Times are seconds for a
second of the run, after the first call of each.
"""

from __future__ import annotations

import tempfile
import time
from pathlib import Path
from typing import NamedTuple

import moordyn
import numpy as np
import typer
from rich.console import Console
from rich.table import Table

import ropeway as rw

ROPE = rw.Rope(mass_per_length=2.4, axial_stiffness=24.026e6, breaking_load=450e3)
SPAN, LENGTH, KEPT, LOST, GRAVITY = 240.0, 240.55, 1950.0, 1000.0, 9.80665
UNTIL, SAMPLE = 4.0, 0.005
"""Time of the run, which has one rebound, and interval of its samples [s]."""
STEP = 1e-4
"""Of MoorDyn [s]."""


class Drop(NamedTuple):
    """Height of the load at rest and at its highest, relative to the supports [m]; least tension at an end [N]; time
    for a second of the run [s]."""

    rest: float
    highest: float
    tension: float
    cost: float


def ours(pieces: int) -> Drop:
    """ropeway with `pieces` exact catenaries on each side."""
    s = rw.System("drop")
    (span,) = s.string(ROPE, rw.Anchor("a", at=(0.0, 0.0)), rw.Anchor("b", at=(SPAN, 0.0)), length=LENGTH)
    for name, mass in (("kept", KEPT), ("lost", LOST)):
        s.hang(rw.Load(name, mass=mass), span, at=LENGTH / 2.0)
    inertia, lost = rw.Inertia(nodes=2 * (pieces - 1), damping=0.0), rw.Intervention(0.0, "load lost", "lost")
    model = rw.assemble(s)

    def run() -> rw.Result:
        return rw.simulate(model, UNTIL, every=SAMPLE, inertia=inertia, interventions=[lost])

    run()
    begin = time.perf_counter()
    result = run()
    cost = (time.perf_counter() - begin) / UNTIL
    heights = [result.record(i)["kept.z"] for i in range(len(result.records))]
    return Drop(heights[0], max(heights), float(result.full_frame["a_b.tension_a"].min()), cost)


FILE = """MoorDyn input file

---- LINE TYPES
name Diam Mass/m EA BA/-zeta EI Cd Ca CdAx CaAx
(-) (m) (kg/m) (N) (N-s/-) (N-m^2) (-) (-) (-) (-)
rope 1e-5 {mass} {stiffness} {damping} 0 {drag} 0 0 0
hook 1e-5 0.001 1e6 -0.5 0 0 0 0 0
---- POINTS
ID Type X Y Z Mass Volume CdA Ca
(-) (-) (m) (m) (m) (kg) (m3) (m2) (-)
1 Fixed 0 0 -100 0 0 0 0
2 Fixed {span} 0 -100 0 0 0 0
3 Free {half} 0 -115 {kept} 0 {area} 0
4 Free {half} 0 -116 {lost} 0 {area} 0
---- LINES
ID LineType AttachA AttachB UnstrLen NumSegs Outputs
(-) (-) (-) (-) (m) (-) (-)
1 rope 1 3 {side} {pieces} -
2 rope 3 2 {side} {pieces} -
3 hook 3 4 1.0 1 -
{failure}---- OPTIONS
0 writeLog
{step} dtM
{water} WtrDnsty
500 WtrDpth
9.80665 g
3e6 kBot
3e5 cBot
0 WaveKin
----
"""
FAILURE = """---- FAILURE
FailID Point Lines FailTime FailTen
(-) (-) (-) (s) (N)
1 3 3 1e9 1e12
"""
"""MoorDyn 2.7 breaks the line in its first step when the time of the failure is ahead."""


def _moordyn(path: Path, pieces: int, *, still: bool) -> object:
    """A system in heavy drag that comes to rest, or one without any that loses its load at once."""
    text = FILE.format(
        mass=ROPE.mass_per_length, stiffness=ROPE.axial_stiffness, span=SPAN, half=SPAN / 2.0, side=LENGTH / 2.0,
        kept=KEPT, lost=LOST, pieces=pieces, step=STEP, damping=-1.0 if still else 0.0, drag=1e4 if still else 0.0,
        area=1e3 if still else 0.0, water=1000.0 if still else 0.0, failure="" if still else FAILURE,
    )  # fmt: skip
    path.write_text(text)
    system = moordyn.Create(str(path))
    moordyn.SetVerbosity(system, moordyn.LEVEL_NONE)
    moordyn.Init_NoIC(system, [], [])
    return system


def theirs(pieces: int) -> Drop:
    """MoorDyn with `pieces` springs on each side."""
    with tempfile.TemporaryDirectory() as folder:
        system, now = _moordyn(Path(folder) / "still.txt", pieces, still=True), 0.0
        while now < 60.0:
            moordyn.Step(system, [], [], now, 1.0)
            now += 1.0
        rest = moordyn.GetPointPos(moordyn.GetPoint(system, 3))[2] + 100.0
        state = moordyn.Serialize(system)
        moordyn.Close(system)
        system = _moordyn(Path(folder) / "drop.txt", pieces, still=False)
        moordyn.Deserialize(system, state)
        load, side = moordyn.GetPoint(system, 3), moordyn.GetLine(system, 1)
        heights, tensions, end, begin = [], [], now + UNTIL, time.perf_counter()
        while now < end:
            moordyn.Step(system, [], [], now, SAMPLE)
            now += SAMPLE
            heights.append(moordyn.GetPointPos(load)[2] + 100.0)
            tensions.append(float(np.linalg.norm(moordyn.GetLineNodeTen(side, 0))))
        cost = (time.perf_counter() - begin) / UNTIL
        moordyn.Close(system)
    return Drop(rest, max(heights), min(tensions), cost)


def chain(pieces: int = 200) -> Drop:
    """A chain of springs with half their masses at each end, by the leapfrog method."""
    side, begin = LENGTH / 2.0 / pieces, time.perf_counter()
    stiffness, mass = ROPE.axial_stiffness / side, np.full(2 * pieces - 1, ROPE.mass_per_length * side)
    middle = pieces - 1

    def forces(place: np.ndarray, masses: np.ndarray) -> tuple[np.ndarray, float]:
        whole = np.vstack([[0.0, 0.0], place, [SPAN, 0.0]])
        apart = np.diff(whole, axis=0)
        length = np.hypot(apart[:, 0], apart[:, 1])
        pull = (stiffness * (length - side) / length)[:, None] * apart
        total = np.diff(pull, axis=0)
        total[:, 1] -= masses * GRAVITY
        return total, float(stiffness * (length[0] - side))

    masses = mass.copy()
    masses[middle] += KEPT + LOST
    place = _rest(masses)
    rest = float(place[middle, 1])
    masses[middle] -= LOST
    speed, step = np.zeros_like(place), 0.5 / np.sqrt(stiffness / mass[0])
    highest, least = rest, np.inf
    for _ in range(int(UNTIL / step)):
        total, tension = forces(place, masses)
        speed += step * total / masses[:, None]
        place = place + step * speed
        highest, least = max(highest, float(place[middle, 1])), min(least, tension)
    return Drop(rest, highest, least, (time.perf_counter() - begin) / UNTIL)


def _rest(masses: np.ndarray) -> np.ndarray:
    """The chain at rest, by shooting: the pull at its first end determines all springs."""
    side = LENGTH / (len(masses) + 1)

    def reach(pull: np.ndarray) -> np.ndarray:
        up = pull[1] + GRAVITY * np.concatenate([[0.0], np.cumsum(masses)])
        tension = np.hypot(pull[0], up)
        length = side * (1.0 + tension / ROPE.axial_stiffness) / tension
        return np.column_stack([length * pull[0], length * up]).cumsum(axis=0)

    pull = np.array([130e3, -GRAVITY * masses.sum() / 2.0])
    for _ in range(50):
        miss = reach(pull)[-1] - (SPAN, 0.0)
        slope = np.column_stack([(reach(pull + d)[-1] - (SPAN, 0.0) - miss) for d in np.eye(2)])
        pull = pull - np.linalg.solve(slope, miss)
    return reach(pull)[:-1]


def main() -> None:
    """Print the errors of both for 1, 2, 4 and 8 pieces on each side."""
    exact = chain()
    table = Table(
        "pieces a side", "of", "rest [mm]", "highest point [mm]", "least tension [kN]", "s per s",
        title=f"Errors of a dropped load; reference: {exact.highest:.4f} m, {exact.tension / 1e3:.2f} kN",
    )  # fmt: skip
    for pieces in (1, 2, 4, 8):
        for name, drop in (("ropeway", ours(pieces)), ("MoorDyn", theirs(pieces))):
            rest, highest = 1e3 * (drop.rest - exact.rest), 1e3 * (drop.highest - exact.highest)
            tension = (drop.tension - exact.tension) / 1e3
            table.add_row(str(pieces), name, f"{rest:.2f}", f"{highest:.2f}", f"{tension:.3f}", f"{drop.cost:.3f}")
    Console().print(table)


if __name__ == "__main__":
    typer.run(main)
