"""Geometry of the payload methods: one span with a carriage at any station."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ropeway.components.argument_checks import checked
from ropeway.components.errors import InputError
from ropeway.systems.studies.handbook.array_checks import require, require_broadcast
from ropeway.systems.studies.handbook.array_roots import Array, Numbers


@checked
@dataclass(frozen=True, eq=False, slots=True)
class LoadedSpan:
    """A span with its carriage. Values are numbers, or arrays that broadcast.

    Parameters
    ----------
    span : float or array
        Horizontal distance between the supports [m].
    deflection : float or array
        Vertical distance from the chord down to the carriage [m].
    chord_slope : float or array, default 0.0
        Slope of the chord down from the upper support, where the tension is given: 0.2 for 20 %, never negative.
    carriage : float or array, default 0.5
        Horizontal distance of the carriage from the upper support, as a share of the span.

    Raises
    ------
    InputError
        A value is out of range, or arrays do not broadcast.

    Examples
    --------
    >>> float(rw.LoadedSpan(200.0, 25.0, 0.1).drop_upper)
    35.0
    """

    span: Numbers
    deflection: Numbers
    chord_slope: Numbers = 0.0
    carriage: Numbers = 0.5

    def __post_init__(self) -> None:
        for field in ("span", "deflection", "chord_slope", "carriage"):
            object.__setattr__(self, field, np.asarray(getattr(self, field), dtype=float))
        require(self.span, "span [m]", lambda v: v > 0.0, "above zero")
        require(self.deflection, "deflection [m]", lambda v: v > 0.0, "above zero")
        if np.any(np.asarray(self.chord_slope) < 0.0):
            raise InputError(
                f"chord_slope is {self.chord_slope!r}",
                "It counts down from the upper support, where the tension is given: mirror the span "
                "(slope without sign, carriage at 1 - carriage)",
            )
        require(self.chord_slope, "chord_slope", lambda v: v <= 5.0, "at most 5 (write 0.2 for 20 %)")
        require(self.carriage, "carriage, share of the span,", lambda v: (v > 0.0) & (v < 1.0), "between 0 and 1")

        require_broadcast(*self.parts)

    @property
    def parts(self) -> tuple[Numbers, ...]:
        """Its four values."""
        return self.span, self.deflection, self.chord_slope, self.carriage

    @property
    def run_upper(self) -> Array:
        """Horizontal distance from the upper support to the carriage [m]."""
        return np.asarray(self.carriage * self.span)

    @property
    def run_lower(self) -> Array:
        """Horizontal distance from the carriage to the lower support [m]."""
        return np.asarray((1.0 - self.carriage) * self.span)

    @property
    def drop_upper(self) -> Array:
        """Height of the upper support above the carriage [m]."""
        return np.asarray(self.deflection + self.chord_slope * self.run_upper)

    @property
    def drop_lower(self) -> Array:
        """Height of the lower support above the carriage [m]; negative where the carriage is higher."""
        return np.asarray(self.deflection - self.chord_slope * self.run_lower)

    @property
    def chord(self) -> Array:
        """Straight distance between the supports [m]."""
        return np.asarray(self.span * np.hypot(1.0, self.chord_slope))
