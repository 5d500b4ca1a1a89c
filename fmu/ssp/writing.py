"""Writes a co-simulation as a system structure of version 1.0."""

from __future__ import annotations

import shutil
import zipfile
from collections.abc import Collection, Iterable, Mapping, Sequence
from pathlib import Path
from xml.etree import ElementTree

import ropeway
from ropeway.components import units
from ropeway.components.errors import InputError
from ropeway.components.whole_files import whole
from ropeway.fmu.importing.fmu_file import Fmu
from ropeway.fmu.importing.variable_types import Value
from ropeway.fmu.ssp.documents import OWN, SSC, SSD, SSV, write_table
from ropeway.fmu.ssp.package import ROOT
from ropeway.fmu.ssp.reading import SspConnection, SspSystem

for _prefix, _namespace in (("ssd", SSD), ("ssc", SSC), ("ssv", SSV), ("ropeway", OWN)):
    ElementTree.register_namespace(_prefix, _namespace)

_MADE = {"version": "1.0", "generationTool": f"ropeway {ropeway.__version__}"}
_SET = "initialValues"
"""Name of all parameter sets: ecos applies those of one name."""
_TYPES = {"Real": "Real", "Integer": "Integer", "Boolean": "Boolean", "String": "String", "Binary": "Binary"}
_SHOWN = ("Real", "Integer", "Boolean", "String", "Binary", "Enumeration")


def write_ssp(system: SspSystem, path: Path, *, name: str, embedded: Collection[Path]) -> None:
    """Writes a package with the files of FMUs that are `embedded`, and the URIs of others.

    Raises InputError, WriteError.
    """
    files = _places(system, embedded)
    values = {f"resources/{slave.name}.ssv": _parameters(slave.name, slave.fmu, slave.start) for slave in system.slaves}
    with whole(path) as file, zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(ROOT, _written(_description(system, name, files)))
        for place, root in values.items():
            archive.writestr(place, _written(root))
        for fmu, place in files.items():
            if fmu in embedded:
                with fmu.open("rb") as content, archive.open(zipfile.ZipInfo(place), "w") as member:
                    shutil.copyfileobj(content, member)


def _places(system: SspSystem, embedded: Collection[Path]) -> dict[Path, str]:
    """The URI of each FMU by its file; slaves of one file share it."""
    places: dict[Path, str] = {}
    for slave in system.slaves:
        file = slave.fmu.path
        places.setdefault(file, f"resources/{slave.name}.fmu" if file in embedded else file.resolve().as_uri())
    return places


def _written(root: ElementTree.Element) -> bytes:
    ElementTree.indent(root)
    written: bytes = ElementTree.tostring(root, encoding="UTF-8", xml_declaration=True)
    return written


def _description(system: SspSystem, name: str, files: Mapping[Path, str]) -> ElementTree.Element:
    root = ElementTree.Element(f"{{{SSD}}}SystemStructureDescription", {**_MADE, "name": name})
    top = ElementTree.SubElement(root, f"{{{SSD}}}System", name=name)
    elements = ElementTree.SubElement(top, f"{{{SSD}}}Elements")
    symbols = _Symbols()
    for slave in system.slaves:
        about = {"name": slave.name, "source": files[slave.fmu.path]}
        about |= {} if slave.kind is None else {"implementation": slave.kind}
        component = ElementTree.SubElement(elements, f"{{{SSD}}}Component", about)
        inputs = [c.target.partition(".")[2] for c in system.connections if c.target.startswith(f"{slave.name}.")]
        _connectors(component, slave.fmu, inputs, symbols)
        bindings = ElementTree.SubElement(component, f"{{{SSD}}}ParameterBindings")
        ElementTree.SubElement(bindings, f"{{{SSD}}}ParameterBinding", source=f"resources/{slave.name}.ssv")
        _annotate(component, {"Slave": slave.settings} if slave.settings else {})
    _connections(top, system.connections)
    symbols.write(root, SSD)
    if system.stop_time is not None:
        times = {"startTime": repr(system.start_time or 0.0), "stopTime": repr(system.stop_time)}
        ElementTree.SubElement(root, f"{{{SSD}}}DefaultExperiment", times)
    _annotate(root, system.settings)
    return root


class _Symbols:
    """Units that a document uses. A symbol is that of the first FMU that defines it."""

    def __init__(self) -> None:
        self._known: dict[str, units.Unit] = {}

    def add(self, symbol: str, fmu: Fmu) -> bool:
        """Adds a unit. Whether it can be named: it has the definition that this FMU gives it."""
        own = units.read(symbol, fmu.units)
        return own is not None and self._known.setdefault(symbol, own) == own

    def write(self, root: ElementTree.Element, namespace: str) -> None:
        """Writes the definitions."""
        if not self._known:
            return
        parent = ElementTree.SubElement(root, f"{{{namespace}}}Units")
        for symbol, unit in self._known.items():
            element = ElementTree.SubElement(parent, f"{{{SSC}}}Unit", name=symbol)
            base = {name: str(n) for name, n in unit.base().items()}
            base |= {"factor": repr(unit.factor)} if unit.factor != 1.0 else {}
            base |= {"offset": repr(unit.offset)} if unit.offset else {}
            ElementTree.SubElement(element, f"{{{SSC}}}BaseUnit", base)


