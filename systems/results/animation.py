"""An animation of a run as GIF, MP4 or a page with a player. matplotlib is imported on use."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ropeway.components.errors import InputError
from ropeway.components.notebook_figure import new_figure
from ropeway.components.whole_files import whole
from ropeway.systems.reporting.blocks import Section
from ropeway.systems.reporting.document import ReportOptions, write_report
from ropeway.systems.results.result_report import line_player, shape_of, tensions_chart

if TYPE_CHECKING:
    from ropeway.systems.results.run_data import RunData


def animate(result: RunData, path: str | Path, frames: int, rate: int) -> Path:
    """Writes the animation of the line. Raises InputError, WriteError."""
    suffix = Path(path).suffix.lower()
    if suffix in (".html", ".htm"):
        options = ReportOptions()
        blocks = (line_player(result, options.style), tensions_chart(result, options.style))
        return write_report(path, result.model.name, [Section(options.style.text("simulation"), blocks)], options)
    if suffix not in (".gif", ".mp4"):
        raise InputError(f"{path} is not an animation", "Use a name that ends with .gif, .mp4 or .html")
    from matplotlib.animation import FFMpegWriter, PillowWriter

    if suffix == ".mp4" and not FFMpegWriter.isAvailable():
        raise InputError("Writing MP4 needs ffmpeg", "Install ffmpeg, or write .gif or .html")
    grid = np.flatnonzero(result.on_grid)
    chosen = grid[np.unique(np.linspace(0, len(grid) - 1, min(frames, len(grid))).astype(int))].tolist()
    shapes = [shape_of(result.record(i)) for i in chosen]
    figure = new_figure(figsize=(10.0, 4.2), dpi=80, layout="constrained")
    axis = figure.subplots()
    axis.set(xlabel="horizontal distance along the line [m]", ylabel="height [m]")
    axis.grid(alpha=0.3)
    for run in result.runs:
        along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(run.points[:, :2], axis=0).T))])
        axis.plot(along, run.points[:, 2], "s", color="0.4", ms=4)
    (rope,) = axis.plot([], [], color="tab:blue", lw=1.3)
    (loads,) = axis.plot([], [], "o", color="tab:green", ms=5)
    every = np.concatenate([shape[0][1] for shape in shapes])
    low, high = float(np.nanmin(every)), float(np.nanmax(every))
    axis.set_ylim(low - 0.08 * (high - low) - 1.0, high + 0.08 * (high - low) + 1.0)
    farthest = max(float(np.nanmax(shape[0][0])) for shape in shapes)
    axis.set_xlim(-0.02 * farthest, 1.02 * farthest)
    writer: Any = PillowWriter(fps=rate) if suffix == ".gif" else FFMpegWriter(fps=rate)
    with whole(path) as file, writer.saving(figure, str(file), dpi=80):
        for i, (line, hung) in zip(chosen, shapes, strict=True):
            rope.set_data(*line)
            loads.set_data(*hung)
            axis.set_title(f"{result.model.name} at t = {result.times[i]:.1f} s")
            writer.grab_frame()
    return Path(path)
