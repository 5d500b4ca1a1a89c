"""The response of a line's control sheaves, tuned by simulation."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import partial
from typing import Any

import numpy as np
import pandas as pd
from scipy.optimize import differential_evolution

from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.errors import EquilibriumError, InputError, SimulationError
from ropeway.components.form import form_of
from ropeway.components.response import Response, check_precedence
from ropeway.components.variable import Kind
from ropeway.systems.dynamics.simulation import simulate
from ropeway.systems.interrupts import interruptible, keeping
from ropeway.systems.modelling.system import System
from ropeway.systems.progress_bar import bar
from ropeway.systems.statics.equilibrium import Equilibrium
from ropeway.systems.statics.equilibrium_solver import equilibrium
from ropeway.systems.statics.warm_start import carried_over
from ropeway.systems.studies.control.control_sheaves import control_sheaves, with_responses
from ropeway.systems.studies.control.objectives import objective_weights, objectives
from ropeway.systems.studies.control.scheduling.initial_schedules import require_sheave
from ropeway.systems.studies.sweeps.journal import JournalRow
from ropeway.systems.studies.sweeps.sweep import rows_of
from ropeway.systems.studies.sweeps.workers import WorkerPool, Workers, worker_pool


@checked
@dataclass(frozen=True, eq=False)
class TunedResponse:
    """The best response found.

    Attributes
    ----------
    line : System
        The line with it.
    response : Response
    precedence : str
    objective : float
        What was minimised.
    baseline : float
        The objective of the response given, inf where that run failed.
    history : DataFrame
        A row for each simulation: what was tuned, `objective`, and `error` and `message` of one that failed (its
        objective is inf).

    Examples
    --------
    >>> tuned = rw.tune_response(
    ...     line, rw.ProportionalResponse(gain=1e-6), over={"gain": (1e-7, 1e-5)}, until=2.0, minimise="energy",
    ...     generations=1, population=4, workers=1,
    ... )
    >>> len(tuned.history)
    11
    """

    line: System
    response: Response
    precedence: str
    objective: float
    baseline: float
    history: pd.DataFrame


@checked
@interruptible
def tune_response(
    line: System,
    response: Response,
    *,
    over: Mapping[str, tuple[float, float] | Sequence[str]],
    minimise: str | Mapping[str, float],
    until: float,
    settle: float = 0.0,
    target: float | None = None,
    every: float = 1.0,
    sheaves: Sequence[str] | None = None,
    start: Equilibrium | None = None,
    generations: int = 10,
    population: int = 6,
    seed: int = 0,
    workers: Workers = None,
    progress: bool | None = None,
    compiled: bool = False,
) -> TunedResponse:
    """Tune a response by simulations of the line, by differential evolution: repeatable for a seed.

    The response as it is given counts too, so that the result is never worse.

    Parameters
    ----------
    line : System
        A line with control sheaves.
    response : Response
        The response to begin with.
    over : mapping of str to (float, float) or names
        What may change: the range of a quantity of the response (`{"increment": (0.002, 0.05)}`), and of "precedence"
        the names to choose from.
    minimise : str or mapping of str to float
        "peak tension" [N], "tension deviation" [N] or "energy" [J] of a run, or a weight for each.
    until : float
        End of each run [s].
    settle : float, default 0.0
        Time from which the objectives of tension count [s].
    target : float, optional
        Tension from which the deviation counts [N]; needed for "tension deviation".
    every : float, default 1.0
        Interval of the records [s].
    sheaves : sequence of str, optional
        Those that get the response; by default all control sheaves.
    start : Equilibrium, optional
        Where every run starts, as `balanced` gives it; by default the line's equilibrium.
    generations : int, default 10
        Number of rounds after the first.
    population : int, default 6
        Simulations in a round for each quantity tuned.
    seed : int, default 0
        Of the random numbers.
    workers : int or dask.distributed.Client, optional
        As for `sweep`.
    progress : bool, optional
        Whether to show a progress bar; by default on a terminal only.
    compiled : bool, default False
        Whether the runs are in compiled code, as in `simulate`.

    Returns
    -------
    TunedResponse

    Raises
    ------
    InputError, UnknownNameError, CompiledError
    SimulationError
        Where every run fails.

    Examples
    --------
    >>> response = rw.ProportionalResponse(gain=1e-6)
    >>> tuned = rw.tune_response(
    ...     line, response, over={"gain": (1e-7, 1e-5)}, until=5.0, minimise="energy",
    ...     generations=1, population=4, workers=1,
    ... )
    >>> tuned.objective <= tuned.baseline
    True
    """
    check.positive(until, "tune_response", "until", "s")
    if not 0.0 <= settle < until:
        raise InputError(f"settle is {settle!r} s of a run of {until:g} s", "Choose it within the run")
    check.not_negative(seed, "tune_response", "seed")
    weights = objective_weights(minimise)
    if "tension deviation" in weights and target is None:
        raise InputError("The tension deviation has no target", "Give target= [N]: runs count from the same tension")
    known = control_sheaves(line)
    chosen = known if sheaves is None else list(sheaves)
    if not chosen:
        raise InputError("tune_response has nothing to tune", f"Name sheaves, as {known[0]!r}, or leave them out")
    for name in chosen:
        require_sheave(name, known)
    # Without responses: the start's own are not those that are tuned.
    bare = None if start is None else carried_over(start, with_responses(line, dict.fromkeys(known)))
    trial = _Trial(line, response, chosen, weights, until, settle, target, every, bare, compiled)
    space = _Space(over)
    space.check(response)
    search = _Search(trial, space, generations, population)
    with keeping(search.table), bar("tune", search.most, progress) as advance, worker_pool(workers) as pool:
        search.run(seed, pool, advance)
    return search.best()


class _Search:
    """Differential evolution over a space of responses; `history` has what was tuned and found, a row a run."""

    def __init__(self, trial: _Trial, space: _Space, generations: int, population: int) -> None:
        self.trial, self.space = trial, space
        self.generations, self.population = generations, population
        self.history: list[dict[str, Any]] = []

    @property
    def most(self) -> int:
        """Largest number of runs."""
        return 1 + (self.generations + 1) * max(5, self.population * len(self.space.over))

    def table(self) -> pd.DataFrame:
        """The history as a frame."""
        return pd.DataFrame(self.history).rename_axis("run")

    def run(self, seed: int, pool: WorkerPool, advance: Callable[[float], None]) -> None:
        """Runs all generations."""
        given = {name: getattr(self.trial.response, name, self.trial.line.precedence) for name in self.space.over}
        self.history.append({**given, **self.trial.baseline()})
        differential_evolution(
            lambda values: self._objectives(values, pool, advance),
            self.space.bounds,
            x0=self.space.place(given),
            maxiter=self.generations,
            popsize=self.population,
            tol=1e-3,
            rng=np.random.default_rng(seed),
            polish=False,
            integrality=self.space.whole,
            updating="deferred",
            vectorized=True,
        )

    def _objectives(self, values: np.ndarray, pool: WorkerPool, advance: Callable[[float], None]) -> np.ndarray:
        """Objectives of a generation, its members in columns."""
        cases = [self.space.case(member) for member in values.T]
        rows: list[dict[str, Any]] = [{**case, "objective": np.inf} for case in cases]
        try:
            for done, (i, (found,)) in enumerate(pool(partial(rows_of, self.trial), [[case] for case in cases]), 1):
                rows[i].update(found)
                advance(len(self.history) + done)
        finally:  # those that have run
            self.history.extend(row for row in rows if "message" in row)
        return np.array([row["objective"] for row in rows])

    def best(self) -> TunedResponse:
        """The best response. Raises SimulationError where every run failed."""
        table, first = self.table(), self.history[0]
        best = self.history[int(table["objective"].to_numpy().argmin())]
        if not np.isfinite(best["objective"]):
            raise SimulationError("Every run of the line fails", f"The message of the first: {first['message']}")
        tuned, precedence = self.trial.variant({name: best[name] for name in self.space.over})
        line = self.trial.line_with(tuned, precedence)
        return TunedResponse(line, tuned, precedence, best["objective"], first["objective"], table)


@dataclass(frozen=True)
class _Space:
    """What is tuned, as numbers: a range as it is, a precedence by its place."""

    over: Mapping[str, Sequence[Any]]

    def check(self, response: Response) -> None:
        """Raises InputError."""
        if not isinstance(response, Response):
            raise InputError(f"response is {response!r}", "Give a ThresholdResponse or another response")
        known = [f.name for f in fields(response)]
        if not self.over:
            raise InputError("tune_response has nothing to tune", f"Give ranges over {', '.join(known)} or precedence")
        for name, values in self.over.items():
            if isinstance(values, str) or not isinstance(values, Sequence):
                raise InputError(f"{name} is tuned over {values!r}", "Give (low, high), or two precedences or more")
            if name == "precedence":
                for precedence in values:
                    check_precedence(str(precedence))
            elif name not in known:
                raise InputError(f"A {type(response).__name__} has no {name!r}", f"It has {', '.join(known)}")
            else:
                for end in values:
                    check.number(end, "tune_response", f"an end of {name}")
            if len(set(values)) < 2 or (name != "precedence" and (len(values) != 2 or values[0] > values[1])):
                raise InputError(f"{name} is tuned over {values!r}", "Give (low, high), or two precedences or more")

    @property
    def whole(self) -> list[bool]:
        """Which numbers are whole."""
        return [name == "precedence" for name in self.over]

    @property
    def bounds(self) -> list[tuple[float, float]]:
        """Least and largest numbers."""
        return [
            (0, len(values) - 1) if name == "precedence" else (float(values[0]), float(values[1]))
            for name, values in self.over.items()
        ]

    def case(self, numbers: np.ndarray) -> dict[str, Any]:
        """What the numbers mean."""
        return {
            name: values[round(number)] if name == "precedence" else float(number)
            for (name, values), number in zip(self.over.items(), numbers, strict=True)
        }

    def place(self, case: Mapping[str, Any]) -> list[float] | None:
        """The numbers of a case; None where it is outside."""
        numbers = []
        for (name, values), (low, high) in zip(self.over.items(), self.bounds, strict=True):
            value = case[name]
            if name == "precedence":
                value = list(values).index(value) if value in values else None
            if value is None or not low <= value <= high:
                return None
            numbers.append(float(value))
        return numbers


@dataclass(frozen=True)
class _Trial:
    """A run of the line with changes of the response, and its objective."""

    line: System
    response: Response
    sheaves: Sequence[str]
    weights: Mapping[str, float]
    until: float
    settle: float
    target: float | None
    every: float
    start: Equilibrium | None
    compiled: bool
    known: dict[Hashable, Equilibrium] = field(default_factory=dict)

    def __getstate__(self) -> dict[str, Any]:
        return {**vars(self), "known": {}}

    def __call__(self, **changes: Any) -> dict[str, float]:
        start = self._started(*self.variant(changes))
        result = simulate(start.model, self.until, every=self.every, start=start, compiled=self.compiled)
        found = objectives(result, settle=self.settle, target=self.target)
        return {"objective": sum(weight * found[name] for name, weight in self.weights.items())}

    def _started(self, response: Response, precedence: str) -> Equilibrium:
        """The state from which a trial begins. Responses that differ in their parameters only share a model."""
        key = (precedence, form_of(response), response.period, response.delay)
        if key not in self.known:
            line = self.line_with(response, precedence)
            rest = equilibrium(line, compiled=self.compiled) if self.start is None else carried_over(self.start, line)
            self.known[key] = rest
        rest = self.known[key]
        point, places = rest.point.copy(), rest.model.p.index
        for sheave in self.sheaves:
            for own in response.variables():
                if own.kind is Kind.PARAMETER:
                    point.p[places[f"{sheave}.{own.name}"]] = own.value
        return replace(rest, point=point)

    def line_with(self, response: Response, precedence: str) -> System:
        """The line with one response at all the sheaves."""
        return with_responses(self.line, dict.fromkeys(self.sheaves, response), precedence)

    def variant(self, changes: Mapping[str, Any]) -> tuple[Response, str]:
        """The response and the precedence with changes."""
        own = {name: value for name, value in changes.items() if name != "precedence"}
        return replace(self.response, **own), changes.get("precedence", self.line.precedence)

    def baseline(self) -> JournalRow:
        """The objective without changes, or why the line cannot run so. Raises InputError; SimulationError where the
        line has no equilibrium: no response changes that."""
        try:
            return {**self(), "error": "", "message": ""}
        except EquilibriumError as error:
            raise SimulationError(
                "Every run of the line fails at its start", f"The message of the first: {error}"
            ) from error
        except SimulationError as error:
            return {"objective": np.inf, "error": type(error).__name__, "message": str(error)}
