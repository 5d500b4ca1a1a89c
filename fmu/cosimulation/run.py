"""A run of coupled slaves: opened, initialised, advanced, recorded and closed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass

import pandas as pd

from ropeway.components import check
from ropeway.components.errors import InputError
from ropeway.fmu.cosimulation.communication_points import points, require_steps
from ropeway.fmu.cosimulation.connections import Connection
from ropeway.fmu.cosimulation.coupling import Coupling, Driving, Scheme, Span
from ropeway.fmu.cosimulation.input_signals import Inputs, signals
from ropeway.fmu.cosimulation.pacing import Pace
from ropeway.fmu.cosimulation.participants import Participant
from ropeway.fmu.cosimulation.recording import Recorder
from ropeway.fmu.cosimulation.scenario import Scenario, changes
from ropeway.fmu.cosimulation.step_control import StepControl, Stepper
from ropeway.fmu.importing.participant import OpenFmu
from ropeway.systems.progress_bar import bar


@dataclass(frozen=True)
class Request:
    """What drives a run from outside, and what it records; see `CoSimulation.run`."""

    inputs: Inputs | None = None
    scenario: Scenario | None = None
    outputs: Sequence[str] | None = None
    every: float | None = None
    pace: float | None = None

    def __post_init__(self) -> None:
        for name in ("every", "pace"):
            if getattr(self, name) is not None:
                check.positive(getattr(self, name), "run", name)


@dataclass(frozen=True)
class Run:
    """Participants by name, their connections, and how steps are taken."""

    participants: Mapping[str, Participant]
    connections: Sequence[Connection]
    scheme: Scheme
    control: StepControl | None
    span: Span

    def __post_init__(self) -> None:
        self.span.require()
        if not self.participants:
            raise InputError("There is no slave", "Add FMUs or systems")

    def rows(self, request: Request, progress: bool | None) -> pd.DataFrame:
        """The recorded rows. Raises InputError, FmuError, Interrupted."""
        span, driving = self.span, self._driving(request)
        with ExitStack() as stack:
            advance = stack.enter_context(bar("co-simulate", span.until, progress))
            slaves = {name: stack.enter_context(OpenFmu(p.fmu, name, p.kind)) for name, p in self.participants.items()}
            require_steps(slaves, span, driving.slow, self.scheme, self.control)
            coupling = Coupling(slaves, self.connections, self.scheme, driving, span)
            stepper = None if self.control is None else Stepper(coupling, self.control, span.step)
            expected = 0 if stepper else span.count(request.every) + len(driving.breaks)
            record = Recorder(coupling, request.outputs, request.every, expected)
            with record.kept():
                self._begin(coupling)
                record.add(span.start)
                clock = Pace(request.pace, span.start)
                for time in points(coupling, stepper, driving, span):
                    record.add(time)
                    clock.wait(time)
                    advance(time)
                if coupling.aligned:
                    record.finish(coupling.time)
            frame = record.frame()
        if stepper is not None:
            frame.attrs |= {"repeated": stepper.repeated, "inexact": stepper.inexact}
        if request.pace is not None:
            frame.attrs["late"] = clock.late
        return frame

    def _driving(self, request: Request) -> Driving:
        """What drives the slaves from outside. Raises InputError if an input is open or driven twice."""
        fmus = {name: p.fmu for name, p in self.participants.items()}
        driving = signals({} if request.inputs is None else request.inputs, fmus, self.span.until)
        connected = {c.target for c in self.connections}
        if twice := connected & driving.keys():
            raise InputError(f"{min(twice)!r} is already driven", "An input takes a connection or values over time")
        for name, participant in self.participants.items():
            for entry in participant.open:
                if entry not in participant.start and f"{name}.{entry}" not in connected | driving.keys():
                    raise InputError(f"Input {entry!r} of {name!r} is open", "Connect it, or give it a start value")
        found = {} if request.scenario is None else changes(request.scenario, fmus, connected)
        if twice := found.keys() & driving.keys():
            raise InputError(f"{min(twice)!r} is in the inputs and in the scenario", "Change it in one of them")
        return Driving(driving, found, {name: p.step for name, p in self.participants.items() if p.step is not None})

    def _begin(self, coupling: Coupling) -> None:
        """Initialises all slaves. Raises FmuRunError."""
        for name, slave in coupling.slaves.items():
            slave.enter(coupling.time, self.participants[name].start, self.span.until)
        coupling.initialise()
        for slave in coupling.slaves.values():
            slave.leave()
        coupling.exchange()
