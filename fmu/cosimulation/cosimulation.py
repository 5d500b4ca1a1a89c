"""Slaves coupled by a master: Jacobi or Gauss-Seidel, explicit or iterated with rollback, steps fixed or controlled."""

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
    """`open`: inputs that somebody must give."""

    fmu: Fmu
    kind: str
    start: Mapping[str, Value]
    open: tuple[str, ...]


@checked
class CoSimulation:
    """FMUs and systems that exchange values at communication points.

    step: between two points [s]; with `control` the first one. master: "Jacobi" (all from the values at the last point)
    or "Gauss-Seidel" (in the order in which they were added, each with the newest values). iterated: each step is
    repeated until the values at its end agree to `tolerance` (relative, on changes of the inputs); inputs are then
    linear in time where a slave can take that, else held at their mean. Raises InputError.
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
        """Adds an FMU, or a system, which is exported first; returns the FMU. kind: how it is moved on, "ModelExchange"
        by an integrator here; by default "CoSimulation" where the FMU is for it.

        start: values of its parameters, structural ones too, and inputs: numbers, Booleans, texts, bytes, names or
        values of an enumeration's items; of an array one element ("u[1]") or all ("u"). What a system leaves open must
        be connected, driven or have a value here. Raises InputError, FmuImportError, FmuVariableError."""
        check.name(name, "slave")
        if name in self._participants:
            raise InputError(f"Two slaves are named {name!r}", "Give each a name of its own")
        left: tuple[str, ...] = ()
        if isinstance(participant, System | Model | Equilibrium):
            rest = participant if isinstance(participant, Equilibrium) else equilibrium(participant)
            left = tuple(n for n, s in zip(rest.model.u.names, rest.model.signals, strict=True) if s is None)
            participant = export(rest, self._folder / f"{name}.fmu")
        fmu = participant if isinstance(participant, Fmu) else load(participant)
        if kind is None:
            kind = "ModelExchange" if fmu.kinds == ("ModelExchange",) else "CoSimulation"
        require_kind(fmu, kind)
        fmu, values = _started(fmu, name, start or {})
        self._participants[name] = _Participant(fmu, kind, values, left)
        return fmu

    def connect(self, source: str, target: str) -> Connection:
        """Lets an output drive an input, "slave.variable" each: numbers with their units converted, Booleans, integers,
        enumerations, texts; a Boolean or an integer may drive a number too. Raises InputError for a slave that is not
        there, FmuVariableError for a variable that is not, or does not fit."""
        ends = []
        for end, causality in ((source, "output"), (target, "input")):
            slave, _, variable = end.partition(".")
            if slave not in self._participants:
                raise InputError(f"{end!r}: no slave is named {slave!r}", f"Slaves are {', '.join(self._participants)}")
            fmu = self._participants[slave].fmu
            require_connectable(fmu, variable, causality)
            ends.append((fmu, variable))
        if any(c.target == target for c in self._connections):
            raise InputError(f"{target!r} is driven already", "An input takes one connection")
        one, other = (fmu.entry(variable) for fmu, variable in ends)
        if not fits(one, other):
            raise FmuVariableError(
                f"{source!r} is of type {one.type}, {target!r} of type {other.type}: it cannot drive it",
                "Connect variables of one kind, or an enumeration to one with the same items",
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
        """Runs from `start_time` to `until` [s].

        inputs: values over time of inputs that nothing drives, and of tunable parameters, in their own units, as
        `{"slave.variable": ...}`: a Schedule, a pandas Series with times [s] as its index, or a constant; or a table as
        a DataFrame or its path, with a column for each and one `time`. Values are linear between rows where the
        variable is continuous, two rows of one time being a jump; else each holds until the next. Communication points
        are added where inputs bend or jump if all slaves can take steps of any length.

        Returns all outputs over time, columns "slave.variable", the real ones first; in `attrs` their "units"; "ended",
        why an FMU has ended the run itself, else None; "left_out", outputs that cannot be shown, with reasons; with a
        step control how many steps were "repeated" and the "inexact" times, where the least step missed the tolerance.
        progress: show a bar (by default only on a terminal). Raises InputError, FmuImportError, FmuVariableError, and
        FmuRunError or Interrupted, which have the rows so far as `result`."""
        check.number(until, "run", "until", "s")
        check.number(start_time, "run", "start_time", "s")
        if until <= start_time:
            raise InputError(f"run: until is {until!r} s", f"It must be above the start time, {start_time:g} s")
        check.count((until - start_time) / self.step, "run", "steps")
        if not self._participants:
            raise InputError("There is no slave", "Add FMUs or systems")
        given = signals(
            {} if inputs is None else inputs, {name: p.fmu for name, p in self._participants.items()}, until
        )
        self._require_driven(given)
        with ExitStack() as stack:
            advance = stack.enter_context(bar("co-simulate", until, progress))
            slaves = {name: stack.enter_context(OpenFmu(p.fmu, name, p.kind)) for name, p in self._participants.items()}
            coupling = Coupling(slaves, self._connections, self._scheme, given, start_time)
            if self._scheme.iterated:
                _require_rollback(slaves)
            stepper = None if self.control is None else Stepper(coupling, self.control, self.step)
            record = Recorder(coupling)
            with record.kept():
                self._begin(coupling, until)
                record.add(start_time)
                while record.times[-1] < until - 1e-9 * self.step and coupling.ended is None:
                    time = self._take(coupling, stepper, given, len(record.times), start_time, until)
                    if not coupling.aligned:
                        break
                    record.add(time)
                    advance(time)
            frame = record.frame()
        if stepper is not None:
            frame.attrs |= {"repeated": stepper.repeated, "inexact": stepper.inexact}
        return frame

    def _require_driven(self, given: Mapping[str, Signal]) -> None:
        """Raises InputError where an input is left open or driven twice."""
        driven = {c.target for c in self._connections}
        if twice := driven & given.keys():
            raise InputError(f"{min(twice)!r} is driven already", "An input takes a connection or values over time")
        for name, participant in self._participants.items():
            for entry in participant.open:
                if entry not in participant.start and f"{name}.{entry}" not in driven | given.keys():
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
        given: Mapping[str, Signal],
        i: int,
        start: float,
        until: float,
    ) -> float:
        """The step to point i, or to where an FMU ends the run; the time reached."""
        if stepper is not None:
            return stepper.step(coupling.time, next_break(given, coupling.time, until))
        end = until if i >= (until - start) / self.step - 1e-9 else start + i * self.step
        cuts = all(slave.varies_steps for slave in coupling.slaves.values())
        while coupling.ended is None and coupling.time < end - 1e-9 * self.step:
            stop = next_break(given, coupling.time, end) if cuts else end
            coupling.step(stop - coupling.time)
            if coupling.ended is None:
                coupling.time = stop
        return coupling.time


def _started(fmu: Fmu, name: str, start: Mapping[str, object]) -> tuple[Fmu, dict[str, Value]]:
    """The FMU in the sizes that structural parameters among its start values give it, and the other start values.
    Raises InputError, FmuVariableError."""
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
                f"{name!r} cannot go back in time, so its steps cannot be repeated",
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
