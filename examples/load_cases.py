"""Load cases of a material ropeway: cold, heat, ice and wind, with and without loads, and the table of its supports.

One page shows the line in elevation, its side sway in plan, how much of the allowed tension each case uses, and the
forces that each support must bear with the cases that set them.
"""

from __future__ import annotations

import sys
from pathlib import Path

import ropeway as rw

ROPE = rw.Rope(
    mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3, diameter=0.0286, name="RHOL-IWRC 29"
)
WEATHER = [
    rw.Environment("calm"),
    rw.Environment("cold", temperature=-25.0),
    rw.Environment("hot", temperature=40.0),
    rw.Environment("iced", temperature=-5.0, ice_thickness=0.015),
    rw.Environment("wind", temperature=5.0, wind_pressure=250.0, wind_from=160.0),
]
STORM = rw.Environment("storm", temperature=5.0, wind_pressure=900.0, wind_from=160.0)
CASES = [*WEATHER, rw.LoadCase("storm, out of operation", STORM, "empty", safety_factor=2.5)]


def main(folder: Path = Path("ropeway-cases")) -> rw.LoadCases:
    """Prints what governs, writes tables, the page and the stringing table into `folder`."""
    line = rw.monocable(
        ROPE,
        supports=str(Path(__file__).parent / "line.csv"),
        tension=45e3,
        load_mass=300.0,
        load_spacing=50.0,
        load_drag_area=1.2,
    )
    cases = rw.load_cases(line, CASES)
    shown = ["highest_tension", "span", "safety", "safety_factor", "utilisation", "least_force", "least_force_at"]
    print(cases.frame[shown].round(2).to_string())
    governing = cases.governing
    ropes = governing[governing["subject"] == "rope"]
    print("\n", ropes[["quantity", "case", "value", "next_case", "by"]].round(2).to_string(index=False), sep="")
    supports = governing[(governing["quantity"] == "bearing_load")]
    print(f"\nHighest bearing loads come from {supports['case'].value_counts().to_dict()}")
    folder.mkdir(parents=True, exist_ok=True)
    cases.to_csv(folder / "cases.csv")
    rw.write_table(governing, folder / "governing.csv")
    rw.write_table(rw.support_table(cases, rollers={"s1": 8, "s2": 6}), folder / "supports.csv")
    rw.write_table(rw.stringing_table(line, [-10.0, 0.0, 10.0, 20.0, 30.0]), folder / "stringing.csv")
    cases.plot().savefig(folder / "load_cases.png", dpi=110)
    return cases


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
