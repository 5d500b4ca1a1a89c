"""Heights over the ground along a run."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from ropeway.components.errors import InputError
from ropeway.systems.statics.equilibrium import Equilibrium

if TYPE_CHECKING:
    from ropeway.systems.results.run_data import RunData

_POINTS = 25
"""Points of a span at every record: the chords between them are about 1 cm above its rope. The lowest record of each
span is measured again by more."""


def heights(result: RunData) -> np.ndarray:
    """Least height of each span with its loads over the ground at all records, shape (records, spans) [m]. Raises
    InputError where the system has no ground."""
    if result.model.system.ground is None:
        raise InputError(f"{result.model.name!r} has no ground", "Give its line a terrain")
    found = []
    for point, passed in result.solved_points(range(len(result.records))):
        line = Equilibrium(result.model, point, result.runs, tuple(passed), ())
        found.append([clearance.height for clearance in line.heights_over_ground(_POINTS)])
    return np.array(found)


def clearance(result: RunData) -> pd.DataFrame:
    """As `Equilibrium.clearance`, each span at the record in which it is lowest, with its time [s]."""
    lowest = np.argmin(result.heights, axis=0)
    names = [span.name for run in result.runs for span in run.spans]
    rows: dict[str, pd.Series] = {}
    for i in sorted(set(lowest.tolist())):
        frame = result.record(i).clearance.assign(time=result.records[i].time)
        rows |= {name: frame.loc[name] for name, own in zip(names, lowest, strict=True) if own == i}
    found = pd.DataFrame([rows[name] for name in names]).rename_axis("span")
    found.attrs["units"] = {**dict.fromkeys(found.columns, "m"), "time": "s"}
    return found
