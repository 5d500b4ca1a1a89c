"""Systems in files: as they are declared, or as a line from a table of supports."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import pandas as pd

from ropeway.components.check import PartName
from ropeway.components.component import Component, Port, SignalInput, SignalOutput
from ropeway.components.errors import InputError
from ropeway.components.response import check_precedence
from ropeway.components.span import Span
from ropeway.systems.exchange.project_text import Json, Keys
from ropeway.systems.exchange.project_values import Decoder, Encoder, FileKind
from ropeway.systems.modelling.system import System
from ropeway.systems.rigs.endless import endless
from ropeway.systems.rigs.monocable import monocable

_LOAD, _FEED = ("name", "mass", "spans", "at"), ("spans", "spacing", "masses")
_OWN = ("name", "gravity", "temperature")
_FIELDS = (
    "kind",
    "name",
    "gravity",
    "temperature",
    "precedence",
    "components",
    "connections",
    "supplies",
    "signals",
    "loads",
    "feeds",
    "ground",
    "map_frame",
    "environment",
)


def _write(encoder: Encoder, system: System) -> dict[str, Json]:
    found: dict[str, Json] = {
        "name": system.name,
        "gravity": system.gravity,
        "temperature": system.temperature,
        "precedence": dict(system.precedences),
        "components": [encoder.part(c) for c in system.components.values()],
        "connections": {f"{a}.{end}": f"{b}.{seat}" for (a, end), (b, seat) in system.connections.items()},
        "supplies": {str(drive): str(unit) for drive, unit in system.supplies.items()},
        "signals": {f"{a}.{one}": f"{b}.{other}" for (a, one), (b, other) in system.links.items()},
        "loads": [
            {"name": str(h.load.name), "mass": h.load.mass, "spans": [str(s.name) for s in h.spans], "at": h.at}
            | ({"drag_area": h.load.drag_area} if h.load.drag_area else {})
            for h in system.hung
        ],
        "feeds": [
            {"spans": [str(s.name) for s in f.spans], "spacing": f.spacing, "masses": list(f.masses)}
            | ({} if f.around is None else {"around": f.around})
            | ({"prefix": f.prefix} if f.prefix else {})
            | ({"drag_area": f.drag_area} if f.drag_area else {})
            for f in system.feeds
        ],
    }
    for name in ("ground", "map_frame", "environment"):
        if getattr(system, name) is not None:
            found[name] = encoder.part(getattr(system, name))
    return {name: value for name, value in found.items() if value not in ({}, []) and value != {"": "all at once"}}


def _read(decoder: Decoder, data: Mapping[str, Json], keys: Keys) -> System:
    decoder.require_fields(data, keys, _FIELDS, ("name", "components"))
    lists = {n: decoder.require_list(data.get(n, []), (*keys, n)) for n in ("components", "loads", "feeds")}
    system: System = decoder.made(System, keys, {n: data[n] for n in _OWN if n in data})
    for i, each in enumerate(lists["components"]):
        here = (*keys, "components", i)
        component = decoder.part(each, here)
        if not isinstance(component, Component):
            raise decoder.error(here, f"a {each['type']} is no component", "List components here")
        _do(decoder, here, system.add, component)
    for group, precedence in decoder.require_object(data.get("precedence", {}), (*keys, "precedence")).items():
        _do(decoder, (*keys, "precedence", group), check_precedence, precedence)
        system.precedences[PartName(group) if group else group] = precedence
    _join(decoder, system, data, keys)
    for name in ("ground", "map_frame", "environment"):
        if name in data:
            setattr(system, name, decoder.part(data[name], (*keys, name)))
    for i, each in enumerate(lists["loads"]):
        here = (*keys, "loads", i)
        decoder.require_fields(each, here, (*_LOAD, "drag_area"), _LOAD)
        load = decoder.part({"type": "Load"} | {n: v for n, v in each.items() if n not in ("spans", "at")}, here)
        _do(decoder, here, system.hang, load, _spans(decoder, system, each, here), at=each["at"])
    for i, each in enumerate(lists["feeds"]):
        here = (*keys, "feeds", i)
        decoder.require_fields(each, here, (*_FEED, "around", "prefix", "drag_area"), _FEED)
        spans = _spans(decoder, system, each, here)
        own = {n: each[n] for n in ("spacing", "masses", "drag_area") if n in each}
        _do(decoder, here, system.feed, spans, **own)
        extra = {"around": each.get("around"), "prefix": each.get("prefix", "")}
        system.feeds[-1] = replace(system.feeds[-1], **extra)
    return system


def _join(decoder: Decoder, system: System, data: Mapping[str, Json], keys: Keys) -> None:
    """Connects what the file connects."""

    def component(name: Any, here: Keys) -> Component:
        found = system.components.get(str(name))
        if found is None:
            raise decoder.error(here, f"there is no component {name!r}", "Name one of the components above")
        return found

    def port(name: Any, here: Keys) -> Port:
        owner, _, own = str(name).rpartition(".")
        ports = {p.name: p for p in component(owner, here).ports}
        if own not in ports:
            raise decoder.error(here, f"{owner!r} has no port {own!r}", f"It has {', '.join(ports) or 'none'}")
        return ports[own]

    def signal(name: Any, here: Keys, cls: type[SignalInput] | type[SignalOutput]) -> Port:
        owner, _, own = str(name).rpartition(".")
        return cls(component(owner, here), own)

    joints = {n: decoder.require_object(data.get(n, {}), (*keys, n)) for n in ("connections", "supplies", "signals")}
    for one, other in joints["connections"].items():
        here = (*keys, "connections", one)
        _do(decoder, here, system.connect, port(one, here), port(other, here))
    for drive, unit in joints["supplies"].items():
        here = (*keys, "supplies", drive)
        supplied, feeding = (
            getattr(component(name, here), p, None) for name, p in ((drive, "supply"), (unit, "outlet"))
        )
        if not (isinstance(supplied, Port) and isinstance(feeding, Port)):
            raise decoder.error(here, f"{unit!r} cannot supply {drive!r}", "Name a control sheave and a power unit")
        _do(decoder, here, system.connect, supplied, feeding)
    for one, other in joints["signals"].items():
        here = (*keys, "signals", one)
        _do(decoder, here, system.connect, signal(one, here, SignalInput), signal(other, here, SignalOutput))


def _do(decoder: Decoder, keys: Keys, call: Callable[..., Any], *args: Any, **named: Any) -> None:
    """Calls a method of the system, with the line in its error."""
    decoder.made(partial(call, *args), keys, named)


def _spans(decoder: Decoder, system: System, data: Mapping[str, Json], keys: Keys) -> tuple[Span, ...]:
    found = []
    for name in decoder.require_list(data["spans"], (*keys, "spans")):
        span = system.components.get(str(name))
        if not isinstance(span, Span):
            raise decoder.error((*keys, "spans"), f"there is no span {name!r}", "Name spans of the components above")
        found.append(span)
    return tuple(found)


def _never(encoder: Encoder, system: System) -> dict[str, Json]:
    raise InputError("A system is saved as it is declared", "Save it as a system")


def _line(make: Callable[..., System], decoder: Decoder, data: Mapping[str, Json], keys: Keys) -> System:
    """A line from its table of supports, written by hand: the arguments of `rw.monocable` or `rw.endless`."""
    hints = {n: str(p.annotation) for n, p in inspect.signature(make).parameters.items()}
    decoder.require_fields(data, keys, ("kind", *hints), ("rope", "supports", "tension"))
    given = {n: decoder.value(v, (*keys, n), hints[n]) for n, v in data.items() if n not in ("kind", "supports")}
    table = data["supports"]
    if isinstance(table, list) and table and isinstance(table[0], list):
        header, *rows = table
        for i, row in enumerate(rows, 1):
            if not isinstance(row, list) or len(row) != len(header):
                cause = f"a row needs {len(header)} values"
                raise decoder.error((*keys, "supports", i), cause, f"Give {', '.join(map(str, header))}")
        table = pd.DataFrame(rows, columns=header)
    elif isinstance(table, str):
        table = decoder.folder / table
    else:
        remedy = 'Give rows, the first of them ["name", "x", "y", "z", "kind"], or the path of a table'
        raise decoder.error((*keys, "supports"), "this is no table", remedy)
    system: System = decoder.made(make, keys, {**given, "supports": table})
    return system


KINDS = (
    FileKind("system", System, _write, _read),
    FileKind("monocable", System, _never, partial(_line, monocable), lambda value: False),
    FileKind("endless", System, _never, partial(_line, endless), lambda value: False),
)
"""The forms of a system in files; lines from tables are read only."""
