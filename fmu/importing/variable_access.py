"""Reading and writing the variables of an instance, in groups of one type, with whole arrays."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from ctypes import POINTER, c_double, c_size_t, c_uint8, c_uint32, cast
from dataclasses import dataclass
from typing import Any

import numpy as np
from fmpy import fmi3 as binding3

from ropeway.fmu.importing.interface import FmuInterface
from ropeway.fmu.importing.variable_types import Value, kind_of, taken_by

_IN_2 = {"Enumeration": "Integer"}
_IN_3 = {"Enumeration": "Int64"}
"""Types that are passed as another type."""


@dataclass(frozen=True, slots=True)
class Group:
    """Variables of one type.

    `names`: the requested variables; `places`: their positions in the request; `references`: value references, arrays
    once; `count`: number of all elements; `picked`: positions of the requested values among these; `scalars`: no array
    is among them; `real`: they are real; `label`: the names, for messages; `fixed`: one that cannot change during a
    run; `doubles`: the memory through which scalars of double precision are passed.
    """

    type: str
    names: tuple[str, ...]
    places: list[int]
    references: list[int]
    count: int
    picked: list[int]
    scalars: bool
    real: bool
    label: str
    fixed: str
    doubles: Doubles | None


class Doubles:
    """References, and memory for their values as `ctypes` and NumPy see it."""

    __slots__ = ("count", "numbers", "references", "values")

    def __init__(self, references: Sequence[int]) -> None:
        self.count = len(references)
        self.references = (c_uint32 * self.count)(*references)
        self.values = (c_double * self.count)()
        self.numbers = np.ctypeslib.as_array(self.values)


class Access:
    """Values of an instance, given its FMU and FMPy's object."""

    def __init__(self, fmu: FmuInterface, opened: Any, three: bool) -> None:
        self._fmu, self._opened, self._three = fmu, opened, three
        self._get, self._set = ("fmi3GetFloat64", "fmi3SetFloat64") if three else ("fmi2GetReal", "fmi2SetReal")
        self._groups: dict[tuple[str, ...], list[Group]] = {}  # cached: the same variables are read at every step

    def references(self, names: Iterable[str]) -> list[int]:
        """Value references. Raises FmuVariableError."""
        return [self._fmu.entry(name).reference for name in names]

    def groups(self, names: tuple[str, ...]) -> list[Group]:
        """Variables by their types. Raises FmuVariableError."""
        if names not in self._groups:
            places: dict[str, list[int]] = {}
            for i, name in enumerate(names):
                places.setdefault(self._fmu.entry(name).type, []).append(i)
            self._groups[names] = [self._group(kind, names, own) for kind, own in places.items()]
        return self._groups[names]

    def _group(self, fmi_type: str, names: tuple[str, ...], places: list[int]) -> Group:
        own = tuple(names[i] for i in places)
        entries = [self._fmu.entry(name) for name in own]
        first: dict[int, int] = {}
        count = 0
        for entry in entries:
            if entry.reference not in first:
                first[entry.reference] = count
                count += entry.size
        fixed = [
            name
            for name, e in zip(own, entries, strict=True)
            if e.causality in ("parameter", "calculatedParameter", "structuralParameter") and e.variability != "tunable"
        ]
        scalars = count == len(own) == len(first)
        doubles = Doubles(list(first)) if scalars and fmi_type in ("Real", "Float64") else None
        return Group(
            (_IN_3 if self._three else _IN_2).get(fmi_type, fmi_type),
            own,
            places,
            list(first),
            count,
            [first[e.reference] + e.place for e in entries],
            scalars,
            kind_of(fmi_type) == "Real",
            ", ".join(own),
            fixed[0] if fixed else "",
            doubles,
        )

    def _pass(self, function: str, doubles: Doubles) -> None:
        more = (doubles.count,) if self._three else ()
        call = getattr(self._opened, function)
        call(self._opened.component, doubles.references, doubles.count, doubles.values, *more)

    def numbers(self, group: Group) -> np.ndarray | list[Value]:
        """Values of a group's names, as numbers."""
        if group.doubles is None:
            return self.read(group)
        self._pass(self._get, group.doubles)
        return group.doubles.numbers

    def read(self, group: Group) -> list[Value]:
        """Values of a group's names."""
        if group.doubles is not None:
            self._pass(self._get, group.doubles)
            found: list[Value] = group.doubles.numbers.tolist()
            return found
        values_read = self._whole(group)
        return values_read if group.scalars else [values_read[i] for i in group.picked]

    def _whole(self, group: Group) -> list[Any]:
        """Values of all elements. Raises FMPy's FMICallException, as all calls here."""
        if not self._three:
            values_read = getattr(self._opened, f"get{group.type}")(group.references)
            if group.type == "Boolean":
                return [bool(v) for v in values_read]
            return [_decoded(v) for v in values_read] if group.type == "String" else values_read
        if group.type == "String":
            return self._strings(group)
        if group.type == "Binary":
            return [v or b"" for v in self._opened.getBinary(group.references, group.count)]
        values_read = getattr(self._opened, f"get{group.type}")(group.references, group.count)
        return list(values_read)

    def _strings(self, group: Group) -> list[str]:
        references = (binding3.fmi3ValueReference * len(group.references))(*group.references)
        values_read = (binding3.fmi3String * group.count)()
        self._opened.fmi3GetString(self._opened.component, references, len(references), values_read, group.count)
        return [_decoded(v) for v in values_read]

    def write(self, group: Group, values: Mapping[str, object]) -> None:
        """Sets the variables of a group; other elements of an array keep their values. Raises FmuVariableError."""
        file, entry = self._fmu.path.name, self._fmu.entries
        own: list[Any] = [values[name] for name in group.names]
        if not group.real or any(type(value) is not float for value in own):
            own = [taken_by(entry[name], name, file, value) for name, value in zip(group.names, own, strict=True)]
        if group.doubles is not None:
            group.doubles.values[:] = own
            self._pass(self._set, group.doubles)
            return
        if not group.scalars:
            given = len(set(group.picked)) == group.count
            every = [None] * group.count if given else self._whole(group)
            for i, value in zip(group.picked, own, strict=True):
                every[i] = value
            own = every
        if group.type == "Binary":
            self._set_binary(group, own)
        else:
            getattr(self._opened, f"set{group.type}")(group.references, own)

    def _set_binary(self, group: Group, values: list[Any]) -> None:
        references = (binding3.fmi3ValueReference * len(group.references))(*group.references)
        buffers = [(c_uint8 * max(len(v), 1))(*v) for v in values]
        pointers = (binding3.fmi3Binary * len(buffers))(*(cast(b, POINTER(c_uint8)) for b in buffers))
        sizes = (c_size_t * len(values))(*(len(v) for v in values))
        self._opened.fmi3SetBinary(self._opened.component, references, len(references), sizes, pointers, len(values))


def _decoded(text: bytes | None) -> str:
    return (text or b"").decode(errors="replace")
