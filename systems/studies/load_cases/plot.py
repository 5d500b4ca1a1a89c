"""One page of load cases: elevation, plan, tensions by case, forces on supports. matplotlib is imported on use."""

from __future__ import annotations

from collections.abc import Iterator
from textwrap import shorten
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import pandas as pd

from ropeway.components.ground import Ground
from ropeway.components.notebook_figure import new_figure
from ropeway.components.rounding import at_least
from ropeway.systems.modelling.rope_path import Run
from ropeway.systems.results.limit_lines import ABOVE
from ropeway.systems.rigs.skyline_rig import SkylineRig
from ropeway.systems.statics.equilibrium import Equilibrium
from ropeway.systems.studies.load_cases.governing import of_all_ropes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ropeway.systems.studies.load_cases.data import CasesData

_COLOURS = ("tab:red", "tab:blue", "tab:green", "tab:orange", "tab:purple", "tab:brown", "tab:pink", "tab:olive",
            "tab:cyan", "0.4")  # fmt: skip
_MOST_BARS = 48
"""Most cases with a bar of their own: those that use most."""
_POINTS = 25


class _Shape(NamedTuple):
    """Curves of a case: distance along the line, offset to the left of it, height, and height above the chord of the
    span, negative for a sag; NaN between spans [m]."""

    along: np.ndarray
    aside: np.ndarray
    height: np.ndarray
    above: np.ndarray


def cases_figure(study: CasesData) -> Figure:
    """The page."""
    shapes = {name: _shape(state) for name, state in study.states.items()}
    colours = _colours(study)
    sways = any(np.nanmax(np.abs(shape.aside)) > 1e-6 for shape in shapes.values())
    ratios = [2.4, 1.8, *([1.3] if sways else []), 3.2]
    figure = new_figure(figsize=(12.5, 1.5 * sum(ratios) + 1.0), layout="constrained")
    panels = figure.add_gridspec(len(ratios), 2, height_ratios=ratios)
    top = figure.add_subplot(panels[0, :])
    _elevation(top, study, shapes, colours)
    panel = figure.add_subplot(panels[1, :], sharex=top)
    _curves(panel, shapes, colours, "above", "above the chord [m]")
    if sways:
        panel = figure.add_subplot(panels[2, :], sharex=top)
        _curves(panel, shapes, colours, "aside", "to the left [m]")
    panel.set_xlabel("station [m]" if isinstance(study.of, SkylineRig) else "distance along the line [m]")
    _utilisation(figure.add_subplot(panels[-1, 0]), study, colours)
    _supports(figure.add_subplot(panels[-1, 1]), study, colours)
    figure.suptitle(_headline(study))
    return figure


def _headline(study: CasesData) -> str:
    worst = study.frame.loc[study.frame["utilisation"].idxmax()]
    used = f"{at_least(100.0 * worst['utilisation'])} % of the tension allowed"
    return f"{study.of.name}: {len(study.cases)} load cases; most is used in {worst.name!r}: {used} in {worst['span']}"


def _colours(study: CasesData) -> dict[str, str]:
    """A colour for each case that governs something, in the order of how much; grey for the others."""
    ranked = study.governing.loc[study.governing["quantity"] != "lift_off_reserve", "case"].value_counts()
    first = [str(case) for case in study.frame["utilisation"].sort_values(ascending=False).index[:1]]
    names = list(dict.fromkeys([*first, *map(str, ranked.index)]))
    return dict(zip(names, _COLOURS, strict=False))


def _shape(state: Equilibrium | pd.DataFrame) -> _Shape:
    """Ropes of a line, or the path of a rig's carriage."""
    if isinstance(state, pd.DataFrame):
        x, y, z = (state[f"carriage_{axis}"].to_numpy(float) for axis in "xyz")
        return _Shape(x, y, z, -state["sag"].to_numpy(float))
    parts = list(_spans(state))
    return _Shape(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))


def _spans(line: Equilibrium) -> Iterator[tuple[np.ndarray, ...]]:
    """The curves of each span, with a gap behind."""
    gap = np.full(1, np.nan)
    for r, run in enumerate(line.runs):
        points = line.points(r)
        steps = np.diff(points, axis=0)
        starts = np.concatenate([[0.0], np.cumsum(np.hypot(steps[:, 0], steps[:, 1]))])
        for k, span in enumerate(run.spans):
            flat = float(np.hypot(*steps[k, :2])) or 1.0
            way = steps[k, :2] / flat
            xyz = line.profile(span.name, _POINTS)[["x", "y", "z"]].to_numpy()
            along, aside = ((xyz[:, :2] - points[k, :2]) @ np.array([way, [-way[1], way[0]]]).T).T
            chord = points[k, 2] + along / flat * steps[k, 2]
            curves = (starts[k] + along, aside, xyz[:, 2], xyz[:, 2] - chord)
            yield tuple(np.concatenate([curve, gap]) for curve in curves)


