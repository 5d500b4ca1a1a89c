"""The safety report of a run, as tables and text."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from ropeway.components.node import Node
from ropeway.components.response import response_of
from ropeway.components.rounding import at_least, at_most
from ropeway.systems.interrupts import interruptible

if TYPE_CHECKING:
    from ropeway.systems.modelling.rope_path import Run
    from ropeway.systems.results.run_data import RunData


@dataclass(frozen=True)
class Summary:
    """The safety report of a run. `supports` has a row per support (highest and lowest tension with times, least
    support force, grip and relief), `spans` a row per span (highest tension over SWL and MBL, lowest tension, largest
    sag below the chord). `str()` gives the text."""

    supports: pd.DataFrame
    spans: pd.DataFrame
    text: str

    def __str__(self) -> str:
        return self.text


@interruptible
def summary(result: RunData, factors: pd.DataFrame | None = None) -> Summary:
    """The safety report, with forces in N and times in s, from both sides of every event. `factors`: of a run with
    inertia, its `dynamic_factor`."""
    spans = pd.DataFrame(_span_rows(result))
    events = result.events
    held = Counter(events.loc[events["event"] == "load held", "component"])
    supports = pd.DataFrame([_support_row(result, node, held[node.name]) for node in each_node(result.runs)])
    if factors is not None:
        for table, key in ((spans, "span"), (supports, "support")):
            table["dynamic_factor"] = factors["factor"].reindex(table[key]).to_numpy()
    return Summary(supports.set_index("support"), spans.set_index("span"), _text(result, supports, spans))


def _span_rows(result: RunData) -> list[dict[str, object]]:
    """One row per span. Each record with the largest sag of a span is created once for all spans."""
    frame, until = result.full_frame, result.slack_time
    every = [(run, span.name) for run in result.runs for span in run.spans]
    lowest_record = [int(frame[f"{name}.horizontal"].to_numpy().argmin()) for _, name in every]
    rows: dict[str, dict[str, object]] = {}
    for low in sorted(set(lowest_record)):
        line = result.record(low)
        for (run, name), own in zip(every, lowest_record, strict=True):
            if own == low:
                rows[name] = _span_row(frame, run, low, line.profile(name, 201), name, until)
    return [rows[name] for _, name in every]


def _span_row(
    frame: pd.DataFrame, run: Run, low: int, curve: pd.DataFrame, name: str, until: float
) -> dict[str, object]:
    counted = frame.index <= until
    ends, rope = frame.loc[counted, [f"{name}.tension_a", f"{name}.tension_b"]].to_numpy(), run.rope
    high = int(ends.max(axis=1).argmax())
    x, y, z = (curve[axis].to_numpy() for axis in "xyz")
    along = np.hypot(x - x[0], y - y[0])
    chord = z[0] + along / along[-1] * (z[-1] - z[0]) if along[-1] > 0.0 else z
    return {
        "span": name,
        "highest_tension": ends[high].max(),
        "at": frame.index[high],
        "over_SWL": ends[high].max() / rope.safe_working_load,
        "over_MBL": ends[high].max() / rope.breaking_load,
        "lowest_tension": ends.min(),
        "largest_sag": float((chord - z).max()),
        "sag_at": frame.index[low],
    }


def _support_row(result: RunData, node: Node, held: int) -> dict[str, object]:
    frame = result.full_frame[result.full_frame.index <= result.slack_time]
    time = frame.index.to_numpy()
    tension = frame[ends_at(result.runs, node)].to_numpy()
    row: dict[str, object] = {
        "support": node.name,
        "kind": type(node).__name__,
        "highest_tension": tension.max(),
        "at": time[tension.max(axis=1).argmax()],
        "lowest_tension": tension.min(),
    }
    for column, quantity in (("least_support_force", "support_force"), ("least_grip_margin", "grip_margin")):
        if f"{node.name}.{quantity}" in frame:
            row[column] = frame[f"{node.name}.{quantity}"].min()
    if f"{node.name}.relief_open" in frame:
        row["relief_open_time"] = np.trapezoid(frame[f"{node.name}.relief_open"], time)
    response = response_of(node)
    if response is not None and response.tension_range is not None:
        low, high = response.tension_range
        outside = ((tension > high) | (tension < low)).any(axis=1)
        row["time_outside_range"] = np.trapezoid(outside.astype(float), time)
    row["loads_held"] = held
    return row


def ends_at(runs: Sequence[Run], node: Node) -> list[str]:
    """Names of the outputs with rope tensions at a node."""
    found = []
    for run in runs:
        for k, other in enumerate(run.nodes):
            if other is node:
                found += [f"{run.spans[k - 1].name}.tension_b"] if k > 0 else []
                found += [f"{run.spans[k].name}.tension_a"] if k < len(run.spans) else []
    return found


def _text(result: RunData, supports: pd.DataFrame, spans: pd.DataFrame) -> str:
    rope = result.runs[0].rope
    top, sag = spans.loc[spans["highest_tension"].idxmax()], spans.loc[spans["largest_sag"].idxmax()]
    low = spans.loc[spans["lowest_tension"].idxmin()]
    lines = [
        f"{result.model.name}: {len(spans)} spans, {result.times[-1]:g} s",
        f"Highest tension {at_least(top['highest_tension'] / 1e3, 1)} kN in {top['span']} at {top['at']:.1f} s: "
        f"{at_least(100.0 * top['over_SWL'])} % of SWL {at_most(rope.safe_working_load / 1e3, 1)} kN, "
        f"{at_least(100.0 * top['over_MBL'])} % of MBL {at_most(rope.breaking_load / 1e3, 1)} kN",
        f"Lowest tension {at_most(low['lowest_tension'] / 1e3, 1)} kN in {low['span']}; "
        f"largest sag {sag['largest_sag']:.2f} m in {sag['span']} at {sag['sag_at']:.1f} s",
    ]
    if "dynamic_factor" in spans:
        worst, held = (t.loc[t["dynamic_factor"].idxmax()] for t in (spans, supports))
        lines.append(
            f"Largest dynamic factor {at_least(worst['dynamic_factor'], 2)} of a rope ({worst['span']}), "
            f"{at_least(held['dynamic_factor'], 2)} of a support ({held['support']})"
        )
    if np.isfinite(result.slack_time):
        lines.append(
            f"A rope goes slack at {result.slack_time:.2f} s. Tensions count until then: the snap of a rope that "
            "tightens again is not resolved"
        )
    if result.in_balance:
        lines.append(f"Without inertia, in equilibrium at every time: {', '.join(result.in_balance)}")
    for column, sign, words in (
        ("least_support_force", -1.0, "Supports where the rope lifts off (least support force [N])"),
        ("least_grip_margin", -1.0, "Drives on which the rope slips (least grip margin)"),
        ("relief_open_time", 1.0, "Drives with an open relief valve (time [s])"),
        ("loads_held", 1.0, "Hold-down supports that held a load (number of loads)"),
        ("time_outside_range", 1.0, "Control sheaves outside their tension range (time [s])"),
    ):
        if column in supports:
            found = supports[sign * supports[column].fillna(0.0) > 0.0]
            values = ", ".join(f"{r['support']} ({r[column]:.4g})" for _, r in found.iterrows())
            lines.append(f"{words}: {values or 'none'}")
    if result.model.system.ground is not None:
        lowest = result.clearance.loc[result.clearance["rope_clearance"].idxmin()]
        height = at_most(lowest["rope_clearance"], 2)
        lines.append(f"Least height over the ground {height} m in {lowest.name} at {lowest['time']:.1f} s")
    return "\n".join(lines)


def each_node(runs: Sequence[Run]) -> list[Node]:
    """All nodes without repetition."""
    return list({node.name: node for run in runs for node in run.nodes}.values())
