"""Harvey (2013) as printed, with his roundings and misprints, only to reproduce his numbers.

All results here contain his errors; the corrected methods are in `payload_methods`. Sections and equations are those of
the report. Forces are in any consistent unit; his are in kgf.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from ropeway.components.errors import InputError
from ropeway.systems.studies.handbook.array_roots import Array, Numbers
from ropeway.systems.studies.handbook.lira_worksheet import Readings, lira_worksheet
from ropeway.systems.studies.handbook.loaded_span import LoadedSpan
from ropeway.systems.studies.handbook.payload_methods import Method, chord_moment_balance, modified_moment_balance

_A_LOW, _A_HIGH = 50.0, 2000.0


class Belly(NamedTuple):
    """Result of Appendix 5: catenary parameter a [m], length s [m] and moment arm e [m] of the piece."""

    parameter: float
    length: float
    arm: float
    iterations: int


class LinkSum(NamedTuple):
    """Harvey's rigid-link sums: gross load, tension of the lower link, weights of the links."""

    gross: Array
    tension_lower: Array
    weight_upper: Array
    weight_lower: Array


def belly(run: float, drop: float, *, tolerance: float = 1e-4) -> Belly:
    """Appendix 5: bisection for the catenary that is level at the carriage, a(cosh(d/a) - 1) = v.

    Physically wrong: it implies H = 410 to 3483 kgf where the rope has 18,000. The function returns the upper end of
    the bracket, as his code does. His listing's tolerance of 0.001 m on the height gives his 1000.96 m (true 1000.83),
    but 117.94 and 335.81 m; his other numbers, 204.04, 148.35, 335.80 and 117.93 m, need 0.0001. Raises InputError
    where his code would not terminate.
    """
    if not _has_belly(run, drop):
        raise InputError(
            f"A piece {run} m long and {drop} m high has no catenary parameter in {_A_LOW:g} to {_A_HIGH:g} m",
            "Harvey's program does not terminate; use kendrick_iteration",
        )
    low, high, count, v_low = _A_LOW, _A_HIGH, 0, np.inf
    while abs(drop - v_low) >= tolerance and low < (middle := 0.5 * (low + high)) < high:
        v_low = _belly_drop(low, run)
        if _belly_drop(middle, run) > drop:
            low = middle
        else:
            high = middle
        count += 1
    s = high * np.sinh(run / high)
    arm = 0.5 * run - drop / s * (high - 0.5 * run / np.tanh(run / (2.0 * high)))
    return Belly(high, float(s), float(arm), count)


def simplified_moment_balance(line: LoadedSpan, weight: Numbers, tension: Numbers) -> Array:
    """App. 4.1: the chord rounded to whole metres, and 202 m for 203.961 m at a slope of 20 %."""
    rounded = np.round(line.chord)
    misprint = (np.abs(np.asarray(line.chord_slope) - 0.2) < 1e-12) & (np.asarray(line.span) == 200.0)
    return chord_moment_balance(line, weight, tension, np.where(misprint, 202.0, rounded))


def modified_moment_balance_printed(line: LoadedSpan, weight: Numbers, tension: Numbers) -> Array:
    """Eq. 31 and App. 4.2 with the coefficient 3/16 instead of 1/8."""
    return modified_moment_balance(line, weight, tension, coefficient=3.0 / 16.0)


def rigid_link_sum(line: LoadedSpan, weight: Numbers, tension: Numbers) -> LinkSum:
    """App. 4.3: T1 and T2 along the links, the whole weight of both taken off, T2 = T1 - (L2/h2)(R1 - R2).

    The lower link cancels: P = T1 (sin1 + sin2) - 2 R1 - C.
    """
    upper = np.hypot(line.run_upper, line.drop_upper)
    lower = np.hypot(line.run_lower, line.drop_lower)
    return _sum(line, tension, weight * upper, weight * lower)


def rigid_link_sums(line: LoadedSpan, weight: Numbers, tension: Numbers) -> Array:
    """Gross load of `rigid_link_sum`: 2.5 to 3.8 % low on his profiles."""
    return rigid_link_sum(line, weight, tension).gross


def improved_rigid_link_sum(line: LoadedSpan, weight: Numbers, tension: Numbers) -> LinkSum:
    """App. 4.5: the sums of App. 4.3 with the weights of `belly`, R1 - R2 in the order that his numbers have.
    NaN where a piece has no belly."""
    upper = _belly_length(line.run_upper, line.drop_upper)
    lower = _belly_length(line.run_lower, line.drop_lower)
    return _sum(line, tension, weight * upper, weight * lower)


