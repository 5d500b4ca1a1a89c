"""The stepper of a line: with inertia or without, in compiled code or not."""

from __future__ import annotations

from collections.abc import Sequence

from ropeway.systems.dynamics.event_stepper import EventStepper
from ropeway.systems.dynamics.inertia.compiled_inertial import CompiledInertialStepper
from ropeway.systems.dynamics.inertia.inertial_stepper import InertialStepper
from ropeway.systems.dynamics.line_stepper import Signal
from ropeway.systems.dynamics.recorder import Recorder
from ropeway.systems.statics.line_state import LineState


def stepper_of(
    state: LineState,
    signals: Sequence[Signal],
    tolerance: float,
    recorder: Recorder | None = None,
    *,
    compiled: bool = False,
) -> EventStepper | InertialStepper:
    """The stepper of a line, with or without inertia; compiled: it moves in the compiled core."""
    if state.model.inertia is not None:
        kind = CompiledInertialStepper if compiled else InertialStepper
        return kind(state, signals, tolerance, recorder)
    return EventStepper(state, signals, tolerance, recorder, compiled=compiled)
