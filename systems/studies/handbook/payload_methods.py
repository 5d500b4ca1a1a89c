"""The named payload methods of practice, corrected, with one common signature.

Each method is a function `method(line, weight, tension)`. It returns the gross load (payload and carriage) of a span
for a tension at its upper support and a weight per metre of rope. Arguments are numbers or arrays in any consistent
unit of force. The result is NaN where the tension is too low for the rope's own weight. `payload_for_tension` and
`tension_for_payload` apply a method to a rope, in kg and N, and raise an error instead.

The carriage may be at any station of the span. The sources have it at mid-span; the general forms follow from the same
balance. "Clamped" means equal horizontal tension on both sides of the carriage. Stated errors are relative to the exact
clamped payload on Harvey's three profiles (2013, App. 4: span 200 m, deflection 12.5 %, chord slope 0, 10, 20 %), see
docs/methods.md for more.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np

from ropeway.components.annotation_checks import Positive
from ropeway.components.argument_checks import checked
from ropeway.components.errors import SlackRopeError
from ropeway.components.rope import Rope, rope_of
from ropeway.systems.modelling.system import GRAVITY
from ropeway.systems.studies.handbook.array_checks import require, require_broadcast
from ropeway.systems.studies.handbook.array_roots import Array, Numbers, rising
from ropeway.systems.studies.handbook.inextensible_catenary import catenary_for_sag, minimum_tension
from ropeway.systems.studies.handbook.kendrick import Weighed, kendrick_iteration, weighed
from ropeway.systems.studies.handbook.loaded_span import LoadedSpan
from ropeway.systems.studies.handbook.payload_exact import catenary_clamped, catenary_rolling

Method = Callable[[LoadedSpan, Numbers, Numbers], Array]
"""A payload method: gross load of a span for a weight per metre and a tension at its upper support."""


def weightless(line: LoadedSpan, weight: Numbers, tension: Numbers) -> Array:
    """Weightless straight links (Harvey eq. 1; Sessions). Error +4.2, +4.5, +4.8 %."""
    nothing = Weighed(np.zeros(np.shape(weight)), 0.0)
    return _clamped(line, tension, nothing, nothing)


def parabolic(line: LoadedSpan, weight: Numbers, tension: Numbers) -> Array:
    """Links with weight w times their horizontal run (Harvey eq. 2; Sessions), for taut, flat ropes. Error
    +0.12, +0.16, +0.24 %."""
    return _clamped(
        line,
        tension,
        Weighed(weight * line.run_upper, line.run_upper / 2.0),
        Weighed(weight * line.run_lower, line.run_lower / 2.0),
    )


def rigid_link(line: LoadedSpan, weight: Numbers, tension: Numbers) -> Array:
    """Straight heavy links (Hartsough & Miles 1987; Harvey eq. 3-9). Error -0.003 %.

    Harvey's own sums (`harvey_as_printed.rigid_link_sums`) are 2.5 to 3.8 % low: his tension acts along the chord, and
    he still subtracts the whole weight.
    """
    return _clamped(line, tension, *_straight(line, weight))


def rigid_link_rolling(line: LoadedSpan, weight: Numbers, tension: Numbers) -> Array:
    """Straight heavy links with LoggerPC's rule T_upper - T_lower = w dh and a horizontal mainline. Error -0.003 %,
    relative to the exact rolling payload."""
    upper, lower = _straight(line, weight)
    at_lower_support = tension + np.asarray(weight) * (line.drop_lower - line.drop_upper)
    return _gross(
        line,
        link_horizontal(line.run_upper, line.drop_upper, upper, tension),
        link_horizontal(line.run_lower, line.drop_lower, lower, at_lower_support),
        upper,
        lower,
    )


def improved_rigid_link(line: LoadedSpan, weight: Numbers, tension: Numbers) -> Array:
    """Sessions' improved rigid link, as in LoggerPC: H from the straight link, then weight and centroid of the
    catenary (Harvey eq. 10-14 with eq. 13 for the upper node, [w d/(2T)]^2). Error below 0.003 %."""
    upper, _ = _straight(line, weight)
    h = link_horizontal(line.run_upper, line.drop_upper, upper, tension)
    return _gross(line, h, h, *_catenaries(line, weight, h))


def kendrick(line: LoadedSpan, weight: Numbers, tension: Numbers) -> Array:
    """Kendrick's improved rigid link, iterated (Harvey eq. 15-24 with r = R). Exact for all tensions above the minimum;
    equal to `catenary_clamped`."""
    h = kendrick_iteration(line.run_upper, line.drop_upper, weight, tension).horizontal
    return _gross(line, h, h, *_catenaries(line, weight, h))


def simplified_moment_balance(line: LoadedSpan, weight: Numbers, tension: Numbers) -> Array:
    """Moments of the whole span about the carriage, with T along the chord (Visser 1998; Harvey eq. 28-30 with the true
    chord length; he has 202 m for 203.961 m). Error +3.6, +6.2, +8.6 %."""
    return chord_moment_balance(line, weight, tension, line.chord)


def chord_moment_balance(line: LoadedSpan, weight: Numbers, tension: Numbers, chord: Numbers) -> Array:
    """The simplified moment balance for a given chord length l_d [m]."""
    horizontal = np.asarray(tension) * line.span / chord
    return np.asarray(horizontal * line.deflection / _lever(line) - weight * np.asarray(chord) / 2.0)


def modified_moment_balance(
    line: LoadedSpan, weight: Numbers, tension: Numbers, *, coefficient: float = 1.0 / 8.0
) -> Array:
    """Harvey's moment balance with the slope of the upper link (his eq. 31, corrected):
    T = Q l/(4 y cos) + q l^2/(8 y cos^2). Error +0.24, +0.23, +0.23 %; with his coefficient 3/16, which counts the rope
    one and a half times, -1.75, -1.88, -2.05 %."""
    cosine = line.run_upper / np.hypot(line.run_upper, line.drop_upper)
    rope = 4.0 * coefficient * weight * np.asarray(line.span) / cosine
    return np.asarray(np.asarray(tension) * cosine * line.deflection / _lever(line) - rope)


def lira(line: LoadedSpan, weight: Numbers, tension: Numbers) -> Array:
    """The LIRA handbook's superposition with computed nomograph factors (1983, in Harvey App. 4.6;
    the nomographs are not in the sources). Error -0.07 %."""
    rope = cable_factor(line) * np.asarray(weight) * line.span
    return np.asarray((tension - rope) / load_factor(line))


def cable_factor(line: LoadedSpan) -> Array:
    """LIRA's Fig. A.1: tension at the upper support of a bare rope through the carriage's position, over weight times
    span."""
    bare = catenary_for_sag(line.span, -np.asarray(line.chord_slope) * line.span, line.deflection, line.carriage)
    return np.asarray(bare.forces(1.0).tension_start / line.span)


def load_factor(line: LoadedSpan) -> Array:
    """LIRA's Fig. A.2 and A.3: tension at the upper support per load, for a weightless rope."""
    upper, lower = line.drop_upper / line.run_upper, line.drop_lower / line.run_lower
    return np.asarray(np.hypot(1.0, upper) / (upper + lower))


