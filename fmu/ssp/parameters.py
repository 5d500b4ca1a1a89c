"""Parameter sets (.ssv) with their mappings (.ssm), bound to the elements of a system."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from xml.etree import ElementTree

from ropeway.components.units import Unit
from ropeway.fmu.errors import FmuImportError, FmuVariableError
from ropeway.fmu.importing.fmu_file import Fmu
from ropeway.fmu.importing.variable_types import Mapped
from ropeway.fmu.ssp.documents import (
    MAPPING,
    SSC,
    SSD,
    SSM,
    SSV,
    VALUES,
    Document,
    Quantity,
    defined_units,
    linear_of,
    parsed,
    quantity_of,
    table_of,
    truth,
)
from ropeway.fmu.ssp.package import Package

_SET = "application/x-ssp-parameter-set"


@dataclass(frozen=True)
class Parameter:
    """A value of a parameter set.

    `quantity`: the unit of a real one, None if it is that of the variable. The value in the unit of the variable then
    becomes `factor` times it plus `offset`.
    """

    value: object
    quantity: Quantity | None = None
    factor: float = 1.0
    offset: float = 0.0

    def value_in(self, quantity: Quantity | None, what: str) -> object:
        """The value in a unit; None: in its own. Raises FmuVariableError."""
        one = (1.0, 0.0)
        if self.quantity is not None and quantity is not None:
            one = self.quantity.conversion(quantity, what)
        return scaled(scaled(self.value, *one), self.factor, self.offset)


def scaled(value: object, factor: float, offset: float) -> object:
    """A number, or a list of numbers, times a factor plus an offset; exactly the value for 1 and 0."""
    if (factor, offset) == (1.0, 0.0):
        return value
    if isinstance(value, list):
        return [scaled(part, factor, offset) for part in value]
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise FmuVariableError(f"The value {value!r} cannot be scaled", "Scale numbers only")
    return factor * value + offset


@dataclass(frozen=True)
class Binding:
    """Values by name, bound to an element."""

    where: str
    values: Mapping[str, Parameter]


@dataclass(frozen=True)
class _Files:
    """Where documents are: relative to `base` in a package, or inside the FMU `component`."""

    package: Package
    base: str
    component: str | None

    def read(self, element: ElementTree.Element, source: str) -> bytes:
        """The document to which an element refers."""
        if element.get("sourceBase") != "component":
            return self.package.read(source, self.base)
        if self.component is None:
            raise FmuImportError(f"{source} is inside a component, but its element is none", "Export the SSP again")
        return self.package.within(self.package.inside(self.component, self.base), source)


def read_bindings(
    element: ElementTree.Element, package: Package, base: str, units: Mapping[str, Unit], component: str | None = None
) -> tuple[Binding, ...]:
    """The parameter sets of an element, in their order; `component`: its FMU. Raises FmuImportError."""
    found = element.iterfind(f"{{{SSD}}}ParameterBindings/{{{SSD}}}ParameterBinding")
    files = _Files(package, base, component)
    return tuple(_binding(binding, files, units) for binding in found)


def _binding(element: ElementTree.Element, files: _Files, units: Mapping[str, Unit]) -> Binding:
    where = element.get("source", "values inside the description")
    if element.get("type", _SET) != _SET:
        raise FmuImportError(f"Parameters of {where} are of type {element.get('type')}", "Give a parameter set (.ssv)")
    inline = element.find(f"{{{SSD}}}ParameterValues/{{{SSV}}}ParameterSet")
    root = _loaded(element, inline, files, VALUES)
    known = {**units, **defined_units(root, SSV)}
    prefix = element.get("prefix", "")
    values = {}
    for parameter in root.iterfind(f"{{{SSV}}}Parameters/{{{SSV}}}Parameter"):
        name = prefix + parameter.get("name", "")
        values[name] = Parameter(_value(parameter, f"{name!r} of {where}"), quantity_of(parameter, known))
    mapping = element.find(f"{{{SSD}}}ParameterMapping")
    if mapping is not None:
        inline = mapping.find(f"{{{SSM}}}ParameterMapping")
        values = _mapped(values, _loaded(mapping, inline, files, MAPPING))
    return Binding(where, values)


def _loaded(
    element: ElementTree.Element, inline: ElementTree.Element | None, files: _Files, kind: Document
) -> ElementTree.Element:
    """The root of a document that is inside an element or in a file."""
    source = element.get("source")
    if source is not None:
        return parsed(files.read(element, source), source, kind)
    if inline is None:
        raise FmuImportError("A parameter binding has neither values nor a source", "Export the SSP again")
    return inline


def _value(parameter: ElementTree.Element, what: str) -> object:
    """The value of a parameter as a number, Boolean, text or bytes; of an array as a list."""
    for typed in parameter:
        kind = typed.tag.partition("}")[2]
        if kind == "Annotations":
            continue
        text = typed.get("value", "")
        if typed.tag.startswith(f"{{{SSV}}}") and kind in _READ:
            read = _READ[kind]
            many = typed.find(f"{{{SSC}}}Dimension") is not None or parameter.find("{*}Dimension") is not None
            return [read(part) for part in text.split()] if many else read(text)
    raise FmuImportError(
        f"{what} has no value that can be read", "Give a Real, Integer, Boolean, String or Enumeration"
    )


_INTEGERS = ("Integer", *(f"{sign}Int{n}" for sign in ("", "U") for n in (8, 16, 32, 64)))
_READ: dict[str, Callable[[str], object]] = {
    **dict.fromkeys(("Real", "Float64", "Float32"), float),
    **dict.fromkeys(_INTEGERS, int),
    "Boolean": truth,
    "String": str,
    "Enumeration": str,
    "Binary": bytes.fromhex,
}


def _mapped(values: Mapping[str, Parameter], root: ElementTree.Element) -> dict[str, Parameter]:
    """The values under the names that a mapping gives them; others are not applied."""
    found = {}
    for entry in root.iterfind(f"{{{SSM}}}MappingEntry"):
        source, target = entry.get("source", ""), entry.get("target", "")
        if source not in values:
            raise FmuImportError(
                f"A mapping names the parameter {source!r}, which is not in its set", "Correct its name"
            )
        one = values[source]
        if truth(entry.get("suppressUnitConversion")):
            one = replace(one, quantity=None)
        factor, offset = linear_of(entry)
        found[target] = replace(_translated(one, entry), factor=factor, offset=offset)
    return found


def _translated(one: Parameter, entry: ElementTree.Element) -> Parameter:
    """A Boolean, integer or item of an enumeration translated by a table."""
    table = table_of(entry)
    return one if table is None else replace(one, value=translated(one.value, table))


def translated(value: object, table: Mapping[Mapped, Mapped]) -> Mapped:
    """What a table has for a value. Raises FmuImportError."""
    if not isinstance(value, bool | int | str) or value not in table:
        raise FmuImportError(f"A mapping has no entry for the value {value!r}", "Add it")
    return table[value]


def quantity_in(fmu: Fmu, name: str) -> Quantity | None:
    """Unit of a real variable of an FMU, by the name of a scalar, an array or an element."""
    first = fmu.arrays.get(name, (name,))[0]
    if first not in fmu.entries or fmu.entries[first].kind != "Real":
        return None
    row = fmu.variable(first)
    return Quantity(str(row["unit"]), fmu.units, bool(row["relative"])) if row["unit"] else None
