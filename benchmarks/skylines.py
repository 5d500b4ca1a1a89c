"""Time of a skyline's load path, payload study and support layout; the load path also with a system for each station.

    python benchmarks/skylines.py

Six spans with five saddles, 200 stations; a corridor of two spans with all limits, 100 stations; two supports among 11
sites of 4 heights at 7 m clearance. Times are the best of three, assembly included.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from payload_speed import best

import ropeway as rw

ROPE = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)
MAIN = rw.Rope(mass_per_length=0.73, axial_stiffness=8e6, breaking_load=120e3)
GROUND = Path(__file__).resolve().parents[1] / "examples" / "corridor.csv"
STATIONS = np.linspace(2.5, 597.5, 200)


def six_spans(mainline: rw.Rope | None = None, radius: float = 0.0) -> rw.SkylineRig:
    """A standing skyline of 600 m."""
    heights = (3.0, -2.0, 4.0, 0.0, 5.0)
    supports = [
        rw.IntermediateSupport(f"s{i}", at=(100.0 * i, z), radius=radius) for i, z in enumerate(heights, start=1)
    ]
    return rw.standing_skyline(
        None,
        headspar=rw.HeadSpar("head", at=(0.0, 0.0)),
        supports=supports,
        tailspar=rw.TailSpar("tail", at=(600.0, -1.0)),
        skyline=ROPE,
        length=603.0,
        mainline=mainline,
        carriage=rw.Carriage("carriage", mass=450.0),
    )


def corridor() -> rw.SkylineRig:
    """The corridor of the examples."""
    return rw.standing_skyline(
        rw.Profile.from_csv(GROUND),
        headspar=rw.HeadSpar("head", station=0.0, height=15.0),
        supports=[rw.IntermediateSupport("jack", station=260.0, height=9.0)],
        tailspar=rw.TailSpar("tail", station=480.0, height=8.0),
        skyline=ROPE,
        tension=70e3,
        mainline=MAIN,
        carriage=rw.Carriage("carriage", mass=450.0),
    )


def supports() -> rw.SupportPlan:
    """The supports of the corridor for 2500 kg."""
    bare = rw.standing_skyline(
        rw.Profile.from_csv(GROUND),
        headspar=rw.HeadSpar("head", station=0.0, height=15.0),
        tailspar=rw.TailSpar("tail", station=480.0, height=8.0),
        skyline=ROPE,
        tension=70e3,
        carriage=rw.Carriage("carriage", mass=450.0),
    )
    sites = rw.support_range(40.0, 440.0, 40.0, (6.0, 9.0, 12.0, 15.0))
    return rw.optimise_supports(bare, sites, payload=2500.0, clearance=7.0, most=2)


def one_by_one() -> None:
    """Solve each station from a cold start in a separate system."""
    rig = six_spans()
    for x in STATIONS:
        rw.equilibrium(rig.system(rig.span_of(float(x)), float(x), payload=1500.0))


def main() -> None:
    """Prints times and ratios."""
    rw.load_path(corridor(), 1000.0, [50.0])  # imports and compiled parts
    path = best(lambda: rw.load_path(six_spans(), 1500.0, STATIONS), 3)
    alone = best(one_by_one, 1)
    print(f"load path, six spans, 200 stations     {path:6.2f} s, a system for each {alone / path:.0f} times")
    for name, how in (("a mainline", {"mainline": MAIN}), ("shoes", {"radius": 4.0})):
        found = best(lambda how=how: rw.load_path(six_spans(**how), 1500.0, STATIONS), 3)
        print(f"  with {name:10s}                      {found:6.2f} s, {found / path:.1f} times the first")
    stations = np.linspace(4.0, 476.0, 100)
    along = best(lambda: rw.load_path(corridor(), 1500.0, stations), 3)
    most = best(lambda: rw.payload(corridor(), safety_factor=3.0, clearance=1.0, stations=stations), 3)
    print(f"payload with all limits, 100 stations  {most:6.2f} s, {most / along:.1f} load paths")
    layout = best(supports, 1)
    tried = supports().tried
    print(f"two supports among 11 sites, 4 heights {layout:6.2f} s, {tried} trials of {1e3 * layout / tried:.1f} ms")


if __name__ == "__main__":
    main()
