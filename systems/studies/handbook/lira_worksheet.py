"""The LIRA handbook's single-span skyline worksheet, with computed values in place of its nomographs.

New Zealand Cable Logging Handbook (LIRA 1983, Figure 5.20) in Harvey (2013), App. 4.6. The nomographs are not in
the sources. Fig. A.1 and A.2/A.3 are computed exactly; Fig. A.4 to A.17 depend on the handbook's unknown modulus; they
use the rope's own stiffness here (Harvey's readings imply EA = 4.9, 4.0 and 3.7e7 N).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ropeway.components.annotation_checks import PositiveNumbers
from ropeway.components.argument_checks import checked
from ropeway.components.catenary import Strain
from ropeway.components.errors import SlackRopeError
from ropeway.systems.studies.handbook.array_checks import require_broadcast
from ropeway.systems.studies.handbook.array_roots import Array, Numbers
from ropeway.systems.studies.handbook.elastic_piece import ElasticPiece
from ropeway.systems.studies.handbook.inextensible_catenary import catenary_for_length
from ropeway.systems.studies.handbook.loaded_span import LoadedSpan
from ropeway.systems.studies.handbook.payload_exact import elastic_state
from ropeway.systems.studies.handbook.payload_methods import cable_factor, load_factor


class Readings(NamedTuple):
    """A user's readings from the nomographs.

    Fig. A.1, Fig. A.2/A.3, Fig. A.4-A.17 (share of the span), and the remaining tension as rounded for the load factor.
    """

    cable_factor: float
    tension_per_load: float
    deflection_change: float
    remaining: float


class Worksheet(NamedTuple):
    """The worksheet's boxes: forces in the unit used, deflection as a share of the span."""

    cable_factor: Array
    cable_tension: Array
    remaining: Array
    tension_per_load: Array
    gross: Array
    payload: Array
    load_factor: Array
    unloaded_deflection: Array
    unloaded_tension: Array


@checked
def lira_worksheet(
    line: LoadedSpan,
    weight: PositiveNumbers,
    tension: PositiveNumbers,
    *,
    carriage_weight: Numbers = 0.0,
    strain: Strain | None = None,
    readings: Readings | None = None,
) -> Worksheet:
    """Fill in the worksheet for one or many spans, in any consistent unit of force.

    The error of the payload is about -0.07 % (superposition). Harvey's last box reads Fig. A.1 at the loaded
    deflection; here it uses the unloaded one, as the worksheet requires.

    Parameters
    ----------
    line : LoadedSpan
        The span with its carriage.
    weight : float or array
        Weight of the rope per metre.
    tension : float or array
        Tension at the upper support, the safe working load.
    carriage_weight : float or array, default 0.0
        Weight of the carriage, subtracted from the gross load.
    strain : Strain, optional
        Strain of the rope, for the unloaded deflection; None for an inextensible rope.
    readings : Readings, optional
        Readings from the nomographs, instead of computed values.

    Returns
    -------
    Worksheet
        The boxes of the worksheet.

    Raises
    ------
    InputError
        A value is out of range, or arrays do not broadcast.
    SlackRopeError
        The tension is too low for the rope's own weight.

    Examples
    --------
    >>> sheet = rw.lira_worksheet(rw.LoadedSpan(200.0, 25.0, 0.1), weight=34.0, tension=190e3)
    >>> round(float(sheet.gross))
    85801
    """
    require_broadcast(*line.parts, weight, tension, carriage_weight)
    if readings is None:
        one, per_load = cable_factor(line), load_factor(line)
    else:
        one, per_load = np.asarray(readings.cable_factor), np.asarray(readings.tension_per_load)
    own = one * np.asarray(weight) * line.span
    remaining = tension - own
    gross = remaining / per_load
    ratio = (remaining if readings is None else readings.remaining) / (one * weight)
    if readings is None:
        deflection = unloaded_deflection(line, weight, tension, strain or Strain(0.0, 0.0))
    else:
        deflection = np.asarray(line.deflection) / line.span - readings.deflection_change
    bare = LoadedSpan(line.span, deflection * line.span, line.chord_slope)
    unloaded = cable_factor(bare) * np.asarray(weight) * line.span
    return Worksheet(one, own, remaining, per_load, gross, gross - carriage_weight, ratio, deflection, unloaded)


def unloaded_deflection(line: LoadedSpan, weight: Numbers, tension: Numbers, strain: Strain) -> Array:
    """Mid-span deflection of the bare rope as a share of the span, after the load of a clamped carriage is removed.
    `tension` is that at the upper support under load. Exact. Raises SlackRopeError."""
    loaded = elastic_state(line, weight, tension, strain, "clamped")
    length = loaded.length_upper + loaded.length_lower
    if np.isnan(length).any():
        raise SlackRopeError("The tension is too low for the rope's own weight", "Raise the tension")
    span, w = np.asarray(line.span, dtype=float), np.asarray(weight, dtype=float)
    rise = -np.asarray(line.chord_slope) * span
    # An elastic rope may be shorter than its chord: the initial guess is slightly longer.
    start = catenary_for_length(span, rise, np.maximum(length, 1.0001 * line.chord))
    bare = ElasticPiece.between(span, rise, w, strain, w * np.asarray(start.parameter), length)
    return np.asarray(bare._replace(length=length).solve(length=length).sag(0.5) / span)
