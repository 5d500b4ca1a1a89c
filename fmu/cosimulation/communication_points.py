"""Communication points of a run: of fixed or controlled steps, and at jumps of what drives the slaves."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from ropeway.components import check
from ropeway.components.errors import InputError
from ropeway.fmu.cosimulation.coupling import Coupling, Driving, Scheme, Span
from ropeway.fmu.cosimulation.input_signals import next_break
from ropeway.fmu.cosimulation.step_control import StepControl, Stepper
from ropeway.fmu.importing.participant import OpenFmu


def is_multiple(length: float, step: float) -> bool:
    """Whether a length is a whole number of steps."""
    count = length / step
    return round(count) >= 1 and abs(count - round(count)) < 1e-6


def multiple(name: str, step: float | None, master: float) -> float | None:
    """The step of a slow slave, None if it takes that of the master [s]. Raises InputError if it is no multiple."""
    if step is None:
        return None
    check.positive(step, f"Slave {name!r}", "step", "s")
    if not is_multiple(step, master):
        raise InputError(
            f"Slave {name!r} has steps of {step:g} s, which is no multiple of {master:g} s",
            "Give the master the shortest step",
        )
    return step if step > 1.5 * master else None


def require_steps(
    slaves: Mapping[str, OpenFmu], span: Span, slow: Mapping[str, float], scheme: Scheme, control: StepControl | None
) -> None:
    """Raises InputError if a slave does not accept the steps of a run; `slow`: steps of slow slaves [s]."""
    for name, slave in slaves.items():
        if scheme.iterated and not slave.can_restore:
            raise InputError(
                f"{name!r} cannot restore its state, so its steps cannot be repeated",
                'Use iterated=False, or add it with kind="ModelExchange"',
            )
        if slave.varies_steps:
            continue
        if control is not None:
            raise InputError(f"{name!r} accepts steps of one length only", "Leave out the step control")
        step = slow.get(name, span.step)
        if not is_multiple(span.until - span.start, step):
            raise InputError(
                f"{name!r} accepts steps of one length only, and {span.until - span.start:g} s are no whole number of "
                f"steps of {step:g} s",
                "Choose another step, or another end of the run",
            )


def points(coupling: Coupling, stepper: Stepper | None, driving: Driving, span: Span) -> Iterator[float]:
    """Advances the slaves; yields the time of each point, up to the end or to where an FMU ends the run.

    Raises FmuRunError.
    """
    breaks, number = driving.breaks, 0
    cuts = all(slave.varies_steps for slave in coupling.slaves.values())
    while coupling.time < span.until - 1e-9 * span.step and coupling.ended is None:
        number += 1
        if stepper is not None:
            stepper.step(coupling.time, next_break(breaks, coupling.time, span.until))
        else:
            end = span.point(number)
            while coupling.ended is None and coupling.time < end - 1e-9 * span.step:
                stop = next_break(breaks, coupling.time, end) if cuts else end
                coupling.step(stop - coupling.time)
                if coupling.ended is None:
                    coupling.time = stop
        if not coupling.aligned:
            return
        yield coupling.time
