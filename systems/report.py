"""What a run comes to: safety, power and energy, as tables and text."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from ropeway.components.component import Node
from ropeway.components.control_sheave import ControlSheave
from ropeway.components.response import ThresholdResponse
from ropeway.components.return_wheel import TensionedReturn
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


def summary(result: Result) -> Summary:
    """The safety report; forces in N, times in s, from both sides of every event."""
    frame = result.full_frame
    spans = pd.DataFrame([_span_row(result, run, k) for run in result.runs for k in range(len(run.spans))])
    nodes = {node.name: node for run in result.runs for node in run.nodes}
    supports = pd.DataFrame([_support_row(result, frame, node) for node in nodes.values()])
    return Summary(supports.set_index("support"), spans.set_index("span"), _text(result, supports, spans))


def _span_row(result: Result, run: Run, k: int) -> dict[str, object]:
    frame, name, rope = result.full_frame, run.spans[k].name, run.rope
    ends = frame[[f"{name}.tension_a", f"{name}.tension_b"]].to_numpy()
    high, low = int(ends.max(axis=1).argmax()), int(frame[f"{name}.horizontal"].to_numpy().argmin())
    curve = result.record(low).profile(name, 201)
    a, b = curve.iloc[0], curve.iloc[-1]
    along = np.hypot(curve["x"] - a["x"], curve["y"] - a["y"])
    chord = a["z"] + along / along.iloc[-1] * (b["z"] - a["z"]) if along.iloc[-1] > 0.0 else curve["z"]
    return {
        "span": name,
        "highest_tension": ends[high].max(),
        "at": frame.index[high],
        "over_SWL": ends[high].max() / rope.safe_working_load,
        "over_MBL": ends[high].max() / rope.breaking_load,
        "lowest_tension": ends.min(),
        "largest_sag": float((chord - curve["z"]).max()),
        "sag_at": frame.index[low],
    }


def _support_row(result: Result, frame: pd.DataFrame, node: Node) -> dict[str, object]:
    sides = [
        c for c in (f"{node.name}.{q}" for q in ("tension_in", "tension_out", "rope_tension", "tension")) if c in frame
    ]
    tension = frame[sides].to_numpy()
    time = frame.index.to_numpy()
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
    response = node.response if isinstance(node, ControlSheave) else None
    if isinstance(response, ThresholdResponse):
        outside = ((tension > response.high) | (tension < response.low)).any(axis=1)
        row["time_outside_range"] = np.trapezoid(outside.astype(float), time)
    held = result.events.query("event == 'load held'")
    row["loads_held"] = int((held["component"] == node.name).sum())
    return row


def _text(result: Result, supports: pd.DataFrame, spans: pd.DataFrame) -> str:
    rope = result.runs[0].rope
    top, sag = spans.loc[spans["highest_tension"].idxmax()], spans.loc[spans["largest_sag"].idxmax()]
    low = spans.loc[spans["lowest_tension"].idxmin()]
    lines = [
        f"{result.model.name}: {len(spans)} spans, {result.times[-1]:g} s",
        f"Highest tension {top['highest_tension'] / 1e3:.1f} kN in {top['span']} at {top['at']:.1f} s: "
        f"{top['over_SWL']:.0%} of SWL {rope.safe_working_load / 1e3:.1f} kN, "
        f"{top['over_MBL']:.0%} of MBL {rope.breaking_load / 1e3:.1f} kN",
        f"Lowest tension {low['lowest_tension'] / 1e3:.1f} kN in {low['span']}; "
        f"largest sag {sag['largest_sag']:.2f} m in {sag['span']} at {sag['sag_at']:.1f} s",
    ]
    for column, sign, words in (
        ("least_support_force", -1.0, "rope lifts off [N]"),
        ("least_grip_margin", -1.0, "grip lost"),
        ("relief_open_time", 1.0, "relief valve open [s]"),
        ("loads_held", 1.0, "loads held at a hold-down"),
        ("time_outside_range", 1.0, "outside its tension range [s]"),
    ):
        if column in supports:
            found = supports[sign * supports[column].fillna(0.0) > 0.0]
            values = ", ".join(f"{r['support']} ({r[column]:.4g})" for _, r in found.iterrows())
            lines.append(f"{words}: {values or 'nowhere'}")
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

    drives (work of the control sheaves' drives), ends (work of drums, and energy of the rope that they pay
    out or wind in), loads (weight put on and taken off), take_up (work of a tensioned return) go in; gravity,
    elastic, kinetic (of the drives) is what is gained; friction and crossings (what a line loses when it
    jumps as a load passes an idler) is what is spent; residual is what is left, zero but for the integration.
    """
    frame, times = result.full_frame, result.times
    still = np.diff(times) == 0.0
    parts = dict.fromkeys(("drives", "ends", "loads", "take_up", "friction"), np.zeros(len(still)))
    for run in result.runs:
        for name, value in _run_energy(result, run).items():
            parts[name] = parts[name] + value
    elastic = np.diff(frame.filter(regex=r"\.elastic_energy$").sum(axis=1))
    gravity = np.diff(frame.filter(regex=r"\.gravity_energy$").sum(axis=1))
    kinetic = np.diff(_kinetic(result))
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


