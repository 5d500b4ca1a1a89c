"""Results of a simulation: states at many times, outputs on request, events, files."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
import pandas as pd

from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.errors import CompilerError, EquilibriumError, SimulationError, WriteError
from ropeway.components.node import Node
from ropeway.components.table_writer import Tabular
from ropeway.systems.interrupts import interruptible
from ropeway.systems.modelling.dae_model import Model, kept_with_model
from ropeway.systems.modelling.rope_path import Run
from ropeway.systems.results import line_clearance
from ropeway.systems.results.column_labels import Labels
from ropeway.systems.solvers.array_outputs import has_groups, outputs_of_rows
from ropeway.systems.solvers.compiled_rows import compiled_outputs, solve_rows
from ropeway.systems.solvers.condensed_newton import solve_points
from ropeway.systems.solvers.newton import newton_of
from ropeway.systems.solvers.state_rows import StateRows
from ropeway.systems.statics.certificate.certify import certify_records, certify_rows
from ropeway.systems.statics.certificate.checks import Certificate
from ropeway.systems.statics.equilibrium import Equilibrium
from ropeway.systems.statics.line_records import restored
from ropeway.systems.statics.line_state import LineState
from ropeway.systems.statics.record_blocks import RecordRows, Records, RowRestorer

_SLACK = "slack rope"
_BATCH = 145_000
"""Approximate number of values of the records that are restored together: more take memory and save no time."""
_KEPT = 50_000_000
"""Most numbers of outputs at all records that events are found from at once; the frames keep theirs."""


class Event(NamedTuple):
    """An event of a component at a time [s]. `value` is the load's number or the relevant quantity, `load` the load's
    name."""

    time: float
    component: str
    event: str
    value: float
    load: str = ""


@checked
@dataclass(frozen=True, eq=False, repr=False)
class RunData(Tabular):
    """Records of a run, and quantities derived from them by the model. Fields as in `rw.Result`."""

    model: Model
    runs: tuple[Run, ...]
    parameters: np.ndarray
    records: Records
    on_grid: np.ndarray
    exact: np.ndarray
    noted: tuple[Event, ...]
    tolerance: float
    compiled: bool = False

    @property
    def times(self) -> np.ndarray:
        """Times of all records [s]. An event has two records at the same time."""
        return self.records.times

    @cached_property
    @interruptible
    def _solved(self) -> tuple[np.ndarray, np.ndarray]:
        """Outputs and algebraic variables at all records."""
        y, z, others = self._evaluated(np.arange(len(self.records)))
        self.__dict__["checks"] = self._exact_checks.and_also(others)
        return y, z

    def _evaluate(self, which: np.ndarray, outputs: np.ndarray, y: np.ndarray, z: np.ndarray) -> Certificate:
        """Writes the outputs at places `outputs` and the algebraic variables at records `which` into arrays. Returns
        the certificate of those that the run has not solved itself. Raises SimulationError for a record that fails."""
        of_core = compiled_outputs(self.model, outputs.tobytes()) if self._in_core else None

        def inexact() -> Iterator[StateRows]:
            done = 0
            for rows in self._batches(which):
                block = slice(done, done + len(rows))
                if of_core is None:
                    y[block] = outputs_of_rows(self.model, rows, outputs)
                else:
                    of_core.write(rows, y[block])
                z[block] = rows.z
                others, done = ~self.exact[which[block]], block.stop
                if others.any():
                    yield rows.some(others)

        return self._certified(which[~self.exact[which]], inexact())

    def _evaluated(self, which: np.ndarray) -> tuple[np.ndarray, np.ndarray, Certificate]:
        """All outputs and the algebraic variables at records `which`, and the certificate of those that the run has not
        solved itself. Raises SimulationError for a record that fails."""
        y, z = (np.empty((len(which), len(table))) for table in (self.model.y, self.model.z))
        return y, z, self._evaluate(which, np.arange(len(self.model.y)), y, z)

    @cached_property
    def checks(self) -> Certificate:
        """The certificate of all records, with the worst of each check. Raises SimulationError for a record that
        fails."""
        others = np.flatnonzero(~self.exact)
        return self._exact_checks.and_also(self._certified(others, self._batches(others)))

    @cached_property
    def _exact_checks(self) -> Certificate:
        """The certificate of the records that the run has solved itself."""
        solved = np.flatnonzero(self.exact)
        return self._certified(solved, self._batches(solved))

    @property
    def certificate(self) -> pd.DataFrame:
        """The worst of each check over all records: index check; columns value, limit, holds, component, time [s]."""
        times = self.times
        return self.checks.frame.assign(time=[times[c.record] for c in self.checks.checks])

    def require_certified(self) -> None:
        """Checks the records that the run has solved itself. Raises SimulationError with the result before the first
        record that fails."""
        _ = self._exact_checks

    @property
    def _together(self) -> int:
        """Number of records that are restored together."""
        m = self.model
        return max(1, _BATCH // max(1, sum(map(len, (m.x, m.z, m.u, m.p, m.d)))))

    def _batches(self, which: np.ndarray) -> Iterator[StateRows]:
        """The solved states of records `which`, in batches, each of which lasts until the next one."""
        if not len(which):
            return
        most = min(self._together, len(which))
        restorer = RowRestorer(self.model, self.runs, self.parameters, most, compiled=self._in_core)
        for first in range(0, len(which), most):
            part = which[first : first + most]
            rows, left = restorer.rows(self.records.rows(part)), np.flatnonzero(~self.exact[part])
            if self._in_core and len(left):
                left = solve_rows(self.model, rows, left)
            solve_points(self.model, [rows[i] for i in left.tolist()])
            yield rows

    @cached_property
    def _in_core(self) -> bool:
        """Whether states are restored and outputs evaluated in the compiled core, where the run was compiled and
        components do not read each other's outputs, without inertia. The numbers are the same without a compiler."""
        if not self.compiled or not has_groups(self.model):
            return False
        try:
            compiled_outputs(self.model, np.array(self.model.y.shown, dtype=int).tobytes())
        except (CompilerError, WriteError):
            return False
        return True

    def _certified(self, which: np.ndarray, batches: Iterable[StateRows]) -> Certificate:
        """The certificate of records `which`. Raises SimulationError."""
        found = certify_rows(self.model, self.runs, batches).numbered(which.tolist())
        self._require(found, found.failed.record if found.failed else 0)
        return found

    def _require(self, certificate: Certificate, i: int) -> None:
        """Raises SimulationError with the result before record i if a check fails."""
        try:
            certificate.require(self.model)
        except EquilibriumError as error:
            before = replace(
                self,
                records=self.records[:i],
                on_grid=self.on_grid[:i],
                exact=self.exact[:i],
                noted=tuple(event for event in self.noted if event.time <= self.records[i].time),
            )
            raise SimulationError(error.cause, error.remedy, self.records[i].time, before) from error

    @property
    def outputs(self) -> np.ndarray:
        """All outputs at all records, shape (records, ny)."""
        return self._solved[0]

    @property
    def algebraic(self) -> np.ndarray:
        """All algebraic variables at all records, shape (records, nz)."""
        return self._solved[1]

    def state(self, i: int) -> LineState:
        """The state at a record, without its certificate."""
        state = restored(self.model, self.runs, self.parameters, self.records[i])
        if not self.exact[i]:
            newton_of(self.model).solve(state.point)
        return state

    @cached_property
    def full_frame(self) -> pd.DataFrame:
        """As `frame`, but at all records, including both sides of each event."""
        y, z = self._solved
        table, shown = _Table(self.model, len(self.records)), np.array(self.model.y.shown, dtype=int)
        table.outputs[:] = y[:, shown]
        return table.frame(self.records.rows(np.arange(len(self.records))), z)

    @cached_property
    @interruptible
    def frame(self) -> pd.DataFrame:
        """Outputs, travels and inputs over time [s], one row per interval; units in `attrs["units"]`."""
        which, shown = np.flatnonzero(self.on_grid), np.array(self.model.y.shown, dtype=int)
        table = _Table(self.model, len(which))
        if "_solved" in self.__dict__:
            y, z = (values[which] for values in self._solved)
            table.outputs[:] = y[:, shown]
        else:
            z = np.empty((len(which), len(self.model.z)))
            self._evaluate(which, shown, table.outputs, z)
        return table.frame(self.records.rows(which), z)

    @cached_property
    @interruptible
    def heights(self) -> np.ndarray:
        """Least height of each span with its loads over the ground at all records, shape (records, spans) [m]. Raises
        InputError for a system without ground."""
        return line_clearance.heights(self.model, self._column)

    def _column(self, name: str) -> np.ndarray:
        """A variable at all records."""
        m = self.model
        if name in m.y.index:
            return self.outputs[:, m.y.index[name]]
        if name in m.z.index:
            return self.algebraic[:, m.z.index[name]]
        if name in m.x.index:
            return self.records.rows(np.arange(len(self.records))).x[:, m.x.index[name]]
        return np.full(len(self.records), self.parameters[m.p.index[name]])

    @cached_property
    def clearance(self) -> pd.DataFrame:
        """Least height of each span over the ground. Index span; columns rope_clearance (least of the rope and its
        loads), the station of the ground there, load_clearance (of the lowest load) [m], time [s]. Raises InputError
        for a system without ground."""
        names = [span.name for run in self.runs for span in run.spans]
        return line_clearance.clearance(names, self.heights, self.record, self.times)

    @cached_property
    def events(self) -> pd.DataFrame:
        """Events in order of time: columns time [s], component, event, value, load.

        Events are crossings and loads put on, taken off, held and released (value: the load's number), responses
        (value: the correction [m/s]), interventions, and limits exceeded (tension above SWL or MBL, lift-off; value:
        the output concerned). A line with a clearance also has below clearance (value: the height over the ground [m]).
        A run with inertia also has slack rope, and hits ground, of a rope or its loads.
        """
        low = [*self._lower_than(self._clearance, "below clearance"), *self._lower_than(self._touched, "hits ground")]
        found = sorted([*self.noted, *self.limits_reached, *low], key=lambda e: e.time)
        frame = pd.DataFrame(found, columns=list(Event._fields))
        return frame.astype({"time": float, "value": float})

    @cached_property
    def limits_reached(self) -> list[Event]:
        """Limits of components that are exceeded, at the first record in which they are."""
        limits, found, last, done = self.model.limits, list[Event](), np.zeros((1, 0), dtype=bool), 0
        for outputs in self._outputs_in_parts():
            exceeded = limits.broken(outputs)
            begun = _onsets(exceeded, last if done else None)
            found += [
                Event(
                    float(self.records[done + i].time),
                    limits.components[j],
                    limits.events[j],
                    float(outputs[i, limits.output[j]]),
                )
                for i, j in zip(*np.nonzero(begun), strict=True)
            ]
            last, done = exceeded[-1:], done + len(outputs)
        return found

    def _outputs_in_parts(self) -> Iterator[np.ndarray]:
        """Outputs of all records in their order, (records, ny); in parts where all are too many to keep."""
        count = len(self.records)
        if "_solved" in self.__dict__ or count * len(self.model.y) <= _KEPT:
            yield self.outputs
            return
        for first in range(0, count, self._together):
            yield self._evaluated(np.arange(first, min(first + self._together, count)))[0]

    @property
    def slack_time(self) -> float:
        """Time at which the first rope goes slack in a run with inertia [s], inf without one: after it tensions are not
        quoted, as the snap of a rope that tightens again is not resolved."""
        start = self.times[0]
        return min((e.time for e in self.limits_reached if e.event == _SLACK and e.time > start), default=np.inf)

    @property
    def in_balance(self) -> tuple[str, ...]:
        """Names of the nodes that have no inertia in a run with it: saddles, blocks, logs, spars, elastic anchors and
        components of the user's are in equilibrium with their ropes at every time. Empty without inertia."""
        if self.model.inertia is None:
            return ()
        unknown = {name.rpartition(".")[0] for name in self.model.z.names}
        nodes = [c for c in self.model.system.components.values() if isinstance(c, Node) and not c.inertial]
        return tuple(node.name for node in nodes if node.name in unknown)

    @property
    def _clearance(self) -> float | None:
        ground = self.model.system.ground
        return None if ground is None else ground.clearance

    @property
    def _touched(self) -> float | None:
        """The height at which loads thrown about hit the ground [m]; a line in equilibrium has its clearance only."""
        return None if self.model.system.ground is None or self.model.inertia is None else 0.0

    def _lower_than(self, height: float | None, event: str) -> list[Event]:
        """Events of spans that fall below a height over the ground [m]."""
        if height is None:
            return []
        names = [span.name for run in self.runs for span in run.spans]
        return [
            Event(float(self.records[i].time), names[k], event, float(self.heights[i, k]))
            for i, k in zip(*np.nonzero(_onsets(self.heights < height)), strict=True)
        ]

    def record(self, i: int) -> Equilibrium:
        """The line at a record, by its index in `full_frame`. Raises SimulationError if its certificate fails."""
        check.index(i, len(self.records), "Result.record", "i")
        return self._line(self.state(i), i)

    def _line(self, state: LineState, i: int) -> Equilibrium:
        self._require(certify_records(state.model, state.runs, [(state.point, state.passed)]), i)
        pending = self.records[i].pending.after(state.point.t)
        return Equilibrium(state.model, state.point, tuple(state.runs), tuple(state.passed), state.held, pending)


