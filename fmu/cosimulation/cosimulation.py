"""Slaves coupled by a master: Jacobi or Gauss-Seidel, explicit or iterated, with fixed or controlled steps."""

from __future__ import annotations

import shutil
import tempfile
import weakref
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import pandas as pd

from ropeway.components import check, units
from ropeway.components.argument_checks import checked
from ropeway.components.errors import InputError
from ropeway.fmu.cosimulation.coupling import Coupling, Master, Scheme
from ropeway.fmu.cosimulation.discrete_exchange import Connection
from ropeway.fmu.cosimulation.input_signals import Inputs, Signal, next_break, signals
from ropeway.fmu.cosimulation.recording import Recorder
from ropeway.fmu.cosimulation.step_control import StepControl, Stepper
from ropeway.fmu.errors import FmuVariableError
from ropeway.fmu.exporting.export import export
from ropeway.fmu.importing.fmu_file import Fmu, load
from ropeway.fmu.importing.instance import require_kind
from ropeway.fmu.importing.participant import OpenFmu, require_connectable
from ropeway.fmu.importing.variable_types import Value, fits
from ropeway.systems.interrupts import interruptible
from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.modelling.system import System
from ropeway.systems.progress_bar import bar
from ropeway.systems.statics.equilibrium import Equilibrium
from ropeway.systems.statics.equilibrium_solver import equilibrium


@dataclass(frozen=True)
class _Participant:
    """A slave of a co-simulation; `open`: inputs that need a value."""

    fmu: Fmu
    kind: str
    start: Mapping[str, Value]
    open: tuple[str, ...]


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

    Examples
    --------
    >>> master = rw.fmu.CoSimulation(step=1.0)
    >>> part = master.add("span", "span.fmu")
    >>> master.run(5.0).columns.tolist()
    ['span.a.tension', 'span.b.tension']
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
        self._participants: dict[str, _Participant] = {}
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

        Returns
        -------
        Fmu
            The FMU.

        Raises
        ------
        InputError
            A name that is used twice, or an invalid value.
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
        if kind is None:
            kind = "ModelExchange" if fmu.kinds == ("ModelExchange",) else "CoSimulation"
        require_kind(fmu, kind)
        fmu, values = _started(fmu, name, start or {})
        self._participants[name] = _Participant(fmu, kind, values, open_inputs)
        return fmu

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
        conversion = _conversion(*ends[0], *ends[1]) if one.kind == other.kind == "Real" else (1.0, 0.0)
        held = one.kind != "Real" or not other.continuous
        connection = Connection(source, target, *conversion, held)
        self._connections.append(connection)
        return connection

    @interruptible
    def run(
        self,
        until: float,
        *,
        start_time: float = 0.0,
        inputs: Inputs | None = None,
        progress: bool | None = None,
    ) -> pd.DataFrame:
        """Run the co-simulation.

        Communication points are added at vertices and jumps of the inputs if all slaves accept steps of any length.

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
        progress : bool, optional
            Whether to show a progress bar; by default only on a terminal.

        Returns
        -------
        DataFrame
            All outputs over time, columns "slave.variable", real ones first. `attrs`: "units"; "ended", why an FMU
            ended the run, or None; "left_out", outputs that cannot be shown, with reasons; with a step control the
            number of "repeated" steps and the "inexact" times, at which the smallest step missed the tolerance.

        Raises
        ------
        InputError
            Invalid times, or an open input.
        FmuImportError
            A binary cannot be loaded.
        FmuVariableError
            Unknown variables in `inputs`.
        FmuRunError, Interrupted
            An FMU failed, or the user interrupted; `result` has the rows up to then.
        """
        check.number(until, "run", "until", "s")
        check.number(start_time, "run", "start_time", "s")
        if until <= start_time:
            raise InputError(f"run: until is {until!r} s", f"It must be above the start time, {start_time:g} s")
        check.count((until - start_time) / self.step, "run", "steps")
        if not self._participants:
            raise InputError("There is no slave", "Add FMUs or systems")
        driving = signals(
            {} if inputs is None else inputs, {name: p.fmu for name, p in self._participants.items()}, until
        )
        self._require_driven(driving)
        with ExitStack() as stack:
            advance = stack.enter_context(bar("co-simulate", until, progress))
            slaves = {name: stack.enter_context(OpenFmu(p.fmu, name, p.kind)) for name, p in self._participants.items()}
            coupling = Coupling(slaves, self._connections, self._scheme, driving, start_time)
            if self._scheme.iterated:
                _require_rollback(slaves)
            stepper = None if self.control is None else Stepper(coupling, self.control, self.step)
            record = Recorder(coupling)
            with record.kept():
                self._begin(coupling, until)
                record.add(start_time)
                while record.times[-1] < until - 1e-9 * self.step and coupling.ended is None:
                    time = self._take(coupling, stepper, driving, len(record.times), start_time, until)
                    if not coupling.aligned:
                        break
                    record.add(time)
                    advance(time)
            frame = record.frame()
        if stepper is not None:
            frame.attrs |= {"repeated": stepper.repeated, "inexact": stepper.inexact}
        return frame

    def _require_driven(self, driving: Mapping[str, Signal]) -> None:
        """Raises InputError if an input is open or driven twice."""
        driven = {c.target for c in self._connections}
        if twice := driven & driving.keys():
            raise InputError(f"{min(twice)!r} is already driven", "An input takes a connection or values over time")
        for name, participant in self._participants.items():
            for entry in participant.open:
                if entry not in participant.start and f"{name}.{entry}" not in driven | driving.keys():
                    raise InputError(f"Input {entry!r} of {name!r} is open", "Connect it, or give it a start value")

    def _begin(self, coupling: Coupling, until: float) -> None:
        """Initialises all slaves. Raises FmuRunError."""
        for name, slave in coupling.slaves.items():
            slave.enter(coupling.time, self._participants[name].start, until)
        coupling.initialise()
        for slave in coupling.slaves.values():
            slave.leave()
        coupling.exchange()

    def _take(
        self,
        coupling: Coupling,
        stepper: Stepper | None,
        driving: Mapping[str, Signal],
        i: int,
        start: float,
        until: float,
    ) -> float:
        """Step to point i, or to where an FMU ends the run; returns the time reached."""
        if stepper is not None:
            return stepper.step(coupling.time, next_break(driving, coupling.time, until))
        end = until if i >= (until - start) / self.step - 1e-9 else start + i * self.step
        cuts = all(slave.varies_steps for slave in coupling.slaves.values())
        while coupling.ended is None and coupling.time < end - 1e-9 * self.step:
            stop = next_break(driving, coupling.time, end) if cuts else end
            coupling.step(stop - coupling.time)
            if coupling.ended is None:
                coupling.time = stop
        return coupling.time


