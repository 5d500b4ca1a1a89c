"""The largest payloads along a corridor, as data."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import pandas as pd

from ropeway.components.argument_checks import checked
from ropeway.components.table_writer import Tabular
from ropeway.systems.reporting.style import Style
from ropeway.systems.rigs.skyline_rig import SkylineRig
from ropeway.systems.studies.skyline.limits import is_lowered
from ropeway.systems.studies.skyline.payload.remarks import (
    BareRope,
    bare_rope,
    haulback_that_hauls,
    not_hauled,
    remarks,
    under_ground,
)


@checked
@dataclass(frozen=True, eq=False, repr=False)
class PayloadData(Tabular):
    """The largest payload by station, and derived quantities. Fields as in `rw.PayloadStudy`."""

    rig: SkylineRig
    frame: pd.DataFrame
    safety_factor: float
    mainline_safety_factor: float
    clearance: float | None
    saddle_angle: tuple[float, float] | None = None
    roller_force: float | None = None

    @property
    def hauled(self) -> bool:
        """Whether mainline and haulback can haul the carriage past all stations without a clamp."""
        return not len(self.not_hauled)

    @cached_property
    def not_hauled(self) -> np.ndarray:
        """Stations [m] at which the mainline would have to push; the payload there needs a clamp."""
        return not_hauled(self.rig, self.frame)

    @cached_property
    def haulback_needed(self) -> float | None:
        """Least haulback tension [N] that hauls the corridor's payload past all stations, at most 2 percent too high.
        None if no change is needed, or if no tension within the rope's safe working load is enough."""
        return haulback_that_hauls(self.rig, self.not_hauled, self.payload)

    @cached_property
    def bare_rope(self) -> BareRope | None:
        """Point of the bare skyline nearest to the ground; None without a terrain, or for a running skyline."""
        return bare_rope(self.rig)

    @cached_property
    def remarks(self) -> list[str]:
        """Remarks on the payload: stations at which it is not hauled; the bare rope, or where no clearance is asked the
        load or its rope, below the ground."""
        return self.remarks_in(Style())

    def remarks_in(self, style: Style) -> list[str]:
        """The remarks in a report's words and units."""
        under = under_ground(self.frame if self.clearance is None else self.frame[:0])
        return remarks(self.not_hauled, len(self.frame), self.haulback_needed, self.bare_rope, under, style)

    @cached_property
    def limiting(self) -> pd.Series[Any]:
        """The row of the station with the least payload, which is that of the corridor."""
        return self.frame.loc[self.frame["payload"].idxmin()]

    @property
    def lowered(self) -> bool:
        """Whether the yarder lowers the skyline to the clearance at each station."""
        return self.clearance is not None and is_lowered(self.rig)

    @property
    def payload(self) -> float:
        """Largest payload that passes all stations [kg]."""
        return float(self.limiting["payload"])
