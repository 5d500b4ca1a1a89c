"""Comparison of all payload methods with the exact payload and with the numbers of Harvey (2013)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from ropeway.components.annotation_checks import Positive
from ropeway.components.argument_checks import checked
from ropeway.components.errors import InputError, UnknownNameError
from ropeway.components.rope import Rope, rope_of
from ropeway.systems.modelling.system import GRAVITY
from ropeway.systems.studies.handbook.array_checks import require
from ropeway.systems.studies.handbook.array_roots import Array, Numbers
from ropeway.systems.studies.handbook.harvey_as_printed import SLOPES, TABLE_2
from ropeway.systems.studies.handbook.loaded_span import LoadedSpan
from ropeway.systems.studies.handbook.payload_exact import Joint, catenary_clamped, catenary_rolling, elastic_state
from ropeway.systems.studies.handbook.payload_methods import METHODS, Method, payload_for_tension

UNITS = {"chord_slope": "1", "payload": "kg", "error": "1", "error_rolling": "1", "as_printed": "kg", "printed": "kg"}
"""Units of the columns of the comparison."""


@checked
def compare_payload_methods(
    *,
    span: float,
    deflection: float,
    chord_slopes: Sequence[float],
    rope: Rope | str,
    tension: float | None = None,
    carriage_mass: float = 0.0,
    carriage: float = 0.5,
    as_printed: bool = False,
    gravity: Positive = GRAVITY,
) -> pd.DataFrame:
    """Compare the payloads of all methods on one span at several chord slopes.

    Parameters
    ----------
    span : float
        Horizontal distance between the supports [m].
    deflection : float
        Vertical distance from the chord to the carriage [m].
    chord_slopes : sequence of float
        Slopes of the chord down from the upper support, 0.2 for 20 %.
    rope : Rope or str
        A rope, or a name from `rw.ropes()`.
    tension : float, optional
        Tension at the upper support [N]; by default the rope's safe working load.
    carriage_mass : float, default 0.0
        Mass of the carriage [kg].
    carriage : float, default 0.5
        Distance of the carriage from the upper support, as a share of the span.
    as_printed : bool, default False
        Whether to add the printed results of the sources.
    gravity : float, default 9.80665
        Gravitational acceleration [m/s2].

    Returns
    -------
    DataFrame
        One row for each method and slope. Columns: method, chord_slope, payload [kg], error (relative to the exact
        clamped payload: inextensible rope, equal horizontal tension on both sides of the carriage), error_rolling
        (relative to the exact rolling payload: equal tension, horizontal mainline). The rows "elastic catenary" include
        the rope's own stretch. `as_printed` adds the columns as_printed (payload of the source's formula or readings
        with their errors), printed (the number in Harvey (2013), Table 2, for his span) and erratum. His rigid-link
        sums have separate rows, as printed only.

    Raises
    ------
    InputError
        A value is out of range.
    SlackRopeError
        The tension is too low for the rope's own weight.

    Examples
    --------
    >>> table = rw.compare_payload_methods(span=200.0, deflection=25.0, chord_slopes=[0.1], rope="RHOL-IWRC 29")
    >>> float(table.set_index("method")["error"].round(4)["weightless"])
    0.0439
    """
    rope = rope_of(rope)
    slopes = np.asarray(chord_slopes, dtype=float)
    if slopes.ndim != 1 or slopes.size == 0:
        raise InputError(f"chord_slopes is {chord_slopes!r}", "Give a sequence of slopes, (0.0, 0.1, 0.2)")
    line = LoadedSpan(span, deflection, slopes, carriage)
    pull = rope.safe_working_load if tension is None else tension
    weight = rope.mass_per_length * gravity

    def payload(method: Method) -> Array:
        value = payload_for_tension(method, line, rope, pull, carriage_mass=carriage_mass, gravity=gravity)
        return np.broadcast_to(value, slopes.shape)

    payloads = {name: payload(method) for name, method in METHODS.items()}
    if np.isfinite(rope.axial_stiffness):
        payloads |= {f"elastic catenary, {j}": payload(_elastic(rope, j)) for j in ("clamped", "rolling")}
    table = pd.DataFrame(
        [(name, slope, value) for name, row in payloads.items() for slope, value in zip(slopes, row, strict=True)],
        columns=["method", "chord_slope", "payload"],
    )
    for column, joint in (("error", "clamped"), ("error_rolling", "rolling")):
        table[column] = table["payload"] / np.tile(payloads[f"catenary, {joint}"], len(payloads)) - 1.0
    if as_printed:
        harveys_span = _is_harveys(line, weight / gravity, pull / gravity, carriage_mass)
        table = _with_printed(table, line, weight / gravity, pull / gravity, carriage_mass, harveys_span)
    table.attrs["units"] = {name: UNITS.get(name, "") for name in table.columns}
    return table


@checked
def method_errors(
    rope: Rope | str,
    *,
    span: float,
    tension: float,
    slopes: ArrayLike,
    deflections: ArrayLike,
    carriages: ArrayLike,
    methods: Sequence[str] | None = None,
    gravity: Positive = GRAVITY,
) -> pd.DataFrame:
    """Find the error of each method's gross load over a grid of spans.

    Parameters
    ----------
    rope : Rope or str
        A rope, or a name from `rw.ropes()`.
    span : float
        Horizontal distance between the supports [m].
    tension : float
        Tension at the upper support [N].
    slopes : array_like
        Chord slopes of the grid.
    deflections : array_like
        Deflections at the carriage, as shares of the span.
    carriages : array_like
        Distances of the carriage from the upper support, as shares of the span.
    methods : sequence of str, optional
        Names in `METHODS`; by default all.
    gravity : float, default 9.80665
        Gravitational acceleration [m/s2].

    Returns
    -------
    DataFrame
        Index method; columns: reference, lowest, highest, mean absolute error (relative), and slope, deflection and
        carriage of the worst error. The reference of a rolling method is the rolling catenary.

    Raises
    ------
    InputError
        A value is out of range.
    UnknownNameError
        There is no such method.
    SlackRopeError
        The tension is too low for the rope's own weight.

    Examples
    --------
    >>> grid = {"slopes": [0.0, 0.1], "deflections": [0.1], "carriages": [0.3, 0.5]}
    >>> errors = rw.method_errors("RHOL-IWRC 29", span=200.0, tension=190e3, **grid)
    >>> bool(errors.loc["parabolic", "highest"] > errors.loc["rigid link", "highest"])
    True
    """
    rope = rope_of(rope)
    require(tension, "tension [N]", lambda v: v > 0.0, "above zero")
    s, y, c = (v.ravel() for v in np.meshgrid(*map(np.asarray, (slopes, deflections, carriages)), indexing="ij"))
    line = LoadedSpan(span, y * span, s, c)

    def gross(method: Method) -> Array:
        return payload_for_tension(method, line, rope, tension, gravity=gravity)

    if unknown := set(methods or ()) - set(METHODS):
        raise UnknownNameError(f"No method {min(unknown)!r}", f"Known are {', '.join(METHODS)}")
    exact = {"clamped": gross(catenary_clamped), "rolling": gross(catenary_rolling)}
    rows = []
    for name in METHODS if methods is None else methods:
        reference = "rolling" if "rolling" in name else "clamped"
        error = gross(METHODS[name]) / exact[reference] - 1.0
        k = int(np.argmax(np.abs(error)))
        rows.append((name, reference, error.min(), error.max(), np.abs(error).mean(), s[k], y[k], c[k]))
    names = ["method", "reference", "lowest", "highest", "mean", "worst_slope", "worst_deflection", "worst_carriage"]
    return pd.DataFrame(rows, columns=names).set_index("method")


def _elastic(rope: Rope, joint: str) -> Method:
    def method(line: LoadedSpan, weight: Numbers, tension: Numbers) -> Array:
        typed: Joint = "rolling" if joint == "rolling" else "clamped"
        return elastic_state(line, weight, tension, rope.strain, typed).gross

    return method


def _with_printed(
    table: pd.DataFrame,
    line: LoadedSpan,
    weight_kgf: float,
    tension_kgf: float,
    carriage_mass: float,
    harveys_span: bool,
) -> pd.DataFrame:
    """The comparison with the columns as_printed, printed and erratum, and rows for Harvey's own sums."""
    slopes = np.asarray(line.chord_slope)
    rows = []
    for name, source in TABLE_2.items():
        values = np.broadcast_to(source.method(line, weight_kgf, tension_kgf) - carriage_mass, slopes.shape)
        numbers = dict(zip(SLOPES, source.payloads, strict=True)) if harveys_span else {}
        rows += [
            (name, slope, value, numbers.get(round(float(slope), 9), np.nan), source.erratum)
            for slope, value in zip(slopes, values, strict=True)
        ]
    printed = pd.DataFrame(rows, columns=["method", "chord_slope", "as_printed", "printed", "erratum"])
    printed = printed.drop_duplicates(["method", "chord_slope"])
    whole = table.merge(printed, how="left", on=["method", "chord_slope"])
    whole = pd.concat([whole, printed[~printed["method"].isin(table["method"])]], ignore_index=True)
    return whole.fillna({"erratum": ""})


def _is_harveys(line: LoadedSpan, weight_kgf: float, tension_kgf: float, carriage_mass: float) -> bool:
    """Whether a span is that of Harvey's Table 2."""
    values = [float(v) for v in (line.span, line.deflection, line.carriage, weight_kgf, tension_kgf, carriage_mass)]
    return bool(np.allclose(values, (200.0, 25.0, 0.5, 3.48, 19600.0, 150.0), rtol=1e-3, atol=0.0))
