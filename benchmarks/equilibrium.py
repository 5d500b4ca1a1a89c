"""Speed of an equilibrium: ropeway, scipy.optimize.root on the same residuals, and MoorPy.

    python benchmarks/equilibrium.py --spans 10 --spans 100

Each time is the minimum of several tries. A solver is not run if its time on a shorter line predicts a time above its
budget. Columns: `first` includes building the solver's functions; `cold` and `warm` are public calls after it; `Newton`
is Newton's method alone on the problem of hybr, from the same start; `certificate` is the check of one state with its
stability, which every solve contains once; `difference` is the largest relative difference in tension.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Annotated, NamedTuple

import lines
import numpy as np
import typer
from rich.console import Console
from rich.table import Table
from scipy.optimize import root

import ropeway as rw
from ropeway.systems.modelling.assembly import assemble
from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.solvers.model_functions import Buffered
from ropeway.systems.solvers.newton import Newton, newton_of
from ropeway.systems.statics.certificate.certify import certify
from ropeway.systems.statics.equilibrium import Equilibrium
from ropeway.systems.statics.line_state import LineState

KINDS = {"driven": lines.driven, "given": lines.given}


class Ours(NamedTuple):
    """Times [s] of one line, and its model and equilibrium."""

    assembly: float
    first: float
    cold: float
    warm: float
    newton: float
    certificate: float
    model: Model
    rest: Equilibrium


class Other(NamedTuple):
    """Time of another solver [s], and its largest relative difference from our tensions."""

    time: float
    difference: float


def least(run: Callable[[], object], tries: int = 30, budget: float = 2.0) -> float:
    """The least time of several tries within a budget, with at least one try [s]."""
    end, found = time.perf_counter() + budget, np.inf
    for _ in range(tries):
        before = time.perf_counter()
        run()
        after = time.perf_counter()
        found = min(found, after - before)
        if after > end:
            break
    return found


def ours(build: Callable[[int], rw.System], spans: int) -> Ours:
    """Our times: public calls, and Newton's method alone from the cold start."""
    system = build(spans)
    assembly = least(lambda: assemble(system), tries=5)
    model = assemble(system)
    first = least(lambda: rw.equilibrium(model), tries=1)
    rest = rw.equilibrium(model)
    heavier = {f"{load.load}.mass": 1.02 * load.mass for load in rest.loads.itertuples()}
    start, newton = LineState.cold(model).point, newton_of(model)
    rope = [float(rest.point.p[layout.length_start].sum()) for layout in model.layouts]
    return Ours(
        assembly,
        first,
        least(lambda: rw.equilibrium(model)),
        least(lambda: rw.equilibrium(model, start=rest, parameters=heavier)),
        least(lambda: newton.solve(start.copy())),
        least(lambda: certify(model, rest.point, rest.runs, rest.passed, rope=rope), tries=300),
        model,
        rest,
    )


def hybr(model: Model) -> Other:
    """Powell's hybrid method of MINPACK from the cold start, on our compiled and scaled residual."""
    point, newton = LineState.cold(model).point, Newton(model)
    start, *known = newton.arguments(point)
    residual = Buffered(newton.residual)
    before = time.perf_counter()
    found = root(lambda v: residual(v, *known)[0].copy(), start, method="hybr")
    spent = time.perf_counter() - before
    if not found.success:
        return Other(spent, np.nan)
    newton.solve(point)
    force = np.concatenate([layout.force for layout in model.layouts])
    theirs = _norms(found.x * model.z.nominals, force)
    return Other(spent, float(np.abs(theirs / _norms(point.z, force) - 1.0).max()))


def _norms(z: np.ndarray, force: np.ndarray) -> np.ndarray:
    """Tension at the start of each span [N]."""
    return np.asarray(np.sqrt(sum(z[force + axis] ** 2 for axis in range(3))))


