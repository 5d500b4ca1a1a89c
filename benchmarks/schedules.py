"""Optimal schedules against constant speed and a tuned threshold response, with their computing times.

python benchmarks/schedules.py --spans 20
"""

from __future__ import annotations

import math
import time
from typing import Annotated

import numpy as np
import pandas as pd
import typer
from rich.console import Console
from rich.table import Table
from scipy.optimize import differential_evolution

import ropeway as rw

ROPE = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)
LIMITS = rw.ScheduleLimits(force=2e3, power=2e3)
SETTLE = 10.0
OBJECTIVES = {"peak tension": ("kN", 1e3), "tension deviation": ("N", 1.0), "energy": ("kJ", 1e3)}


def supports(spans: int) -> pd.DataFrame:
    """Spans of about 100 m over a hump of 30 m, a control sheave at every fifth support."""
    rows = []
    for k in range(spans + 1):
        kind = "drum" if k in (0, spans) else "idler" if k % 5 else "control"
        name = {"drum": "end" if k else "start", "idler": f"s{k}", "control": f"c{k // 5}"}[kind]
        height = 30.0 * math.sin(math.pi * k / spans) + 2.0 * math.sin(0.9 * k)
        rows.append((name, 100.0 * k + 4.0 * math.sin(1.7 * k), 5.0 * (-1) ** k, height, kind))
    return pd.DataFrame(rows, columns=["name", "x", "y", "z", "kind"])


def line(spans: int, response: rw.ThresholdResponse | None = None) -> rw.System:
    """A line full of loads of 100 to 500 kg, two a span; a response acts at all control sheaves but the first."""
    masses = np.random.default_rng(7).uniform(100.0, 500.0, 3 * spans).round().tolist()
    names = [f"c{k}" for k in range(2, (spans - 1) // 5 + 1)]
    responses = None if response is None else dict.fromkeys(names, response)
    return rw.monocable(ROPE, supports(spans), tension=40e3, load_mass=masses, load_spacing=51.0, response=responses)


def simulated(spans: int, until: float, response: rw.ThresholdResponse | None = None) -> rw.Result:
    """A run at constant speed or with a response, from the balanced line."""
    start = rw.balanced(line(spans, response))
    return rw.simulate(start.model, until, every=0.5, start=start, progress=False)


def tuned(spans: int, until: float, objective: str, target: float, trials: int) -> tuple[dict[str, float], float]:
    """Objectives of the best threshold response from a search with about `trials` simulations, and the time of the
    search."""
    begin = time.perf_counter()

    def response(x: np.ndarray) -> rw.ThresholdResponse:
        low, width, increment, hold = x
        return rw.ThresholdResponse(low=low, high=low + width, increment=increment, hold=hold, limit=0.15)

    def value(x: np.ndarray) -> float:
        try:
            result = simulated(spans, until, response(x))
        except rw.RopewayError:
            return math.inf
        return rw.objectives(result, settle=SETTLE, target=target)[objective]

    bounds = [(36e3, 43e3), (1e3, 10e3), (0.002, 0.03), (0.0, 3.0)]
    found = differential_evolution(value, bounds, popsize=5, maxiter=max(1, trials // 20 - 1), seed=1, polish=False)
    best = rw.objectives(simulated(spans, until, response(found.x)), settle=SETTLE, target=target)
    return best, time.perf_counter() - begin


def main(
    spans: Annotated[int, typer.Option(help="Number of spans.")] = 20,
    until: Annotated[float, typer.Option(help="Length of the schedule [s].")] = 120.0,
    trials: Annotated[int, typer.Option(help="Simulations for tuning a threshold response; 0: none.")] = 100,
    starts: Annotated[int, typer.Option(help="Different starts for each objective.")] = 3,
) -> None:
    """Plan each objective from several starts, and print its value against the alternatives."""
    system = line(spans)
    rest = rw.balanced(system)
    intervals = round(until / 2.0)
    table = Table(
        "objective", "constant", "tuned", "optimised", "spread of starts %", "rounds", "solver s", "wall s", "search s"
    )
    checks = Table("objective", "crossings ms", "peak N", "variables", "constraints", "force kN", "power kW")
    constant = simulated(spans, until)
    rng = np.random.default_rng(5)
    for name, (unit, scale) in OBJECTIVES.items():
        plans, walls = [], []
        for k in range(starts):
            warm = None
            if k:
                times = np.linspace(0.0, until, intervals + 1)
                waves = rng.uniform(-0.02, 0.02, len(rest.model.u.names)) * (k > 1)
                waves[0] = 0.0
                warm = {
                    f"c{i + 1}": rw.Schedule(times, 1.0 + wave * np.sin(times / 9.0)) for i, wave in enumerate(waves)
                }
            begin = time.perf_counter()
            plans.append(
                rw.optimise_schedule(
                    system, until, minimise=name, limits=LIMITS, intervals=intervals, settle=SETTLE, start=rest,
                    warm_start=warm, progress=False,
                )
            )  # fmt: skip
            walls.append(time.perf_counter() - begin)
        plan = plans[0]
        values = [p.objective for p in plans]
        best, searched = ({}, 0.0) if not trials else tuned(spans, until, name, plan.target, trials)
        other = rw.objectives(constant, settle=SETTLE, target=plan.target)
        table.add_row(
            f"{name} [{unit}]",
            f"{other[name] / scale:.2f}",
            f"{best[name] / scale:.2f}" if best else "",
            f"{plan.objective / scale:.2f}",
            f"{100.0 * (max(values) / min(values) - 1.0):.3f}",
            str(len(plan.history.rounds)),
            f"{sum(r.solve_seconds for r in plan.history.rounds):.1f}",
            f"{walls[0]:.1f}",
            f"{searched:.0f}",
        )
        late = plan.result.full_frame.loc[SETTLE:]
        checks.add_row(
            name,
            f"{1e3 * plan.gap.crossing_time:.1e}",
            f"{plan.gap.peak_tension:.2g}",
            str(plan.history.variables),
            str(plan.history.constraints),
            f"{late.filter(regex=r'drive_force$').abs().max(axis=None) / 1e3:.3f}",
            f"{late.filter(regex=r'^c[0-9]+.power$').abs().max(axis=None) / 1e3:.3f}",
        )
    loads = int(rest.passed[0][0] - rest.passed[0][-1])
    crossings = int(constant.events["event"].str.startswith("crossing").sum())
    console = Console(width=130, markup=False)
    console.print(f"{spans} spans, {loads} loads, {until:g} s, {crossings} crossings; simulated from {SETTLE:g} s on")
    console.print(table)
    console.print(checks)


if __name__ == "__main__":
    typer.run(main)
