"""Tables of the variables and units of a model description."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping
from typing import Any
from xml.etree import ElementTree

import pandas as pd

from ropeway.components import units
from ropeway.fmu.importing.variable_types import Entry, Value, kind_of

_COLUMNS = ("kind", "causality", "variability", "unit", "start", "nominal", "description", "reference", "relative")
_TRUE = "true", "1"


def complete(described: Any, root: ElementTree.Element) -> None:
    """Sets what FMPy 0.3.32 does not read of variables: relativeQuantity, intermediateUpdate."""
    within = {e.get("name") for e in root.iterfind("ModelVariables/*") if e.get("intermediateUpdate") in _TRUE}
    own = {
        parent.get("name", element.get("name")): element.get("relativeQuantity") in _TRUE
        for parent in root.iterfind("ModelVariables/*")
        for element in (parent, *parent)
        if "relativeQuantity" in element.attrib
    }
    for variable in described.modelVariables:
        variable.relativeQuantity = own.get(variable.name)
        variable.intermediateUpdate = variable.name in within


def variable_tables(
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
        nominal = _nominal(v.name, v.nominal or (declared.nominal if declared is not None else None))
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
            if kind == "Real":
                _require_number(v.name, "start", start)
            described_as = v.description or "", v.valueReference, relative
            rows[name] = kind, v.causality, v.variability, unit, start, nominal, *described_as
    table = pd.DataFrame.from_dict(rows, orient="index", columns=list(_COLUMNS))
    return table.rename_axis("name"), entries, arrays


def _nominal(name: str, given: str | None) -> float | None:
    _require_number(name, "nominal", given)
    return None if given is None else float(given)


def _require_number(name: str, what: str, given: str | None) -> None:
    """Raises ValueError."""
    try:
        if given is None or math.isfinite(float(given)):
            return
    except ValueError:
        pass
    raise ValueError(f"{what} of {name!r} is {given!r:.60}, which is not a finite number")


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


def defined_units(described: Any) -> dict[str, units.Unit]:
    """Units by name. Raises ValueError."""
    found = {}
    for unit in described.unitDefinitions:
        base = unit.baseUnit
        if base is not None:
            exponents = {s: int(getattr(base, s) or 0) for s in units.BASE}
            found[unit.name] = units.from_base(exponents, float(base.factor or 1.0), float(base.offset or 0.0))
    return found
