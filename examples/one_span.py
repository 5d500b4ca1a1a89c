"""One span with a turn: forces at the ends, shape of the rope, and the largest load."""

import math
import sys
from pathlib import Path

from matplotlib.figure import Figure

import ropeway as rw


def main(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    rope = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)
    s = rw.System("one span")
    (span,) = s.string(rope, rw.Anchor("a", at=(0.0, 0.0)), rw.Anchor("b", at=(400.0, -60.0)), length=408.0)
    s.hang(rw.Load("turn", mass=6000.0), span, at=190.0)
    loaded = rw.equilibrium(s)
    print(f"6000 kg: {loaded['a_b.tension_a'] / 1e3:.1f} kN at a, {loaded['a_b.tension_b'] / 1e3:.1f} kN at b")

    limit = rw.equilibrium(s, given={"a_b.tension_a": rope.safe_working_load}, solve_for="turn.mass")
    most = math.floor(limit["turn.mass"])  # what it carries is rounded down
    print(f"At the safe working load of {rope.safe_working_load / 1e3:.1f} kN it carries {most} kg")

    taut = rw.equilibrium(s, given={"turn.z": -50.0}, solve_for="a_b.length")
    print(
        f"To keep the turn at z = -50 m the rope must be {taut['a_b.length']:.2f} m long: "
        f"{taut['a_b.tension_a'] / 1e3:.0f} kN"
    )

    figure = Figure(figsize=(9.0, 4.0), layout="constrained")
    axis = figure.subplots()
    for eq, label, style in (
        (loaded, "6000 kg on 408 m of rope", "-"),
        (limit, f"{most} kg on 408 m (safe working load)", "--"),
        (taut, f"6000 kg on {taut['a_b.length']:.1f} m", "-"),
    ):
        curve = eq.profile("a_b")
        (drawn,) = axis.plot(curve["x"], curve["z"], style, label=f"{label}: {eq['a_b.tension_a'] / 1e3:.0f} kN")
        axis.plot(eq["turn.x"], eq["turn.z"], "v", color=drawn.get_color(), ms=8)
    axis.plot([0.0, 400.0], [0.0, -60.0], "^", color="0.3", ms=9)
    axis.set(
        xlabel="x [m]",
        ylabel="z [m]",
        title="One span with a turn: load, rope, and tension at the upper end a (heights 2 times exaggerated)",
        aspect=2.0,
    )
    for name, x, z in (("a", 0.0, 0.0), ("b", 400.0, -60.0)):
        axis.annotate(name, (x, z), xytext=(8, 4), textcoords="offset points")
    figure.legend(fontsize="small", loc="outside lower center", ncols=3, frameon=False)
    axis.margins(y=0.12)
    axis.grid(alpha=0.3)
    figure.savefig(folder / "one_span.png", dpi=110)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
