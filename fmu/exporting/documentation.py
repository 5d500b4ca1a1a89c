"""The page and the picture inside an FMU."""

from __future__ import annotations

import html
import io
from collections.abc import Iterable

import numpy as np

from ropeway.components.carriage import Carriage
from ropeway.fmu.exporting.interface import FmuVariable, Interface
from ropeway.fmu.exporting.model_description import About
from ropeway.systems.statics.equilibrium import Equilibrium

_PAGE = """<!DOCTYPE html>
<html lang="en">
<head><meta charset="utf-8"><title>{name}</title>
<style>body {{ font-family: sans-serif; max-width: 60em }} td, th {{ text-align: left; padding-right: 1em }}</style>
</head>
<body>
<h1>{name}</h1>
<p>{description}</p>
{picture}
<p>Made by ropeway {version}. The FMU starts from the equilibrium that was solved when it was made; with other
parameters it is solved anew when it is initialised, each load where it is clamped to its rope. Inputs are held between
communication points. Loads and carriages that pass supports are events: located inside a step of Co-Simulation, event
indicators in Model Exchange. A schedule that is part of the model keeps its last value after its end.</p>
<p>What goes wrong is a status and a message in the log, never a wrong number: a step that cannot be carried out is
discarded and leaves the state as it was.</p>
<h2>Inputs</h2>
{inputs}
<h2>Outputs</h2>
{outputs}
<h2>Parameters</h2>
{parameters}
</body>
</html>
"""


def page(about: About, interface: Interface, picture: str | None) -> str:
    """documentation/index.html; picture: its path as seen from there."""
    variables = interface.variables
    image = f'<p><img src="{picture}" alt="the line at rest" width="640"></p>' if picture else ""
    return _PAGE.format(
        name=html.escape(about.name),
        description=html.escape(about.description),
        version=about.version,
        picture=image,
        inputs=_table(v for v in variables if v.causality == "input"),
        outputs=_table(v for v in variables if v.causality == "output"),
        parameters=_table(v for v in variables if v.causality == "parameter"),
    )


def _table(variables: Iterable[FmuVariable]) -> str:
    rows = "\n".join(
        f"<tr><td>{html.escape(v.name)}</td><td>{_start(v)}</td><td>{html.escape(v.unit)}</td>"
        f"<td>{html.escape(v.description)}</td></tr>"
        for v in variables
    )
    head = "<tr><th>name</th><th>start</th><th>unit</th><th></th></tr>"
    return f"<table>\n{head}\n{rows}\n</table>" if rows else "<p>None.</p>"


def _start(variable: FmuVariable) -> str:
    return "" if variable.start is None else f"{variable.start:g}"


def picture(rest: Equilibrium) -> bytes:
    """The ropes at rest, with supports and loads, as PNG."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.0, 4.0), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    places = [rest.points(r) for r in range(len(rest.runs))]
    for run, points in zip(rest.runs, places, strict=True):
        origin = places[0][0, :2]
        shapes = [rest.profile(span.name, 31) for span in run.spans]
        for shape in shapes:
            across = np.hypot(shape["x"] - origin[0], shape["y"] - origin[1])
            axes.plot(across, shape["z"], color="tab:blue", linewidth=1.0)
        carriage = np.array([isinstance(node, Carriage) for node in run.nodes])
        for chosen, marker, what in ((~carriage, "k^", "support"), (carriage, "ks", "carriage")):
            if np.any(chosen):
                across = np.hypot(*(points[chosen, :2] - origin).T)
                axes.plot(across, points[chosen, 2], marker, markersize=4, label=what)
        loads = rest.loads[rest.loads["span"].isin([span.name for span in run.spans])]
        axes.plot(
            np.hypot(loads["x"] - origin[0], loads["y"] - origin[1]),
            loads["z"],
            "o",
            color="tab:red",
            markersize=2.5,
            label="load" if len(loads) else None,
        )
    axes.set_xlabel("distance [m]")
    axes.set_ylabel("elevation [m]")
    handles, labels = axes.get_legend_handles_labels()
    named = dict(zip(labels, handles, strict=True))  # each once, on whatever rope
    axes.legend(named.values(), named.keys())
    file = io.BytesIO()
    figure.savefig(file, format="png")
    return file.getvalue()
