"""Forces on the supports of a rig with its carriage at many places."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from ropeway.systems.modelling.rope_path import Run
from ropeway.systems.results.end_forces import end_forces
from ropeway.systems.results.support_rows import ALL, OF_FORCES, RopeSeat, support_rows
from ropeway.systems.studies.skyline.carriage_model import Solved, SpanModel

EXTREMES = ("highest bearing load", "least vertical force", "largest break angle")
"""States of a support that a table shows."""


def support_states(solved: Sequence[Solved], rollers: Mapping[str, int] | None = None) -> pd.DataFrame:
    """Rows of all solved states in the columns of `support_rows`; state is the number of the solved state."""
    groups: dict[SpanModel, list[int]] = {}
    for i, one in enumerate(solved):
        groups.setdefault(one.at, []).append(i)
    found = []
    for at, members in groups.items():
        states = [solved[i] for i in members]
        ends = end_forces(at.model, [one.point for one in states], at.model.runs, at.passed)
        outputs = np.array([one.outputs for one in states])
        rows = support_rows(at.model, ends, outputs, rollers, _Names(at))
        rows["state"] = np.array(members)[rows["state"]]
        found.append(rows)
    frame = _with_sums(pd.concat(found, ignore_index=True))
    frame.attrs["units"] = found[0].attrs["units"]
    return frame


def _with_sums(rows: pd.DataFrame) -> pd.DataFrame:
    """The rows with one for all ropes in every state, at supports that have several ropes in any."""
    several = rows.loc[rows["rope"] == ALL, "support"].unique()
    own = rows[rows["support"].isin(several)]
    lone = own[~own.duplicated(["state", "support"], keep=False)].assign(rope=ALL)
    lone[[c for c in lone.columns[4:] if c not in OF_FORCES]] = np.nan
    return pd.concat([rows, lone], ignore_index=True).sort_values("state", kind="stable", ignore_index=True)


class _Names:
    """Names of a rig's supports and ropes: whatever sits at the top of a spar or support belongs to it."""

    def __init__(self, at: SpanModel) -> None:
        self._roles, self._rig = at.roles, at.rig
        self._stands = {tuple(node.at): node.name for node in at.rig.stands}

    def __call__(self, seat: RopeSeat, run: Run) -> tuple[str, str]:
        support, role = seat.support, self._roles[seat.run]
        name = self._stands.get(tuple(support.at), support.name)
        if role == "":
            return name, run.nodes[0].name  # a guyline is named by its anchor
        return name, self._rig.kind.carrying_rope if role == "skyline" else role


def extremes(states: pd.DataFrame) -> pd.DataFrame:
    """For each rope at each support the rows of its `EXTREMES`, with the least force and reserve of all states."""
    found = []
    for _, rows in states.groupby(["support", "rope"], sort=False):
        wanted = [rows["bearing_load"].idxmax(), rows["vertical_force"].idxmin()]
        angles = rows["break_angle"].dropna()
        if len(angles):
            wanted.append(angles.abs().idxmax())
        part = rows.loc[wanted].assign(extreme=EXTREMES[: len(wanted)])
        for name in ("least_force", "lift_off_reserve"):
            part[name] = rows[name].min()
        found.append(part)
    frame = pd.concat(found, ignore_index=True)
    frame.attrs["units"] = states.attrs["units"]
    return frame
