"""The exact payload of a span: two catenaries joined at the carriage.

The tension at the upper support determines the upper piece. The lower piece has one free parameter, so the carriage
must supply a condition: equal horizontal tensions for a clamped carriage without other horizontal forces, equal
tensions for a rolling carriage with a mainline. Forces are in any consistent unit.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np

from ropeway.components.annotation_checks import PositiveNumbers
from ropeway.components.argument_checks import checked
from ropeway.components.catenary import Strain
from ropeway.components.errors import SlackRopeError
from ropeway.systems.studies.handbook.array_checks import require_broadcast
from ropeway.systems.studies.handbook.array_roots import Array, Numbers
from ropeway.systems.studies.handbook.elastic_piece import ElasticPiece
from ropeway.systems.studies.handbook.inextensible_catenary import length_between, taut_u, vertical_at
from ropeway.systems.studies.handbook.loaded_span import LoadedSpan

Joint = Literal["clamped", "rolling"]
"""Joint of carriage and skyline."""


class ExactLoad(NamedTuple):
    """The exact state of a loaded span.

    `gross` is the weight of payload and carriage; `pull` is the horizontal pull of the mainline on a rolling carriage
    towards the upper support; lengths [m] are unstretched.
    """

    gross: Array
    horizontal_upper: Array
    horizontal_lower: Array
    tension_lower_support: Array
    carriage_tension_upper: Array
    carriage_tension_lower: Array
    length_upper: Array
    length_lower: Array
    pull: Array


def catenary_clamped(line: LoadedSpan, weight: Numbers, tension: Numbers) -> Array:
    """Gross load for a tension at the upper support: inextensible catenaries with equal horizontal tension.

    Exact. NaN where the tension is too low for the rope's own weight.
    """
    return exact_state(line, weight, tension, "clamped").gross


def catenary_rolling(line: LoadedSpan, weight: Numbers, tension: Numbers) -> Array:
    """Gross load for a tension at the upper support: inextensible catenaries with equal tension at the carriage and a
    horizontal mainline. Exact. NaN where the tension is too low."""
    return exact_state(line, weight, tension, "rolling").gross


@checked
def exact_load(
    line: LoadedSpan, weight: PositiveNumbers, tension: PositiveNumbers, joint: Joint, *, pull_slope: Numbers = 0.0
) -> ExactLoad:
    """Find the exact state of an inextensible rope, in any consistent unit of force.

    Parameters
    ----------
    line : LoadedSpan
        The span with its carriage.
    weight : float or array
        Weight of the rope per metre.
    tension : float or array
        Tension at the upper support.
    joint : {"clamped", "rolling"}
        Joint of carriage and skyline: clamped with equal horizontal tensions, or rolling with equal tensions.
    pull_slope : float or array, default 0.0
        Slope (rise over run) of the mainline from a rolling carriage towards the upper support.

    Returns
    -------
    ExactLoad
        Gross load, tensions and lengths.

    Raises
    ------
    InputError
        A value is out of range, or arrays do not broadcast.
    SlackRopeError
        The tension is too low for the rope's own weight.

    Examples
    --------
    >>> round(float(rw.exact_load(rw.LoadedSpan(200.0, 25.0, 0.1), 34.0, 190e3, "clamped").gross))
    85864
    """
    require_broadcast(*line.parts, weight, tension, pull_slope)
    return _solved(exact_state(line, weight, tension, joint, pull_slope=pull_slope), tension)


@checked
def elastic_load(
    line: LoadedSpan,
    weight: PositiveNumbers,
    tension: PositiveNumbers,
    strain: Strain,
    joint: Joint,
    *,
    pull_slope: Numbers = 0.0,
) -> ExactLoad:
    """Find the exact state of an elastic rope, in any consistent unit of force.

    Parameters
    ----------
    line : LoadedSpan
        The span with its carriage.
    weight : float or array
        Weight of the rope per unstretched metre.
    tension : float or array
        Tension at the upper support.
    strain : Strain
        Coefficients of eps(T) = c1 T + c2 T^2 in the unit of force used (`Rope.strain` with N).
    joint : {"clamped", "rolling"}
        Joint of carriage and skyline: clamped with equal horizontal tensions, or rolling with equal tensions.
    pull_slope : float or array, default 0.0
        Slope (rise over run) of the mainline from a rolling carriage towards the upper support.

    Returns
    -------
    ExactLoad
        Gross load, tensions and lengths.

    Raises
    ------
    InputError
        A value is out of range, or arrays do not broadcast.
    SlackRopeError
        The tension is too low for the rope's own weight.

    Examples
    --------
    >>> rope = rw.Rope.named("RHOL-IWRC 29")
    >>> state = rw.elastic_load(rw.LoadedSpan(200.0, 25.0, 0.1), 34.0, 190e3, rope.strain, "clamped")
    >>> round(float(state.gross))
    85884
    """
    require_broadcast(*line.parts, weight, tension, pull_slope)
    return _solved(elastic_state(line, weight, tension, strain, joint, pull_slope=pull_slope), tension)


def _solved(state: ExactLoad, tension: Numbers) -> ExactLoad:
    """Returns the state. Raises SlackRopeError if none exists."""
    bad = np.isnan(state.gross)
    if bad.any():
        given = float(np.broadcast_to(tension, bad.shape)[bad].flat[0])
        raise SlackRopeError(
            f"A tension of {given:.6g} is too low for the rope's own weight",
            "Raise the tension, or reduce the deflection",
        )
    return state


def exact_state(
    line: LoadedSpan, weight: Numbers, tension: Numbers, joint: Joint, *, pull_slope: Numbers = 0.0
) -> ExactLoad:
    """As `exact_load`, with NaN where the tension is too low for the rope's own weight."""
    w, t = np.asarray(weight, dtype=float), np.asarray(tension, dtype=float)
    d1, h1, d2, h2 = line.run_upper, line.drop_upper, line.run_lower, line.drop_lower
    u1 = taut_u(d1, h1, t, w)
    horizontal = w * d1 / (2.0 * u1)
    # Along a load-free piece T_upper - T_lower = w dh: a rolling carriage transmits the tension.
    u2 = taut_u(d2, h2, t + w * (h2 - h1), w) if joint == "rolling" else w * d2 / (2.0 * horizontal)
    horizontal_lower = w * d2 / (2.0 * u2)
    s1, s2 = length_between(u1, d1, h1), length_between(u2, d2, h2)
    lift = (vertical_at(u1, d1, h1, w) - w * s1) + (vertical_at(u2, d2, h2, w) - w * s2)
    end = np.hypot(horizontal_lower, vertical_at(u2, d2, h2, w))
    pull = horizontal_lower - horizontal
    return ExactLoad(
        lift + pull * pull_slope, horizontal, horizontal_lower, end, t - w * h1, end - w * h2, s1, s2, pull
    )


