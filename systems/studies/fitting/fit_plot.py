"""Figure of a fit: measured and predicted values, residuals, and intervals. matplotlib is imported on use."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ropeway.components.notebook_figure import new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ropeway.systems.studies.fitting.fit_data import FitData

_COLOURS = ("tab:blue", "tab:orange", "tab:green", "tab:purple", "tab:brown", "tab:olive", "tab:cyan", "tab:pink")
_MOST = 6
"""Most measured columns that are drawn."""
_LARGE = {"N": (1e3, "kN"), "Pa": (1e5, "bar"), "J": (1e3, "kJ"), "W": (1e3, "kW")}


def fit_figure(fit: FitData) -> Figure:
    """A row for each measured column, values on the left and residuals on the right; below the free quantities."""
    columns = list(fit.measured.columns)[:_MOST]
    figure = new_figure(figsize=(10.5, 2.4 * len(columns) + 0.9 + 0.32 * len(fit.frame)), layout="constrained")
    heights = [2.4] * len(columns) + [0.9 + 0.32 * len(fit.frame)]
    grid = figure.add_gridspec(len(columns) + 1, 2, width_ratios=[2.0, 1.0], height_ratios=heights)
    for i, (column, colour) in enumerate(zip(columns, _COLOURS, strict=False)):
        _values(fit, column, colour, figure.add_subplot(grid[i, 0]), last=i == len(columns) - 1)
        _residuals(fit, column, colour, figure.add_subplot(grid[i, 1]))
    _intervals(fit, figure.add_subplot(grid[len(columns), :]))
    figure.suptitle(f"Fit of {fit.name}")
    return figure


def _shown(fit: FitData, column: str) -> tuple[float, str]:
    """Size and symbol of the unit in which a column is shown."""
    unit = fit.measured.attrs["units"][column]
    return _LARGE.get(unit, (1.0, unit))


def _values(fit: FitData, column: str, colour: str, axis: Axes, *, last: bool) -> None:
    size, unit = _shown(fit, column)
    there = fit.measured[column].notna()
    x = fit.measured.index[there].to_numpy(float)
    axis.errorbar(
        x, fit.measured.loc[there, column] / size, 2.0 * fit.sigma.loc[there, column] / size, fmt="o", ms=3, lw=0.8,
        color=colour, ecolor="0.6", label="measured, two standard deviations",
    )  # fmt: skip
    style = {"ls": "none", "marker": "_", "ms": 9, "mew": 1.6} if len(x) > 1 and not _series(fit) else {"lw": 1.3}
    axis.plot(x, fit.predicted.loc[there, column] / size, color="black", label="predicted", zorder=3, **style)
    axis.set_ylabel(f"{column} [{unit}]")
    if last:
        axis.set_xlabel("time [s]" if _series(fit) else "row of the table")
    axis.grid(alpha=0.3)
    axis.legend(fontsize="x-small", loc="best")


def _series(fit: FitData) -> bool:
    return fit.measured.index.name == "time"


def _residuals(fit: FitData, column: str, colour: str, axis: Axes) -> None:
    values = (fit.residuals[column] / fit.sigma[column]).dropna().to_numpy()
    widest = max(3.5, float(np.abs(values).max(initial=0.0)) * 1.05)
    bins = np.linspace(-widest, widest, 22)
    axis.hist(values, bins.tolist(), color=colour, alpha=0.6)
    x = np.linspace(-widest, widest, 201)
    axis.plot(x, len(values) * (bins[1] - bins[0]) * np.exp(-0.5 * x * x) / np.sqrt(2.0 * np.pi), color="black", lw=1.0)
    axis.set(xlabel="residual over standard deviation", ylabel="values")


def _intervals(fit: FitData, axis: Axes) -> None:
    """Intervals of the free quantities, relative to the fitted value, and their declared values."""
    names = list(fit.frame.index)
    for y, (name, row) in enumerate(fit.frame.iterrows()):
        size = abs(row["value"]) or 1.0
        text = f"{name} = {row['value']:.6g} {row['unit'] if row['unit'] != '1' else ''}"
        if np.isfinite(row["standard_error"]):
            low, high = 100.0 * (row["low"] - row["value"]) / size, 100.0 * (row["high"] - row["value"]) / size
            axis.plot([low, high], [y, y], color="tab:blue", lw=5, alpha=0.5, solid_capstyle="butt")
            text += f"  ({row['standard_error']:.2g})"
        else:
            text += "  (not identified)"
        axis.plot(0.0, y, "o", color="tab:blue", ms=5)
        axis.annotate(text, (0.0, y), xytext=(0, 5), textcoords="offset points", ha="center", fontsize="x-small")
    axis.set(yticks=range(len(names)), ylim=(-0.6, len(names) - 0.2), xlabel="95 % interval, relative to the value [%]")
    axis.set_yticklabels(names, fontsize="x-small")
    widest = max((abs(v) for v in axis.get_xlim()), default=1.0)
    axis.set_xlim(-1.1 * widest, 1.1 * widest)
    axis.grid(alpha=0.3, axis="x")
