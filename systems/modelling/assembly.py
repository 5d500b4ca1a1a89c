"""Assembly of the flat model from declarations. The equations of each kind of component become one CasADi function,
which is called once per component; the calls are joined at the ports. The structure is checked before any solve."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from ropeway.components.argument_checks import checked
from ropeway.components.check import Range
from ropeway.components.environment import Environment
from ropeway.components.errors import InputError, UnbalancedSystemError
from ropeway.components.inertia import Inertia
from ropeway.components.node import Node
from ropeway.components.schedule import Schedule
from ropeway.components.variable import Kind, Site, Variable
from ropeway.components.weather import SHARED, shared_variables, signals_of
from ropeway.systems.interrupts import interruptible, stop_if_interrupted
from ropeway.systems.modelling.connections.ports import require_connected
from ropeway.systems.modelling.connections.signals import with_links, with_residuals
from ropeway.systems.modelling.dae_model import Model, component_of
from ropeway.systems.modelling.declarations import north_of, require_weather, thin_ropes
from ropeway.systems.modelling.equation_graph import EquationGraph
from ropeway.systems.modelling.initial_guess import RunStart, run_start
from ropeway.systems.modelling.model_tables import Balance, Limits, LoadSlots, RunLayout, Travel, VariableTable
from ropeway.systems.modelling.rope_path import Run, find_runs, slot_counts
from ropeway.systems.modelling.sampled_control import clocks, responses_of
from ropeway.systems.modelling.structure import KNOWN, Structure, key_of
from ropeway.systems.modelling.system import System


@checked
@interruptible
def assemble(system: System, slots: Sequence[Sequence[int]] | None = None) -> Model:
    """Assemble the flat model of a system.

    The same declarations give the same model.

    Parameters
    ----------
    system : System
        The declarations.
    slots : sequence of sequence of int, optional
        Smallest numbers of load slots in each span of each run; by default as many as the loads need.

    Returns
    -------
    Model
        The flat differential-algebraic equations.

    Raises
    ------
    InputError
        An invalid declaration.
    UnbalancedSystemError
        An open port, or unequal numbers of equations and unknowns.

    Examples
    --------
    >>> model = rw.assemble(line)
    >>> model.y.units[model.y.index["c1.tension_in"]]
    'N'
    """
    return assembled(system, slots)


def in_weather(system: System | Model, environment: Environment | None, named: Collection[str] = ()) -> Model:
    """The model of a system, in other weather where one is given. Its quantities are in the model unless it is calm
    and none of them is `named`. Raises InputError, UnbalancedSystemError."""
    if environment is None:
        return system if isinstance(system, Model) else assemble(system)
    declared = system.system if isinstance(system, Model) else system
    calm = environment.is_calm(declared.temperature) and not set(named).intersection(SHARED)
    if isinstance(system, Model) and declared.environment == (None if calm else environment):
        return system
    weathered = declared.in_weather(environment)
    if calm:
        weathered.environment = None
    return assemble(weathered)


def assembled(system: System, slots: Sequence[Sequence[int]] | None = None, inertia: Inertia | None = None) -> Model:
    """As `assemble`, for declarations that are known to be sound. Components with `inertia` have no more slots than
    asked for: each has states."""
    functions = KNOWN.functions
    require_connected(system)
    require_weather(system)
    runs = find_runs(system)
    if slots is not None and [len(s) for s in slots] != [len(run.spans) for run in runs]:
        raise InputError("slots does not fit the system", "Give the number of slots of each span of each run")
    starts = [run_start(run, system.gravity) for run in runs]
    sites = _sites(system, runs, starts, slots, exact=inertia is not None)
    own = {c.name: functions.variables_of(c, sites[c.name]) for c in system.components.values()}
    variables = with_links(system, own)
    rows = with_residuals(system, variables)
    shared = _shared(system)
    tables = {kind: _table(kind, rows, shared) for kind in Kind}
    layouts, balances = tuple(_layout(run, tables) for run in runs), _balances(system, runs, tables)

    def build() -> Structure:
        return EquationGraph(system, runs, sites, variables, tables, functions).structure()

    indices = {kind: table.index for kind, table in tables.items()}
    positions = (balances, tuple(layout.key for layout in layouts))
    key, size = key_of(system, runs, sites, {**variables, "": shared}, positions), sum(map(len, tables.values()))
    structure = build() if key is None else KNOWN.get(key, size, build)
    model = Model(
        system=system.copy(),
        tables=tables,
        structure=structure,
        signals=_signals_of(system)
        + tuple(
            system.components[name].driver(v.name)
            for name, owned in variables.items()
            for v in owned
            if v.kind is Kind.INPUT
            for _ in range(v.size)
        ),
        runs=runs,
        layouts=layouts,
        balances=balances,
        swaps={f"{c}.{v.name}": f"{c}.{v.freed_by}" for c, owned in variables.items() for v in owned if v.freed_by},
        limits=_limits(system, tables[Kind.OUTPUT]),
        clocks=clocks(responses_of(runs), system.precedence_of, structure.outputs, indices),
        kept=np.array(tables[Kind.DISCRETE].shown, dtype=int),
        free_states=tuple(
            f"{name}.{v.name}"
            for name, owned in variables.items()
            for v in owned
            if v.kind is Kind.STATE and not v.kept_at_rest
        ),
        inertia=inertia,
        rate_of={f"{c}.{v.name}": f"{c}.{v.rate_of}" for c, owned in variables.items() for v in owned if v.rate_of},
    )
    stop_if_interrupted()
    _check_structure(model, system)
    return model


def _sites(
    system: System,
    runs: Sequence[Run],
    starts: Sequence[RunStart],
    slots: Sequence[Sequence[int]] | None,
    *,
    exact: bool,
) -> dict[str, Site]:
    """Scales and initial guesses of each component, from its ropes; exact: with as many `slots` as are given."""
    sites, weather = dict[str, Site](), system.environment is not None
    for r, (run, start) in enumerate(zip(runs, starts, strict=True)):
        counts = slot_counts(run, start.counts)
        if slots is not None and exact:
            counts = tuple(slots[r])
        elif slots is not None:
            counts = tuple(max(a, b) for a, b in zip(counts, slots[r], strict=True))
        for k, span in enumerate(run.spans):
            tension = (float(start.force[k, 0]), float(start.force[k, 1]), float(start.force[k, 2]))
            # Each span has its own scale: tensions of sections of one rope can differ by a factor of 100.
            force = max(float(np.linalg.norm(tension)), 1e-3 * start.scale)
            sites[span.name] = Site(force, float(start.chord[k]), counts[k], tension, weather)
        for node in run.nodes:
            site = Site(start.scale, float(np.mean(start.chord)), weather=weather)
            known = sites.get(node.name)
            if known is None or known.force < site.force:
                sites[node.name] = site
    return {name: sites.get(name, Site(1.0, 1.0, weather=weather)) for name in system.components}


def _shared(system: System) -> tuple[Variable, ...]:
    """What all components have in common."""
    return shared_variables(
        system.environment, system.gravity, system.temperature, north_of(system), thin_ropes(system)
    )


def _signals_of(system: System) -> tuple[float | Schedule, ...]:
    """Values of the weather over time."""
    return () if system.environment is None else signals_of(system.environment, system.temperature)


def _table(kind: Kind, variables: dict[str, tuple[Variable, ...]], shared: Sequence[Variable]) -> VariableTable:
    """All variables of one kind, first those that all components share. Arrays are name[1], name[2], ..."""
    stop_if_interrupted()
    names: list[str] = []
    units: list[str] = []
    descriptions: list[str] = []
    values: list[float] = []
    nominals: list[float] = []
    ranges: list[Range] = []
    hidden: list[str] = []
    every = [("", v) for v in shared] + [(f"{c}.", v) for c, owned in variables.items() for v in owned]
    for owner, v in every:
        if v.kind is not kind:
            continue
        array = v.value if isinstance(v.value, tuple) else (v.value,) * v.size
        indexed = isinstance(v.value, tuple) or v.size != 1 or v.hidden
        own = [f"{owner}{v.name}[{i + 1}]" for i in range(v.size)] if indexed else [f"{owner}{v.name}"]
        names += own
        hidden += own if v.hidden else []
        units += [v.unit] * v.size
        descriptions += [v.description] * v.size
        values += array
        nominals += [v.nominal] * v.size
        ranges += [v.range] * v.size
    return VariableTable(
        tuple(names),
        tuple(units),
        tuple(descriptions),
        np.array(values, float),
        np.array(nominals, float),
        tuple(ranges),
        frozenset(hidden),
        sum(v.kind is kind for v in shared),
    )


def _layout(run: Run, tables: dict[Kind, VariableTable]) -> RunLayout:
    def positions(kind: Kind, names: Sequence[str]) -> np.ndarray:
        index = tables[kind].index
        return np.array([index.get(name, -1) for name in names], dtype=int)

    travel = [f"{n.name}.{seat.travel}" for n, seat in zip(run.nodes, run.seats, strict=True)]
    discrete = tables[Kind.DISCRETE].index
    first = {
        slot: np.array([discrete.get(f"{s.name}.slot_{slot}[1]", 0) for s in run.spans], dtype=int)
        for slot in ("mass", "at", "ride", "empty")
    }
    first["drag"] = positions(Kind.DISCRETE, [f"{s.name}.slot_drag[1]" for s in run.spans])
    count = []
    for s in run.spans:
        n = 0
        while f"{s.name}.slot_mass[{n + 1}]" in discrete:
            n += 1
        count.append(n)
    passages = [(node, node.through(seat) or seat, seat) for node, seat in zip(run.nodes, run.seats, strict=True)]
    ends = [[(node, out) for node, out, _ in passages[:-1]], [(node, arrives) for node, _, arrives in passages[1:]]]
    return RunLayout(
        travel=Travel(positions(Kind.STATE, travel), positions(Kind.ALGEBRAIC, travel)),
        slots=LoadSlots(count=np.array(count), **first),
        length_start=positions(Kind.PARAMETER, [f"{s.name}.length_start" for s in run.spans]),
        mass_per_length=positions(Kind.PARAMETER, [f"{s.name}.mass_per_length" for s in run.spans]),
        compliance=positions(Kind.PARAMETER, [f"{s.name}.compliance" for s in run.spans]),
        force=positions(Kind.ALGEBRAIC, [f"{s.name}.force_x" for s in run.spans]),
        held=positions(Kind.DISCRETE, [f"{n.name}.held" for n in run.nodes]),
        held_travel=positions(Kind.DISCRETE, [f"{n.name}.held_travel" for n in run.nodes]),
        aside=np.array(
            [positions(Kind.ALGEBRAIC, [f"{n.name}.{seat.offset}_rope" for n, seat in end]) for end in ends]
        ),
        grip=positions(Kind.PARAMETER, [f"{n.name}.grip" for n in run.nodes]),
    )


def _limits(system: System, outputs: VariableTable) -> Limits:
    owned = [(c.name, limit) for c in system.components.values() for limit in c.limits()]
    return Limits(
        output=np.array([outputs.index[f"{name}.{limit.output}"] for name, limit in owned], dtype=int),
        low=np.array([limit.low for _, limit in owned], dtype=float),
        high=np.array([limit.high for _, limit in owned], dtype=float),
        events=tuple(limit.event for _, limit in owned),
        components=tuple(name for name, _ in owned),
    )


def _balances(system: System, runs: Sequence[Run], tables: dict[Kind, VariableTable]) -> tuple[Balance, ...]:
    unknowns, residuals = tables[Kind.ALGEBRAIC].index, tables[Kind.RESIDUAL].index
    found = []
    for run in runs:
        for k, (node, seat) in enumerate(zip(run.nodes, run.seats, strict=True)):
            balance = node.balance_at(seat)
            if balance is not None and seat.travel is not None:
                # At the end of a rope, travel winds rope in and raises the tension.
                sign = -1.0 if k == len(run.nodes) - 1 else 1.0
                travel = unknowns[f"{node.name}.{seat.travel}"]
                found.append(Balance(travel, residuals[f"{node.name}.{balance}"], sign))
    for c in system.components.values():
        for place, force in c.free if isinstance(c, Node) else ():
            found.append(Balance(unknowns[f"{c.name}.{place}"], residuals[f"{c.name}.{force}"], 1.0))
    return tuple(found)


def _check_structure(model: Model, system: System) -> None:
    """Checks that equations and unknowns are equal in number and have a matching. Raises UnbalancedSystemError."""
    unknowns, residuals = model.z.names, model.r.names
    if len(unknowns) != len(residuals):
        raise UnbalancedSystemError(
            f"System {model.name!r} has {len(unknowns)} unknowns and {len(residuals)} equations",
            "Fix or free a quantity",
        )
    if not unknowns:
        return
    match = model.determined
    if np.any(match < 0):
        undetermined = [unknowns[i] for i in sorted(set(range(len(unknowns))) - set(match.tolist()))]
        extra = [residuals[i] for i in np.flatnonzero(match < 0)]
        owner = component_of(undetermined[0])
        raise UnbalancedSystemError(
            f"Structural rank {int(np.sum(match >= 0))} of {len(unknowns)}: no equation determines "
            f"{', '.join(undetermined[:5])}, and {', '.join(extra[:5])} is superfluous",
            f"Check {owner!r}{system.origin(owner, ', added at {}')}",
        )
