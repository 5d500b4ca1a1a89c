"""Any study over many cases, on several workers."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from inspect import signature
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from ropeway.components.argument_checks import checked
from ropeway.components.errors import CompiledError, InputError, WorkerError
from ropeway.systems.interrupts import interruptible, keeping, users_code
from ropeway.systems.modelling.assembly import assemble
from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.modelling.system import System
from ropeway.systems.progress_bar import bar
from ropeway.systems.studies.sweeps.cases import Units, any_unit, table_of
from ropeway.systems.studies.sweeps.found_rows import FAILURE, FoundRows, NumberRows, Rows
from ropeway.systems.studies.sweeps.journal import Journal, JournalRow
from ropeway.systems.studies.sweeps.line_study import LineStudy, line_mark, line_study, line_unit, line_units
from ropeway.systems.studies.sweeps.workers import Workers, worker_pool

Study = Callable[..., Mapping[str, Any] | float]
"""A function of the parameters of a case, by name."""


@checked
@interruptible
def sweep(
    study: Study | System | Model,
    parameters: Mapping[str, Iterable[Any]] | pd.DataFrame | str | Path,
    *,
    outputs: str | Sequence[str] | None = None,
    workers: Workers = None,
    path: str | Path | None = None,
    progress: bool | None = None,
    compiled: bool = False,
) -> pd.DataFrame:
    """Run a study over many cases; the result does not depend on the workers.

    Parameters
    ----------
    study : callable, System or Model
        A function called as `study(**case)`, which returns a number (column `value`), or numbers and text by name; or a
        line, whose equilibrium is solved with the parameters of the case. The line keeps its unstretched lengths,
        except those that are parameters.
    parameters : mapping of str to values, DataFrame, str or Path
        Values of each parameter, for all their combinations; or a table with a row a case, as `latin_hypercube` makes,
        or its file. Parameters of a line are named as for `equilibrium`: "l7.mass", "s3.z", "a_b.length". A name may
        have a unit in brackets: "c1.speed [km/h]" is `c1.speed`, its values become m/s; those of a function's
        parameters become SI.
    outputs : str or sequence of str, optional
        Of a line; by default all of the model.
    workers : int or dask.distributed.Client, optional
        Number of local processes, by default one for each core; 1: this process alone.
    path : str or Path, optional
        A Parquet file for the table; an interrupted sweep continues from the rows there are.
    progress : bool, optional
        Whether to show a progress bar; by default on a terminal only.
    compiled : bool, default False
        Of a line: whether to solve in compiled code, as in `equilibrium`.

    Returns
    -------
    DataFrame
        A row a case, in the order of the cases. Columns: parameters, results, and `error` (its type) and `message` of a
        case that failed, otherwise empty. `attrs["units"]`: units of a line's quantities.

    Raises
    ------
    InputError, UnknownNameError
        Before the first case.
    WorkerError, Interrupted
        With the rows so far as `result`.
    WriteError

    Examples
    --------
    >>> table = rw.sweep(line, {"l8.mass": [300.0, 450.0]}, outputs=["c1.tension_in"], workers=1)
    >>> table[["l8.mass", "c1.tension_in"]].round(0)
       l8.mass  c1.tension_in
    0    300.0        46639.0
    1    450.0        46890.0
    """
    units = dict[str, str]()
    if isinstance(study, (System, Model)):
        model = study if isinstance(study, Model) else assemble(study)
        cases = _cases(parameters, partial(line_unit, model))
        names = list(cases.columns)
        _require_numbers(cases)
        variants = line_study(model, names, [outputs] if isinstance(outputs, str) else outputs, compiled=compiled)
        task: Study = variants
        units, mark = line_units(model, [*names, *variants.outputs]), line_mark(model, variants)
    elif compiled:
        raise CompiledError("A function is not compiled", "Leave out compiled=True, or sweep a line")
    elif outputs is not None:
        raise InputError("outputs are read from a line, not from a function", "Let the function return them")
    else:
        cases = _cases(parameters)
        _require_fitting(study, cases)
        if path is not None and getattr(study, "__name__", "") == "<lambda>":
            raise InputError("A file cannot tell one lambda from another", "Give a function with a name")
        task, mark = _UsersStudy(study), _mark(study)
    if path is not None and Path(path).suffix != ".parquet":
        raise InputError(f"path is {str(path)!r}", "The table is written as Parquet: end it in .parquet")
    rows = FoundRows()

    def so_far() -> pd.DataFrame:
        return rows.table(cases, units)

    with ExitStack() as stack:
        stack.enter_context(keeping(so_far))
        journal = None if path is None else stack.enter_context(Journal(path, mark, cases))
        finished = None if journal is None else journal.finished()
        if finished is not None:
            return finished
        try:
            _run(task, cases, rows, workers, journal, progress)
        except WorkerError as error:
            error.result = so_far()
            raise
        return so_far() if journal is None else journal.finish(so_far())


def _cases(
    parameters: Mapping[str, Iterable[Any]] | pd.DataFrame | str | Path, unit_of: Units = any_unit
) -> pd.DataFrame:
    """One row a case. Raises InputError, also where a parameter has the name of a column of failures."""
    cases = table_of(parameters, unit_of)
    if taken := set(cases.columns) & set(FAILURE):
        raise InputError(f"A parameter is named {taken.pop()!r}, as a column of failures", "Give it another name")
    return cases


def _run(
    study: Study,
    cases: pd.DataFrame,
    rows: FoundRows,
    workers: Workers,
    journal: Journal | None,
    progress: bool | None,
) -> None:
    """Adds the rows of all cases, by number."""
    if journal is not None:
        known = journal.rows()
        rows.add(list(known), list(known.values()))
    left = [i for i in range(len(cases)) if i not in rows]
    whole = isinstance(study, LineStudy)
    size = max(1, min(1000, len(cases) // 8)) if whole else max(1, min(50, len(cases) // 200))
    chunks = [left[k : k + size] for k in range(0, len(left), size)]
    if isinstance(study, LineStudy):
        values = cases.to_numpy(dtype=float)
        tasks: Iterable[Any] = (values[chunk] for chunk in chunks)
        work: Callable[[Any], Rows] = partial(study.rows, tuple(cases.columns))
    else:
        every = cases.to_dict("records")
        tasks, work = ([every[i] for i in chunk] for chunk in chunks), partial(rows_of, study)
    with bar("sweep", len(cases), progress) as advance, worker_pool(workers) as pool:
        advance(len(rows))
        for k, found in pool(work, tasks):
            rows.add(chunks[k], found)
            if journal is not None:
                named = found.named() if isinstance(found, NumberRows) else found
                journal.add(dict(zip(chunks[k], named, strict=True)))
            advance(len(rows))


@dataclass(frozen=True)
class _UsersStudy:
    """A function of the user's."""

    study: Study

    def __call__(self, **case: Any) -> Mapping[str, Any] | float:
        with users_code():
            return self.study(**case)


