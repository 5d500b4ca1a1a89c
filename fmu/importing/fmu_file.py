"""An FMU file: its names, capabilities and variables."""

from __future__ import annotations

import difflib
import itertools
import zipfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import fmpy
import pandas as pd

from ropeway.components import units
from ropeway.components.argument_checks import checked
from ropeway.fmu.errors import FmuImportError, FmuVariableError
from ropeway.fmu.importing.variable_types import Entry, Value, kind_of, taken_by

_COLUMNS = ("kind", "causality", "variability", "unit", "start", "nominal", "description", "reference", "relative")


@checked
@dataclass(frozen=True, eq=False)
class Fmu:
    """An FMU file; `rw.fmu.load` reads it.

    Parameters
    ----------
    path : Path
        The file.
    name : str
        Name of the model.
    fmi : str
        Version of FMI.
    kinds : tuple of str
        "ModelExchange", "CoSimulation", "ScheduledExecution".
    platforms : tuple of str
        Platforms of its binaries.
    variables : DataFrame
        Index name; columns kind, causality, variability, unit, start, nominal, description, (value) reference and
        relative (FMI's relativeQuantity: the values are differences). An array `u` has a row for each element: `u[1]`,
        `u[2]`, or `u[1,2]`.
    units : mapping of str to Unit
        Units that it defines by SI base units; others are read by their symbols.
    description : object
        FMPy's model description.
    entries : mapping of str to Entry
        Types of the variables.
    arrays : mapping of str to tuple of str
        Names of the elements of each array.
    structure : mapping of str, optional
        Values of structural parameters other than their start values.

    Examples
    --------
    >>> fmu = rw.fmu.load("span.fmu")
    >>> fmu.names("output")
    ['a.tension', 'b.tension']
    """

    path: Path
    name: str
    fmi: str
    kinds: tuple[str, ...]
    platforms: tuple[str, ...]
    variables: pd.DataFrame
    units: Mapping[str, units.Unit]
    description: Any
    entries: Mapping[str, Entry]
    arrays: Mapping[str, tuple[str, ...]]
    structure: Mapping[str, Value] = field(default_factory=dict)

    def variable(self, name: str) -> pd.Series:
        """Row of a variable.

        Parameters
        ----------
        name : str
            Name of a scalar or of an element.

        Returns
        -------
        Series
            Its row of `variables`.

        Raises
        ------
        FmuVariableError
            An unknown variable.
        """
        if name not in self.entries:
            raise self._unknown(name)
        row: pd.Series = self.variables.loc[name]
        return row

    def entry(self, name: str) -> Entry:
        """Type of a variable.

        Parameters
        ----------
        name : str
            Name of a scalar or of an element.

        Returns
        -------
        Entry
            Its type.

        Raises
        ------
        FmuVariableError
            An unknown variable.
        """
        if name not in self.entries:
            raise self._unknown(name)
        return self.entries[name]

    def _unknown(self, name: str) -> FmuVariableError:
        if elements := self.arrays.get(name):
            cause = f"{name!r} of {self.path.name} is an array of {len(elements)}"
            return FmuVariableError(cause, f"Name one of its elements, {', '.join(elements[:3])}", name)
        near = difflib.get_close_matches(name, list(self.entries), n=5, cutoff=0.4)
        remedy = f"Did you mean {', '.join(near)}?" if near else "List them with fmu.variables"
        return FmuVariableError(f"{self.path.name} has no variable {name!r}", remedy, name)

    def names(self, causality: str, *kinds: str) -> list[str]:
        """Names of the variables of a causality.

        Parameters
        ----------
        causality : str
            Such as "input", "output" or "parameter".
        *kinds : str
            Kinds of variables, such as "Boolean"; by default "Real".

        Returns
        -------
        list of str
            The names.
        """
        wanted = kinds or ("Real",)
        return [n for n, entry in self.entries.items() if entry.causality == causality and entry.kind in wanted]

    def outputs(self, *kinds: str) -> list[str]:
        """Names of the outputs that can be read at any communication point.

        Parameters
        ----------
        *kinds : str
            Kinds of variables; by default "Real".

        Returns
        -------
        list of str
            The names.
        """
        return [n for n in self.names("output", *kinds) if not self.entries[n].clocked]

    def values(self, given: Mapping[str, object]) -> dict[str, Value]:
        """Values converted to the types of the FMU.

        Parameters
        ----------
        given : mapping of str
            Values by name; those of an array as a sequence, nested or flat.

        Returns
        -------
        dict of str
            Values by name of scalars and elements.

        Raises
        ------
        FmuVariableError
            An unknown variable, or a value of the wrong type or size.
        """
        found: dict[str, Value] = {}
        for name, value in given.items():
            elements = self.arrays.get(name)
            if elements is None:
                found[name] = taken_by(self.entry(name), name, self.path.name, value)
                continue
            parts = _flat(value)
            if len(parts) != len(elements):
                cause = f"{name!r} of {self.path.name} is an array of {len(elements)}; {len(parts)} values were given"
                raise FmuVariableError(cause, "Give a value for each element", name)
            found |= {n: taken_by(self.entries[n], n, self.path.name, v) for n, v in zip(elements, parts, strict=True)}
        return found

    def shaped(self, structure: Mapping[str, Value]) -> Fmu:
        """The FMU with other structural parameters, and arrays of the sizes that follow.

        Parameters
        ----------
        structure : mapping of str
            Values of structural parameters.

        Returns
        -------
        Fmu
            The resized FMU.
        """
        variables, entries, arrays = _tables(self.description, structure)
        return replace(self, variables=variables, entries=entries, arrays=arrays, structure=dict(structure))