def _connectors(component: ElementTree.Element, fmu: Fmu, inputs: Sequence[str], symbols: _Symbols) -> None:
    """All outputs, and the inputs that are connected: some tools set all that are declared, to zero."""
    shown = [*inputs, *(v for v in fmu.outputs(*_SHOWN))]
    if not shown:
        return
    parent = ElementTree.SubElement(component, f"{{{SSD}}}Connectors")
    for name in shown:
        entry, unit = fmu.entry(name), str(fmu.variable(name)["unit"])
        kind = "input" if entry.causality == "input" else "output"
        connector = ElementTree.SubElement(parent, f"{{{SSD}}}Connector", name=name, kind=kind)
        if entry.kind in _TYPES:
            real = {"unit": unit} if entry.kind == "Real" and unit and symbols.add(unit, fmu) else {}
            ElementTree.SubElement(connector, f"{{{SSC}}}{_TYPES[entry.kind]}", real)


def _connections(system: ElementTree.Element, connections: Iterable[SspConnection]) -> None:
    parent = None
    for one in connections:
        parent = ElementTree.SubElement(system, f"{{{SSD}}}Connections") if parent is None else parent
        (start, output), (end, entry) = one.source.split(".", 1), one.target.split(".", 1)
        ends = {"startElement": start, "startConnector": output, "endElement": end, "endConnector": entry}
        if one.plain:
            plain = ElementTree.SubElement(parent, f"{{{SSD}}}Connection", ends)
            if one.mapping is not None:
                _map(plain, one)
            continue
        element = ElementTree.SubElement(parent, f"{{{SSD}}}Connection", {**ends, "suppressUnitConversion": "true"})
        scale = {"factor": repr(one.factor), "offset": repr(one.offset)}
        ElementTree.SubElement(element, f"{{{SSC}}}LinearTransformation", scale)


def _map(element: ElementTree.Element, one: SspConnection) -> None:
    """A table of Booleans, of names of items, or of integers. Raises InputError."""
    mapping = one.mapping or {}
    kinds = {type(value) for row in mapping.items() for value in row}
    if len(kinds) > 1:
        raise InputError(
            f"The mapping of {one.source} to {one.target} is between different kinds of values, which SSP has not",
            "Map Booleans to Booleans, and integers or items of enumerations to each other",
        )
    write_table(element, {bool: "Boolean", int: "Integer", str: "Enumeration"}[kinds.pop()], mapping)


def _annotate(element: ElementTree.Element, settings: Mapping[str, Mapping[str, str]]) -> None:
    """Settings of this library's master, which other tools ignore."""
    if not settings:
        return
    parent = ElementTree.SubElement(element, f"{{{SSD}}}Annotations")
    for name, values in settings.items():
        one = ElementTree.SubElement(parent, f"{{{SSC}}}Annotation", type="ropeway.cosimulation")
        ElementTree.SubElement(one, f"{{{OWN}}}{name}", dict(values))


def _parameters(name: str, fmu: Fmu, start: Mapping[str, object]) -> ElementTree.Element:
    """The start values of a slave as a parameter set, in the units of its variables."""
    root = ElementTree.Element(f"{{{SSV}}}ParameterSet", {**_MADE, "name": _SET})
    parent = ElementTree.SubElement(root, f"{{{SSV}}}Parameters")
    symbols = _Symbols()
    for variable, value in start.items():
        entry, unit = fmu.entry(variable), str(fmu.variable(variable)["unit"])
        parameter = ElementTree.SubElement(parent, f"{{{SSV}}}Parameter", name=variable)
        kind, more = entry.kind, {}
        if kind == "Real" and unit and symbols.add(unit, fmu):
            more = {"unit": unit}
        if kind == "Enumeration":
            items = {number: item for item, number in entry.items.items()}
            kind, value = ("Enumeration", items[value]) if value in items else ("Integer", value)
        if kind == "Integer" and not -(2**31) <= int(value) < 2**31:  # type: ignore[call-overload]
            raise InputError(f"{f'{name}.{variable}'!r} is {value}, too large for SSP 1.0", "Set it in the FMU")
        ElementTree.SubElement(parameter, f"{{{SSV}}}{kind}", {"value": _text(value), **more})
    symbols.write(root, SSV)
    return root


def _text(value: Value | object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return value.hex() if isinstance(value, bytes) else repr(value) if isinstance(value, float) else str(value)
