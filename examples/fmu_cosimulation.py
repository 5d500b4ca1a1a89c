"""Two lines in co-simulation: a sheave with a hydraulic drive on the first gives the speed of the second."""

import sys
from pathlib import Path

import matplotlib as mpl
import pandas as pd

import ropeway as rw


def main(folder: Path) -> None:
    mpl.use("Agg")
    import matplotlib.pyplot as plt

    rope = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)
    supports = pd.read_csv(Path(__file__).with_name("line.csv")).iloc[:8]
    supports.loc[supports.index[-1], "kind"] = "drum"
    drive = rw.HydraulicDrive(
        displacement=1e-4,
        gear_ratio=20.0,
        sheave_radius=0.5,
        relief_pressure=350e5,
        pump_flow=0.02,
        engine_power=60e3,
        inertia=500.0,
    )
    lines = {
        name: rw.monocable(
            rope, supports=supports, tension=45e3, speed=1.0, load_mass=300.0, load_spacing=50.0, name=name, drive=own
        )
        for name, own in (("first", drive), ("second", None))
    }
    together = rw.fmu.CoSimulation(step=0.1, iterated=True)
    together.add("first", lines["first"], start={"c1.speed": 1.05})
    together.add("second", lines["second"])
    together.connect("first.c1.rope_speed", "second.c1.speed")
    frame = together.run(until=30.0)
    print(frame[["first.c1.rope_speed", "first.c1.travel", "second.c1.travel"]].tail(3))

    figure, axes = plt.subplots(layout="constrained")
    for name in lines:
        axes.plot(frame.index, frame[f"{name}.c1.tension_out"] / 1e3, label=name)
    axes.set(xlabel="time [s]", ylabel="c1.tension_out [kN]")
    axes.legend()
    figure.savefig(folder / "fmu_cosimulation.png", dpi=110)
    plt.close(figure)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
