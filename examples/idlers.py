"""One rope over idler sheaves: a load in one span pulls in rope from the others."""

import sys
from pathlib import Path

from matplotlib.figure import Figure

import ropeway as rw


def main(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    rope = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)
    figure = Figure(figsize=(9.0, 4.5), layout="constrained")
    axis = figure.subplots()
    for at in (50.0, 150.0, 250.0):
        s = rw.System("idlers")
        spans = s.string(
            rope,
            rw.Anchor("a", at=(0, 0)),
            rw.Sheave("s1", at=(100, 5)),
            rw.Sheave("s2", at=(210, 2)),
            rw.Anchor("b", at=(300, 12)),
            length=303.0,
        )
        s.hang(rw.Load("l1", mass=400.0), spans, at=at)
        eq = rw.equilibrium(s)
        lengths = ", ".join(f"{span.name} {eq[f'{span.name}.length']:.3f} m" for span in spans)
        print(f"Load at {at:.0f} m: highest tension {max(eq['a_s1.tension_a'], eq['s2_b.tension_b']):.0f} N; {lengths}")
        for i, span in enumerate(spans):
            curve = eq.profile(span.name)
            label = f"load at {at:.0f} m of rope: {eq['s2_b.tension_b'] / 1e3:.1f} kN at b" if i == 0 else None
            axis.plot(curve["x"], curve["z"], color=f"C{int(at // 100)}", label=label)
        axis.plot(eq["l1.x"], eq["l1.z"], "v", color=f"C{int(at // 100)}", ms=9)
    axis.plot([0, 100, 210, 300], [0, 5, 2, 12], "o", color="0.3", ms=8, zorder=3)
    axis.set(
        xlabel="x [m]", ylabel="z [m]", title="400 kg on a rope of 303 m over two idler sheaves (heights exaggerated)"
    )
    for name, x, z in (("a", 0, 0), ("s1", 100, 5), ("s2", 210, 2), ("b", 300, 12)):
        axis.annotate(name, (x, z), xytext=(0, 9), textcoords="offset points", ha="center")
    axis.margins(y=0.12)
    axis.legend()
    axis.grid(alpha=0.3)
    figure.savefig(folder / "idlers.png", dpi=110)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