METHODS: Mapping[str, Method] = MappingProxyType(
    {
        "weightless": weightless,
        "parabolic": parabolic,
        "rigid link": rigid_link,
        "rigid link, rolling": rigid_link_rolling,
        "improved rigid link": improved_rigid_link,
        "Kendrick's iteration": kendrick,
        "simplified moment balance": simplified_moment_balance,
        "modified moment balance": modified_moment_balance,
        "LIRA worksheet": lira,
        "catenary, clamped": catenary_clamped,
        "catenary, rolling": catenary_rolling,
    }
)
"""All methods by name."""


@checked
def payload_for_tension(
    method: Method,
    line: LoadedSpan,
    rope: Rope | str,
    tension: Numbers,
    *,
    carriage_mass: Numbers = 0.0,
    gravity: Positive = GRAVITY,
) -> Array:
    """Find the payload for a tension at the upper support by one of the methods.

    Parameters
    ----------
    method : callable
        One of `METHODS`, as `METHODS["rigid link"]`.
    line : LoadedSpan
        The span with its carriage.
    rope : Rope or str
        A rope, or a name from `rw.ropes()`.
    tension : float or array
        Tension at the upper support [N].
    carriage_mass : float or array, default 0.0
        Mass of the carriage [kg].
    gravity : float, default 9.80665
        Gravitational acceleration [m/s2].

    Returns
    -------
    array
        Payload [kg]; negative where the rope cannot support the carriage alone.

    Raises
    ------
    InputError
        A value is out of range, or arrays do not broadcast.
    SlackRopeError
        The tension is too low for the rope's own weight.

    Examples
    --------
    >>> from ropeway.systems.studies.handbook.payload_methods import METHODS
    >>> line, rope = rw.LoadedSpan(200.0, 25.0, 0.1), rw.Rope.named("RHOL-IWRC 29")
    >>> round(float(rw.payload_for_tension(METHODS["rigid link"], line, rope, 190e3)))
    8754
    """
    rope = rope_of(rope)
    require_broadcast(*line.parts, tension, carriage_mass)
    require(tension, "tension [N]", lambda v: v > 0.0, "above zero")
    require(carriage_mass, "carriage_mass [kg]", lambda v: v >= 0.0, "zero or more")
    weight = rope.mass_per_length * gravity
    gross = method(line, weight, tension)
    if np.isnan(gross).any():
        raise _too_little(line, weight, tension, np.isnan(gross))
    return np.asarray(gross / gravity - carriage_mass)


