"""Slaves coupled by a master: Jacobi or Gauss-Seidel, explicit or iterated, with fixed or controlled steps."""

from __future__ import annotations

import shutil
import tempfile
import weakref
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Literal

import pandas as pd

from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.errors import InputError
from ropeway.fmu.cosimulation.communication_points import is_multiple, points, require_steps
from ropeway.fmu.cosimulation.coupling import Coupling, Driving, Master, Scheme, Span
from ropeway.fmu.cosimulation.discrete_exchange import Connection
from ropeway.fmu.cosimulation.input_signals import Inputs, signals
from ropeway.fmu.cosimulation.pacing import Pace
from ropeway.fmu.cosimulation.participants import Participant, conversion, started
from ropeway.fmu.cosimulation.recording import Recorder
from ropeway.fmu.cosimulation.scenario import Scenario, changes
from ropeway.fmu.cosimulation.step_control import StepControl, Stepper
from ropeway.fmu.errors import FmuVariableError
from ropeway.fmu.exporting.export import export
from ropeway.fmu.importing.fmu_file import Fmu, load
from ropeway.fmu.importing.instance import require_kind
from ropeway.fmu.importing.participant import OpenFmu, require_connectable
from ropeway.fmu.importing.variable_types import fits
from ropeway.systems.interrupts import interruptible
from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.modelling.system import System
from ropeway.systems.progress_bar import bar
from ropeway.systems.statics.equilibrium import Equilibrium
from ropeway.systems.statics.equilibrium_solver import equilibrium


