"""Tables of an FMU in C: sizes, names, start values, and positions of the runs in the vectors (see ropeway.h)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ropeway.components.errors import InputError
from ropeway.fmu.exporting.carriage_corridor import Corridor
from ropeway.fmu.exporting.inertial_solution import InertialSolution, fill_inertial
from ropeway.fmu.exporting.interface import Interface
from ropeway.fmu.exporting.section_solution import fill_line
from ropeway.systems.dynamics.load_crossings import balances_of
from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.native.c_tables import Tables
from ropeway.systems.statics.line_state import LineState
from ropeway.systems.statics.load_positions import loads_once
from ropeway.systems.statics.pending_events import Pending


@dataclass(frozen=True)
class Settings:
    """Tolerance of the integrator; deceleration of an emergency stop [m/s2], None if it is not an input."""

    tolerance: float
    emergency_stop: float | None = None


_HIDDEN, _READ, _PARAMETER, _INPUT, _STATE = range(5)


def fill(interface: Interface, settings: Settings) -> Tables:
    """The tables of an FMU."""
    tolerance = settings.tolerance
    tables = Tables()
    equations = interface.equations
    m, state, point = equations.model, equations.state, equations.state.point
    _equations(tables, interface, tolerance)
    for name, values in (("x", point.x), ("z", point.z), ("u", point.u), ("p", point.p), ("d", point.d)):
        tables.numbers(f"{name}_start", values)
    tables.numbers("mass_start", equations.masses)
    numbers = [p + run.loads.first for p, run in zip(state.passed, state.runs, strict=True)]
    tables.integers("passed_start", np.concatenate([[], *numbers]))
    for name, table in (("x", m.x), ("z", m.z), ("r", m.r)):
        tables.numbers(f"{name}_nominal", table.nominals)
    tables.texts("equation_name", (*(f"rate of {n}" for n in m.x.names), *m.r.names))
    tables.texts("input_name", m.u.names)
    tables.size("NF", len(equations.followed))
    tables.integers("followed_input", equations.followed)
    tables.integers("followed_source", equations.followed.values())
    tables.integers("switch", equations.switches.values())
    tables.integers("switch_shown", [name in interface.inputs for name in equations.switches])
    tables.integers("access", _access(interface))
    tables.integers("tunable", [interface.is_tunable(name) for name in (*m.p.names, *interface.mass_names)])
    tables.texts("variable_name", _names(interface))
    _schedules(tables, interface)
    _stops(tables, equations.commanded if interface.stops else {}, settings)
    _runs(tables, interface)
    _limits(tables, m, interface)
    _clocks(tables, m, equations.pending)
    _places(tables, equations.corridor)
    tables.numbers("least", [r.least for r in m.p.ranges])
    tables.numbers("most", [r.most for r in m.p.ranges])
    tables.integers("above", [r.above for r in m.p.ranges])
    return tables


def _equations(tables: Tables, interface: Interface, tolerance: float) -> None:
    equations = interface.equations
    m = equations.model
    order, *room = equations.factors
    room_l, room_u = np.maximum(room, fill_line(tables, equations.by_sections, m)).tolist()
    sizes = {"NX": len(m.x), "NZ": len(m.z), "NU": len(m.u), "NP": len(m.p), "ND": len(m.d), "NY": len(m.y)}
    sizes |= {"NM": len(equations.masses), "NW": len(m.x) + len(m.z), "NNZ": equations.pattern.nnz()}
    sizes |= {"NK": len(interface.supports), "NL": len(m.limits.output), "NSW": len(equations.switches)}
    sizes |= {"LCAP": room_l, "UCAP": room_u, "COUPLED": int(equations.coupled)}
    for part in ("arg", "res", "iw", "w"):
        sizes[f"SZ_{part.upper()}"] = max(1, *(getattr(f, f"sz_{part}")() for f in equations.functions))
    for name, size in sizes.items():
        tables.size(name, size)
    force = float(m.z.nominals.max()) if len(m.z) else 1.0
    tables.size("TOLERANCE", float(tolerance))
    tables.size("FORCE_SCALE", force)
    tables.size("FORCE_NEAR", 1e-7 * force)
    tables.integers("colind", equations.pattern.colind())
    tables.integers("row", equations.pattern.row())
    tables.integers("column_order", order)
    tables.functions("jacobian_of", [] if equations.jacobian is None else ["rw_jacobian"])
    tables.size("GROUPS", 1 + max(equations.groups, default=-1))
    tables.integers("group", equations.groups)


def _access(interface: Interface) -> np.ndarray:
    first = interface.first
    access = np.full(first.limit, _HIDDEN)
    for v in interface.variables:
        if v.kind == "Real":
            access[v.reference] = {"parameter": _PARAMETER, "input": _INPUT}.get(v.causality, _READ)
    access[first.x : first.dx] = _STATE
    return access


def _names(interface: Interface) -> list[str]:
    """Name of each variable by its reference, "" if it is not exported."""
    names = [""] * interface.first.end
    for v in interface.variables:
        names[v.reference] = v.name
    return names


def _stops(tables: Tables, commanded: Mapping[int, int], settings: Settings) -> None:
    tables.size("NE", len(commanded))
    tables.size("STOP_DECELERATION", settings.emergency_stop or 1.0)
    tables.integers("stop_input", commanded)
    tables.integers("stop_correction", commanded.values())


def _schedules(tables: Tables, interface: Interface) -> None:
    names = interface.equations.model.u.names
    inside = {i: s for i, s in interface.equations.schedules.items() if names[i] not in interface.inputs}
    tables.size("NS", len(inside))
    tables.integers("schedule_input", inside)
    tables.integers("schedule_first", np.concatenate([[0], np.cumsum([len(s.times) for s in inside.values()])]))
    tables.numbers("schedule_time", [t for s in inside.values() for t in s.times])
    tables.numbers("schedule_value", [v for s in inside.values() for v in s.speeds])


def _runs(tables: Tables, interface: Interface) -> None:
    equations = interface.equations
    state, m = equations.state, equations.model
    run_of = [r for r, _ in interface.supports]
    tables.integers("run_of", run_of)
    tables.integers("run_first", _offsets([len(run.nodes) for run in state.runs]))
    tables.integers("travel", [interface.travel_of(i) for i in range(len(run_of))])
    tables.texts("support_name", [state.runs[r].nodes[k].name for r, k in interface.supports])
    tables.numbers("span_scale", state.span_scale)
    spans: dict[str, list[int]] = {"length_start": [], "slot_count": [], "slot_mass": [], "slot_at": []}
    spans |= {"slot_ride": [], "slot_empty": [], "slot_drag": [], "force": []}
    held: dict[str, list[int]] = {"held": [], "held_travel": [], "law": []}
    laws = balances_of(m)
    reads: dict[str, list[int]] = {"vertical_b": [], "pull_b": [], "tension_in": [], "tension_out": []}
    y = m.y.index
    for run, layout in zip(state.runs, m.layouts, strict=True):
        slots = layout.slots
        columns = (
            layout.length_start,
            slots.count,
            slots.mass,
            slots.at,
            slots.ride,
            slots.empty,
            slots.drag,
            layout.force,
        )
        for cells, column in zip(spans.values(), columns, strict=True):
            cells += [*(int(c) for c in column), 0]  # the last support of a run has no span
        held["held"] += [int(c) for c in layout.held]
        held["held_travel"] += [int(c) for c in layout.held_travel]
        held["law"] += [laws.get(int(c), -1) for c in layout.travel.algebraic]
        reads["vertical_b"] += [*(y.get(f"{span.name}.vertical_b", -1) for span in run.spans), -1]
        reads["pull_b"] += [*(y.get(f"{span.name}.pull_b_x[1]", -1) for span in run.spans), -1]
        for name in ("tension_in", "tension_out"):
            reads[name] += [y.get(f"{node.name}.{name}", -1) for node in run.nodes]
    for name, cells in {**spans, **held, **reads}.items():
        tables.integers(name, cells)
    _loads(tables, state, equations.mass_names)
    tables.integers("wind", [m.u.index.get(name, -1) for name in ("wind_pressure", "wind_from")])
    tables.integers("north", [m.p.index.get("north", -1)])
    inertial = equations.inertial
    fill_inertial(tables, inertial if isinstance(inertial, InertialSolution) else None, m)


def _loads(tables: Tables, state: LineState, mass_names: Sequence[Sequence[str]]) -> None:
    for run in state.runs:
        if run.feed is not None and not run.around:
            repeated = np.array(run.feed.masses)[np.arange(len(run.loads.mass)) % len(run.feed.masses)]
            if not np.array_equal(repeated, run.loads.mass):
                raise InputError(f"Loads of {run.name} have other masses than their feed", "Feed loads of these masses")
    loads = [loads_once(state, r) if run.around else run.loads for r, run in enumerate(state.runs)]
    tables.integers("load_first", _offsets([len(own.place) for own in loads]))
    tables.numbers("load_place", np.concatenate([[], *(own.place for own in loads)]))
    tables.numbers("load_drag", np.concatenate([[], *(own.drag for own in loads)]))
    tables.integers("around", [run.around for run in state.runs])
    tables.integers("mass_first", _offsets([len(names) for names in mass_names]))
    tables.numbers("feed_spacing", [0.0 if run.feed is None else run.feed.spacing for run in state.runs])


def _limits(tables: Tables, m: Model, interface: Interface) -> None:
    limits = m.limits
    low, high = (np.where(np.isfinite(bound), np.abs(bound), 0.0) for bound in (limits.low, limits.high))
    bounds = np.maximum(low, high)
    scale = np.maximum(bounds, m.y.nominals[limits.output]) if len(limits.output) else bounds
    tables.integers("limit_output", limits.output)
    tables.numbers("limit_low", limits.low)
    tables.numbers("limit_high", limits.high)
    tables.numbers("limit_scale", scale)
    tables.numbers("limit_slack", 1e-6 * scale)
    tables.texts("limit_name", interface.limit_names)


def _clocks(tables: Tables, m: Model, pending: Pending) -> None:
    tables.size("NC", len(m.clocks))
    tables.size("NQ", max((len(clock.entries) for clock in m.clocks), default=0))
    tables.numbers("clock_period", [clock.period for clock in m.clocks])
    tables.numbers("clock_phase", [pending.next_tick(clock) for clock in m.clocks])
    tables.integers("clock_first", _offsets([len(clock.entries) for clock in m.clocks]))
    tables.integers("clock_entry", [e for clock in m.clocks for e in clock.entries])
    tables.integers("clock_corrects", [e in clock.corrections for clock in m.clocks for e in clock.entries])
    tables.functions("clock_update", [f"rw_clock_{i}" for i in range(len(m.clocks))])


def _places(tables: Tables, corridor: Corridor | None) -> None:
    passages = [] if corridor is None else corridor.passages
    tables.size("NPL", len(passages))
    tables.size("NB", max(0, len(passages) - 1))
    tables.size("NG", 0 if corridor is None else corridor.count)
    tables.size("MEAN_SPAN", 0.0 if corridor is None else corridor.mean_span)
    rows = [passage for of in passages for passage in of]
    tables.integers("passage_first", _offsets([len(of) for of in passages]))
    tables.integers("passage_to", [passage.to for passage in rows])
    tables.texts("passage_event", [passage.event for passage in rows])
    tables.numbers("passage_jump", np.concatenate([[], *(passage.jump for passage in rows)]))
    tables.functions("margins", [] if corridor is None else [corridor.function.name()])


def _offsets(sizes: Sequence[int]) -> np.ndarray:
    return np.concatenate([[0], np.cumsum(sizes)]).astype(int)
