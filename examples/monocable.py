"""Ten minutes of a mono-cable line of 24 spans with travelling loads."""

import sys
from pathlib import Path

import ropeway as rw


def main(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    rope = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)
    supports = Path(__file__).with_name("line.csv")
    line = rw.monocable(rope, supports=supports, tension=45e3, speed=1.0, load_mass=300.0, load_spacing=50.0)
    result = rw.simulate(line, until=600.0, every=1.0)
    tensions = result.frame.filter(regex=r"^c\d\.tension_(in|out)$") / 1e3
    print(tensions.agg(["min", "mean", "max"]).T.round(1).rename_axis("tension [kN]"))
    print(result.events["event"].value_counts())
    result.plot().savefig(folder / "monocable_tensions.png", dpi=110)
    result.plot_line(time=300.0).savefig(folder / "monocable_line.png", dpi=110)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