@checked
class CoSimulation:
    """FMUs and systems that exchange values at communication points.

    With `iterated`, each step is repeated until the values at its end agree. Inputs are then linear in time if the
    slave supports it, otherwise constant at their mean.

    Parameters
    ----------
    step : float
        Communication step [s]; with a step control the first one.
    master : {"Jacobi", "Gauss-Seidel"}, default "Jacobi"
        Jacobi: all slaves use the values of the last communication point. Gauss-Seidel: slaves run in the order in
        which they were added, each with the newest values.
    iterated : bool, default False
        Whether steps are repeated until they converge.
    tolerance : float, default 1e-9
        Relative tolerance of the iteration, on changes of the inputs.
    iterations : int, default 50
        Largest number of iterations.
    control : StepControl, optional
        Step size control; by default constant steps.

    Raises
    ------
    InputError
        A step or tolerance that is not positive, or no iterations.
    """

    def __init__(
        self,
        step: float,
        *,
        master: Master = "Jacobi",
        iterated: bool = False,
        tolerance: float = 1e-9,
        iterations: int = 50,
        control: StepControl | None = None,
    ) -> None:
        check.positive(step, "CoSimulation", "step", "s")
        check.positive(tolerance, "CoSimulation", "tolerance")
        if iterations < 1:
            raise InputError(f"iterations is {iterations!r}", "Give at least one")
        self.step, self.control = float(step), control
        self._scheme = Scheme(master, iterated, tolerance, iterations)
        self._participants: dict[str, Participant] = {}
        self._connections: list[Connection] = []
        self._folder = Path(tempfile.mkdtemp(prefix="ropeway-"))
        weakref.finalize(self, shutil.rmtree, self._folder, ignore_errors=True)

    def add(
        self,
        name: str,
        participant: System | Model | Equilibrium | Fmu | str | Path,
        *,
        kind: Literal["CoSimulation", "ModelExchange"] | None = None,
        start: Mapping[str, object] | None = None,
        isolated: bool | None = None,
        timeout: float | None = None,
        step: float | None = None,
    ) -> Fmu:
        """Add an FMU, or a system, which is exported first.

        Parameters
        ----------
        name : str
            Name of the slave.
        participant : System, Model, Equilibrium, Fmu, str or Path
            The system, or the FMU or its file.
        kind : {"CoSimulation", "ModelExchange"}, optional
            How it is advanced: by its own solver, or by an integrator of this library. By default "CoSimulation" if the
            FMU supports it.
        start : mapping of str, optional
            Start values of parameters (also structural ones) and inputs: numbers, Booleans, texts, bytes, names or
            values of enumeration items; for an array one element ("u[1]") or all ("u"). An open input of a system must
            be connected, driven, or have a start value.
        isolated : bool, optional
            Whether it runs in a process of its own, so that a crash of it does not end the session; by default as it
            was loaded.
        timeout : float, optional
            Longest time of one call of an isolated slave [s]; by default as it was loaded, 60 s.
        step : float, optional
            Its own communication step [s], a multiple of the master's, for a slow slave: its inputs and outputs change
            at the ends of its steps only. Not with iterated or controlled steps.

        Returns
        -------
        Fmu
            The FMU.

        Raises
        ------
        InputError
            A name that is used twice, an invalid value, or a step that is not a multiple.
        FmuImportError
            The file cannot be used.
        FmuVariableError
            An unknown variable, or a value of the wrong type.
        """
        check.name(name, "slave")
        if name in self._participants:
            raise InputError(f"Two slaves are named {name!r}", "Give each its own name")
        open_inputs: tuple[str, ...] = ()
        if isinstance(participant, System | Model | Equilibrium):
            rest = participant if isinstance(participant, Equilibrium) else equilibrium(participant)
            open_inputs = tuple(n for n, s in zip(rest.model.u.names, rest.model.signals, strict=True) if s is None)
            participant = export(rest, self._folder / f"{name}.fmu")
        fmu = participant if isinstance(participant, Fmu) else load(participant)
        if timeout is not None:
            check.positive(timeout, "add", "timeout", "s")
            fmu = replace(fmu, timeout=timeout)
        fmu = fmu if isolated is None else replace(fmu, isolated=isolated)
        if kind is None:
            kind = "ModelExchange" if fmu.kinds == ("ModelExchange",) else "CoSimulation"
        require_kind(fmu, kind)
        fmu, values = started(fmu, name, start or {})
        self._participants[name] = Participant(fmu, kind, values, open_inputs, self._own_step(name, step))
        return fmu

    def _own_step(self, name: str, step: float | None) -> float | None:
        """Raises InputError."""
        if step is None:
            return None
        check.positive(step, f"Slave {name!r}", "step", "s")
        if self._scheme.iterated or self.control is not None:
            raise InputError(f"Slave {name!r} has a step of its own", "Use iterated=False without a step control")
        if not is_multiple(step, self.step):
            raise InputError(
                f"Slave {name!r} has steps of {step:g} s, which is no multiple of {self.step:g} s",
                "Give the master the shortest step",
            )
        return step if step > 1.5 * self.step else None

    def connect(self, source: str, target: str) -> Connection:
        """Connect an output to an input.

        Units are converted. A Boolean or an integer may drive a number.

        Parameters
        ----------
        source, target : str
            Output and input, "slave.variable" each.

        Returns
        -------
        Connection
            The connection, with the factor and offset of the units.

        Raises
        ------
        InputError
            An unknown slave, or an input that is already driven.
        FmuVariableError
            An unknown variable, or types or units that do not match.
        """
        ends = []
        for end, causality in ((source, "output"), (target, "input")):
            slave, _, variable = end.partition(".")
            if slave not in self._participants:
                raise InputError(f"{end!r}: no slave is named {slave!r}", f"Slaves are {', '.join(self._participants)}")
            fmu = self._participants[slave].fmu
            require_connectable(fmu, variable, causality)
            ends.append((fmu, variable))
        if any(c.target == target for c in self._connections):
            raise InputError(f"{target!r} is already driven", "An input takes one connection")
        one, other = (fmu.entry(variable) for fmu, variable in ends)
        if not fits(one, other):
            raise FmuVariableError(
                f"{source!r} is of type {one.type}, {target!r} of type {other.type}: they cannot be connected",
                "Connect variables of the same kind, or enumerations with the same items",
                ends[1][1],
            )
        converted = conversion(*ends[0], *ends[1]) if one.kind == other.kind == "Real" else (1.0, 0.0)
        held = one.kind != "Real" or not other.continuous
        connection = Connection(source, target, *converted, held)
        self._connections.append(connection)
        return connection

    @interruptible
    def run(
        self,
        until: float,
        *,
        start_time: float = 0.0,
        inputs: Inputs | None = None,
        scenario: Scenario | None = None,
        outputs: Sequence[str] | None = None,
        every: float | None = None,
        pace: float | None = None,
        progress: bool | None = None,
    ) -> pd.DataFrame:
        """Run the co-simulation.

        Communication points are added at vertices and jumps of the inputs, and at changes of the scenario, if all
        slaves accept steps of any length.

        Parameters
        ----------
        until : float
            End time [s].
        start_time : float, default 0
            Start time [s].
        inputs : mapping of str, DataFrame, str or Path, optional
            Values over time of unconnected inputs and of tunable parameters, in their own units: {"slave.variable":
            value} with a Schedule, a pandas Series with times [s] as its index, or a constant; or a table with a column
            for each and one `time`. Continuous variables are linear between rows, and two rows of one time are a jump;
            others keep each value until the next.
        scenario : DataFrame, str or Path, optional
            Changes at given times: a table with the columns `time` [s], `variable` ("slave.variable") and `value`, in
            its own unit, of inputs and tunable parameters. A changed input ignores its connection until an empty value
            releases it.
        outputs : sequence of str, optional
            Variables to record, "slave.variable"; by default all outputs.
        every : float, optional
            Interval of the rows [s]: a row at the first communication point from each multiple on, and at the end; by
            default at each communication point.
        pace : float, optional
            Simulated seconds for each second of the clock, 1: real time; by default as fast as possible.
        progress : bool, optional
            Whether to show a progress bar; by default only on a terminal.

        Returns
        -------
        DataFrame
            The variables over time, columns "slave.variable", by default real ones first. `attrs`: "units"; "ended",
            why an FMU ended the run, or None; "left_out", outputs that cannot be shown, with reasons; with a step
            control the number of "repeated" steps and the "inexact" times, at which the smallest step missed the
            tolerance; with a pace "late", the largest time by which it was behind the clock [s].

        Raises
        ------
        InputError
            Invalid times, an open input, or steps that a slave does not accept.
        FmuImportError
            A binary cannot be loaded.
        FmuVariableError
            Unknown variables in `inputs`, `scenario` or `outputs`.
        FmuRunError, Interrupted
            An FMU failed, or the user interrupted; `result` has the rows up to then.
        """
        span = Span(float(start_time), float(until), self.step)
        span.require()
        if not self._participants:
            raise InputError("There is no slave", "Add FMUs or systems")
        for name, value in (("every", every), ("pace", pace)):
            if value is not None:
                check.positive(value, "run", name)
        driving = self._driving(inputs, scenario, until)
        with ExitStack() as stack:
            advance = stack.enter_context(bar("co-simulate", until, progress))
            slaves = {name: stack.enter_context(OpenFmu(p.fmu, name, p.kind)) for name, p in self._participants.items()}
            require_steps(slaves, span, driving.slow, self._scheme, self.control)
            coupling = Coupling(slaves, self._connections, self._scheme, driving, span)
            stepper = None if self.control is None else Stepper(coupling, self.control, self.step)
            expected = 0 if stepper else int((until - start_time) / (every or self.step)) + len(driving.breaks) + 2
            record = Recorder(coupling, outputs, every, expected)
            with record.kept():
                self._begin(coupling, until)
                record.add(start_time)
                clock = Pace(pace, start_time)
                for time in points(coupling, stepper, driving, span):
                    record.add(time)
                    clock.wait(time)
                    advance(time)
                if coupling.aligned:
                    record.finish(coupling.time)
            frame = record.frame()
        if stepper is not None:
            frame.attrs |= {"repeated": stepper.repeated, "inexact": stepper.inexact}
        if pace is not None:
            frame.attrs["late"] = clock.late
        return frame

    def _driving(self, inputs: Inputs | None, scenario: Scenario | None, until: float) -> Driving:
        """What drives the slaves from outside. Raises InputError if an input is open or driven twice."""
        fmus = {name: p.fmu for name, p in self._participants.items()}
        driving = signals({} if inputs is None else inputs, fmus, until)
        connected = {c.target for c in self._connections}
        if twice := connected & driving.keys():
            raise InputError(f"{min(twice)!r} is already driven", "An input takes a connection or values over time")
        for name, participant in self._participants.items():
            for entry in participant.open:
                if entry not in participant.start and f"{name}.{entry}" not in connected | driving.keys():
                    raise InputError(f"Input {entry!r} of {name!r} is open", "Connect it, or give it a start value")
        found = {} if scenario is None else changes(scenario, fmus, connected)
        if twice := found.keys() & driving.keys():
            raise InputError(f"{min(twice)!r} is in the inputs and in the scenario", "Change it in one of them")
        return Driving(driving, found, {name: p.step for name, p in self._participants.items() if p.step is not None})

    def _begin(self, coupling: Coupling, until: float) -> None:
        """Initialises all slaves. Raises FmuRunError."""
        for name, slave in coupling.slaves.items():
            slave.enter(coupling.time, self._participants[name].start, until)
        coupling.initialise()
        for slave in coupling.slaves.values():
            slave.leave()
        coupling.exchange()