def _run_energy(result: Result, run: Run) -> dict[str, np.ndarray]:
    """Work in each interval between records, by kind."""
    frame, times = result.full_frame, result.times
    weight, strain = run.rope.mass_per_length * result.parameters[0], run.rope.strain
    none = np.zeros(len(times) - 1)
    parts = {"drives": none, "ends": none, "loads": _load_work(result, run), "take_up": none, "friction": none}

    def mean(values: np.ndarray | pd.Series) -> np.ndarray:
        array = np.asarray(values)
        return (array[1:] + array[:-1]) / 2.0

    last = len(run.nodes) - 1
    for k, node in enumerate(run.nodes[: last if run.closed else None]):
        if f"{node.name}.travel" not in frame:
            continue
        moved = np.diff(frame[f"{node.name}.travel"])
        if k in (0, last) and not run.closed:
            height = result.parameters[result.model.p.index[f"{node.name}.z"]]
            carried = strain.potential(frame[f"{node.name}.rope_tension"].to_numpy()) - weight * height
            parts["ends"] = parts["ends"] + (1.0 if k else -1.0) * mean(carried) * moved
            continue
        gained = strain.potential(frame[f"{node.name}.tension_in"]) - strain.potential(
            frame[f"{node.name}.tension_out"]
        )
        if not isinstance(node, ControlSheave):
            parts["friction"] = parts["friction"] - mean(gained) * moved * (np.diff(times) > 0.0)
        elif node.hydraulic is None:
            parts["drives"] = parts["drives"] + mean(gained) * moved
        else:
            # What the drive gives goes into the rope, its losses and its own motion: smoother than its force.
            lost = mean(frame[f"{node.name}.loss"]) * np.diff(times)
            own = node.hydraulic.inertia / 2.0 * np.diff(frame[f"{node.name}.rope_speed"] ** 2)
            parts["drives"] = parts["drives"] + mean(gained) * moved + lost + own
            parts["friction"] = parts["friction"] + lost
        if isinstance(node, TensionedReturn):
            parts["take_up"] = parts["take_up"] + node.take_up * np.diff(frame[f"{node.name}.slide"])
    return parts


def _load_work(result: Result, run: Run) -> np.ndarray:
    """Energy that loads bring with them when they are put on, or take away."""
    work = np.zeros(len(result.times) - 1)
    if run.closed:
        return work
    loads, gravity = run.loads, result.parameters[0]
    for k, sign in ((0, 1.0), (len(run.nodes) - 1, -1.0)):
        r = result.runs.index(run)
        passed = np.array([record.passed[r][k] - loads.first for record in result.records])
        total = np.concatenate([[0.0], np.cumsum(loads.mass)])
        height = result.parameters[result.model.p.index[f"{run.nodes[k].name}.z"]]
        work += sign * np.diff(total[passed]) * gravity * height
    return work


def _kinetic(result: Result) -> np.ndarray:
    frame, value = result.full_frame, np.zeros(len(result.times))
    for node in _each(result.runs):
        if isinstance(node, ControlSheave) and node.hydraulic is not None:
            value = value + node.hydraulic.inertia / 2.0 * frame[f"{node.name}.rope_speed"].to_numpy() ** 2
    return value


def _each(runs: Sequence[Run]) -> list[Node]:
    """All nodes, each once."""
    return list({node.name: node for run in runs for node in run.nodes}.values())
