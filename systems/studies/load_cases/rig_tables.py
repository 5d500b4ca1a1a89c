"""Tables of a rig in all load cases, over the stations of its carriage."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import pandas as pd

from ropeway.systems.results.support_rows import UNITS
from ropeway.systems.rigs.skyline_rig import SkylineRig
from ropeway.systems.studies.load_cases.case_tables import CaseTables, RopeTension, rope_rows, with_units
from ropeway.systems.studies.load_cases.load_case import LoadCase
from ropeway.systems.studies.skyline.carriage_model import Solved
from ropeway.systems.studies.skyline.clearances import load_clearance, rope_clearance
from ropeway.systems.studies.skyline.rope_tensions import end_tensions
from ropeway.systems.studies.skyline.support_states import extremes, support_states


def rig_tables(
    rig: SkylineRig, cases: Sequence[LoadCase], states: Sequence[Sequence[Solved]], stations: np.ndarray
) -> CaseTables:
    """The tables of a rig with its carriage at all stations in each case."""
    ropes = [
        row
        for case, solved in zip(cases, states, strict=True)
        for row in rope_rows(case, list(_tensions(rig, solved, stations)))
    ]
    supports = pd.concat(
        [rig_supports(solved, stations).assign(case=case.name) for case, solved in zip(cases, states, strict=True)],
        ignore_index=True,
    )
    supports = supports[["case", *(c for c in supports.columns if c != "case")]]
    clearances = None
    if rig.terrain is not None:
        rows = [row for case, solved in zip(cases, states, strict=True) for row in _clearances(rig, case, solved)]
        clearances = with_units(pd.DataFrame(rows))
    return CaseTables(with_units(pd.DataFrame(ropes)), with_units(supports, dict(UNITS)), clearances)


def rig_supports(solved: Sequence[Solved], stations: np.ndarray) -> pd.DataFrame:
    """Rows of a rig's supports: in the extreme states over several stations, or at the only one."""
    states = support_states(solved)
    found = extremes(states) if len(solved) > 1 else states.assign(extreme="")
    found["station"] = stations[found.pop("state").to_numpy()]
    columns = ["support", "kind", "rope", "extreme", "station"]
    found = found[[*columns, *(c for c in found.columns if c not in columns)]]
    return with_units(found, dict(UNITS))


def _tensions(rig: SkylineRig, solved: Sequence[Solved], stations: np.ndarray) -> Iterator[RopeTension]:
    """Of each rope, over all stations."""
    found: dict[str, RopeTension] = {}
    for one, station in zip(solved, stations.tolist(), strict=True):
        for run, role in zip(one.at.model.runs, one.at.roles, strict=True):
            name = rig.kind.carrying_rope if role == "skyline" else role or run.nodes[0].name
            ends = np.array(end_tensions(one, run.spans))
            k, known = int(np.argmax(ends)), found.get(name)
            lowest = float(ends.min()) if known is None else min(known.lowest, float(ends.min()))
            if known is None or ends[k] > known.highest:
                known = RopeTension(name, run.rope, float(ends[k]), lowest, run.spans[k // 2].name, station)
            found[name] = known._replace(lowest=lowest)
    yield from found.values()


def _clearances(rig: SkylineRig, case: LoadCase, solved: Sequence[Solved]) -> Iterator[dict[str, object]]:
    """Of each span of the corridor, over the stations in it."""
    if rig.terrain is None:
        return
    heights = [(one.at.span, rope_clearance(one, rig.terrain), load_clearance(one, rig.terrain)) for one in solved]
    for k in sorted({span for span, _, _ in heights}):
        own = np.array([pair for span, *pair in heights if span == k])
        name = f"{rig.stands[k].name}_{rig.stands[k + 1].name}"
        rope, load = own.min(axis=0)
        yield {"case": case.name, "span": name, "rope_clearance": float(rope), "load_clearance": float(load)}