def elastic_state(
    line: LoadedSpan,
    weight: Numbers,
    tension: Numbers,
    strain: Strain,
    joint: Joint,
    *,
    pull_slope: Numbers = 0.0,
) -> ExactLoad:
    """As `elastic_load`, with NaN where the tension is too low for the rope's own weight."""
    w = np.asarray(weight, dtype=float)
    stiff = exact_state(line, weight, tension, joint)
    d1, h1, d2, h2 = line.run_upper, line.drop_upper, line.run_lower, line.drop_lower
    upper = ElasticPiece.between(d1, -h1, w, strain, stiff.horizontal_upper, stiff.length_upper).solve(tension=tension)
    at_carriage = upper.end_tension
    lower = ElasticPiece.between(d2, h2, w, strain, stiff.horizontal_lower, stiff.length_lower)
    lower = lower.solve(tension=at_carriage) if joint == "rolling" else lower.solve(horizontal=upper.horizontal)
    pull = lower.horizontal - upper.horizontal
    gross = lower.vertical - (upper.vertical + w * upper.length) + pull * pull_slope
    return ExactLoad(
        gross,
        upper.horizontal,
        lower.horizontal,
        lower.end_tension,
        at_carriage,
        np.hypot(lower.horizontal, lower.vertical),
        upper.length,
        lower.length,
        pull,
    )
