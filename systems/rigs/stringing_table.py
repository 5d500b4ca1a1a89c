"""Tension, sag and wave-return time of an empty rope by temperature, for setting it up."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import pandas as pd

from ropeway.components import check
from ropeway.components.anchor import Anchor
from ropeway.components.annotation_checks import Positive
from ropeway.components.argument_checks import checked
from ropeway.components.environment import TEMPERATURES, Environment
from ropeway.components.errors import InputError
from ropeway.components.rope import Rope
from ropeway.components.span import Span
from ropeway.systems.interrupts import interruptible
from ropeway.systems.modelling.assembly import assemble
from ropeway.systems.modelling.system import GRAVITY, STRUNG, System
from ropeway.systems.reporting.blocks import Table
from ropeway.systems.reporting.style import Style
from ropeway.systems.rigs.bare_skyline import bare_system
from ropeway.systems.rigs.skyline_rig import SkylineRig
from ropeway.systems.statics.equilibrium import Equilibrium
from ropeway.systems.statics.equilibrium_solver import equilibrium

TEMPERATURES_SHOWN = (-20.0, -10.0, 0.0, 10.0, 20.0, 30.0)
"""Temperatures of the table in a report [degrees C]."""

_UNITS = {
    "temperature": "degC", "tension_a": "N", "tension_b": "N", "horizontal": "N", "sag": "m", "return_time": "s"
}  # fmt: skip
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(24)
"""Gauss' rule for the time of a wave along a span."""


@checked
@interruptible
def stringing_table(
    of: Rope | str | System | SkylineRig,
    temperatures: Sequence[float],
    *,
    span: float | None = None,
    rise: float = 0.0,
    tension: float | None = None,
    length: float | None = None,
    strung: float = STRUNG,
    gravity: Positive = GRAVITY,
) -> pd.DataFrame:
    """Tension, sag and wave-return time of the empty rope by temperature.

    A rope that is set to a tension of the table at the temperature of the day has its wanted tension at the temperature
    for which it is designed. The rope moves freely over idlers.

    Parameters
    ----------
    of : Rope, str, System or SkylineRig
        A rope or its name, for a single span; a line, without its loads; or a rig, its bare skyline.
    temperatures : sequence of float
        Temperatures of the rope [degrees C].
    span, rise : float, optional
        Of a rope: horizontal distance between its ends, and height of the second above the first [m].
    tension, length : float, optional
        Of a rope: its tension at the first end, or its unstretched length [m], at the temperature `strung`.
    strung : float, default 15
        Of a rope: that temperature [degrees C]; a line or rig has its own.
    gravity : float, default 9.80665
        Of a rope: gravitational acceleration [m/s2].

    Returns
    -------
    DataFrame
        A row for each temperature and span: temperature, span, tension_a and tension_b at its ends, horizontal [N];
        sag, the largest one below the chord [m]; return_time, in which a transverse wave runs from one end of the span
        to the other and back [s]. Units in `attrs["units"]`.

    Raises
    ------
    InputError
        No temperature, or arguments that do not belong together.
    SlackRopeError, EquilibriumError
        The rope does not hang taut.

    Examples
    --------
    >>> table = rw.stringing_table("RHOL-IWRC 29", [-20.0, 15.0], span=480.0, tension=70e3)
    >>> table["sag"].is_monotonic_increasing
    True
    """
    if not len(temperatures):
        raise InputError("stringing_table has no temperature", "Give one or more in degrees C")
    for value in temperatures:
        check.number(value, "stringing_table", "a temperature", "degrees C", TEMPERATURES)
    if isinstance(of, (System, SkylineRig)):
        if span is not None or tension is not None or length is not None:
            raise InputError("span, tension and length are those of a rope", "Leave them out, or give a rope")
        line = _empty(of) if isinstance(of, System) else bare_system(of)[0]
    else:
        line = _one_span(Rope._from_given(of), span, rise, tension, length, strung, gravity)
    first, *_ = temperatures
    model = assemble(line.in_weather(Environment("stringing", temperature=float(first))))
    rows: list[dict[str, Any]] = []
    solved: Equilibrium | None = None
    for temperature in temperatures:
        solved = equilibrium(model, parameters={"temperature": float(temperature)}, start=solved)
        rows += [{"temperature": float(temperature), **row} for row in _spans(solved)]
    frame = pd.DataFrame(rows)
    frame.attrs["units"] = {column: _UNITS.get(column, "") for column in frame.columns}
    return frame