def _started(fmu: Fmu, name: str, start: Mapping[str, object]) -> tuple[Fmu, dict[str, Value]]:
    """The FMU resized by structural parameters among its start values, and the other start values.

    Raises InputError, FmuVariableError.
    """
    structural = [key for key in start if key in fmu.entries and fmu.entry(key).causality == "structuralParameter"]
    if structural:
        fmu = fmu.shaped(fmu.values({key: start[key] for key in structural}))
    for key, value in start.items():
        if key in fmu.entries and fmu.entry(key).kind == "Real":
            check.number(value, f"Slave {name!r}", key)
    values = fmu.values(start)
    for key in start:
        for entry in fmu.arrays.get(key, (key,)):
            row = fmu.variable(entry)
            if row["causality"] == "output" and pd.isna(row["start"]):
                raise FmuVariableError(f"{key!r} of {fmu.path.name} is calculated", "Give parameters and inputs", key)
    return fmu, {key: value for key, value in values.items() if key not in structural}


def _require_rollback(slaves: Mapping[str, OpenFmu]) -> None:
    for name, slave in slaves.items():
        if not slave.can_restore:
            raise InputError(
                f"{name!r} cannot restore its state, so its steps cannot be repeated",
                'Use iterated=False, or add it with kind="ModelExchange"',
            )


def _conversion(source: Fmu, output: str, target: Fmu, entry: str) -> tuple[float, float]:
    """Factor and offset from one unit to another. Raises FmuVariableError."""
    first, second = source.variable(output), target.variable(entry)
    one, other = str(first["unit"]), str(second["unit"])
    differences = bool(first["relative"]), bool(second["relative"])
    try:
        return units.conversion(one, other, source.units, target.units, differences=differences)
    except InputError as error:
        raise FmuVariableError(
            f"{output!r} of {source.path.name} is in {one}, {entry!r} of {target.path.name} in {other}: {error.cause}",
            error.remedy,
            entry,
        ) from error