def moorpy(rest: Equilibrium, tolerance: float, whole: bool) -> Other:
    """MoorPy on the same spans: fixed supports, our unstretched lengths, loads as free points with mass.

    `whole`: the line as one system; otherwise each span separately, as they are independent. Only `solveEquilibrium` is
    timed, not the setup of the system."""
    import moorpy as mp

    run, layout = rest.runs[0], rest.model.layouts[0]
    lengths, loads = rest.point.p[layout.length_start], dict(iter(rest.loads.groupby("span", sort=False)))
    rope, deep = run.rope, np.array([0.0, 0.0, -1000.0])  # below its water line, high above its sea bed
    kind = {"name": "rope", "m": rope.mass_per_length, "d_vol": 0.0, "EA": rope.axial_stiffness, "w": 0.0}
    kind["w"] = rope.mass_per_length * rest.model.system.gravity
    systems, first = [], []
    for k, span in enumerate(run.spans):
        if not systems or not whole:
            systems.append(mp.System(depth=1e5, rho=0.0, g=rest.model.system.gravity))
            systems[-1].addPoint(1, run.points[k] + deep)
        system = systems[-1]
        place, step = run.points[k] + deep, run.points[k + 1] - run.points[k]
        done = 0.0
        for load in loads[span.name].itertuples() if span.name in loads else ():
            system.addPoint(0, place + load.distance / lengths[k] * step, m=load.mass)
            _line(system, load.distance - done, kind)
            first += [system.lineList[-1]] if done == 0.0 else []
            done = load.distance
        system.addPoint(1, place + step)
        _line(system, lengths[k] - done, kind)
        first += [system.lineList[-1]] if done == 0.0 else []
    for system in systems:
        system.initialize()
    before = time.perf_counter()
    for system in systems:
        system.solveEquilibrium(tol=tolerance)
    spent = time.perf_counter() - before
    tension = np.array([rest[f"{span.name}.tension_a"] for span in run.spans])
    return Other(spent, float(np.abs(np.array([line.TA for line in first]) / tension - 1.0).max()))


def _line(system: object, length: float, kind: dict[str, object]) -> None:
    """A line between the last two points of a MoorPy system."""
    last = len(system.pointList)  # type: ignore[attr-defined]
    system.addLine(length, kind, pointA=last - 1, pointB=last)  # type: ignore[attr-defined]


class Budget:
    """Runs a solver while its predicted time, a power of the number of spans, is within a budget [s]."""

    def __init__(self, budget: float, power: float) -> None:
        self.budget, self.power = budget, power
        self.last: tuple[int, float] | None = None

    def run(self, spans: int, solver: Callable[[], Other]) -> Other | None:
        """The result, the fastest of three for a quick solver; None if it was not run."""
        if self.last is not None and self.last[1] * (spans / self.last[0]) ** self.power > self.budget:
            self.budget = 0.0
            return None
        found = solver()
        for _ in range(2 if found.time < 2.0 else 0):
            found = min(found, solver())
        self.last = (spans, found.time)
        return found


def main(
    spans: Annotated[list[int] | None, typer.Option(help="Numbers of spans.")] = None,
    others: Annotated[bool, typer.Option(help="Include SciPy and MoorPy.")] = True,
    budget: Annotated[float, typer.Option(help="Longest predicted run of another solver [s].")] = 40.0,
    tolerance: Annotated[float, typer.Option(help="MoorPy's tolerance of positions [m].")] = 1e-6,
) -> None:
    """Print the tables."""
    sizes = sorted(spans or [10, 100, 500, 1000])
    console = Console(width=130)
    found: dict[tuple[str, int], Ours] = {}
    for kind, build in KINDS.items():
        table = Table(title=f"ropeway, {kind} line, two loads a span [ms]")
        for name in ("spans", "unknowns", "assembly", "first", "cold", "warm", "Newton", "certificate"):
            table.add_column(name, justify="right")
        for name in ("certificate/warm", "cold/span", "warm/span"):
            table.add_column(name, justify="right")
        for n in sizes:
            our = found[kind, n] = ours(build, n)
            own, by_span = [f"{1e3 * t:.3g}" for t in our[:6]], [f"{1e3 * t / n:.3g}" for t in (our.cold, our.warm)]
            table.add_row(str(n), str(len(our.model.z)), *own, f"{our.certificate / our.warm:.0%}", *by_span)
        console.print(table)
    if not others:
        return
    for kind in KINDS:
        runs = {
            "hybr": (Budget(budget, 3.5), lambda our: hybr(our.model)),
            "MoorPy": (Budget(budget, 1.8), lambda our: moorpy(our.rest, tolerance, True)),
            "MoorPy by span": (Budget(budget, 1.0), lambda our: moorpy(our.rest, tolerance, False)),
        }
        table = Table(title=f"Other solvers, and their times relative to ropeway's; {kind} line")
        for name in ("spans", "solver", "time [s]", "x cold", "x warm", "x Newton", "difference"):
            table.add_column(name, justify="right")
        for n in sizes:
            our = found[kind, n]
            for name, (limit, solver) in runs.items():
                other = limit.run(n, lambda solver=solver, our=our: solver(our))
                if other is None:
                    table.add_row(str(n), name, "not run")
                    continue
                ratios = [f"{other.time / t:.0f}" for t in (our.cold, our.warm, our.newton)]
                table.add_row(str(n), name, f"{other.time:.3g}", *ratios, f"{other.difference:.1e}")
        console.print(table)


if __name__ == "__main__":
    typer.run(main)
