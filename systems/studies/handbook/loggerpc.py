"""LoggerPC's working assumptions, by name, with their limits.

Brown et al. (1997), LOGGERPC 3.2 User's Manual, in Harvey (2013), section 2.2.10.1; also SkylineXL and CHPS.
The assumptions:

- Cable segments are straight and pin-connected, with the centre of gravity of a catenary: the improved rigid
  link (`payload_methods.improved_rigid_link`).
- Standing and live skylines: the mainline or the haulback is tensioned, never both; running skylines: both.
  A slack line exerts only its weight on the carriage.
- The log follows the path of the carriage, also downhill; it does not slide freely.

One of these can change a payload more than the choice of the tension method.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ropeway.components.errors import InputError
from ropeway.components.rope import Rope
from ropeway.components.terrain import Profile
from ropeway.systems.studies.handbook.array_checks import require
from ropeway.systems.studies.handbook.array_roots import Array, Numbers

POUND_FORCE = 4.4482216152605
"""[N]."""

AXIAL_STIFFNESS = 3.5e6 * POUND_FORCE
"""AE of every rope, 3,500,000 lbf in N. It is correct for a rope of 1.56 kg/m (19 mm); a 28.6 mm rope has 34.8 MN, 2.2
times as much. On Harvey's profiles elasticity changes the payload of that rope by 2.1 kg of 9000, with this value by
4.6 kg."""

LOG_FRICTION = 0.9
"""Friction coefficient of a dragged log on slopes up to 90 %."""

STEEPEST_LOG_SLOPE = 1.10
"""Largest slope at which the log's drag is considered reasonable."""

HAULBACK_FRICTION = 0.5
"""Drag of the haulback, relative to its weight."""

HAULBACK_CHORD_SLOPE = 0.20
"""Chord slope below which uphill yarding needs a haulback."""


def lower_tension(tension_upper: Numbers, weight: Numbers, height: Numbers) -> Array:
    """Tension [N] at the lower end of a segment, its upper end `height` [m] higher: T_upper - w dh, weight [N/m].

    Exact for an inextensible catenary; for an elastic one T + T^2/(2 EA) changes by w dh, so the rule has a relative
    error of T/EA in w dh, about 0.1 %. Raises InputError for a result that is not positive.
    """
    require(height, "height [m]", lambda v: v >= 0.0, "zero or more, from the lower end up")
    tension = np.asarray(tension_upper - np.asarray(weight) * height)
    require(tension, "tension at the lower end [N]", lambda v: v > 0.0, "above zero: raise the upper tension")
    return tension


def log_friction(slope: Numbers) -> Array:
    """Friction coefficient of a dragged log on a ground slope (rise over run): 0.9, or the slope itself above 0.9, so
    that the log never slides freely. Raises InputError above 110 %."""
    require(
        slope,
        "ground slope",
        lambda v: v <= STEEPEST_LOG_SLOPE,
        f"at most {STEEPEST_LOG_SLOPE:g}, the limit of the method",
    )
    return np.maximum(LOG_FRICTION, slope)


def log_slope(stations: ArrayLike, elevations: ArrayLike, carriage: float, *, log_run: float = 0.0) -> float:
    """Ground slope below a dragged log: from the terrain point before the carriage to the one below it.

    `stations` [m] increase in the direction of yarding; `carriage` is its station [m]; `log_run` is the horizontal part
    of the log's drag [m]. The point below the carriage is the last one at or before it. Raises InputError without an
    earlier point, or if `log_run` is longer than that step: LoggerPC is inaccurate there.
    """
    ground = Profile(stations, elevations)
    x, z = ground.station, ground.elevation
    k = int(np.searchsorted(x, carriage, side="right")) - 1
    if k < 1 or carriage > x[-1]:
        raise InputError(
            f"The carriage at station {carriage} m has no terrain point before it",
            "Extend the profile, or move the carriage",
        )
    step = float(x[k] - x[k - 1])
    if log_run > step:
        raise InputError(
            f"The log reaches {log_run} m back, more than the terrain step of {step:.6g} m",
            "Give terrain points farther apart than the length of the log",
        )
    return float((z[k] - z[k - 1]) / step)


def haulback_needed(chord_slope: Numbers, *, downhill: bool) -> np.ndarray:
    """Whether a haulback is needed: always for downhill yarding, uphill on chords below 20 %.

    `chord_slope` is rise over run without sign. Harvey's program tests "below -20 %", so it never asks for a haulback.
    Raises InputError for a negative slope.
    """
    require(chord_slope, "chord_slope", lambda v: v >= 0.0, "zero or more; give downhill=True for downhill yarding")
    return np.asarray(downhill | (np.asarray(chord_slope) < HAULBACK_CHORD_SLOPE))


def haulback_drag(span: Numbers, weight: Numbers) -> Array:
    """Horizontal drag [N] of the haulback on the carriage: half its weight over the horizontal span [m], with weight in
    N/m. It ignores the height between the spars, so it is too low on steep spans."""
    require(span, "span [m]", lambda v: v > 0.0, "above zero")
    return np.asarray(HAULBACK_FRICTION * np.asarray(span) * weight)


def stiffness_ratio(rope: Rope) -> float:
    """Ratio of LoggerPC's stretch of a rope to its actual stretch: its axial stiffness over `AXIAL_STIFFNESS`."""
    return rope.axial_stiffness / AXIAL_STIFFNESS
