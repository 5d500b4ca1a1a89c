"""A system structure as slaves, start values and connections of a co-simulation."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path as File
from typing import Any

from ropeway.components.errors import RopewayError, RopewayWarning
from ropeway.components.identifier import identifier
from ropeway.fmu.errors import FmuImportError, FmuVariableError
from ropeway.fmu.importing.archive import ArchiveLimits
from ropeway.fmu.importing.fmu_file import Fmu, load
from ropeway.fmu.importing.variable_types import Mapped
from ropeway.fmu.ssp.package import Package
from ropeway.fmu.ssp.parameters import Binding, Parameter, quantity_in, scaled, translated
from ropeway.fmu.ssp.structure import Component, SubSystem, read_description
from ropeway.fmu.ssp.wiring import Path, Place, Wiring


@dataclass(frozen=True)
class SspSlave:
    """An FMU of a system structure; `settings`: of this library's master."""

    name: str
    fmu: Fmu
    kind: str | None
    start: Mapping[str, object]
    settings: Mapping[str, str]


@dataclass(frozen=True)
class SspConnection:
    """An output that drives an input, "slave.variable" each: the input is factor times the output plus offset.

    `plain`: it is only converted between the units of the variables, or mapped; `mapping`: values of the input by
    those of the output.
    """

    source: str
    target: str
    factor: float
    offset: float
    plain: bool
    mapping: Mapping[Mapped, Mapped] | None = None


@dataclass(frozen=True)
class SspSystem:
    """The content of a system structure; `settings`: of this library's master, by element."""

    slaves: tuple[SspSlave, ...]
    connections: tuple[SspConnection, ...]
    start_time: float | None
    stop_time: float | None
    settings: Mapping[str, Mapping[str, str]]


def read_ssp(path: str | File, folder: File, limits: ArchiveLimits) -> SspSystem:
    """The content of a file .ssp or .ssd; FMUs of an archive are written into a folder.

    Parameter values that fit no variable are ignored, with a RopewayWarning. Raises FmuImportError, FmuVariableError.
    """
    package = Package(path, folder, limits)
    try:
        described = read_description(package)
    except RopewayError:
        raise
    except ValueError as error:  # documents of version 2.0 are not checked by a schema
        raise FmuImportError(f"{package.path.name} has a value that cannot be read: {error}", "Correct it") from error
    components = dict(_components(described.system, ()))
    if not components:
        raise FmuImportError(f"{package.path.name} has no FMU", "Export the SSP again")
    loaded: dict[tuple[File, str], Fmu] = {}
    fmus: dict[Path, Fmu] = {}
    for place, component in components.items():
        key = component.package.path, component.source
        if key not in loaded:
            loaded[key] = load(component.package.local(component.source), limits=limits)
        fmus[place] = loaded[key]
    names = _names(components)
    wiring = Wiring(described.system, fmus)
    values = _Values(described.system, fmus, wiring)
    slaves = tuple(
        SspSlave(names[path], fmus[path], c.kind, values.of(path), c.settings) for path, c in components.items()
    )
    values.warn_of_unused(package.path.name)
    connections = [c for target in wiring.targets for c in _connections(wiring, target, names)]
    return SspSystem(slaves, tuple(connections), described.start_time, described.stop_time, described.settings)


def _components(system: SubSystem, path: Path) -> Iterator[tuple[Path, Component]]:
    for name, element in system.elements.items():
        if isinstance(element, SubSystem):
            yield from _components(element, (*path, name))
        elif isinstance(element, Component):
            yield (*path, name), element


def _names(paths: Mapping[Path, Any]) -> dict[Path, str]:
    """A name for each slave: the names of systems and component as one identifier."""
    names: dict[Path, str] = {}
    for path in paths:
        plain = name = "_".join(identifier(part) for part in path)
        number = 1
        while name in names.values():
            number += 1
            name = f"{plain}_{number}"
        names[path] = name
    return names


