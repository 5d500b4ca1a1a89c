"""What a run is given: the signals of its inputs, where it starts, what acts on it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ropeway.components import check
from ropeway.components.carriage import Carriage
from ropeway.components.errors import InputError, UnknownNameError
from ropeway.components.inertia import Inertia
from ropeway.components.node import Node
from ropeway.components.schedule import Schedule
from ropeway.components.span import Span
from ropeway.systems.dynamics.inertia.inertial_state import inertial_state
from ropeway.systems.dynamics.inertia.inertial_system import with_inertia
from ropeway.systems.dynamics.line_stepper import LineStepper, Signal
from ropeway.systems.modelling.dae_model import Model, component_of, nearest
from ropeway.systems.modelling.intervention import EMERGENCY_STOP, LOAD_LOST, STOP, SWITCHED, Intervention
from ropeway.systems.modelling.system import System
from ropeway.systems.solvers.compiled_line import compiled_line
from ropeway.systems.solvers.kernels.compiled_newton import require_kernels
from ropeway.systems.solvers.line_sections import line_sections
from ropeway.systems.statics.equilibrium import Equilibrium
from ropeway.systems.statics.line_state import LineState
from ropeway.systems.statics.warm_start import carried_over, declared_alike


def start_of(start: Equilibrium, model: Model, inertia: Inertia | None) -> Equilibrium:
    """Where a run starts, from an equilibrium or a state of another run. Raises InputError."""
    if start.model.inertia is None:
        return start if declared_alike(start, model.system) else carried_over(start, model)
    if start.model.inertia != inertia:
        raise InputError(f"start is of a run with {start.model.inertia}", "Give the same inertia=")
    if not declared_alike(start, with_inertia(model.system, inertia)):
        raise InputError(f"start is of another system than {model.name!r}", "Continue a run with inertia as it is")
    return start


def in_core(model: Model, signals: Sequence[Signal], inertia: Inertia | None) -> bool:
    """Whether the compiled core moves a model: a line by its sections, or a system with inertia; otherwise it solves
    all equations together. Raises CompiledError where it can do none of them, CompilerError, WriteError."""
    if inertia is not None:
        return True
    changes = any(isinstance(signal, Schedule) for signal in signals[: model.u.shared])
    if changes or isinstance(line_sections(model), str):
        require_kernels(model)
        return False
    compiled_line(model)
    return True


def require_no_events(system: System) -> None:
    """Raises InputError for a component with events of its own, as an embedded FMU, which a line with inertia does not
    handle."""
    for name, component in system.components.items():
        if component.external_events is not None:
            raise InputError(
                f"{name!r} has events of its own, which a run with inertia does not handle",
                "Leave out inertia=, or couple it by CoSimulation",
            )


def signals_of(model: Model, inputs: Mapping[str, Signal], until: float) -> tuple[Signal, ...]:
    """The signal of each input of the model. Raises InputError, UnknownNameError."""
    for name in inputs:
        if name not in model.u.index:
            raise UnknownNameError(f"{name!r} is not an input of {model.name!r}", nearest(name, model.u.names))
    signals: list[Signal] = []
    for name, own, within in zip(model.u.names, model.signals, model.u.ranges, strict=True):
        signal = inputs.get(name, own)
        if signal is None:
            raise InputError(f"Input {name!r} is open", f"Give it: simulate(..., inputs={{{name!r}: 1.0}})")
        if isinstance(signal, Schedule) and signal.times[-1] < until:
            raise InputError(
                f"The schedule of {name!r} ends at {signal.times[-1]:g} s, the run at {until:g} s",
                "Make the schedule longer or the run shorter",
            )
        for value in signal.speeds if isinstance(signal, Schedule) else (signal,):
            check.number(value, f"Input {name!r}", "value", within=within)
        signals.append(signal)
    return tuple(signals)


def is_speed(system: System, component: str, quantity: str) -> bool:
    """Whether an input is the commanded speed of a drive."""
    return quantity == "speed" and isinstance(system.components[component], Node)


def check_interventions(model: Model, interventions: Sequence[Intervention], inertia: Inertia | None) -> None:
    """Raises InputError, UnknownNameError for an intervention that the system does not allow."""
    for intervention in interventions:
        if intervention.inertial:
            _check_inertial(model, intervention, inertia)
    interventions = [i for i in interventions if not i.inertial]
    driven = [target for target in model.system.links if is_speed(model.system, *target)]
    for intervention in interventions:
        if intervention.action == EMERGENCY_STOP and driven:
            raise InputError(
                f"An emergency stop cannot ramp down {'.'.join(driven[0])!r}, which another component drives",
                "Brake that sheave",
            )
        if intervention.component is None:
            continue
        known = _known(model, intervention.action)
        if intervention.component not in known:
            raise UnknownNameError(
                f"{intervention.action!r} does not apply to {intervention.component!r}",
                f"It applies to {', '.join(known) or 'nothing in this system'}",
            )


def _known(model: Model, action: str) -> list[str]:
    """Names of the components to which an action without inertia applies."""
    if action == STOP:
        return [component_of(n) for n in model.u.names if is_speed(model.system, *n.rpartition(".")[::2])]
    return [component_of(n) for n in model.d.names if n.rpartition(".")[2] == SWITCHED[action][0]]


def _check_inertial(model: Model, intervention: Intervention, inertia: Inertia | None) -> None:
    """Raises InputError, UnknownNameError for an intervention that takes mass off the line."""
    action, name = intervention.action, str(intervention.component)
    if inertia is None:
        raise InputError(f"{action!r} needs inertia", "Give simulate(..., inertia=rw.Inertia())")
    if action == LOAD_LOST:
        known = [load for run in model.runs for load in run.loads.names]
    else:
        kind = Carriage if action == "payload dropped" else Span
        # A carriage on a shoe has no inertia.
        known = [n for n, c in model.system.components.items() if type(c) is kind]
    if name not in known:
        raise UnknownNameError(
            f"{action!r} does not apply to {name!r}",
            f"It applies to {', '.join(known[:12]) or 'nothing in this system'}",
        )


def started(state: LineState, signals: Sequence[Signal], inertia: Inertia) -> LineState:
    """A line with inertia that starts as the quasi-static line moves."""
    line = LineStepper(state, signals, 1e-6)
    line.set_time(0.0)
    motion = line.solve(float(min(line.breaks[line.breaks > 0.0], default=1.0)))
    return inertial_state(line.state, inertia, (motion.x, motion.z))
