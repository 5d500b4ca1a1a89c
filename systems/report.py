"""What a run comes to: safety, power and energy, as tables and text."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from ropeway.components.component import Node
from ropeway.components.response import ThresholdResponse
from ropeway.components.rounding import at_least, at_most
from ropeway.systems.interrupts import interruptible
from ropeway.systems.model import component_of

if TYPE_CHECKING:
    from ropeway.systems.result import Result
    from ropeway.systems.run import Run


@dataclass(frozen=True)
class Summary:
    """The safety report of a run. supports: a row each (highest and lowest tension with their times, least
    support force, grip and relief); spans: a row each (highest tension over SWL and MBL, lowest tension,
    largest sag below the chord); `str()` gives the text."""

    supports: pd.DataFrame
    spans: pd.DataFrame
    text: str

    def __str__(self) -> str:
        return self.text


@interruptible
def summary(result: Result) -> Summary:
    """The safety report; forces in N, times in s, from both sides of every event."""
    spans = pd.DataFrame(_span_rows(result))
    happened = result.events
    held = Counter(happened.loc[happened["event"] == "load held", "component"])
    supports = pd.DataFrame([_support_row(result, node, held[node.name]) for node in _each(result.runs)])
    return Summary(supports.set_index("support"), spans.set_index("span"), _text(result, supports, spans))


def _span_rows(result: Result) -> list[dict[str, object]]:
    """A row a span; each record in which a span sags most is made once for all spans."""
    frame = result.full_frame
    every = [(run, span.name) for run in result.runs for span in run.spans]
    slackest = [int(frame[f"{name}.horizontal"].to_numpy().argmin()) for _, name in every]
    rows: dict[str, dict[str, object]] = {}
    for low in sorted(set(slackest)):
        line = result.record(low)
        for (run, name), own in zip(every, slackest, strict=True):
            if own == low:
                rows[name] = _span_row(frame, run, low, line.profile(name, 201), name)
    return [rows[name] for _, name in every]


def _span_row(frame: pd.DataFrame, run: Run, low: int, curve: pd.DataFrame, name: str) -> dict[str, object]:
    ends, rope = frame[[f"{name}.tension_a", f"{name}.tension_b"]].to_numpy(), run.rope
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


def _support_row(result: Result, node: Node, held: int) -> dict[str, object]:
    frame, time = result.full_frame, result.full_frame.index.to_numpy()
    tension = frame[_ends_at(result.runs, node)].to_numpy()
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
    response = getattr(node, "response", None)
    if isinstance(response, ThresholdResponse):
        outside = ((tension > response.high) | (tension < response.low)).any(axis=1)
        row["time_outside_range"] = np.trapezoid(outside.astype(float), time)
    row["loads_held"] = held
    return row


def _ends_at(runs: Sequence[Run], node: Node) -> list[str]:
    """The tensions of the ropes at a node, as names of outputs."""
    found = []
    for run in runs:
        for k, other in enumerate(run.nodes):
            if other is node:
                found += [f"{run.spans[k - 1].name}.tension_b"] if k > 0 else []
                found += [f"{run.spans[k].name}.tension_a"] if k < len(run.spans) else []
    return found


def _text(result: Result, supports: pd.DataFrame, spans: pd.DataFrame) -> str:
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
    for column, sign, words in (
        ("least_support_force", -1.0, "Supports from which the rope lifts off (least support force [N])"),
        ("least_grip_margin", -1.0, "Drives on which the rope slips (least grip margin)"),
        ("relief_open_time", 1.0, "Drives with an open relief valve (time [s])"),
        ("loads_held", 1.0, "Hold-down supports that a load could not pass (number of loads)"),
        ("time_outside_range", 1.0, "Control sheaves outside their tension range (time [s])"),
    ):
        if column in supports:
            found = supports[sign * supports[column].fillna(0.0) > 0.0]
            values = ", ".join(f"{r['support']} ({r[column]:.4g})" for _, r in found.iterrows())
            lines.append(f"{words}: {values or 'none'}")
    return "\n".join(lines)


def power(result: Result) -> pd.DataFrame:
    """Power of the drives into the rope: index sheave, and `line` for all; mean, highest and lowest power [W],
    energy pulled and recovered [J]."""
    frame = result.full_frame
    time = frame.index.to_numpy()
    columns = [c for c in frame.columns if c.endswith(".power")]
    values = {component_of(c): frame[c].to_numpy() for c in columns}
    if values:
        values["line"] = np.sum(list(values.values()), axis=0)
    rows = {
        name: {
            "mean": np.trapezoid(p, time) / time[-1],
            "highest": p.max(),
            "lowest": p.min(),
            "pulled": np.trapezoid(np.maximum(p, 0.0), time),
            "recovered": np.trapezoid(np.maximum(-p, 0.0), time),
        }
        for name, p in values.items()
    }
    return pd.DataFrame.from_dict(rows, orient="index").rename_axis("sheave")


def energy(result: Result) -> pd.Series:
    """The energy balance of a run [J].

    drives (work of the control sheaves' drives), ends (work of drums and of supports that move, and energy of the rope
    that drums pay out or wind in), loads (weight put on and taken off), take_up (work that components take from
    outside, as a tensioned return) go in; gravity, elastic, kinetic (of the components) is what is gained; friction
    and crossings (what a line loses when it jumps as a load passes an idler) is what is spent; residual is the rest,
    zero but for the integration.
    """
    frame, times = result.full_frame, result.times
    still = np.diff(times) == 0.0
    parts = dict.fromkeys(("drives", "ends", "loads", "take_up", "friction", "kinetic"), np.zeros(len(still)))
    for r in range(len(result.runs)):
        _add(parts, _rope_work(result, r))
    for node in _each(result.runs):
        _add(parts, _own_work(result, node))
    elastic = np.diff(frame.filter(regex=r"\.elastic_energy$").sum(axis=1))
    gravity = np.diff(frame.filter(regex=r"\.gravity_energy$").sum(axis=1))
    kinetic = parts.pop("kinetic")
    work = parts["drives"] + parts["ends"] + parts["loads"] + parts["take_up"] - parts["friction"]
    left = work - elastic - gravity - kinetic
    return pd.Series(
        {
            **{name: value.sum() for name, value in parts.items() if name != "friction"},
            "gravity": gravity.sum(),
            "elastic": elastic.sum(),
            "kinetic": kinetic.sum(),
            "friction": parts["friction"].sum(),
            "crossings": left[still].sum(),
            "residual": left[~still].sum(),
        },
        name="energy [J]",
    )


def _add(parts: dict[str, np.ndarray], more: Mapping[str, np.ndarray]) -> None:
    for name, value in more.items():
        parts[name] = parts[name] + value


def _mean(values: np.ndarray | pd.Series) -> np.ndarray:
    """In each interval between records."""
    array = np.asarray(values)
    return (array[1:] + array[:-1]) / 2.0


def _drives(node: Node) -> bool:
    """Whether a node drives a rope that runs over it."""
    return node.drive_speed is not None and node.through(node.arriving) is not None


def _rope_work(result: Result, r: int) -> dict[str, np.ndarray]:
    """Work of supports and loads on a rope in each interval, by kind."""
    frame, run = result.full_frame, result.runs[r]
    weight, strain = run.rope.mass_per_length * result.parameters[0], run.rope.strain
    none = np.zeros(len(result.times) - 1)
    parts = {"drives": none, "ends": none, "loads": _load_work(result, r), "friction": none}
    last, moves = len(run.nodes) - 1, np.diff(result.times) > 0.0
    for k, (node, seat) in enumerate(zip(run.nodes, run.seats, strict=True)):
        coming = None if k == 0 else frame[f"{run.spans[k - 1].name}.tension_b"]
        going = None if k == last else frame[f"{run.spans[k].name}.tension_a"]
        parts["ends"] = parts["ends"] + _shift_work(result, r, k)
        if f"{node.name}.{seat.travel}" not in frame or (run.closed and k == last):
            continue
        if run.closed and k == 0:
            coming = frame[f"{run.spans[-1].name}.tension_b"]
        moved = np.diff(frame[f"{node.name}.{seat.travel}"])
        if coming is None or going is None:
            tension, sign = (going, -1.0) if coming is None else (coming, 1.0)
            carried = strain.potential(np.asarray(tension)) - weight * _coordinate(result, node, "z")
            parts["ends"] = parts["ends"] + sign * _mean(carried) * moved
            continue
        gained = _mean(strain.potential(coming) - strain.potential(going)) * moved
        if _drives(node):
            parts["drives"] = parts["drives"] + gained
        else:
            parts["friction"] = parts["friction"] - gained * moves
    return parts


def _coordinate(result: Result, node: Node, axis: str) -> np.ndarray | float:
    """Of a node, over time where it moves [m]."""
    name = f"{node.name}.{axis}"
    place = result.model.p.index.get(name)
    return result.full_frame[name].to_numpy() if place is None else float(result.parameters[place])


def _shift_work(result: Result, r: int, k: int) -> np.ndarray | float:
    """Work on a rope of a node that moves, by the forces at the rope's ends there."""
    run, frame, work = result.runs[r], result.full_frame, 0.0
    node, first = run.nodes[k], result.model.layouts[r].force
    for i, axis in enumerate("xyz"):
        if f"{node.name}.{axis}" not in frame:
            continue
        force = np.zeros(len(result.times))
        for span, end, sign in ((k, "a", -1.0), (k - 1, "b", 1.0)):
            if 0 <= span < len(run.spans):
                tension = result.algebraic[:, first[span] + i]
                force += frame[f"{run.spans[span].name}.vertical_{end}"] if axis == "z" else sign * tension
        work = work + _mean(force) * np.diff(frame[f"{node.name}.{axis}"])
    return work


