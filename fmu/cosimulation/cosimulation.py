"""Slaves coupled by a master: Jacobi or Gauss-Seidel, explicit or iterated, with fixed or controlled steps."""

from __future__ import annotations

import shutil
import tempfile
import weakref
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Literal

import pandas as pd

from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.errors import InputError
from ropeway.fmu.cosimulation import ssp_exchange
from ropeway.fmu.cosimulation.communication_points import multiple
from ropeway.fmu.cosimulation.connections import Connection, Conversion, connected
from ropeway.fmu.cosimulation.coupling import Master, Scheme, Span
from ropeway.fmu.cosimulation.input_signals import Inputs
from ropeway.fmu.cosimulation.participants import Participant, started
from ropeway.fmu.cosimulation.run import Request, Run
from ropeway.fmu.cosimulation.scenario import Scenario
from ropeway.fmu.cosimulation.step_control import StepControl
from ropeway.fmu.exporting.export import export
from ropeway.fmu.importing.archive import ArchiveLimits
from ropeway.fmu.importing.fmu_file import Fmu, load
from ropeway.fmu.importing.instance import require_kind
from ropeway.fmu.ssp.reading import SspSystem, read_ssp
from ropeway.fmu.ssp.writing import write_ssp
from ropeway.systems.interrupts import interruptible
from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.modelling.system import System
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
        self._participants: dict[str, Participant] = {}
        self._connections: list[Connection] = []
        self.start_time = 0.0
        self.stop_time: float | None = None
        self._folder = Path(tempfile.mkdtemp(prefix="ropeway-"))
        weakref.finalize(self, shutil.rmtree, self._folder, ignore_errors=True)
        self._own_folders = {self._folder}

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
        if step is not None and (self._scheme.iterated or self.control is not None):
            raise InputError(f"Slave {name!r} has a step of its own", "Use iterated=False without a step control")
        own_step = multiple(name, step, self.step)
        self._participants[name] = Participant(fmu, kind, values, open_inputs, own_step)
        return fmu

    def connect(
        self,
        source: str,
        target: str,
        *,
        factor: float = 1.0,
        offset: float = 0.0,
        convert_units: bool = True,
        mapping: Mapping[bool | int | str, bool | int | str] | None = None,
    ) -> Connection:
        """Connect an output to an input.

        A Boolean or an integer may drive a number.

        Parameters
        ----------
        source, target : str
            Output and input, "slave.variable" each.
        factor, offset : float, default 1 and 0
            The input is factor times the converted output plus offset; real variables only.
        convert_units : bool, default True
            Whether values are converted from the unit of the output to that of the input first.
        mapping : mapping, optional
            The value of the input for each value of the output: Booleans, integers, and items of enumerations by name
            or number. A value of the output without one ends the run.

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
        connection = connected(self._participants, source, target, Conversion(factor, offset, convert_units, mapping))
        if any(c.target == target for c in self._connections):
            raise InputError(f"{target!r} is already driven", "An input takes one connection")
        self._connections.append(connection)
        return connection

    def to_ssp(
        self, path: str | Path, *, until: float | None = None, start_time: float = 0.0, embed: bool = True
    ) -> Path:
        """Write the FMUs, their start values and connections as a system structure (SSP 1.0).

        Other tools read it; `from_ssp` reads the settings of the master as well. Inputs over time are not part of it.

        Parameters
        ----------
        path : str or Path
            The file to write; it ends in .ssp.
        until, start_time : float, optional
            Times of the default experiment [s].
        embed : bool, default True
            Whether the FMUs are in the file; otherwise it refers to them by their paths. FMUs without a file of their
            own, as of systems of this library, are always in it.

        Returns
        -------
        Path
            The file.

        Raises
        ------
        InputError
            An invalid path or time, or no slave.
        WriteError
            The file could not be written.

        Examples
        --------
        >>> master = rw.fmu.CoSimulation(step=1.0)
        >>> part = master.add("span", "span.fmu")
        >>> master.to_ssp("yard.ssp", until=5.0).name
        'yard.ssp'
        """
        target = ssp_exchange.new_file(path)
        if not self._participants:
            raise InputError("There is no slave", "Add FMUs or systems")
        for name, value in (("until", until), ("start_time", start_time)):
            if value is not None:
                check.number(value, "to_ssp", name, "s")
        slaves = tuple(ssp_exchange.slave(name, p) for name, p in self._participants.items())
        connections = tuple(ssp_exchange.connection(c, self._participants) for c in self._connections)
        settings = ssp_exchange.settings_of(self.step, self._scheme, self.control)
        system = SspSystem(slaves, connections, start_time, until, settings)
        kept = {s.fmu.path for s in slaves if embed or not self._own_folders.isdisjoint(s.fmu.path.parents)}
        write_ssp(system, target, name=target.stem, embedded=kept)
        return target

    @classmethod
    def from_ssp(
        cls,
        path: str | Path,
        *,
        step: float | None = None,
        isolated: bool | None = None,
        limits: ArchiveLimits | None = None,
    ) -> CoSimulation:
        """Read a system structure (SSP).

        Systems within systems become slaves with joined names: `winch.drum` becomes `winch_drum`. Values of parameter
        sets that fit no variable are ignored, with a `RopewayWarning`.

        Parameters
        ----------
        path : str or Path
            A file .ssp, or .ssd with its FMUs beside it; of version 1.0 or 2.0.
        step : float, optional
            Communication step [s]; by default that of `to_ssp`, or the smallest one that an FMU suggests.
        isolated : bool, optional
            Whether all slaves run in processes of their own; by default those that `to_ssp` has noted.
        limits : ArchiveLimits, optional
            Limits on the archive and on those of its FMUs.

        Returns
        -------
        CoSimulation
            Its FMUs, start values and connections; with the master's settings, if `to_ssp` has written it. `start_time`
            and `stop_time` are those of the default experiment [s].

        Raises
        ------
        InputError
            No step is known.
        FmuImportError
            The file, or an FMU in it, cannot be used.
        FmuVariableError
            A connection or parameter value does not fit its variables.

        Examples
        --------
        >>> master = rw.fmu.CoSimulation(step=1.0)
        >>> part = master.add("span", "span.fmu")
        >>> path = master.to_ssp("span.ssp", until=5.0)
        >>> rw.fmu.CoSimulation.from_ssp(path).run(5.0).columns.tolist()
        ['span.a.tension', 'span.b.tension']
        """
        folder = Path(tempfile.mkdtemp(prefix="ropeway-"))
        try:
            system = read_ssp(path, folder, limits or ArchiveLimits())
            made = cls(**ssp_exchange.arguments_of(system, step))
            for one in system.slaves:
                options = ssp_exchange.options_of(one)
                opened = tuple(options.pop("open", ()))
                options |= {} if isolated is None else {"isolated": isolated}
                made.add(one.name, one.fmu, kind=one.kind, start=one.start, **options)  # type: ignore[arg-type]
                made._participants[one.name] = replace(made._participants[one.name], open=opened)
            for c in system.connections:
                scale = {} if c.plain else {"factor": c.factor, "offset": c.offset, "convert_units": False}
                made.connect(c.source, c.target, mapping=c.mapping, **scale)  # type: ignore[arg-type]
        except BaseException:
            shutil.rmtree(folder, ignore_errors=True)
            raise
        weakref.finalize(made, shutil.rmtree, folder, ignore_errors=True)
        made._own_folders.add(folder)
        made.start_time, made.stop_time = system.start_time or 0.0, system.stop_time
        return made

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
        run = Run(self._participants, self._connections, self._scheme, self.control, span)
        return run.rows(Request(inputs, scenario, outputs, every, pace), progress)
