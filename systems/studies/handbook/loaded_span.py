"""The geometry that every payload method starts from: one span with a carriage somewhere in it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ropeway.components.argument_checks import checked
from ropeway.components.errors import InputError
from ropeway.systems.studies.handbook.array_checks import alike, require
from ropeway.systems.studies.handbook.array_roots import Array, Numbers


@checked
@dataclass(frozen=True, eq=False, slots=True)
class LoadedSpan:
    """A span with its carriage; numbers, or arrays that broadcast.

    Parameters
    ----------
    span : float or array
        Horizontal distance of the supports [m].
    deflection : float or array
        Vertical distance from the chord down to the carriage [m].
    chord_slope : float or array, default 0.0
        Fall of the chord over the span, from the upper support, where the tension is given, to the lower one: 0.2 for
        20 %, never negative.
    carriage : float or array, default 0.5
        Horizontal distance of the carriage from the upper support, as a share of the span.

    Raises
    ------
    InputError
        A value is out of its range, or arrays do not broadcast.

    Examples
    --------
    >>> float(LoadedSpan(200.0, 25.0, 0.1).drop_upper)
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
                "It falls from the upper support, where the tension is given: turn the span round "
                "(slope without its sign, carriage at 1 - carriage)",
            )
        require(self.chord_slope, "chord_slope", lambda v: v <= 5.0, "at most 5 (write 0.2 for 20 %)")
        require(self.carriage, "carriage, share of the span,", lambda v: (v > 0.0) & (v < 1.0), "between 0 and 1")

        alike(*self.parts)

    @property
    def parts(self) -> tuple[Numbers, ...]:
        """Its four numbers, or arrays."""
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
        """Height of the upper support over the carriage [m]."""
        return np.asarray(self.deflection + self.chord_slope * self.run_upper)

    @property
    def drop_lower(self) -> Array:
        """Height of the lower support over the carriage [m]; negative where the carriage is higher."""
        return np.asarray(self.deflection - self.chord_slope * self.run_lower)

    @property
    def chord(self) -> Array:
        """Straight distance of the supports [m]."""
        return np.asarray(self.span * np.hypot(1.0, self.chord_slope))