@checked
def tension_for_payload(
    method: Method,
    line: LoadedSpan,
    rope: Rope | str,
    payload: Numbers,
    *,
    carriage_mass: Numbers = 0.0,
    gravity: Positive = GRAVITY,
) -> Array:
    """Find the tension at the upper support of the taut rope for a payload by one of the methods.

    Parameters
    ----------
    method : callable
        One of `METHODS`, as `METHODS["rigid link"]`.
    line : LoadedSpan
        The span with its carriage.
    rope : Rope or str
        A rope, or a name from `rw.ropes()`.
    payload : float or array
        Payload [kg].
    carriage_mass : float or array, default 0.0
        Mass of the carriage [kg].
    gravity : float, default 9.80665
        Gravitational acceleration [m/s2].

    Returns
    -------
    array
        Tension at the upper support [N].

    Raises
    ------
    InputError
        A value is out of range, or arrays do not broadcast.
    SlackRopeError
        The payload is too low for a taut rope through the carriage's position.

    Examples
    --------
    >>> from ropeway.systems.studies.handbook.payload_methods import METHODS
    >>> line, rope = rw.LoadedSpan(200.0, 25.0, 0.1), rw.Rope.named("RHOL-IWRC 29")
    >>> round(float(rw.tension_for_payload(METHODS["rigid link"], line, rope, 8000.0)) / 1e3, 1)
    174.3
    """
    rope = rope_of(rope)
    require_broadcast(*line.parts, payload, carriage_mass)
    require(payload, "payload [kg]", lambda v: v >= 0.0, "zero or more")
    require(carriage_mass, "carriage_mass [kg]", lambda v: v >= 0.0, "zero or more")
    weight, gross = rope.mass_per_length * gravity, (np.asarray(payload) + carriage_mass) * gravity
    high = np.broadcast_to(gross + weight * (line.chord + line.deflection), np.broadcast(gross, line.drop_upper).shape)
    for _ in range(60):
        enough = method(line, weight, high) >= gross
        if enough.all():
            break
        high = np.where(enough, high, 2.0 * high)
    tension = rising(lambda t: method(line, weight, t) - gross, 1e-9 * high, high)
    if np.isnan(tension).any():
        raise SlackRopeError(
            "The payload is too low for a taut rope at this deflection",
            "Reduce the deflection or increase the payload",
        )
    return tension


def link_horizontal(run: Numbers, drop: Numbers, link: Weighed, tension: Numbers) -> Array:
    """Horizontal tension of a straight link for a tension at its end, with the carriage `drop` lower (Harvey eq. 5 and
    8, hence eq. 9; eq. 13 is the same). Moments about the carriage: V d = H h + R e. NaN where the tension is too low
    for the weight."""
    a, b = np.asarray(drop) / run, link.weight * link.arm / run
    with np.errstate(invalid="ignore"):
        return np.asarray((np.sqrt((1.0 + a * a) * np.square(tension) - b * b) - a * b) / (1.0 + a * a))


def _clamped(line: LoadedSpan, tension: Numbers, upper: Weighed, lower: Weighed) -> Array:
    h = link_horizontal(line.run_upper, line.drop_upper, upper, tension)
    return _gross(line, h, h, upper, lower)


def _gross(line: LoadedSpan, h_upper: Array, h_lower: Array, upper: Weighed, lower: Weighed) -> Array:
    """Vertical force of both links at the carriage: the sum of V - R."""
    d1, d2 = line.run_upper, line.run_lower
    upper_part = (h_upper * line.drop_upper + upper.weight * upper.arm) / d1 - upper.weight
    lower_part = (h_lower * line.drop_lower + lower.weight * lower.arm) / d2 - lower.weight
    return np.asarray(np.where(h_upper > 0.0, upper_part + lower_part, np.nan))


def _straight(line: LoadedSpan, weight: Numbers) -> tuple[Weighed, Weighed]:
    d1, d2 = line.run_upper, line.run_lower
    return (
        Weighed(weight * np.hypot(d1, line.drop_upper), d1 / 2.0),
        Weighed(weight * np.hypot(d2, line.drop_lower), d2 / 2.0),
    )


def _catenaries(line: LoadedSpan, weight: Numbers, horizontal: Array) -> tuple[Weighed, Weighed]:
    return (
        weighed(line.run_upper, line.drop_upper, weight, horizontal),
        weighed(line.run_lower, line.drop_lower, weight, horizontal),
    )


def _lever(line: LoadedSpan) -> Array:
    """Moment of a simple beam at the carriage under a unit load there [m]: l/4 at mid-span."""
    return line.run_upper * line.run_lower / np.asarray(line.span)


def _too_little(line: LoadedSpan, weight: float, tension: Numbers, bad: Array) -> SlackRopeError:
    run, drop, given, where = np.broadcast_arrays(line.run_upper, line.drop_upper, tension, bad)
    first = tuple(np.argwhere(where)[0])
    least = minimum_tension(float(run[first]), -float(drop[first]), weight)
    needs = (
        f"the piece from the upper support to the carriage alone needs {least:.6g} N"
        if given[first] < least
        else "the piece from the carriage to the lower support needs more"
    )
    return SlackRopeError(
        f"A tension of {given[first]:.6g} N is too low for the rope's own weight: {needs}",
        "Raise the tension, or reduce the deflection",
    )