@checked
def load(path: str | Path) -> Fmu:
    """Read an FMU of version 2.0 or 3.0.

    Parameters
    ----------
    path : str or Path
        The file.

    Returns
    -------
    Fmu
        Its description.

    Raises
    ------
    FmuImportError
        The file is missing, not an FMU, or of another version.

    Examples
    --------
    >>> rw.fmu.load("span.fmu").variables["unit"]["a.tension"]
    'N'
    """
    file = Path(path)
    if not file.is_file():
        raise FmuImportError(f"There is no file {file}", "Check the path")
    if not zipfile.is_zipfile(file):
        raise FmuImportError(f"{file.name} is not a zip archive", "Export the FMU again")
    with zipfile.ZipFile(file) as archive:
        if "modelDescription.xml" not in archive.namelist():
            raise FmuImportError(f"{file.name} has no modelDescription.xml", "It is a zip archive, but not an FMU")
        try:
            root = ElementTree.fromstring(archive.read("modelDescription.xml"))
        except ElementTree.ParseError as error:
            raise FmuImportError(
                f"modelDescription.xml of {file.name} is not XML: {error}", "Export it again"
            ) from error
    version = root.get("fmiVersion", "?")
    if version != "2.0" and not version.startswith("3.0"):
        raise FmuImportError(f"{file.name} is of FMI version {version}", "Use version 2.0 or 3.0")
    try:
        described = fmpy.read_model_description(str(file), validate=False)
        _mark_differences(described, root)
        variables, entries, arrays = _tables(described, {})
    except Exception as error:
        raise FmuImportError(f"{file.name} cannot be read: {error}", "Check it with fmpy validate") from error
    sections = {
        "ModelExchange": described.modelExchange,
        "CoSimulation": described.coSimulation,
        "ScheduledExecution": described.scheduledExecution,
    }
    kinds = tuple(kind for kind, section in sections.items() if section is not None)
    platforms = tuple(name for name in fmpy.supported_platforms(str(file)) if name != "c-code")
    name, defined = described.modelName, _units(described)
    return Fmu(file, name, version, kinds, platforms, variables, defined, described, entries, arrays)


