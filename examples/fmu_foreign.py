"""An FMU of OpenModelica with the example line: a mass with spring and damper as a dancer.

The rope behind control sheave c1 loads the dancer, whose displacement sets the speed of the sheave. Once as a component
in one simulation, and once in co-simulation with the line's FMU. Downloads the FMU, unless its path is given:

    python fmu_foreign.py [folder for the pictures] [Mass_Damper.fmu]
"""

import hashlib
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

import matplotlib as mpl
import numpy as np

import ropeway as rw

PACKAGE = "gemseo-fmu==3.1.1"
"""The wheel with the FMU (LGPL); it is opened, not installed."""
MEMBER = "gemseo_fmu/problems/fmu_files/linux/Mass_Damper.fmu"
FINGERPRINT = "319a1417576bc63ca148e688dd25cc1e834e0c112172405fc0f18132073f136e"
OFFLINE = f"""This example needs {Path(MEMBER).name} of {PACKAGE}, and access to a package index.
Offline, give the path of that file as the second argument."""
UNTIL, STEP = 60.0, 0.02
DANCER = {"mass.m": 200.0, "spring.c": 50e3, "damper.d": 4.5e3, "fixed.s0": 1.17}
"""1 m per 50 kN; at 66.5 kN the dancer is at 1 m, for 1 m/s."""


def foreign_fmu(folder: Path, given: Path | None) -> Path:
    """The FMU: the given file, or the download, checked by its SHA-256."""
    path = folder / Path(MEMBER).name if given is None else given
    if given is None:
        with tempfile.TemporaryDirectory() as place:
            download = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--dest", place, PACKAGE]
            if subprocess.run(download, check=False).returncode != 0:
                sys.exit(OFFLINE)
            (wheel,) = Path(place).glob("*.whl")
            with zipfile.ZipFile(wheel) as archive:
                path.write_bytes(archive.read(MEMBER))
    if hashlib.sha256(path.read_bytes()).hexdigest() != FINGERPRINT:
        sys.exit(f"{path} is not the FMU of this example: its SHA-256 differs")
    return path


def example_line() -> rw.System:
    """The example line."""
    return rw.monocable(
        rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3),
        supports=Path(__file__).with_name("line.csv"),
        tension=45e3,
        speed=1.0,
        load_mass=300.0,
        load_spacing=50.0,
    )


def main(folder: Path, given: Path | None) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    mpl.use("Agg")
    import matplotlib.pyplot as plt

    fmu = rw.fmu.load(foreign_fmu(folder, given))
    print(fmu.variables.loc[[*fmu.names("input"), *fmu.names("output"), *DANCER], ["causality", "unit", "description"]])

    line, dancer = example_line(), rw.fmu.component("dancer", fmu, parameters=DANCER)
    c1 = line.components["c1"]
    line.add(dancer)
    line.connect(c1.output("tension_out"), dancer.input("f"))
    line.connect(dancer.output("y"), c1.input("speed"))
    one_run = rw.simulate(line, UNTIL, every=STEP).frame
    without = rw.simulate(example_line(), UNTIL, every=STEP).frame

    master = rw.fmu.CoSimulation(STEP, iterated=True)
    master.add("dancer", fmu, kind="ModelExchange", start=DANCER)
    master.add("line", example_line())
    master.connect("line.c1.tension_out", "dancer.f")
    master.connect("dancer.y", "line.c1.speed")
    coupled = master.run(until=UNTIL)

    shown = {
        "c1.tension_out": ("line.c1.tension_out", "N", 1e-3, "tension behind\nsheave c1 [kN]"),
        "dancer.y": ("dancer.y", "m", 1.0, "way of the\ndancer [m]"),
    }
    figure, axes = plt.subplots(3, sharex=True, figsize=(7.0, 7.0), layout="constrained")
    for axis, (name, (other, unit, factor, label)) in zip(axes, shown.items(), strict=False):
        axis.plot(one_run.index, factor * one_run[name], color="0.75", linewidth=5, label="one simulation")
        axis.plot(coupled.index, factor * coupled[other], "C1", linewidth=1, label="co-simulation")
        axis.set_ylabel(label)
        difference = np.abs(coupled[other].to_numpy() - one_run[name].to_numpy())
        print(f"largest difference in {name}: {difference.max():.2g} {unit}")
        axes[2].semilogy(
            one_run.index[1:], difference[1:] / np.ptp(one_run[name]), label=label.split(" [")[0].replace("\n", " ")
        )
    axes[0].plot(without.index, without["c1.tension_out"] / 1e3, "k:", label="without the dancer")
    axes[0].legend(loc="upper center", ncols=3)
    axes[2].set(xlabel="time [s]", ylabel="difference\n(of the range)")
    axes[2].legend()
    figure.savefig(folder / "fmu_foreign.png", dpi=110)
    plt.close(figure)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."), Path(sys.argv[2]) if len(sys.argv) > 2 else None)
