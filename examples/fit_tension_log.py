"""What a log of a tension monitor says of a skyline and of a line: fits to synthetic logs with noise.

    python examples/fit_tension_log.py [folder]

The logs are made with values that the fits do not know, and with the noise of usual devices (random numbers of
seed 21).

1. A standing skyline. The yarder logs the skyline's tension at the headspar, through a monitor that shows 3 % too much,
   and the mainline's; a total station measures the carriage. Pretension, stiffness of the old rope, payload and the
   monitor's gain are fitted; `fit_skyline.png` shows how well.
2. A mono-cable line. While it runs, its loads are weighed by the tensions at the control sheaves; `fit_monitor.png`
   shows the loads that come on the line, and the reserve of the rope against its safe working load.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

import ropeway as rw

SEED = 21
SKYLINE = rw.Rope(mass_per_length=2.4, axial_stiffness=24e6, breaking_load=450e3)
MAINLINE = rw.Rope(mass_per_length=0.73, axial_stiffness=8e6, breaking_load=120e3)
HAUL = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=230e3)
SUPPORTS = pd.DataFrame(
    [
        ("valley", 0.0, 0.0, 0.0, "drum"),
        ("s1", 70.0, 0.0, 9.0, "idler"),
        ("c1", 150.0, 0.0, 15.0, "control"),
        ("s2", 230.0, 0.0, 24.0, "idler"),
        ("c2", 300.0, 0.0, 28.0, "control"),
        ("mountain", 370.0, 0.0, 26.0, "drum"),
    ],
    columns=["name", "x", "y", "z", "kind"],
)
UNTIL = 300.0
"""Duration of the line's log [s]."""


def skyline(tension: float, stiffness: float) -> rw.SkylineRig:
    """A standing skyline over one intermediate support."""
    return rw.standing_skyline(
        None,
        headspar=rw.HeadSpar("head", at=(0.0, 15.0)),
        supports=[rw.IntermediateSupport("jack", at=(140.0, 2.0))],
        tailspar=rw.TailSpar("tail", at=(300.0, -20.0)),
        skyline=replace(SKYLINE, axial_stiffness=stiffness),
        tension=tension,
        mainline=MAINLINE,
        carriage=rw.Carriage("carriage", mass=450.0, payload=2000.0),
    )


def skyline_log(rng: np.random.Generator) -> pd.DataFrame:
    """Fifty stations with a pretension of 74 kN, a rope of 21 MN and 2350 kg."""
    stations = np.linspace(15.0, 285.0, 50)
    path = rw.load_path(skyline(74e3, 21e6), 2350.0, stations)
    return pd.DataFrame(
        {
            "station": stations,
            "skyline_kN": (1.03 * path["headspar_tension"] + rng.normal(0.0, 500.0, 50)) / 1e3,
            "mainline_kN": (path["mainline_tension"] + rng.normal(0.0, 200.0, 50)) / 1e3,
            "height": path["carriage_z"] + rng.normal(0.0, 0.03, 50),
        }
    )


def fit_skyline(folder: Path, rng: np.random.Generator) -> None:
    fit = rw.fit(
        skyline(tension=70e3, stiffness=24e6),
        skyline_log(rng),
        columns={
            "station": "station",
            "skyline_kN": "headspar_tension",
            "mainline_kN": "mainline_tension",
            "height": "carriage_z",
        },
        free=["tension", "skyline.axial_stiffness", "payload", "skyline_kN.gain"],
        sigma={"skyline_kN": 500.0, "mainline_kN": 200.0, "height": 0.03},
    )
    print(fit.frame[["value", "standard_error", "low", "high", "unit"]].to_string())
    print(fit.suggestion)
    fit.plot().savefig(folder / "fit_skyline.png", dpi=110)


def line(masses: float | list[float]) -> rw.System:
    return rw.monocable(HAUL, SUPPORTS, tension=45e3, load_mass=masses, load_spacing=62.0, name="line")


def watch_line(folder: Path, rng: np.random.Generator) -> None:
    masses = rng.uniform(200.0, 450.0, 12).round().tolist()
    run = rw.simulate(line(masses), UNTIL, every=1.0, progress=False)
    columns = [f"{sheave}.tension_{side}" for sheave in ("c1", "c2") for side in ("in", "out")]
    log = run.frame[columns] + rng.normal(0.0, 100.0, (len(run.frame), len(columns)))
    watch = rw.monitor(
        line(300.0),
        columns={"time": "time", **{column: column for column in columns}},
        free="*.mass",
        sigma=100.0,
        prior={"*.mass": (300.0, 100.0)},
    )
    for now in watch.follow(row for row in log.reset_index().to_dict("records")):
        if now.time % 60.0 == 0.0:
            known = [f"{n[:-5]} {now.value[n]:.0f}" for n, e in now.standard_error.items() if e < 10.0]
            print(f"{now.time:5.0f} s  reserve {now.reserve / 1e3:5.1f} kN in {now.span}; kg: {', '.join(known)}")
    tension = run.frame.filter(regex=r"_.*\.tension_[ab]$").max(axis=1)
    _draw(folder / "fit_monitor.png", watch.frame, masses, HAUL.safe_working_load - tension)


def _draw(path: Path, found: pd.DataFrame, masses: list[float], reserve: pd.Series) -> None:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.5, 7.0), layout="constrained")
    loads, rope = figure.subplots(2, 1, sharex=True, height_ratios=(2.0, 1.0))
    names = [name for name in found.columns.get_level_values(0).unique() if name != "reserve"]
    for k, name in enumerate(names):
        value, error = found[name]["value"], found[name]["standard_error"]
        (curve,) = loads.plot(value.index, value, lw=1.3, label=name.removesuffix(".mass"))
        loads.fill_between(value.index, value - 2.0 * error, value + 2.0 * error, color=curve.get_color(), alpha=0.15)
        true = masses[(int(name[1:-5]) - 1) % len(masses)]
        loads.plot(value.dropna().index[[0, -1]], [true, true], color=curve.get_color(), lw=0.9, ls="--")
        if k == len(names) - 1:
            loads.plot([], [], color="0.4", lw=0.9, ls="--", label="true")
    loads.set(ylabel="mass of the load [kg]", ylim=(100.0, 550.0))
    loads.legend(fontsize=8, frameon=False, ncols=5, loc="upper right")
    value, error = found["reserve"]["value"] / 1e3, found["reserve"]["standard_error"] / 1e3
    rope.fill_between(value.index, value - 2.0 * error, value + 2.0 * error, color="#6baed6", alpha=0.5)
    rope.plot(value.index, value, color="#08306b", lw=1.2, label="estimated, two standard errors")
    rope.plot(reserve.index, reserve / 1e3, color="#e08214", lw=1.0, ls="--", label="true")
    rope.set(xlabel="time [s]", ylabel="reserve against SWL [kN]")
    rope.legend(fontsize=8, frameon=False)
    for axis in (loads, rope):
        axis.grid(alpha=0.25)
        axis.spines[["top", "right"]].set_visible(False)
    figure.savefig(path, dpi=110)


def main(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    rng = np.random.default_rng(SEED)
    fit_skyline(folder, rng)
    watch_line(folder, rng)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path("."))
