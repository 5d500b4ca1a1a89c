"""Figures of the theory, computed by the library: `python docs/theory/figures.py FOLDER`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import matplotlib as mpl
import numpy as np
import pandas as pd

import ropeway as rw

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

mpl.use("Agg")
ROPE = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)
BLUE, ORANGE, GREEN, GREY = "#08519c", "#e08214", "#5b8c2a", "0.55"


def new(width: float = 8.0, height: float = 3.4, columns: int = 1) -> tuple[Figure, list[Axes]]:
    """A figure with axes side by side."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    axes = list(np.atleast_1d(figure.subplots(1, columns)))
    for axis in axes:
        axis.spines[["top", "right"]].set_visible(False)
    return figure, axes


def arrow(
    axis: Axes,
    start: tuple[float, float],
    by: tuple[float, float],
    text: str,
    colour: str = ORANGE,
    beside: tuple[float, float] | None = None,
) -> None:
    """A force with its symbol `beside` its head [points]; by default ahead of it."""
    end = (start[0] + by[0], start[1] + by[1])
    axis.annotate("", end, start, arrowprops={"arrowstyle": "-|>", "color": colour, "lw": 1.6})
    if beside is None:
        level = abs(by[0]) > abs(by[1])
        beside = (9.0 * np.sign(by[0]), 0.0) if level else (0.0, 9.0 * np.sign(by[1]))
    axis.annotate(text, end, xytext=beside, textcoords="offset points", color=colour, ha="center", va="center")


def catenary() -> Figure:
    """A span with two clamped loads: chord, sag, and the tension vector at both ends."""
    s = rw.System("span")
    (span,) = s.string(ROPE, rw.Anchor("a", at=(0.0, 0.0)), rw.Anchor("b", at=(200.0, 30.0)), length=209.0)
    s.hang(rw.Load("one", mass=600.0), span, at=70.0)
    s.hang(rw.Load("two", mass=1100.0), span, at=130.0)
    eq = rw.equilibrium(s)
    curve = eq.profile("a_b", 201)
    figure, (axis,) = new(8.0, 3.8)
    axis.plot(curve["x"], curve["z"], color=BLUE, lw=2.0)
    axis.plot([0.0, 200.0], [0.0, 30.0], color=GREY, lw=1.0, ls="--")
    axis.annotate("chord", (150.0, 24.5), color=GREY)
    for load in ("one", "two"):
        x, z = eq[f"{load}.x"], eq[f"{load}.z"]
        axis.plot([x], [z], "o", color=BLUE, ms=6.0)
        arrow(axis, (x, z), (0.0, -12.0), "$m g$")
    x = float(eq["two.x"])
    axis.plot([x, x], [eq["two.z"], 0.15 * x], color=GREY, lw=1.0)
    axis.annotate("sag", (x + 2.0, 0.5 * (eq["two.z"] + 0.15 * x)), color=GREY)
    scale = 40.0 / eq["a_b.tension_b"]
    for place, sign, end in (((0.0, 0.0), -1.0, "a"), ((200.0, 30.0), 1.0, "b")):
        points = curve.iloc[[0, 1]] if end == "a" else curve.iloc[[-2, -1]]
        along = np.diff(points[["x", "z"]].to_numpy(), axis=0)[0]
        along *= sign * scale * eq[f"a_b.tension_{end}"] / np.hypot(*along)
        arrow(axis, place, (along[0], along[1]), f"$T_{end}$")
    arrow(axis, (0.0, 0.0), (-scale * eq["a_b.horizontal"], 0.0), "$H$", GREEN)
    axis.set(xlabel="x [m]", ylabel="z [m]", aspect="equal", xlim=(-48.0, 250.0), ylim=(-42.0, 62.0))
    return figure


