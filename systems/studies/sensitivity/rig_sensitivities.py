"""Derivatives of a rig's load path, station by station."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from ropeway.components import check
from ropeway.components.errors import InputError
from ropeway.systems.results.column_labels import Labels
from ropeway.systems.rigs.skyline_rig import SkylineRig
from ropeway.systems.studies.sensitivity.rig_quantities import linearised, unit_of
from ropeway.systems.studies.sensitivity.rig_readings import rig_reading, unit_of_reading
from ropeway.systems.studies.skyline.certified_states import certified
from ropeway.systems.studies.skyline.load_path import carriage_height, stations_of
from ropeway.systems.studies.skyline.station_solver import Stations


def rig_sensitivities(
    rig: SkylineRig,
    of: Sequence[str],
    to: Sequence[str],
    payload: float,
    stations: Sequence[float] | np.ndarray | None,
    height: float | None,
    *,
    compiled: bool,
) -> pd.DataFrame:
    """A row for each station, columns (of, to). Raises UnknownNameError, InputError, EquilibriumError."""
    check.not_negative(payload, rig.name, "payload", "kg")
    if height is not None and not rig.kind.sets_height:
        raise InputError(f"{rig.name} cannot be lowered or raised", "Remove height, or use a live skyline")
    solver = Stations(rig, by_height=height is not None, compiled=compiled)
    places = stations_of(rig, stations)
    heights = [None if height is None else carriage_height(rig, float(x), height) for x in places]
    solved = certified([solver.solve(float(x), payload, z) for x, z in zip(places, heights, strict=True)])
    rows = []
    for one in solved:
        state = linearised(one, to)
        rows.append(np.concatenate([rig_reading(one, name).at(state)[1].ravel() for name in of]))
    columns = pd.MultiIndex.from_product([of, to], names=["of", "to"])
    frame = pd.DataFrame(rows, index=pd.Index(places, name="station"), columns=columns)
    frame.attrs["units"] = Labels({name: unit_of_reading(solved[0], name) for name in of})
    frame.attrs["per"] = Labels({name: unit_of(solved[0].at, name) for name in to})
    return frame
