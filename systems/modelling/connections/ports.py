"""Connections of ports: rope ends and seats, inputs and outputs, power units and drives."""

from __future__ import annotations

from ropeway.components import units
from ropeway.components.component import Component, Outlet, Port, RopeEnd, Seat, SignalInput, SignalOutput, Supply
from ropeway.components.errors import InputError, UnbalancedSystemError
from ropeway.components.node import Node
from ropeway.components.variable import Kind, Site
from ropeway.systems.modelling.declarations import Declarations


def connect(system: Declarations, one: Port, other: Port) -> None:
    """Connects two ports of a system. Raises InputError."""
    if isinstance(one, (SignalInput, SignalOutput)) or isinstance(other, (SignalInput, SignalOutput)):
        _connect_signal(system, one, other)
        return
    if isinstance(one, (Supply, Outlet)) or isinstance(other, (Supply, Outlet)):
        _connect_supply(system, one, other)
        return
    end, seat = (one, other) if isinstance(one, RopeEnd) else (other, one)
    if not isinstance(end, RopeEnd) or not isinstance(seat, Seat):
        raise InputError(f"{one} and {other} cannot be connected", "Connect a rope end to a seat of a support")
    for port in (end, seat):
        _require_part(system, port.owner)
    seat = _open(system, seat)
    ends = system.connections
    if (end.owner.name, end.name) in ends or (seat.owner.name, seat.name) in system.seated:
        taken = end if (end.owner.name, end.name) in ends else seat
        raise InputError(f"Port {taken} is connected twice", "Each port takes one connection")
    system.connections[end.owner.name, end.name] = (seat.owner.name, seat.name)
    system.seated.add((seat.owner.name, seat.name))


def _open(system: Declarations, seat: Seat) -> Seat:
    """The seat, or another open one if all are equivalent. Raises InputError if none is open."""
    node = seat.owner
    if not (isinstance(node, Node) and node.interchangeable):
        return seat
    found = next((s for s in node.seats if (node.name, s.name) not in system.seated), None)
    if found is None:
        raise InputError(f"All {len(node.seats)} ends of {node.described} are used", "Increase ends=")
    return found


def _connect_signal(system: Declarations, one: Port, other: Port) -> None:
    source, target = (one, other) if isinstance(one, SignalOutput) else (other, one)
    if not isinstance(source, SignalOutput) or not isinstance(target, SignalInput):
        raise InputError(f"{one} and {other} cannot be connected", "Connect an output to an input")
    for port in (source, target):
        _require_part(system, port.owner)
    unit, wanted = (port.owner.unit_of(port.name) for port in (source, target))
    if unit and wanted and not units.same(unit, wanted):
        raise InputError(f"{source} is in {unit}, {target} in {wanted}", "Connect variables of one unit")
    if (target.owner.name, target.name) in system.links:
        raise InputError(f"Port {target} is connected twice", "One output drives an input")
    system.links[target.owner.name, target.name] = (source.owner.name, source.name)


def _connect_supply(system: Declarations, one: Port, other: Port) -> None:
    supply, outlet = (one, other) if isinstance(one, Supply) else (other, one)
    if not isinstance(supply, Supply) or not isinstance(outlet, Outlet):
        raise InputError(f"{one} and {other} cannot be connected", "Connect the supply of a drive to a unit's outlet")
    for port in (supply, outlet):
        _require_part(system, port.owner)
    if not supply.owner.shares:
        raise InputError(
            f"{supply.owner.name!r} takes no power from a unit",
            "Connect a component that has shares, as a hydraulic drive",
        )
    outputs = [v.name for v in outlet.owner.variables(Site(1.0, 1.0)) if v.kind is Kind.OUTPUT]
    missing = [name for name in supply.owner.shares if not outlet.owner.sums or name not in outputs]
    if missing:
        raise InputError(f"{outlet.owner.name!r} has no output {', '.join(missing)}", "Connect it to a power unit")
    if supply.owner.name in system.supplies:
        raise InputError(f"Port {supply} is connected twice", "A drive has one power unit")
    system.supplies[supply.owner.name] = outlet.owner.name


def _require_part(system: Declarations, component: Component) -> None:
    """Raises InputError unless a component was added."""
    if system.components.get(component.name) is not component:
        raise InputError(f"{component.name!r} is not part of system {system.name!r}", "Add it first")


def require_connected(system: Declarations) -> None:
    """Raises UnbalancedSystemError with each open port and the user's file and line."""
    if not system.components:
        raise UnbalancedSystemError(f"System {system.name!r} is empty", "Add components, or string a rope")
    joined = {*system.connections, *system.connections.values()}
    lone = [
        f"{port}{system.origin(c.name, ' (added at {})')}"
        for c in system.components.values()
        for port in c.ports
        if (c.name, port.name) not in joined and not (isinstance(port, Seat) and port.optional)
    ]
    if lone:
        raise UnbalancedSystemError(f"Open ports: {', '.join(lone)}", "Connect each port once")