def _own_work(result: Result, node: Node) -> dict[str, np.ndarray]:
    """What a component takes from outside, stores and loses in each interval: what it gives goes into ropes, its own
    motion and its losses."""
    own = node.energies(lambda name: result.full_frame[f"{node.name}.{name}"].to_numpy())
    none = np.zeros(len(result.times))
    kinetic, supplied = np.diff(none + own.kinetic), np.diff(none + own.supplied)
    lost = _mean(none + own.loss) * np.diff(result.times)
    given = lost + kinetic - supplied
    return {
        "drives" if _drives(node) else "ends": given,
        "kinetic": kinetic,
        "friction": lost,
        "take_up": supplied,
    }


def _load_work(result: Result, r: int) -> np.ndarray:
    """Energy that loads bring with them when they are put on, or take away."""
    work, run = np.zeros(len(result.times) - 1), result.runs[r]
    if run.closed:
        return work
    loads, gravity = run.loads, result.parameters[0]
    for k, sign in ((0, 1.0), (len(run.nodes) - 1, -1.0)):
        passed = np.array([record.passed[r][k] - loads.first for record in result.records])
        total = np.concatenate([[0.0], np.cumsum(loads.mass)])
        height = _coordinate(result, run.nodes[k], "z") + np.zeros(len(result.times))
        work += sign * np.diff(total[passed]) * gravity * _mean(height)
    return work


def _each(runs: Sequence[Run]) -> list[Node]:
    """All nodes, each once."""
    return list({node.name: node for run in runs for node in run.nodes}.values())