def supports() -> Figure:
    """Wrap angle of a sheave, and the force that holds a rolling carriage."""
    figure, (sheave, carriage) = new(9.0, 3.4, 2)
    one, two = np.radians(22.0), np.radians(-14.0)
    sheave.plot([-np.cos(one), 0.0, np.cos(two)], [-np.sin(one), 0.0, np.sin(two)], color=BLUE, lw=2.0)
    sheave.plot([0.0, np.cos(one)], [0.0, np.sin(one)], color=GREY, ls="--", lw=1.0)
    angles = np.linspace(two, one, 40)
    sheave.plot(0.55 * np.cos(angles), 0.55 * np.sin(angles), color=GREY, lw=1.0)
    sheave.annotate(r"$\beta$", (0.6, 0.02), color=GREY)
    sheave.plot([0.0], [0.0], "o", color=BLUE, ms=9.0, mfc="white", mew=1.8)
    arrow(
        sheave,
        (-0.5 * np.cos(one), -0.5 * np.sin(one)),
        (-0.4 * np.cos(one), -0.4 * np.sin(one)),
        "$T_{in}$",
        beside=(2.0, 12.0),
    )
    arrow(
        sheave,
        (0.7 * np.cos(two), 0.7 * np.sin(two)),
        (0.4 * np.cos(two), 0.4 * np.sin(two)),
        "$T_{out}$",
        beside=(2.0, 12.0),
    )
    sheave.set(aspect="equal", xlim=(-1.25, 1.4), ylim=(-0.75, 0.6), title="sheave")
    left, right = np.array([-0.93, 0.55]), np.array([0.93, -0.08])
    carriage.plot([left[0], 0.0, right[0]], [left[1], 0.0, right[1]], color=BLUE, lw=2.0)
    a, b = left / np.hypot(*left), right / np.hypot(*right)
    along, across = (a - b) / np.hypot(*(a - b)), (a + b) / np.hypot(*(a + b))
    carriage.plot(*np.array([-0.6 * along, 0.6 * along]).T, color=GREY, ls="--", lw=1.0)
    carriage.plot([0.0], [0.0], "s", color=BLUE, ms=9.0)
    weight = 0.62
    hold, push = weight * along[1] * along, weight * across[1] * across
    arrow(carriage, (0.0, 0.0), (0.0, -weight), "$(m+P)\\,g$")
    arrow(carriage, (0.0, 0.0), (hold[0], hold[1]), "$F$", GREEN)
    arrow(carriage, (0.0, 0.0), (push[0], push[1]), r"$T\,(\mathbf{u}_a+\mathbf{u}_b)$", BLUE)
    carriage.annotate(r"$\mathbf{e}$", tuple(0.62 * along), xytext=(-10.0, 2.0), textcoords="offset points", color=GREY)
    carriage.set(aspect="equal", xlim=(-1.25, 1.25), ylim=(-0.9, 0.85), title="carriage")
    for axis in (sheave, carriage):
        axis.axis("off")
    return figure


def drive() -> Figure:
    """Force limits of a hydraulic drive over the speed of the rope."""
    p = rw.HydraulicDrive(
        displacement=60e-6,
        gear_ratio=20.0,
        sheave_radius=0.5,
        relief_pressure=250e5,
        pump_flow=3.2e-3,
        engine_power=25e3,
        inertia=800.0,
    )
    speed = np.linspace(0.01, p.top_speed, 300)
    both = p.mechanical_efficiency * p.volumetric_efficiency
    relief = p.relief_force / p.mechanical_efficiency
    driving = np.minimum(relief * p.mechanical_efficiency, p.engine_power * both / speed)
    braking = -np.minimum(relief / p.mechanical_efficiency, p.engine_power / (both * speed))
    figure, (axis,) = new()
    axis.fill_between(speed, braking / 1e3, driving / 1e3, color="#c6dbef")
    axis.plot(speed, driving / 1e3, color=BLUE)
    axis.plot(speed, braking / 1e3, color=BLUE)
    axis.plot([p.top_speed] * 2, [braking[-1] / 1e3, driving[-1] / 1e3], color=BLUE)
    axis.axhline(0.0, color=GREY, lw=0.8)
    at = int(0.62 * len(speed))
    axis.annotate("relief pressure", (0.15, driving[0] / 1e3 + 2.5))
    axis.annotate("engine power", (speed[at] + 0.03, driving[at] / 1e3 + 2.5))
    axis.annotate("pump flow", (p.top_speed + 0.03, 2.0))
    axis.annotate("driving", (0.5, 8.0), color=GREY)
    axis.annotate("braking, with recovery", (0.5, -14.0), color=GREY)
    axis.set(xlabel="rope speed [m/s]", ylabel="force on the rope [kN]", xlim=(0.0, p.top_speed + 0.5))
    axis.set_ylim(1.2 * braking[0] / 1e3, 1.35 * driving[0] / 1e3)
    return figure


