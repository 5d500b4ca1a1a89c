"""How far inertia raises tensions: the peaks of a run over those of the same line in equilibrium at each time."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pandas as pd

from ropeway.components.errors import InputError
from ropeway.systems.interrupts import interruptible
from ropeway.systems.modelling.rope_path import Run
from ropeway.systems.results.quasi_static import equilibria
from ropeway.systems.results.run_data import RunData
from ropeway.systems.results.summary import each_node, ends_at

_STATES = 100
"""Largest number of equilibria, evenly over the records of a run."""
SLACK = "slack rope"
"""The event after which tensions are not quoted: the snap of a rope that tightens is not resolved."""


@interruptible
def dynamic_factor(result: RunData) -> pd.DataFrame:
    """As `Result.dynamic_factor`. Raises InputError for a run without inertia."""
    if result.model.inertia is None:
        raise InputError(f"The run of {result.model.name!r} is without inertia", "Give simulate(..., inertia=rw.Inertia())")
    until = slack_time(result)
    times = result.times
    used = np.flatnonzero(times <= until)
    which = np.unique(np.linspace(0, used[-1], min(len(used), _STATES)).round().astype(int))
    moving = _peaks(result.runs, lambda name: result.full_frame[name].to_numpy()[used])
    lines = [state for state in equilibria(result, which.tolist()) if state is not None]
    outputs = [dict(zip(state.model.y.names, state.outputs(), strict=True)) for state in lines]
    still = _peaks(result.runs, lambda name: np.array([own[name] for own in outputs]))
    rows = {
        name: {
            "kind": kind,
            "highest": float(values.max()),
            "at": float(times[used[int(values.argmax())]]),
            "quasi_static": float(still[name][1].max()) if lines else np.nan,
        }
        for name, (kind, values) in moving.items()
    }
    table = pd.DataFrame.from_dict(rows, "index").rename_axis("component")
    table["factor"] = table["highest"] / table["quasi_static"]
    table.attrs["units"] = {"highest": "N", "at": "s", "quasi_static": "N", "factor": "1"}
    return table


def slack_time(result: RunData) -> float:
    """Time of the first slack rope of a run [s]; inf without one."""
    return min((event.time for event in result.limits_reached if event.event == SLACK), default=np.inf)


def _peaks(runs: tuple[Run, ...], read: Callable[[str], np.ndarray]) -> dict[str, tuple[str, np.ndarray]]:
    """Of each span its highest tension, and of each support its bearing load or the tension of its rope, in time."""
    found: dict[str, tuple[str, np.ndarray]] = {}
    for run in runs:
        for span in run.spans:
            found[span.name] = ("rope", read(f"{span.name}.utilisation") * span.rope.breaking_load)
    for node in each_node(runs):
        try:
            value = read(f"{node.name}.bearing_load")
        except KeyError:
            value = np.max([read(name) for name in ends_at(runs, node)], axis=0)
        found[node.name] = ("support", value)
    return found
