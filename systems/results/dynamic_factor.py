"""What inertia adds to a run: tensions over those in equilibrium, and how far loads swing."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import pandas as pd

from ropeway.systems.modelling.rope_path import Run
from ropeway.systems.results.quasi_static import QuasiStatic
from ropeway.systems.results.run_data import RunData
from ropeway.systems.results.summary import each_node, ends_at
from ropeway.systems.statics.line_state import LineState


def dynamic_factor(result: RunData, still: QuasiStatic) -> pd.DataFrame:
    """As `Result.dynamic_factor`."""
    until, times = result.slack_time, result.times
    used = np.flatnonzero(times <= until)
    moving = _peaks(result.runs, lambda name: result.full_frame[name].to_numpy()[used])
    outputs = [
        dict(zip(line.model.y.names, line.outputs(), strict=True))
        for i, line in zip(still.records, still.lines, strict=True)
        if times[i] <= until
    ]
    resting = _peaks(result.runs, lambda name: np.array([own[name] for own in outputs])) if outputs else {}
    rows = {
        name: {
            "kind": kind,
            "highest": float(values.max()),
            "at": float(times[used[int(values.argmax())]]),
            "quasi_static": float(resting[name][1].max()) if resting else np.nan,
        }
        for name, (kind, values) in moving.items()
    }
    table = pd.DataFrame.from_dict(rows, "index").rename_axis("component")
    table["factor"] = table["highest"] / table["quasi_static"]
    table.attrs["units"] = {"highest": "N", "at": "s", "quasi_static": "N", "factor": "1"}
    return table


def _peaks(runs: Sequence[Run], read: Callable[[str], np.ndarray]) -> dict[str, tuple[str, np.ndarray]]:
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


def swing(result: RunData, still: QuasiStatic) -> pd.DataFrame:
    """As `Result.swing`."""
    largest: dict[str, tuple[float, float]] = {}
    for i, line in zip(still.records.tolist(), still.lines, strict=True):
        resting = _places(line)
        for name, place in _places(result.state(i)).items():
            if name in resting:
                away = float(np.linalg.norm(place - resting[name]))
                largest[name] = max(largest.get(name, (0.0, 0.0)), (away, float(result.times[i])))
    frame = pd.DataFrame.from_dict(largest, "index", columns=["swing", "at"]).rename_axis("load")
    frame.attrs["units"] = {"swing": "m", "at": "s"}
    return frame


def _places(line: LineState) -> dict[str, np.ndarray]:
    """Where the loads of a line are [m]."""
    outputs, index, found = line.outputs(), line.model.y.index, dict[str, np.ndarray]()
    for run, beyond in zip(line.runs, line.passed, strict=True):
        for k, span in enumerate(run.spans):
            for j, load in enumerate(range(int(beyond[k]) - 1, int(beyond[k + 1]) - 1, -1)):
                if run.loads.mass[load] > 0.0:
                    place = [outputs[index[f"{span.name}.slot_{axis}[{j + 1}]"]] for axis in "xyz"]
                    found[run.loads.names[load]] = np.array(place)
    return found