class _Columns(NamedTuple):
    """Columns of a frame: places of the algebraic variables that it shows, names, units and descriptions of all."""

    algebraic: np.ndarray
    names: pd.Index
    units: Labels
    descriptions: Labels


@kept_with_model
def _columns(model: Model) -> _Columns:
    moves = [i for i in model.z.shown if ".force_" not in model.z.names[i]]
    tables = [(model.y, model.y.shown), (model.z, moves), (model.x, model.x.shown), (model.u, range(len(model.u)))]
    found = [(table.names[i], table.units[i], table.descriptions[i]) for table, chosen in tables for i in chosen]
    units, descriptions = (Labels({own[0]: own[k] for own in found}) for k in (1, 2))
    return _Columns(np.array(moves, dtype=int), pd.Index([own[0] for own in found]), units, descriptions)


class _Table:
    """A frame of records; `outputs` (records, outputs) is the part of its values that the outputs that are shown
    take."""

    def __init__(self, model: Model, count: int) -> None:
        self._model, self._columns = model, _columns(model)
        self._values = np.empty((count, len(self._columns.names)))
        self.outputs = self._values[:, : len(model.y.shown)]

    def frame(self, records: RecordRows, z: np.ndarray) -> pd.DataFrame:
        """The frame, with the algebraic variables `z` (records, nz) and the records' states and inputs."""
        columns, first = self._columns, self.outputs.shape[1]
        for block in (z[:, columns.algebraic], records.x[:, list(self._model.x.shown)], records.u):
            self._values[:, first : first + block.shape[1]] = block
            first += block.shape[1]
        index = pd.Index(records.time, name="time")
        frame = pd.DataFrame(self._values, index=index, columns=columns.names.view(), copy=False)
        frame.attrs["units"], frame.attrs["descriptions"] = columns.units, columns.descriptions
        return frame


def _onsets(exceeded: np.ndarray, before: np.ndarray | None = None) -> np.ndarray:
    """Records at which limits become exceeded, from booleans (records, limits); `before` (1, limits): of the record
    before them."""
    first = np.zeros((1, exceeded.shape[1]), dtype=bool) if before is None else before
    return np.asarray(exceeded & ~np.vstack([first, exceeded[:-1]]))