def improved_rigid_link_sums(line: LoadedSpan, weight: Numbers, tension: Numbers) -> Array:
    """Gross load of `improved_rigid_link_sum`: 2.6 to 3.8 % low on his profiles. NaN without a belly."""
    return improved_rigid_link_sum(line, weight, tension).gross


READINGS: Mapping[float, Readings] = MappingProxyType(
    {
        0.0: Readings(1.2, 2.1, 0.0235, 18700.0),
        0.1: Readings(1.23, 2.0, 0.025, 18740.0),
        0.2: Readings(1.27, 2.0, 0.026, 18720.0),
    }
)
"""App. 4.6: his readings of the nomographs, by chord slope; remaining tension in kgf."""


def lira(line: LoadedSpan, weight: Numbers, tension: Numbers) -> Array:
    """App. 4.6: the worksheet with his readings. NaN for any slope but his three, or another deflection than
    12.5 % at mid-span."""
    gross = np.full(np.broadcast(line.span, line.deflection, line.chord_slope, line.carriage, tension).shape, np.nan)
    his = (np.abs(np.asarray(line.deflection) / line.span - 0.125) < 1e-12) & (np.asarray(line.carriage) == 0.5)
    for slope, readings in READINGS.items():
        value = lira_worksheet(line, weight, tension, readings=readings).gross
        gross = np.where(his & (np.abs(np.asarray(line.chord_slope) - slope) < 1e-12), value, gross)
    return gross


class Printed(NamedTuple):
    """A row of Table 2: payloads [kg] at chord slopes of 0, 10 and 20 %, the method as printed, its erratum."""

    payloads: tuple[float, float, float]
    method: Method
    erratum: str


SLOPES = (0.0, 0.1, 0.2)
"""Chord slopes of Table 2."""

TABLE_2: Mapping[str, Printed] = MappingProxyType(
    {
        "simplified moment balance": Printed(
            (9302.0, 9252.0, 9201.0),
            simplified_moment_balance,
            "chord rounded to 200 and 201 m, and 202 m for 203.961 m at 20 % (9104.80); T acts along the chord",
        ),
        "modified moment balance": Printed(
            (8820.0, 8547.0, 8214.0),
            modified_moment_balance_printed,
            "coefficient 3/16 for 1/8: the rope counts one and a half times; 8820 is 8819.33",
        ),
        "Harvey's rigid link": Printed(
            (8640.0, 8495.0, 8109.0),
            rigid_link_sums,
            "tension along the links at the supports and the whole weight taken off; T2 rule without statics "
            "(T_upper - T_lower = w dh)",
        ),
        "Harvey's improved rigid link": Printed(
            (8633.0, 8482.0, 8089.0),
            improved_rigid_link_sums,
            "as the rigid link, and the rope level at the carriage; R2 = 348.85 for 348.58, T2 = 18735 for 18746",
        ),
        "LIRA worksheet": Printed(
            (8786.0, 9222.0, 9208.0),
            lira,
            "factor read as 2.1, 2.0, 2.0 for 2.062, 2.119, 2.193: the rise with slope is a misreading",
        ),
    }
)
"""Harvey's Table 2. Rows called "Harvey's ..." exist as printed only."""


def _sum(line: LoadedSpan, tension: Numbers, weight_upper: Array, weight_lower: Array) -> LinkSum:
    upper = np.hypot(line.run_upper, line.drop_upper)
    lower = np.hypot(line.run_lower, line.drop_lower)
    with np.errstate(divide="ignore", invalid="ignore"):
        tension_lower = tension - lower / line.drop_lower * (weight_upper - weight_lower)
        lift = tension * line.drop_upper / upper + tension_lower * line.drop_lower / lower
    return LinkSum(np.asarray(lift - weight_upper - weight_lower), tension_lower, weight_upper, weight_lower)


def _belly_drop(a: float, run: float) -> float:
    return float(a * np.cosh(run / a) - a)


def _has_belly(run: float, drop: float) -> bool:
    return _belly_drop(_A_HIGH, run) < drop < _belly_drop(_A_LOW, run)


def _belly_length(run: Array, drop: Array) -> Array:
    d, h = np.broadcast_arrays(run, drop)
    values = [
        belly(float(a), float(b)).length if _has_belly(float(a), float(b)) else np.nan
        for a, b in zip(d.flat, h.flat, strict=True)
    ]
    return np.array(values).reshape(d.shape)
