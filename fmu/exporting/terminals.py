"""terminalsAndIcons.xml of FMI 3.0: the variables of an FMU by rope ends, drives and hydraulic ports."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from xml.etree import ElementTree

from ropeway.fmu.exporting.interface import Interface
from ropeway.fmu.exporting.model_description import written

_DRIVE = ("speed", "rope_speed", "travel", "drive_force", "power")
_HYDRAULIC = ("pump_flow", "relief_pressure", "flow", "pressure", "hydraulic_power", "load_power")


@dataclass(frozen=True)
class Terminal:
    """A terminal; `members`: variables by the name of their role."""

    name: str
    kind: str
    description: str
    members: Mapping[str, str]


def terminals(interface: Interface) -> list[Terminal]:
    """The terminals of an FMU that have exported variables."""
    shown = {v.name for v in interface.variables if v.causality in ("input", "output")}
    found = []
    for one in (*_rope_ends(interface), *_of_components(interface)):
        members = {role: name for role, name in one.members.items() if name in shown}
        if members:
            found.append(Terminal(one.name, one.kind, one.description, members))
    return found


def _rope_ends(interface: Interface) -> Iterator[Terminal]:
    """One for each end of each rope; an endless rope has none."""
    for run in interface.equations.state.runs:
        if run.closed:
            continue
        for span, node, side in ((run.spans[0], run.nodes[0], "a"), (run.spans[-1], run.nodes[-1], "b")):
            members = {role: f"{span.name}.{role}_{side}" for role in ("tension", "vertical")}
            members |= {"horizontal": f"{span.name}.horizontal", "travel": f"{node.name}.travel"}
            yield Terminal(f"{span.name}.{side}", "rope end", f"rope at {node.name}", members)


def _of_components(interface: Interface) -> Iterator[Terminal]:
    names: dict[str, set[str]] = {}
    for variable in interface.variables:
        owner, _, quantity = variable.name.rpartition(".")
        names.setdefault(owner, set()).add(quantity)
    for owner, own in names.items():
        if not owner.startswith("der(") and ("drive_force" in own or f"{owner}.speed" in interface.inputs):
            yield _group(owner, "drive", f"drive of {owner}", _DRIVE, own)
        if {"pump_flow", "relief_pressure"} & own or {"flow", "pressure"} <= own:
            yield _group(owner, "hydraulic port", f"hydraulic circuit of {owner}", _HYDRAULIC, own)


def _group(owner: str, kind: str, description: str, roles: Sequence[str], own: set[str]) -> Terminal:
    name = f"{owner}.{kind.split()[0]}"
    return Terminal(name, kind, description, {role: f"{owner}.{role}" for role in roles if role in own})


def terminals_and_icons(found: Sequence[Terminal]) -> bytes:
    """The file. Terminals of one kind connect by the names of their members."""
    root = ElementTree.Element("fmiTerminalsAndIcons", fmiVersion="3.0")
    parent = ElementTree.SubElement(root, "Terminals")
    for one in found:
        kind = f"ropeway.{one.kind.replace(' ', '_')}"
        about = {"name": one.name, "matchingRule": "bus", "terminalKind": kind, "description": one.description}
        element = ElementTree.SubElement(parent, "Terminal", about)
        for role, variable in one.members.items():
            member = {"memberName": role, "variableName": variable, "variableKind": "signal"}
            ElementTree.SubElement(element, "TerminalMemberVariable", member)
    return written(root)
