"""All load cases of a line or a rig, as data."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import pandas as pd

from ropeway.components.argument_checks import checked
from ropeway.components.rounding import at_least
from ropeway.components.table_writer import Tabular
from ropeway.systems.modelling.system import System
from ropeway.systems.rigs.skyline_rig import SkylineRig
from ropeway.systems.statics.equilibrium import Equilibrium
from ropeway.systems.studies.load_cases import governing
from ropeway.systems.studies.load_cases.load_case import LoadCase


@checked
@dataclass(frozen=True, eq=False, repr=False)
class CasesData(Tabular):
    """All load cases, and what governs. Fields as in `rw.LoadCases`."""

    of: System | SkylineRig
    cases: tuple[LoadCase, ...]
    frame: pd.DataFrame
    tensions: pd.DataFrame
    supports: pd.DataFrame
    clearances: pd.DataFrame | None
    states: dict[str, Equilibrium | pd.DataFrame]

    def __repr__(self) -> str:
        worst = self.frame["utilisation"].idxmax()
        used = 100.0 * float(self.frame.loc[worst, "utilisation"])
        most = f"{at_least(used)} % of the tension allowed in {worst!r}"
        return f"<LoadCases of {self.of.name!r}: {len(self.cases)} cases, {most}>"

    @cached_property
    def governing(self) -> pd.DataFrame:
        """Which case sets the extreme of each rope, support and clearance, and by how much: columns subject (rope,
        support or clearance), name, rope, quantity, extreme (highest or lowest), case, value, unit, next_case,
        next_value, by (the difference), share (of the next value)."""
        return governing.governing(self.tensions, self.supports, self.clearances)