def rows_of(study: Study, cases: Sequence[dict[str, Any]]) -> list[JournalRow]:
    """Results of some cases, failures too: the part of a sweep that a worker does."""
    return [_row(study, case) for case in cases]


def _row(study: Study, case: dict[str, Any]) -> JournalRow:
    """The result of a case, or its error: whatever a user's function raises is a result here."""
    try:
        return {**_plain(study(**case), case), **dict.fromkeys(FAILURE, "")}
    except Exception as error:  # noqa: BLE001
        return dict(zip(FAILURE, (type(error).__name__, str(error)), strict=True))


def _plain(found: object, case: Mapping[str, Any]) -> JournalRow:
    """Numbers and text by name. Raises InputError for anything else."""
    pairs = found.items() if isinstance(found, (Mapping, pd.Series)) else [("value", found)]
    row: JournalRow = {}
    for name, each in pairs:
        value = each.item() if isinstance(each, np.generic) else each
        if not isinstance(value, (bool, int, float, str, type(None))):
            raise InputError(f"{name} of the study is a {type(value).__name__}", "Return numbers and text by name")
        if name in case or name in FAILURE:
            raise InputError(f"{name} of the study is the name of another column", "Give it another name")
        row[str(name)] = value
    return row


def _mark(study: Study) -> bytes:
    """What identifies a study: its name, and the values bound to it."""
    try:
        return pickle.dumps(study)
    except (pickle.PicklingError, AttributeError, TypeError):
        return f"{getattr(study, '__module__', '')}.{getattr(study, '__qualname__', repr(study))}".encode()


def _require_numbers(cases: pd.DataFrame) -> None:
    for name, kind in cases.dtypes.items():
        if not pd.api.types.is_numeric_dtype(kind) or pd.api.types.is_bool_dtype(kind):
            raise InputError(f"Parameter {name!r} of the line is not a number in every case", "Give numbers")


def _require_fitting(study: Study, cases: pd.DataFrame) -> None:
    """Raises InputError for a function that does not take the parameters."""
    try:
        signature(study).bind(**cases.iloc[0].to_dict())
    except (TypeError, ValueError) as error:  # ValueError: built in, without a signature
        raise InputError(f"The study does not take these parameters: {error}", "Name them as it does") from error
