"""A clamped carriage drops its payload in the middle of a skyline: how high it jumps, and how the tension swings.

Without inertia the carriage is at once where it hangs empty. With inertia it jumps above that place and swings about
it; the skyline's tension falls below that of the empty line, and rises above it when the carriage comes back.
"""

from __future__ import annotations

import sys
from pathlib import Path

from matplotlib.figure import Figure

import ropeway as rw

LOST = 2.0
"""When the payload drops [s]."""


def skyline() -> tuple[rw.System, rw.Equilibrium]:
    """A skyline of 300 m with a loaded carriage at mid-span, at rest."""
    rig = rw.standing_skyline(
        None,
        headspar=rw.HeadSpar("head", at=(0.0, 15.0)),
        tailspar=rw.TailSpar("tail", at=(300.0, -20.0)),
        skyline="compacted skyline 22",
        tension=60e3,
        carriage=rw.Carriage("carriage", mass=600.0, clamped=True),
    )
    system = rig.system(0, 150.0, payload=800.0)
    return system, rw.equilibrium(system)


def main(folder: Path = Path("ropeway-dropped")) -> rw.Result:
    """Prints jump and tensions, writes table and picture into `folder`."""
    system, rest = skyline()
    drop = rw.Intervention(LOST, "payload dropped", "carriage")
    result = rw.simulate(system, 20.0, every=0.05, start=rest, inertia=rw.Inertia(), interventions=[drop])
    empty = rw.equilibrium(system, parameters={"carriage.payload": 0.0})
    tension, height = result.frame["head_carriage.tension_a"], result.frame["carriage.z"]
    print(f"The carriage jumps {height.max() - rest['carriage.z']:.1f} m; without inertia it rises", end=" ")
    print(f"{empty['carriage.z'] - rest['carriage.z']:.1f} m.")
    print(f"The skyline's tension falls from {rest['head_carriage.tension_a'] / 1e3:.0f} kN", end=" ")
    print(f"to {tension.min() / 1e3:.0f} kN; empty it has {empty['head_carriage.tension_a'] / 1e3:.0f} kN.")
    print(result.energy().round(0).to_string())
    folder.mkdir(parents=True, exist_ok=True)
    result.frame.to_csv(folder / "dropped.csv")
    picture(result, empty).savefig(folder / "dropped.png", dpi=110)
    return result


def picture(result: rw.Result, empty: rw.Equilibrium) -> Figure:
    """Height of the carriage and tension of the skyline over time, with their values on the empty line at rest."""
    figure = Figure(figsize=(8.0, 5.0), layout="constrained")
    upper, lower = figure.subplots(2, 1, sharex=True)
    frame = result.frame
    upper.plot(frame.index, frame["carriage.z"], color="tab:blue")
    upper.axhline(empty["carriage.z"], color="0.5", linestyle="--", label="empty, at rest")
    upper.set_ylabel("height of the carriage [m]")
    lower.plot(frame.index, frame["head_carriage.tension_a"] / 1e3, color="tab:red")
    lower.axhline(empty["head_carriage.tension_a"] / 1e3, color="0.5", linestyle="--")
    lower.set_ylabel("tension at the headspar [kN]")
    lower.set_xlabel("time [s]")
    upper.legend(loc="upper left", bbox_to_anchor=(0.0, 0.9))
    for axes in (upper, lower):
        axes.grid(alpha=0.3)
    return figure


if __name__ == "__main__":
    main(*(Path(a) for a in sys.argv[1:2]))
