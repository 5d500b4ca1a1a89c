"""A diesel-hydraulic power unit and the example line as two FMUs in co-simulation, compared with one simulation.

The unit supplies pressure and flow to the drive of control sheave c4, which loads the engine.
"""

import sys
from pathlib import Path

import matplotlib as mpl
import numpy as np

import ropeway as rw

UNTIL = 20.0
SPEED = rw.Schedule((0.0, 10.0, 13.0, 20.0), (1.0, 1.0, 1.3, 1.3))
CONNECTIONS = (
    ("unit.flow", "c4.pump_flow"),
    ("unit.pressure", "c4.relief_pressure"),
    ("c4.hydraulic_power", "unit.load_power"),
)


def power_unit() -> rw.DieselHydraulicUnit:
    """A slightly too weak engine: it is lugged down, the pressure falls, and the sheave slips back."""
    return rw.DieselHydraulicUnit(
        "unit", rated_power=32e3, rated_speed=230.0, inertia=0.6, displacement=16e-6, relief_pressure=300e5
    )


def example_line() -> rw.System:
    """The example line; pressure and flow of c4's drive are open inputs."""
    drive = rw.HydraulicDrive(
        displacement=60e-6,
        gear_ratio=20.0,
        sheave_radius=0.5,
        relief_pressure=None,
        pump_flow=None,
        engine_power=60e3,
        inertia=800.0,
        brake_force=100e3,
    )
    return rw.monocable(
        rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3),
        supports=Path(__file__).with_name("line.csv"),
        tension=45e3,
        speed=SPEED,
        load_mass=300.0,
        load_spacing=50.0,
        drive={"c4": drive},
    )


def main(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    mpl.use("Agg")
    import matplotlib.pyplot as plt

    whole, unit = example_line(), power_unit()
    whole.add(unit)
    for source, target in CONNECTIONS:
        (one, output), (other, entry) = source.split("."), target.split(".")
        whole.connect(whole.components[one].output(output), whole.components[other].input(entry))
    result = rw.simulate(whole, UNTIL, every=0.1)
    reference = result.frame
    print(result.events[~result.events["event"].str.contains("crossing|load")].to_string())

    alone = rw.System("power unit")
    alone.add(unit)
    files = {
        "power": rw.fmu.export(alone, folder / "power_unit.fmu"),
        "line": rw.fmu.export(example_line(), folder / "line.fmu"),
    }
    owner = {"unit": "power", "c4": "line"}
    ways = {"explicit, 0.02 s": (0.02, False), "iterated, 0.02 s": (0.02, True)}
    frames = {}
    for label, (step, iterated) in ways.items():
        together = rw.fmu.CoSimulation(step, iterated=iterated)
        for name, file in files.items():
            together.add(name, file)
        for source, target in CONNECTIONS:
            ends = [f"{owner[end.split('.')[0]]}.{end}" for end in (source, target)]
            together.connect(*ends)
        frame = together.run(until=UNTIL)
        frames[label] = frame.iloc[:: round(0.1 / step)]

    shown = (
        ("unit.speed", 1.0, "speed of the\nengine [rad/s]"),
        ("unit.pressure", 1e-5, "pressure of the\npower unit [bar]"),
        ("c4.rope_speed", 1.0, "speed of the rope\nat sheave c4 [m/s]"),
        ("c4.tension_in", 1e-3, "tension before\nsheave c4 [kN]"),
    )
    figure, axes = plt.subplots(5, sharex=True, figsize=(7.0, 10.0), layout="constrained")
    for axis, (name, factor, label) in zip(axes, shown, strict=False):
        axis.plot(reference.index, factor * reference[name], color="0.75", linewidth=5, label="one simulation")
        for way, style in zip(ways, ("k:", "C1-"), strict=True):
            values = frames[way][f"{owner[name.split('.')[0]]}.{name}"]
            axis.plot(values.index, factor * values, style, linewidth=1, label=f"FMUs, {way}")
        axis.set_ylabel(label)
    axes[0].legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3, frameon=False, fontsize="small")
    figure.suptitle("A power unit and a line: in one simulation, and as two FMUs")
    for way, style in zip(ways, ("k:", "C1-"), strict=True):
        error = np.abs(frames[way]["line.c4.tension_in"].to_numpy() - reference["c4.tension_in"].to_numpy())
        print(f"{way}: largest difference in the tension before c4 {error.max():.3g} N")
        axes[4].semilogy(reference.index[1:], error[1:], style, label=way)
    axes[4].set(xlabel="time [s]", ylabel="difference in the\ntension [N]")
    figure.savefig(folder / "fmu_cosimulation.png", dpi=110)
    plt.close(figure)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