def _elevation(axis: Axes, study: CasesData, shapes: dict[str, _Shape], colours: dict[str, str]) -> None:
    """All cases in elevation, over the ground."""
    _stand(axis, study)
    for name, shape in sorted(shapes.items(), key=lambda item: item[0] in colours):
        colour = colours.get(name, "0.8")
        label = shorten(name, 40) if name in colours else None
        axis.plot(shape.along, shape.height, color=colour, lw=1.3 if name in colours else 0.6, label=label)
    axis.set_ylabel("height of the carriage [m]" if isinstance(study.of, SkylineRig) else "height [m]")
    axis.grid(alpha=0.25)
    axis.legend(**ABOVE, ncols=4, fontsize="small")


def _stand(axis: Axes, study: CasesData) -> None:
    """Ground and supports."""
    if isinstance(study.of, SkylineRig):
        rig = study.of
        points, names = np.array([node.at for node in rig.stands])[:, [0, 2]], [node.name for node in rig.stands]
        ground = rig.terrain
        if ground is not None:
            axis.plot(ground.station, ground.elevation, color="0.35", lw=1.3)
    else:
        line = next(iter(study.states.values()))
        found = [] if isinstance(line, pd.DataFrame) else [(line.points(r), run) for r, run in enumerate(line.runs)]
        places = [np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(p[:, :2], axis=0).T))]) for p, _ in found]
        points = np.vstack([np.column_stack([x, p[:, 2]]) for x, (p, _) in zip(places, found, strict=True)])
        names = [node.label for _, run in found for node in run.nodes]
        _ground_under(axis, study.of.ground, found, places)
    axis.plot(*points.T, "^", color="tab:brown", ms=5, ls="")
    if len(names) <= 30:
        for name, point in zip(names, points, strict=True):
            axis.annotate(name, point, xytext=(0, 6), textcoords="offset points", ha="center", fontsize="x-small")


def _ground_under(
    axis: Axes, ground: Ground | None, found: list[tuple[np.ndarray, Run]], places: list[np.ndarray]
) -> None:
    """The ground below a line's first rope."""
    if ground is None or not found:
        return
    points, along = found[0][0], places[0]
    at = np.linspace(along[0], along[-1], 400)
    axis.plot(
        at,
        ground.elevations(np.interp(at, along, points[:, 0]), np.interp(at, along, points[:, 1])),
        color="0.35",
        lw=1.3,
    )


def _curves(axis: Axes, shapes: dict[str, _Shape], colours: dict[str, str], which: str, label: str) -> None:
    """One kind of curve of all cases."""
    for name, shape in sorted(shapes.items(), key=lambda item: item[0] in colours):
        width = 1.1 if name in colours else 0.6
        axis.plot(shape.along, getattr(shape, which), color=colours.get(name, "0.8"), lw=width)
    axis.set_ylabel(label)
    axis.grid(alpha=0.25)


def _utilisation(axis: Axes, study: CasesData, colours: dict[str, str]) -> None:
    """How much of the allowed tension each case uses."""
    used = 100.0 * study.frame["utilisation"].sort_values().iloc[-_MOST_BARS:]
    rows = np.arange(len(used))
    axis.barh(rows, used, color=[colours.get(str(name), "0.75") for name in used.index], height=0.8)
    axis.set_yticks(
        rows, [shorten(str(name), 34) for name in used.index], fontsize="x-small" if len(used) > 16 else "small"
    )
    axis.axvline(100.0, color="tab:red", ls="--", lw=1.2)
    axis.set_xlim(0.0, max(105.0, 1.05 * float(used.max())))
    axis.set_ylim(-0.6, len(used) - 0.4)
    axis.set_xlabel("share of the tension allowed [%]")
    axis.grid(axis="x", alpha=0.25)


def _supports(axis: Axes, study: CasesData, colours: dict[str, str]) -> None:
    """Range of the vertical force on each support, with the cases that set its ends."""
    rows = of_all_ropes(study.supports)
    names = list(dict.fromkeys(study.supports["support"]))
    for k, name in enumerate(names):
        own = rows[rows["support"] == name]
        force = own["vertical_force"].round(3) / 1e3  # of equal cases the first
        axis.plot([k, k], [force.min(), force.max()], color="0.6", lw=3.0, solid_capstyle="butt")
        for mark, place in (("^", force.idxmax()), ("v", force.idxmin())):
            colour = colours.get(str(own.loc[place, "case"]), "0.3")
            axis.plot([k], [force[place]], mark, color=colour, ms=5)
    axis.axhline(0.0, color="0.3", lw=0.8)
    axis.set_xticks(range(len(names)), names, rotation=90, fontsize="x-small" if len(names) > 16 else "small")
    axis.set_ylabel("vertical force on the support [kN]")
    axis.grid(axis="y", alpha=0.25)
