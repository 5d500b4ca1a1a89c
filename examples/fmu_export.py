"""The example line as an FMU: exported, run by FMPy without ropeway, compared with IDAS."""

import sys
from pathlib import Path

import fmpy
import matplotlib as mpl
import numpy as np

import ropeway as rw


def main(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    mpl.use("Agg")
    import matplotlib.pyplot as plt

    rope = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)
    supports = Path(__file__).with_name("line.csv")
    line = rw.monocable(rope, supports=supports, tension=45e3, speed=1.0, load_mass=300.0, load_spacing=50.0)
    path = rw.fmu.export(line, folder / "line.fmu", fmi="2.0")
    print(f"{path.name}: {path.stat().st_size / 1e3:.0f} kB")

    every, until = 0.73, 300.0
    run = fmpy.simulate_fmu(str(path), fmi_type="CoSimulation", stop_time=until, step_size=every, output_interval=every)
    result = rw.simulate(line, until=until, every=every)
    name = "c2.tension_in"
    times = result.frame.index.to_numpy()
    at = np.searchsorted(run["time"], times - 1e-6)
    difference = np.abs(run[name][at] - result.frame[name].to_numpy()).max()
    print(f"largest difference from IDAS in {name}: {difference:.2g} N")

    figure, axes = plt.subplots(layout="constrained")
    axes.plot(run["time"], run[name] / 1e3, label="FMU in FMPy")
    axes.plot(times, result.frame[name] / 1e3, "--", label="IDAS")
    axes.set(xlabel="time [s]", ylabel="tension before sheave c2 [kN]")
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2, frameon=False)
    figure.savefig(folder / "fmu_export.png", dpi=110)
    plt.close(figure)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
