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
from ropeway.components.checked import checked
from ropeway.components.errors import InputError
from ropeway.fmu.coupling import Connection, Coupling, Master, Scheme
from ropeway.fmu.errors import FmuVariableError
from ropeway.fmu.exporting import export
from ropeway.fmu.imported import Fmu, load
from ropeway.fmu.instance import require_kind
from ropeway.fmu.slave import Slave, require_causality
from ropeway.fmu.stepping import StepControl, Stepper
from ropeway.systems.equilibrium import Equilibrium, equilibrium
from ropeway.systems.model import Model
from ropeway.systems.progress import bar
from ropeway.systems.system import System


@dataclass(frozen=True)
class _Participant:
    """`open`: inputs that somebody must give."""

    fmu: Fmu
    kind: str
    start: Mapping[str, float]
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
        if master not in ("Jacobi", "Gauss-Seidel"):
            raise InputError(f"master is {master!r}", 'Choose "Jacobi" or "Gauss-Seidel"')
        if iterations < 1:
            raise InputError(f"iterations is {iterations!r}", "Give at least one")
        if control is not None and not isinstance(control, StepControl):
            raise InputError(f"control is {control!r}", f"Give StepControl({control!r})")
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
        start: Mapping[str, float] | None = None,
    ) -> Fmu:
        """Adds an FMU, or a system, which is exported first; returns the FMU. kind: how it is moved on, "ModelExchange"
        by an integrator here; by default "CoSimulation" where the FMU is for it. start: values of its parameters and
        inputs, 0 or 1 for Booleans. What a system leaves open must be connected or have a value here. Raises
        InputError, FmuImportError, FmuVariableError."""
        check.name(name, "slave")
        if name in self._participants:
            raise InputError(f"Two slaves are named {name!r}", "Give each a name of its own")
        if not isinstance(participant, System | Model | Equilibrium | Fmu | str | Path):
            raise InputError(f"{participant!r:.60} is no slave", "Give a system or an FMU; export() makes one of a rig")
        left: tuple[str, ...] = ()
        if isinstance(participant, System | Model | Equilibrium):
            rest = participant if isinstance(participant, Equilibrium) else equilibrium(participant)
            left = tuple(n for n, s in zip(rest.model.u.names, rest.model.signals, strict=True) if s is None)
            participant = export(rest, self._folder / f"{name}.fmu")
        fmu = participant if isinstance(participant, Fmu) else load(participant)
        values = dict(start or {})
        for key, value in values.items():
            row = fmu.variable(key)
            if row["causality"] == "output" and pd.isna(row["start"]):
                raise FmuVariableError(f"{key!r} of {fmu.path.name} is calculated", "Give parameters and inputs", key)
            check.number(value, f"Slave {name!r}", key)
        if kind is not None:
            require_kind(fmu, kind)
        else:
            kind = "CoSimulation" if "CoSimulation" in fmu.kinds else "ModelExchange"
        self._participants[name] = _Participant(fmu, kind, values, left)
        return fmu

    def connect(self, source: str, target: str) -> Connection:
        """Lets an output drive an input, "slave.variable" each; units are converted. Raises InputError for a slave that
        is not there, FmuVariableError for a variable that is not, or does not fit."""
        ends = []
        for end, causality in ((source, "output"), (target, "input")):
            slave, _, variable = end.partition(".")
            if slave not in self._participants:
                raise InputError(f"{end!r}: no slave is named {slave!r}", f"Slaves are {', '.join(self._participants)}")
            fmu = self._participants[slave].fmu
            require_causality(fmu, variable, causality)
            ends.append((fmu, variable))
        if any(c.target == target for c in self._connections):
            raise InputError(f"{target!r} is driven already", "An input takes one connection")
        connection = Connection(source, target, *_conversion(*ends[0], *ends[1]))
        self._connections.append(connection)
        return connection

    def run(self, until: float, *, progress: bool | None = None) -> pd.DataFrame:
        """Runs from 0 to `until` [s]. Returns all outputs over time, columns "slave.variable", the real ones first; in
        `attrs` their "units", and with a step control how many steps were "repeated" and the "inexact" times, where the
        least step missed the tolerance. progress: show a bar (by default only on a terminal). Raises InputError,
        FmuImportError, FmuRunError."""
        check.positive(until, "run", "until", "s")
        if not self._participants:
            raise InputError("There is no slave", "Add FMUs or systems")
        driven = {c.target for c in self._connections}
        for name, participant in self._participants.items():
            for entry in participant.open:
                if entry not in participant.start and f"{name}.{entry}" not in driven:
                    raise InputError(f"Input {entry!r} of {name!r} is open", "Connect it, or give it a start value")
        with ExitStack() as stack:
            advance = stack.enter_context(bar("co-simulate", until, progress))
            slaves = {name: stack.enter_context(Slave(p.fmu, name, p.kind)) for name, p in self._participants.items()}
            coupling = Coupling(slaves, self._connections, self._scheme)
            if self._scheme.iterated:
                _require_rollback(slaves)
            stepper = None if self.control is None else Stepper(coupling, self.control, self.step)
            for name, slave in slaves.items():
                slave.enter(0.0, self._participants[name].start)
            coupling.initialise()
            for slave in slaves.values():
                slave.leave()
            times, rows, discrete = [0.0], [coupling.outputs()], [coupling.discrete()]
            while times[-1] < until:
                if stepper is None:
                    times.append(self._take_fixed(coupling, len(times) - 1, until))
                else:
                    times.append(stepper.step(times[-1], until))
                rows.append(coupling.outputs())
                discrete.append(coupling.discrete())
                advance(times[-1])
        index = pd.Index(times, name="time")
        frame = pd.DataFrame(rows, index, coupling.names).join(pd.DataFrame(discrete, index))
        units = [str(s.fmu.variables.loc[v, "unit"]) for s in slaves.values() for v in s.fmu.names("output")]
        frame.attrs["units"] = dict.fromkeys(frame.columns, "1") | dict(zip(coupling.names, units, strict=True))
        if stepper is not None:
            frame.attrs |= {"repeated": stepper.repeated, "inexact": stepper.inexact}
        return frame

    def _take_fixed(self, coupling: Coupling, i: int, until: float) -> float:
        """Step i of those with a fixed length, of which the last ends at `until`; the time reached."""
        end = until if i + 1 >= until / self.step - 1e-9 else (i + 1) * self.step
        coupling.step(end - i * self.step)
        return end


def _require_rollback(slaves: Mapping[str, Slave]) -> None:
    for name, slave in slaves.items():
        if not slave.can_restore:
            raise InputError(
                f"{name!r} cannot go back in time, so its steps cannot be repeated",
                'Use iterated=False, or add it with kind="ModelExchange"',
            )


def _conversion(source: Fmu, output: str, target: Fmu, entry: str) -> tuple[float, float]:
    """Factor and offset from one unit to another. Raises FmuVariableError."""
    one, other = str(source.variable(output)["unit"]), str(target.variable(entry)["unit"])
    try:
        return units.conversion(one, other, source.units, target.units)
    except InputError as error:
        raise FmuVariableError(
            f"{output!r} of {source.path.name} is in {one}, {entry!r} of {target.path.name} in {other}: {error.cause}",
            error.remedy,
            entry,
        ) from error