def _mark_differences(described: Any, root: ElementTree.Element) -> None:
    """Sets relativeQuantity of the variables; FMPy 0.3.32 reads that of types only."""
    own = {
        parent.get("name", element.get("name")): element.get("relativeQuantity") in ("true", "1")
        for parent in root.iterfind("ModelVariables/*")
        for element in (parent, *parent)
        if "relativeQuantity" in element.attrib
    }
    for variable in described.modelVariables:
        variable.relativeQuantity = own.get(variable.name)


def _tables(
    described: Any, structure: Mapping[str, Value]
) -> tuple[pd.DataFrame, dict[str, Entry], dict[str, tuple[str, ...]]]:
    """Rows and types of all variables, and the elements of each array."""
    rows: dict[str, tuple[object, ...]] = {}
    entries: dict[str, Entry] = {}
    arrays: dict[str, tuple[str, ...]] = {}
    for v in described.modelVariables:
        shape = _shape(v, structure)
        names = [v.name] if shape is None else [f"{v.name}[{','.join(map(str, i))}]" for i in _indices(shape)]
        if shape is not None:
            arrays[v.name] = tuple(names)
        declared = v.declaredType
        items = {} if declared is None else {item.name: int(item.value) for item in declared.items}
        nominal = v.nominal or (declared.nominal if declared is not None else None)
        unit = v.unit or (declared.unit if declared is not None else None) or ""
        own = v.relativeQuantity
        relative = bool(own if own is not None or declared is None else declared.relativeQuantity)
        starts = _starts(v, None if shape is None else len(names))
        for place, (name, start) in enumerate(zip(names, starts, strict=True)):
            kind = kind_of(v.type)
            clocked = bool(v.clocks) and kind != "Clock"
            entries[name] = Entry(
                kind, v.type, v.causality, v.variability, v.valueReference, place, len(names), items, clocked
            )
            number = None if nominal is None else float(nominal)
            described_as = v.description or "", v.valueReference, relative
            rows[name] = kind, v.causality, v.variability, unit, start, number, *described_as
    table = pd.DataFrame.from_dict(rows, orient="index", columns=list(_COLUMNS))
    return table.rename_axis("name"), entries, arrays


def _shape(variable: Any, structure: Mapping[str, Value]) -> tuple[int, ...] | None:
    """Shape of an array; None for a scalar."""
    if not variable.dimensions:
        return None
    sizes = []
    for dimension in variable.dimensions:
        size = dimension.start
        if size is None:
            size = structure.get(dimension.variable.name, dimension.variable.start)
        sizes.append(int(size))
    return tuple(sizes)


def _indices(shape: tuple[int, ...]) -> Iterator[tuple[int, ...]]:
    """Indices of all elements, from 1, the last index fastest."""
    return itertools.product(*(range(1, size + 1) for size in shape))


def _starts(variable: Any, count: int | None) -> list[str | None]:
    """Start value of each element, None if missing."""
    if count is None or variable.start is None:
        return [None if variable.start is None else str(variable.start)] * (1 if count is None else count)
    given: list[str | None] = (
        [str(variable.start)] if variable.type in ("String", "Binary") else list(str(variable.start).split())
    )
    if len(given) == 1:  # one value for all elements
        given = given * count
    return given if len(given) == count else [None] * count


def _flat(value: object) -> list[object]:
    """The elements of nested sequences, in order."""
    if isinstance(value, str | bytes) or not hasattr(value, "__iter__"):
        return [value]
    return [part for one in value for part in _flat(one)]


def _units(described: Any) -> dict[str, units.Unit]:
    found = {}
    for unit in described.unitDefinitions:
        base = unit.baseUnit
        if base is not None:
            exponents = {s: int(getattr(base, s) or 0) for s in units.BASE}
            found[unit.name] = units.from_base(exponents, float(base.factor or 1.0), float(base.offset or 0.0))
    return found
