"""Power of the drives, and the energy balance of a run."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from ropeway.components.errors import InputError
from ropeway.components.node import Node
from ropeway.systems.modelling.intervention import INERTIAL
from ropeway.systems.results.summary import each_node

if TYPE_CHECKING:
    from ropeway.systems.results.run_data import RunData


def drive_powers(result: RunData) -> pd.DataFrame:
    """Power of each drive into the rope [W] at all records, one column per sheave."""
    driving = {node.name: node.drive_power for node in each_node(result.runs) if node.drive_power is not None}
    powers = result.full_frame[[f"{name}.{output}" for name, output in driving.items()]]
    return powers.set_axis(list(driving), axis="columns")


def power(result: RunData) -> pd.DataFrame:
    """Power of the drives into the rope. Index sheave, and `line` for the sum; columns mean, highest and lowest power
    [W], pulled and recovered energy [J]."""
    time, powers = result.times, drive_powers(result)
    values = {name: powers[name].to_numpy() for name in powers}
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


def energy(result: RunData) -> pd.Series:
    """The energy balance of a run [J].

    Inputs are drives (work of the control sheaves' drives), ends (work of drums and moving supports, and energy of rope
    that drums pay out or wind in), loads (put on and taken off, and payloads that drop), take_up (external work on
    components such as a tensioned return). Gains are gravity, elastic and kinetic energy (of components). Losses are
    friction and crossings (energy lost when a line jumps as a load passes an idler). The residual is zero except for
    the integration error.

    With inertia kinetic energy is also that of ropes, loads and idlers, and crossings is the energy lost as loads come
    near supports and leave them. What the damping of the rope takes is `damping`, with the integration error in it; a
    run with a damping of zero has it in the residual. Raises InputError for a run in weather.
    """
    if result.model.weather:
        raise InputError(
            f"The energy balance of {result.model.name!r} does not count wind, ice and temperature",
            "Simulate it without environment",
        )
    if result.model.inertia is not None:
        return _with_inertia(result)
    frame, times = result.full_frame, result.times
    still = np.diff(times) == 0.0
    parts = dict.fromkeys(("drives", "ends", "loads", "take_up", "friction", "kinetic"), np.zeros(len(still)))
    for r in range(len(result.runs)):
        _add(parts, _rope_work(result, r))
    for node in each_node(result.runs):
        _add(parts, _own_work(result, node))
    elastic = np.diff(frame.filter(regex=r"\.elastic_energy$").sum(axis=1))
    gravity = np.diff(frame.filter(regex=r"\.gravity_energy$").sum(axis=1))
    kinetic = parts.pop("kinetic")
    work = parts["drives"] + parts["ends"] + parts["loads"] + parts["take_up"] - parts["friction"]
    remainder = work - elastic - gravity - kinetic
    return pd.Series(
        {
            **{name: value.sum() for name, value in parts.items() if name != "friction"},
            "gravity": gravity.sum(),
            "elastic": elastic.sum(),
            "kinetic": kinetic.sum(),
            "friction": parts["friction"].sum(),
            "crossings": remainder[still].sum(),
            "residual": remainder[~still].sum(),
        },
        name="energy [J]",
    )


def _with_inertia(result: RunData) -> pd.Series:
    """The energy balance of a run with inertia: the work of drives and drums is integrated with the line."""
    frame, times, nodes = result.full_frame, result.times, each_node(result.runs)
    still, zeros = np.diff(times) == 0.0, np.zeros(len(times) - 1)
    parts = dict.fromkeys(("drives", "ends", "loads", "take_up", "friction", "kinetic"), zeros)

    def gain(pattern: str) -> np.ndarray:
        return np.diff(frame.filter(regex=pattern).sum(axis=1))

    for node in nodes:
        own = "drives" if _drives(node) else "ends"
        if f"{node.name}.work" in frame:
            _add(parts, {own: np.diff(frame[f"{node.name}.work"])})
        work = _own_work(result, node)
        # The ropes of a node with inertia take part in its motion: only what comes from outside is counted.
        moving = f"{node.name}.velocity_z" in frame
        _add(parts, {"take_up": work["take_up"]} if moving else work)
    for r, run in enumerate(result.runs):
        _add(parts, {"loads": _load_work(result, r) + _load_speed(result, r), "ends": _rope_let_in(result, r)})
        for k, node in enumerate(run.nodes):
            if f"{node.name}.velocity_z" not in frame:
                _add(parts, {"ends": _shift_work(result, r, k) + zeros})
    _add(parts, {"friction": gain(r"\.lost$"), "kinetic": gain(r"\.kinetic_energy$")})
    elastic, gravity = gain(r"\.elastic_energy$"), gain(r"\.gravity_energy$")
    # A payload that drops leaves with its energy; nothing else changes then.
    parts["loads"] = parts["loads"] + np.where(_drops(result), gravity + parts["kinetic"], 0.0)
    put_in = parts["drives"] + parts["ends"] + parts["loads"] + parts["take_up"]
    remainder = put_in - parts["friction"] - elastic - gravity - parts["kinetic"]
    moving, damped = remainder[~still].sum(), result.model.inertia is not None and result.model.inertia.damping > 0.0
    return pd.Series(
        {
            **{name: parts[name].sum() for name in ("drives", "ends", "loads", "take_up")},
            "gravity": gravity.sum(),
            "elastic": elastic.sum(),
            "kinetic": parts["kinetic"].sum(),
            "friction": parts["friction"].sum(),
            "crossings": remainder[still].sum(),
            "damping": moving if damped else 0.0,
            "residual": 0.0 if damped else moving,
        },
        name="energy [J]",
    )


def _drops(result: RunData) -> np.ndarray:
    """Whether a payload drops in each interval."""
    name, index = INERTIAL["payload dropped"][0], result.model.d.index
    own = [index[key] for node in each_node(result.runs) if (key := f"{node.name}.{name}") in index]
    values = result.records.rows(np.arange(len(result.records))).kept[:, np.isin(result.model.kept, own)]
    return np.asarray((np.diff(values, axis=0) != 0.0).any(axis=1))


def _load_speed(result: RunData, r: int) -> np.ndarray:
    """Kinetic energy of loads that are put on and taken off at the speed of the rope, in each interval."""
    run, frame, work = result.runs[r], result.full_frame, np.zeros(len(result.times) - 1)
    for k, sign in ((0, 1.0), (len(run.nodes) - 1, -1.0)):
        speed = f"{run.nodes[k].name}.{run.seats[k].speed}"
        if speed in frame and not run.closed:
            work += sign * _mass_passed(result, r, k) * _mean(frame[speed].to_numpy() ** 2) / 2.0
    return work


def _mass_passed(result: RunData, r: int, k: int) -> np.ndarray:
    """Mass of the loads that pass support k in each interval."""
    loads = result.runs[r].loads
    first = sum(len(run.nodes) for run in result.runs[:r])
    passed = result.records.rows(np.arange(len(result.records))).passed[:, first + k] - loads.first
    return np.diff(np.concatenate([[0.0], np.cumsum(loads.mass)])[passed])


def _rope_let_in(result: RunData, r: int) -> np.ndarray:
    """Potential and kinetic energy of the rope that enters at a run's first support and leaves at its last, in each
    interval."""
    frame, run = result.full_frame, result.runs[r]
    energy = np.zeros(len(result.times) - 1)
    if run.closed:
        return energy
    mass, duration = run.rope.mass_per_length, np.maximum(np.diff(result.times), 1e-12)
    for k, sign in ((0, 1.0), (len(run.nodes) - 1, -1.0)):
        node, seat = run.nodes[k], run.seats[k]
        if f"{node.name}.{seat.travel}" in frame:
            run_over = np.diff(frame[f"{node.name}.{seat.travel}"])
            height = _mean(_coordinate(result, node, "z") + np.zeros(len(result.times)))
            energy += sign * mass * run_over * (result.parameters[0] * height + (run_over / duration) ** 2 / 2.0)
    return energy


def _add(parts: dict[str, np.ndarray], more: Mapping[str, np.ndarray]) -> None:
    for name, value in more.items():
        parts[name] = parts[name] + value


def _mean(values: np.ndarray | pd.Series) -> np.ndarray:
    """Mean in each interval between records."""
    array = np.asarray(values)
    return (array[1:] + array[:-1]) / 2.0


def _drives(node: Node) -> bool:
    """Whether a node drives a through-running rope."""
    return node.drive_speed is not None and node.through(node.arriving) is not None


def _rope_work(result: RunData, r: int) -> dict[str, np.ndarray]:
    """Work of supports and loads on a rope in each interval, by kind."""
    frame, run = result.full_frame, result.runs[r]
    weight, strain = run.rope.mass_per_length * result.parameters[0], run.rope.strain
    zeros = np.zeros(len(result.times) - 1)
    parts = {"drives": zeros, "ends": zeros, "loads": _load_work(result, r), "friction": zeros}
    last, moves = len(run.nodes) - 1, np.diff(result.times) > 0.0
    for k, (node, seat) in enumerate(zip(run.nodes, run.seats, strict=True)):
        tension_in = None if k == 0 else frame[f"{run.spans[k - 1].name}.tension_b"]
        tension_out = None if k == last else frame[f"{run.spans[k].name}.tension_a"]
        parts["ends"] = parts["ends"] + _shift_work(result, r, k)
        if f"{node.name}.{seat.travel}" not in frame or (run.closed and k == last):
            continue
        if run.closed and k == 0:
            tension_in = frame[f"{run.spans[-1].name}.tension_b"]
        travel_steps = np.diff(frame[f"{node.name}.{seat.travel}"])
        if tension_in is None or tension_out is None:
            tension, sign = (tension_out, -1.0) if tension_in is None else (tension_in, 1.0)
            carried = strain.potential(np.asarray(tension)) - weight * _coordinate(result, node, "z")
            parts["ends"] = parts["ends"] + sign * _mean(carried) * travel_steps
            continue
        work_done = _mean(strain.potential(tension_in) - strain.potential(tension_out)) * travel_steps
        if _drives(node):
            parts["drives"] = parts["drives"] + work_done
        else:
            parts["friction"] = parts["friction"] - work_done * moves
    return parts


def _coordinate(result: RunData, node: Node, axis: str) -> np.ndarray | float:
    """Coordinate of a node [m]; for a moving node, its values over time."""
    name = f"{node.name}.{axis}"
    index = result.model.p.index.get(name)
    return result.full_frame[name].to_numpy() if index is None else float(result.parameters[index])


def _shift_work(result: RunData, r: int, k: int) -> np.ndarray | float:
    """Work of a moving node on a rope, from the forces at the rope's ends there."""
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


def _own_work(result: RunData, node: Node) -> dict[str, np.ndarray]:
    """External work, stored energy and losses of a component in each interval. Its work on ropes is external work minus
    stored energy and losses."""
    own = node.energies(lambda name: result.full_frame[f"{node.name}.{name}"].to_numpy())
    zeros = np.zeros(len(result.times))
    kinetic, supplied = np.diff(zeros + own.kinetic), np.diff(zeros + own.supplied)
    losses = _mean(zeros + own.loss) * np.diff(result.times)
    given = losses + kinetic - supplied
    return {
        "drives" if _drives(node) else "ends": given,
        "kinetic": kinetic,
        "friction": losses,
        "take_up": supplied,
    }


def _load_work(result: RunData, r: int) -> np.ndarray:
    """Energy added by loads that are put on, and removed by loads that are taken off."""
    work, run = np.zeros(len(result.times) - 1), result.runs[r]
    if run.closed:
        return work
    for k, sign in ((0, 1.0), (len(run.nodes) - 1, -1.0)):
        height = _coordinate(result, run.nodes[k], "z") + np.zeros(len(result.times))
        work += sign * _mass_passed(result, r, k) * result.parameters[0] * _mean(height)
    return work