def _one_span(
    rope: Rope,
    span: float | None,
    rise: float,
    tension: float | None,
    length: float | None,
    strung: float,
    gravity: float,
) -> System:
    """A rope between two anchors. Raises InputError, SlackRopeError."""
    if span is None:
        raise InputError("stringing_table of a rope has no span", "Give span=, in metres")
    check.positive(span, "stringing_table", "span", "m")
    check.number(rise, "stringing_table", "rise", "m")
    line = System(rope.name, gravity=gravity, temperature=strung)
    line.string(rope, Anchor("a", at=(0.0, 0.0)), Anchor("b", at=(span, rise)), tension=tension, length=length)
    return line


def _empty(line: System) -> System:
    """A line without its loads."""
    other = line.copy()
    other.hung, other.feeds = [], []
    return other


def _spans(line: Equilibrium) -> Iterator[dict[str, Any]]:
    """A row for each span."""
    for run in line.runs:
        for span in run.spans:
            ends = {name: line[f"{span.name}.{name}"] for name in ("tension_a", "tension_b", "horizontal")}
            yield {"span": span.name, **ends, "sag": _sag(line, span), "return_time": _return_time(line, span)}


def _sag(line: Equilibrium, span: Span) -> float:
    """Largest sag below the chord [m]: where the rope is parallel to it."""
    weight = line[f"{span.name}.mass_per_length"] * line["gravity"]
    length = line[f"{span.name}.length"]
    ends = line.profile(span.name, [0.0, length])[["x", "y", "z"]].to_numpy()
    run, rise = float(np.hypot(*(ends[1] - ends[0])[:2])), float(ends[1, 2] - ends[0, 2])
    if run == 0.0:
        return 0.0
    lowest = (line[f"{span.name}.horizontal"] * rise / run + line[f"{span.name}.vertical_a"]) / weight
    at = line.profile(span.name, [min(max(lowest, 0.0), length)])[["x", "y", "z"]].to_numpy()[0]
    return float(ends[0, 2] + rise / run * np.hypot(*(at - ends[0])[:2]) - at[2])


def _return_time(line: Equilibrium, span: Span) -> float:
    """Time of a transverse wave along the span and back [s]. Its speed against the rope is sqrt(T / mass per stretched
    length), so a metre of unstretched rope takes sqrt(mass per unstretched length * stretched length / T)."""
    length = line[f"{span.name}.length"]
    tension = line.profile(span.name, (0.5 + 0.5 * _NODES) * length)["tension"].to_numpy()
    stretched = line[f"{span.name}.expansion"] * (1.0 + span.rope.strain.at(tension))
    slowness = np.sqrt(line[f"{span.name}.mass_per_length"] * stretched / tension)
    return float(_WEIGHTS @ slowness * length)


def report_table(of: System | SkylineRig, style: Style) -> Table:
    """The table at some temperatures, for a report. Raises EquilibriumError."""
    table = stringing_table(of, TEMPERATURES_SHOWN)
    head = (
        style.head("temperature", "temperature"), style.text("span"), style.head("tension", "force"),
        style.head("sag", "short_length"), style.head("return_time", "time"),
    )  # fmt: skip
    rows = [
        (
            style.number(row["temperature"], "temperature"), str(row["span"]), style.number(row["tension_a"], "force"),
            style.number(row["sag"], "short_length"), style.number(row["return_time"], "time"),
        )
        for _, row in table.iterrows()
    ]  # fmt: skip
    return Table(head, rows, style.text("stringing_note"), texts=2)