def crossing() -> Figure:
    """Tension beside a control sheave, and the travel of an idler, while loads cross."""
    supports = pd.DataFrame(
        {
            "name": ["a", "s1", "s2", "c1", "b"],
            "x": [0.0, 90.0, 180.0, 270.0, 350.0],
            "y": 0.0,
            "z": [0.0, 7.5, 9.0, 16.5, 17.5],
            "kind": ["drum", "idler", "idler", "control", "drum"],
        }
    )
    line = rw.monocable(ROPE, supports, tension=45e3, speed=1.0, load_mass=600.0, load_spacing=40.0)
    result = rw.simulate(line, 60.0, every=0.1)
    figure, (axis,) = new()
    axis.plot(result.frame.index, result.frame["c1.tension_in"] / 1e3, color=BLUE, label="tension before c1")
    events = result.events[result.events["event"].isin(["crossing forward", "load put on"])]
    for support, colour in (("a", BLUE), ("s1", ORANGE), ("s2", GREEN), ("c1", GREY)):
        words = f"a load crosses {support}" if support != "a" else "a load is put on at a"
        for k, time in enumerate(events[events["component"] == support]["time"]):
            axis.axvline(time, color=colour, lw=1.0, ls=":", label=words if k == 0 else None)
    axis.legend(fontsize="small", frameon=False, ncols=5, loc="lower center", bbox_to_anchor=(0.5, 1.0))
    axis.set(xlabel="time [s]", ylabel="tension [kN]", xlim=(0.0, 60.0))
    return figure


def jacobian() -> Figure:
    """Structure of the Jacobian of a line: one block for each span, coupled by the travels of the idlers."""
    s = rw.System("line")
    nodes = [(rw.Sheave if 0 < k < 8 else rw.Anchor)(f"s{k}", at=(60.0 * k, 3.0 * (k % 2))) for k in range(9)]
    s.string(ROPE, *nodes, length=484.0)
    model = rw.assemble(s)
    import casadi as ca

    z = model.sym("z", len(model.z))
    sizes = [len(model.x), len(model.u), len(model.p), len(model.d)]
    x, u, p, d = (model.sym(n, k) for n, k in zip("xupd", sizes, strict=True))
    pattern = ca.jacobian_sparsity(model.dae(model.sym("t"), x, z, u, p, d)[1], z)
    rows, columns = np.array(pattern.row()), np.array(pattern.get_col())
    figure, (axis,) = new(4.2, 4.0)
    axis.plot(columns, rows, "s", color=BLUE, ms=4.5)
    count = len(model.z)
    axis.set(xlabel="algebraic variable", ylabel="residual", aspect="equal", xlim=(-1, count), ylim=(count, -1))
    return figure


FIGURES = (catenary, supports, drive, crossing, jacobian)


def main(folder: Path) -> None:
    """Writes all figures."""
    for figure in FIGURES:
        figure().savefig(folder / f"{figure.__name__}.png", dpi=110)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