def _connections(wiring: Wiring, target: Place, names: Mapping[Path, str]) -> list[SspConnection]:
    """The connection to an input, or those to the elements of an array."""
    origin = wiring.origin(target)
    source = origin.place
    if source.path not in names or source.dictionary is not None:  # an open connector of a system
        return []
    ends = []
    for place in (source, target):
        fmu = wiring.fmus[place.path]
        ends.append([f"{names[place.path]}.{v}" for v in fmu.arrays.get(place.name, (place.name,))])
    if len(ends[0]) != len(ends[1]):
        raise FmuImportError(f"{source} and {target} are arrays of different sizes", "Connect their elements")
    one, other = (quantity_in(wiring.fmus[p.path], p.name) for p in (source, target))
    try:
        direct: tuple[float, float] | None = (1.0, 0.0)
        if one is not None and other is not None:
            direct = one.conversion(other, str(target))
    except FmuVariableError:  # they are connected without a conversion
        direct = None
    plain = (origin.factor, origin.offset) == direct
    scale = origin.factor, origin.offset, plain
    return [SspConnection(a, b, *scale, origin.table) for a, b in zip(*ends, strict=True)]


class _Values:
    """Start values from the parameter sets of all elements; those of outer systems take precedence."""

    def __init__(self, root: SubSystem, fmus: Mapping[Path, Fmu], wiring: Wiring) -> None:
        self._fmus, self._wiring = fmus, wiring
        self._bound = list(_bindings(root, ()))
        self._used: set[tuple[int, str]] = set()

    def of(self, path: Path) -> dict[str, object]:
        """Start values of a component. Raises FmuVariableError."""
        fmu, found = self._fmus[path], dict[str, object]()
        known = {*fmu.entries, *fmu.arrays}
        for target in (t for t in self._wiring.targets if t.path == path):
            origin = self._wiring.origin(target)
            given = None if origin.place.path in self._fmus else self._given(origin.place)
            if given is not None:
                value = given.value_in(self._wiring.unit(origin.place), str(origin.place))
                origin = self._wiring.origin(target, given.quantity)
                value = scaled(value, origin.factor, origin.offset)
                found[target.name] = value if origin.table is None else translated(value, origin.table)
        for i, prefix, binding in self._within(path):
            for name in binding.values:
                variable = name.removeprefix(prefix)
                if name.startswith(prefix) and variable in known:
                    self._used.add((i, name))
                    what = f"{name!r} of {binding.where}"
                    found.pop(variable, None)
                    found[variable] = binding.values[name].value_in(quantity_in(fmu, variable), what)
        return found

    def _given(self, place: Place) -> Parameter | None:
        """The value that is bound to a connector of a system."""
        found = None
        for i, prefix, binding in self._within(place.path):
            name = prefix + place.name
            if name in binding.values:
                self._used.add((i, name))
                found = binding.values[name]
        return found

    def _within(self, path: Path) -> Iterator[tuple[int, str, Binding]]:
        """Bindings of an element and of the systems around it, from the inside, and what names begin with there."""
        for depth in range(len(path), -1, -1):
            prefix = "".join(f"{name}." for name in path[depth:])
            for i, (where, binding) in enumerate(self._bound):
                if where == path[:depth]:
                    yield i, prefix, binding

    def warn_of_unused(self, file: str) -> None:
        """Warns of values that fit no variable."""
        unused = [
            name for i, (_, binding) in enumerate(self._bound) for name in binding.values if (i, name) not in self._used
        ]
        if unused:
            shown = ", ".join(unused[:5]) + (", ..." if len(unused) > 5 else "")
            warnings.warn(
                f"{file}: {len(unused)} parameter values fit no variable: {shown}", RopewayWarning, stacklevel=4
            )


def _bindings(system: SubSystem, path: Path) -> Iterator[tuple[Path, Binding]]:
    for binding in system.bindings:
        yield path, binding
    for name, element in system.elements.items():
        if isinstance(element, SubSystem):
            yield from _bindings(element, (*path, name))
        elif isinstance(element, Component):
            for binding in element.bindings:
                yield (*path, name), binding
