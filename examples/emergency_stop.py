"""The brake of a mono-cable line: emergency stops from 2 m/s at four decelerations."""

import sys
from pathlib import Path

import ropeway as rw

DECELERATIONS = (0.5, 1.0, 2.0, 4.0)
SETTLE = 5.0


def main(folder: Path) -> rw.EmergencyStops:
    """Prints the table, writes it and a picture into `folder`."""
    folder.mkdir(parents=True, exist_ok=True)
    rope = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)
    supports = Path(__file__).with_name("line.csv")
    line = rw.monocable(rope, supports=supports, tension=45e3, speed=2.0, load_mass=300.0, load_spacing=50.0)
    stops = rw.emergency_stop(line, decelerations=DECELERATIONS, settle=SETTLE)
    for a, row in stops.frame.iterrows():
        print(
            f"{a:g} m/s2: stops in {row['stopping_distance']:.1f} m, {row['highest_tension'] / 1e3:.1f} kN in "
            f"{row['in_span']}, {row['dynamic_factor']:.2f} of equilibrium; brake {row['brake_force'] / 1e3:.1f} kN, "
            f"swing {row['swing']:.2f} m"
        )
    stops.to_csv(folder / "emergency_stop.csv")
    stops.plot().savefig(folder / "emergency_stop.png", dpi=80)
    return stops


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
