"""XML documents of SSP: their names and types, checked by the published schemas."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

from ropeway.components.errors import InputError
from ropeway.components.units import BASE, Conversion, Unit, conversion, from_base
from ropeway.fmu.errors import FmuImportError, FmuVariableError
from ropeway.fmu.importing.variable_types import Mapped

SSD, SSC, SSV, SSM, SSB = (
    f"http://ssp-standard.org/SSP1/SystemStructure{name}"
    for name in ("Description", "Common", "ParameterValues", "ParameterMapping", "SignalDictionary")
)
"""Namespaces: the same in versions 1.0 and 2.0."""
OWN = "https://ropeway.invalid/ssp"
"""Namespace of the settings of this library's master in annotations."""


class Document(NamedTuple):
    """A kind of document: its root and the schema for version 1.0."""

    root: str
    schema: str


STRUCTURE = Document(f"{{{SSD}}}SystemStructureDescription", "SystemStructureDescription.xsd")
VALUES = Document(f"{{{SSV}}}ParameterSet", "SystemStructureParameterValues.xsd")
MAPPING = Document(f"{{{SSM}}}ParameterMapping", "SystemStructureParameterMapping.xsd")
DICTIONARY = Document(f"{{{SSB}}}SignalDictionary", "SystemStructureSignalDictionary.xsd")


def parsed(data: bytes, where: str, kind: Document) -> ElementTree.Element:
    """The root of a document of version 1.0, which the schema accepts, or 2.0. Raises FmuImportError."""
    try:
        root = ElementTree.fromstring(data)
    except ElementTree.ParseError as error:
        raise FmuImportError(f"{where} is not XML: {error}", "Export it again") from error
    if root.tag != kind.root:
        raise FmuImportError(f"{where} has the root {root.tag!r}", f"Give a file with the root {kind.root!r}")
    version = root.get("version", "?")
    if version.startswith("1."):
        require_valid(data, where, kind)
    elif version != "2.0":
        raise FmuImportError(f"{where} is of SSP version {version}", "Use version 1.0 or 2.0")
    return root


def require_valid(data: bytes, where: str, kind: Document) -> None:
    """Checks a document by the schema of version 1.0, which FMPy has in its folder `ssp/schema` (BSD-2-Clause).

    Raises FmuImportError.
    """
    import fmpy
    from lxml import etree

    schema = etree.XMLSchema(file=str(Path(fmpy.__file__).parent / "ssp" / "schema" / kind.schema))
    tree = etree.fromstring(data, etree.XMLParser(resolve_entities=False, no_network=True))
    if not schema.validate(tree):
        first = schema.error_log[0]
        raise FmuImportError(
            f"{where}, line {first.line}: {first.message}", f"Correct it: it violates the schema {kind.schema}"
        )


def truth(text: str | None) -> bool:
    """A Boolean of XML."""
    return text in ("true", "1")


def defined_units(parent: ElementTree.Element, namespace: str) -> dict[str, Unit]:
    """Units that a document defines by SI base units."""
    found = {}
    for unit in parent.iterfind(f"{{{namespace}}}Units/{{{SSC}}}Unit"):
        base = unit.find(f"{{{SSC}}}BaseUnit")
        if base is not None:
            exponents = {symbol: int(base.get(symbol, "0")) for symbol in BASE}
            factor, offset = (float(base.get(name, default)) for name, default in (("factor", "1"), ("offset", "0")))
            found[unit.get("name", "")] = from_base(exponents, factor, offset)
    return found


def linear_of(transformed: ElementTree.Element) -> tuple[float, float]:
    """Factor and offset of a connection or mapping entry."""
    linear = transformed.find(f"{{{SSC}}}LinearTransformation")
    return (1.0, 0.0) if linear is None else (float(linear.get("factor", "1")), float(linear.get("offset", "0")))


_TABLES: Mapping[str, Callable[[str | None], Mapped]] = {
    "Boolean": truth,
    "Integer": lambda text: int(text or ""),
    "Enumeration": str,
}
"""Kinds of transformations by a table, and how their values are read."""


def table_of(transformed: ElementTree.Element) -> dict[Mapped, Mapped] | None:
    """Values of the target by those of the source, of a connection or mapping entry; None: it has no table."""
    for kind, read in _TABLES.items():
        table = transformed.find(f"{{{SSC}}}{kind}MappingTransformation")
        if table is not None:
            rows = table.iterfind(f"{{{SSC}}}MapEntry")
            return {read(row.get("source")): read(row.get("target")) for row in rows}
    return None


def write_table(parent: ElementTree.Element, kind: str, table: Mapping[Mapped, Mapped]) -> None:
    """Adds a transformation of a kind of values."""
    element = ElementTree.SubElement(parent, f"{{{SSC}}}{kind}MappingTransformation")
    for ends in table.items():
        shown = [str(v).lower() if isinstance(v, bool) else str(v) for v in ends]
        ElementTree.SubElement(element, f"{{{SSC}}}MapEntry", source=shown[0], target=shown[1])


class Quantity(NamedTuple):
    """A unit by its symbol, the units that are defined beside it, and whether values are differences."""

    unit: str
    units: Mapping[str, Unit]
    relative: bool = False

    def conversion(self, other: Quantity, what: str) -> Conversion:
        """Conversion of values to another unit. Raises FmuVariableError, which names `what` is converted.

        Equal symbols of which one is not defined are one unit: many descriptions omit the units of their FMUs.
        """
        if self.unit == other.unit and not (self.unit in self.units and other.unit in other.units):
            return Conversion(1.0, 0.0)
        try:
            differences = self.relative, other.relative
            return conversion(self.unit, other.unit, self.units, other.units, differences=differences)
        except InputError as error:
            raise FmuVariableError(f"{what}: {error.cause}", error.remedy) from error


def quantity_of(typed: ElementTree.Element, known: Mapping[str, Unit]) -> Quantity | None:
    """The unit of a connector, dictionary entry or parameter; None if none is given."""
    for name in ("Real", "Float64", "Float32"):
        for real in typed.iterfind(f"{{*}}{name}"):
            symbol = real.get("unit")
            return None if symbol is None else Quantity(symbol, known)
    return None
