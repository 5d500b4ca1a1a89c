"""The signals of a system structure: which output drives each input, through systems and signal dictionaries."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from ropeway.fmu.errors import FmuImportError
from ropeway.fmu.importing.fmu_file import Fmu
from ropeway.fmu.importing.variable_types import Mapped
from ropeway.fmu.ssp.documents import Quantity
from ropeway.fmu.ssp.parameters import quantity_in
from ropeway.fmu.ssp.structure import Component, DictionaryUse, Link, SubSystem

Path = tuple[str, ...]
"""Names of the systems and the element, from the outside; the root system has none."""
_SOURCES, _SINKS = ("output", "calculatedParameter"), ("input", "parameter", "structuralParameter")


class Place(NamedTuple):
    """A connector of an element, or a signal of a dictionary (then the path is that of its system)."""

    path: Path
    name: str
    dictionary: str | None = None

    def __str__(self) -> str:
        return ".".join((*self.path, *filter(None, (self.dictionary,)), self.name))


@dataclass(frozen=True)
class Origin:
    """Where a value comes from: an output, or a connector of a system that nothing drives; then it is scaled.

    `table`: the values that others become, one by one; it is not scaled then.
    """

    place: Place
    factor: float = 1.0
    offset: float = 0.0
    quantity: Quantity | None = None
    table: Mapping[Mapped, Mapped] | None = None

    def translated(self, table: Mapping[Mapped, Mapped] | None) -> Origin:
        """The same after another translation."""
        if table is None or self.table is None:
            return self if table is None else replace(self, table=table)
        return replace(self, table={key: table[value] for key, value in self.table.items() if value in table})

    def scaled(self, factor: float, offset: float, quantity: Quantity | None) -> Origin:
        """The same after another scaling, in another unit."""
        if (factor, offset) == (1.0, 0.0):
            return replace(self, quantity=quantity)
        if self.table is not None:
            raise FmuImportError(f"Values of {self.place} are scaled and mapped one by one", "Use one of them")
        return replace(self, factor=factor * self.factor, offset=factor * self.offset + offset, quantity=quantity)

    def converted(self, quantity: Quantity | None, to: Place) -> Origin:
        """The same in another unit; a place without a unit passes on that of the value. Raises FmuVariableError."""
        if quantity is None or self.quantity is None:
            return replace(self, quantity=quantity or self.quantity)
        factor, offset = self.quantity.conversion(quantity, f"The connection of {self.place} to {to}")
        return self.scaled(factor, offset, quantity)


@dataclass
class Wiring:
    """The signals of a system; `fmus`: the FMU of each component by its path."""

    root: SubSystem
    fmus: Mapping[Path, Fmu]
    _from: dict[Place, tuple[Place, Link]] = field(default_factory=dict)
    _quantities: dict[Place, Quantity | None] = field(default_factory=dict)
    targets: list[Place] = field(default_factory=list)
    """Inputs and parameters of components that have a connection, in the order of the connections."""

    def __post_init__(self) -> None:
        self._add(self.root, (), {})

    def _add(self, system: SubSystem, path: Path, known: Mapping[str, Path]) -> None:
        """Adds the connections of a system and of those in it; `known`: systems of the dictionaries by their names."""
        known = {**known, **dict.fromkeys(system.dictionaries, path)}
        for name, signals in system.dictionaries.items():
            self._quantities |= {Place(path, signal, name): unit for signal, unit in signals.items()}
        for name, connector in system.connectors.items():
            self._quantities.setdefault(Place(path, name), connector.quantity)
        for link in system.links:
            self._connect(system, path, known, link)
        for name, element in system.elements.items():
            if isinstance(element, SubSystem):
                self._add(element, (*path, name), known)

    def _connect(self, system: SubSystem, path: Path, known: Mapping[str, Path], link: Link) -> None:
        (one, gives), (other, takes) = (self._end(system, path, known, end) for end in (link.start, link.end))
        if gives is None:
            gives = True if takes is None else not takes
        takes = not gives if takes is None else takes
        if gives == takes:
            raise FmuImportError(
                f"{one} and {other} are connected, but both {'give' if gives else 'take'} a value",
                "Connect an output with an input",
            )
        source, target = (one, other) if gives else (other, one)
        if target in self._from:
            raise FmuImportError(f"{target} is driven by {self._from[target][0]} and {source}", "Remove one connection")
        self._from[target] = source, link
        if target.dictionary is None and target.path in self.fmus:
            self.targets.append(target)

    def _end(
        self, system: SubSystem, path: Path, known: Mapping[str, Path], end: tuple[str | None, str]
    ) -> tuple[Place, bool | None]:
        """An end of a connection, and whether it gives a value within the system; None: either."""
        element_name, name = end
        if element_name is None:
            kind = system.connectors[name].kind if name in system.connectors else None
            place = Place(path, name)
            if kind is None:
                raise FmuImportError(f"{place} is connected, but is not declared", "Export the SSP again")
            return place, None if kind == "inout" else kind in _SINKS  # an input of the system gives inside it
        element = system.elements.get(element_name)
        if element is None:
            raise FmuImportError(
                f"{'.'.join((*path, element_name))} is connected, but is missing", "Export the SSP again"
            )
        place = Place((*path, element_name), name)
        kind = element.connectors[name].kind if name in element.connectors else None
        if isinstance(element, DictionaryUse):
            place = self._signal(element, name, known)
        elif isinstance(element, Component):
            fmu = self.fmus[place.path]
            self._quantities.setdefault(place, element.connectors[name].quantity if kind else None)
            variable = fmu.arrays.get(name, (name,))[0]
            kind = kind or fmu.entry(variable).causality
        if kind is None:
            raise FmuImportError(f"{place} is connected, but is not declared", "Export the SSP again")
        return place, True if kind in _SOURCES else False if kind in _SINKS else None

    def _signal(self, use: DictionaryUse, name: str, known: Mapping[str, Path]) -> Place:
        """The signal of a dictionary."""
        place = Place(known.get(use.dictionary, ()), name, use.dictionary)
        if use.dictionary not in known or place not in self._quantities:
            raise FmuImportError(
                f"The signal dictionary {use.dictionary!r} has no signal {name!r}", "Export the SSP again"
            )
        return place

    def origin(self, target: Place, given: Quantity | None = None) -> Origin:
        """What drives a place, in the unit of the place; `given`: the unit of a value at an open connector of a system
        that declares none. Raises FmuImportError, FmuVariableError."""
        found = self._trace(target, given, ())
        return found.converted(self._own(target), target)

    def unit(self, place: Place) -> Quantity | None:
        """The unit that a connector declares."""
        return self._quantities.get(place)

    def _own(self, place: Place) -> Quantity | None:
        """Unit of the variable of a component; None elsewhere."""
        fmu = None if place.dictionary else self.fmus.get(place.path)
        return None if fmu is None else quantity_in(fmu, place.name)

    def _trace(self, place: Place, given: Quantity | None, seen: tuple[Place, ...]) -> Origin:
        """What drives a place, in the unit of its connector."""
        if place in seen:
            raise FmuImportError(f"{place} drives itself through {', '.join(map(str, seen))}", "Remove one connection")
        if place not in self._from:
            return Origin(place, quantity=self._own(place)).converted(self._quantities.get(place) or given, place)
        source, link = self._from[place]
        before, unit = self._trace(source, given, (*seen, place)), self._quantities.get(place)
        if place.dictionary is None and place.path in self.fmus and unit is None:
            unit = self._own(place)
        if link.converts:
            before = before.converted(unit, place)
        found = before.scaled(link.factor, link.offset, before.quantity if link.converts else unit)
        return found.translated(link.table)
