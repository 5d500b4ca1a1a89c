"""The structure that a description declares: systems, components, signal dictionaries and their connections."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from xml.etree import ElementTree

from ropeway.fmu.errors import FmuImportError
from ropeway.fmu.importing.variable_types import Mapped
from ropeway.fmu.ssp.documents import (
    DICTIONARY,
    OWN,
    SSB,
    SSC,
    SSD,
    STRUCTURE,
    Quantity,
    defined_units,
    linear_of,
    parsed,
    quantity_of,
    table_of,
    truth,
)
from ropeway.fmu.ssp.package import Package
from ropeway.fmu.ssp.parameters import Binding, read_bindings

_FMU, _DESCRIPTION = "application/x-fmu-sharedlibrary", "application/x-ssp-definition"
_PACKAGE = "application/x-ssp-package"
_DEEPEST = 20
"""Largest number of descriptions within each other: an archive can contain itself."""


@dataclass(frozen=True)
class Connector:
    """A connector of an element; `quantity`: None if its unit is that of the variable behind it."""

    kind: str
    quantity: Quantity | None


@dataclass(frozen=True)
class Link:
    """A connection within a system; an end is (element, connector), the element None for the system itself.

    Values are converted between units unless not `converts`, then become factor times the value plus offset, or what
    the `table` has for them.
    """

    start: tuple[str | None, str]
    end: tuple[str | None, str]
    factor: float
    offset: float
    converts: bool
    table: Mapping[Mapped, Mapped] | None = None


@dataclass(frozen=True)
class Component:
    """An FMU of a system, with its package; `settings`: of this library's master."""

    name: str
    connectors: Mapping[str, Connector]
    bindings: tuple[Binding, ...]
    package: Package
    source: str
    kind: str | None
    settings: Mapping[str, str]


@dataclass(frozen=True)
class DictionaryUse:
    """Access of a system to some signals of a signal dictionary."""

    name: str
    connectors: Mapping[str, Connector]
    dictionary: str


@dataclass(frozen=True)
class SubSystem:
    """A system; `dictionaries`: units of the signals of each, by name."""

    name: str
    connectors: Mapping[str, Connector]
    bindings: tuple[Binding, ...]
    elements: Mapping[str, Component | DictionaryUse | SubSystem]
    links: tuple[Link, ...]
    dictionaries: Mapping[str, Mapping[str, Quantity | None]]


@dataclass(frozen=True)
class Description:
    """A description: its root system, times of the default experiment, and settings of this library's master."""

    system: SubSystem
    start_time: float | None
    stop_time: float | None
    settings: Mapping[str, Mapping[str, str]] = field(default_factory=dict)


def read_description(package: Package) -> Description:
    """The description of a package. Raises FmuImportError."""
    root = parsed(package.read(package.root), f"{package.root} of {package.path.name}", STRUCTURE)
    experiment = root.find(f"{{{SSD}}}DefaultExperiment")
    times = {} if experiment is None else experiment.attrib
    start, stop = (float(times[name]) if name in times else None for name in ("startTime", "stopTime"))
    system = _Reader(package, package.root, root).system(_required(root, "System"))
    return Description(system, start, stop, _settings(root))


def _required(parent: ElementTree.Element, name: str) -> ElementTree.Element:
    found = parent.find(f"{{{SSD}}}{name}")
    if found is None:
        raise FmuImportError(f"{parent.tag} has no {name}", "Export the SSP again")
    return found


def _settings(element: ElementTree.Element) -> dict[str, dict[str, str]]:
    """Attributes of this library's annotations by their element."""
    own = element.iterfind(f"{{{SSD}}}Annotations/{{{SSC}}}Annotation/*")
    marked = (a for a in own if a.tag.startswith(f"{{{OWN}}}"))
    return {a.tag.partition("}")[2]: dict(a.attrib) for a in marked}


class _Reader:
    """Reads the systems of one description, at `base` in the package.

    `around`: descriptions of the package that contain it; `depth`: number of all that do.
    """

    def __init__(
        self, package: Package, base: str, root: ElementTree.Element, around: tuple[str, ...] = (), depth: int = 0
    ) -> None:
        self.package, self.base, self.around, self.depth = package, base, (*around, base), depth
        self.units = defined_units(root, SSD)

    def system(self, element: ElementTree.Element) -> SubSystem:
        """A system with all that is in it."""
        made = [self._element(child) for child in element.iterfind(f"{{{SSD}}}Elements/*")]
        links = element.iterfind(f"{{{SSD}}}Connections/{{{SSD}}}Connection")
        known = element.iterfind(f"{{{SSD}}}SignalDictionaries/{{{SSD}}}SignalDictionary")
        return SubSystem(
            element.get("name", ""),
            self._connectors(element),
            read_bindings(element, self.package, self.base, self.units),
            {one.name: one for one in made},
            tuple(self._link(link) for link in links),
            {d.get("name", ""): self._dictionary(d) for d in known},
        )

    def _element(self, element: ElementTree.Element) -> Component | DictionaryUse | SubSystem:
        what = element.tag.partition("}")[2]
        if what == "System":
            return self.system(element)
        name, connectors = element.get("name", ""), self._connectors(element)
        if what == "SignalDictionaryReference":
            return DictionaryUse(name, connectors, element.get("dictionary", ""))
        kind, source = element.get("type", _FMU), element.get("source")
        if source is None or source.startswith("#"):
            raise FmuImportError(f"Component {name!r} has no FMU", "Complete the system in the tool that wrote it")
        if kind in (_DESCRIPTION, _PACKAGE):
            return self._nested(element, source, packed=kind == _PACKAGE)
        if kind != _FMU:
            raise FmuImportError(
                f"Component {name!r} is of type {kind}", "Only FMUs, .ssd and .ssp files can be components"
            )
        implementation = element.get("implementation", "any")
        return Component(
            name,
            connectors,
            read_bindings(element, self.package, self.base, self.units, source),
            self.package,
            source if ":" in source else self.package.inside(source, self.base),
            None if implementation == "any" else implementation,
            _settings(element).get("Slave", {}),
        )

    def _nested(self, element: ElementTree.Element, source: str, *, packed: bool) -> SubSystem:
        """A system of another description or package, with the connectors and bindings of the component."""
        package = self.package.nested(source, self.base) if packed else self.package
        base = package.root if packed else package.inside(source, self.base)
        if not packed and base in self.around:
            raise FmuImportError(f"{base} contains itself", "Remove the component that refers to it")
        if self.depth >= _DEEPEST:
            raise FmuImportError(f"{source} is the {self.depth}th system within another", "Use fewer levels")
        root = parsed(package.read(base), base, STRUCTURE)
        around = () if packed else self.around
        inner = _Reader(package, base, root, around, self.depth + 1).system(_required(root, "System"))
        outer = read_bindings(element, self.package, self.base, self.units)
        return SubSystem(
            element.get("name", ""),
            {**inner.connectors, **self._connectors(element)},
            (*inner.bindings, *outer),
            inner.elements,
            inner.links,
            inner.dictionaries,
        )

    def _link(self, link: ElementTree.Element) -> Link:
        ends = [(link.get(f"{end}Element"), link.get(f"{end}Connector", "")) for end in ("start", "end")]
        indices = [link.get(f"{end}Indices") for end in ("start", "end")]
        ends = [(e, f"{c}[{','.join(i.split())}]" if i else c) for (e, c), i in zip(ends, indices, strict=True)]
        return Link(ends[0], ends[1], *linear_of(link), not truth(link.get("suppressUnitConversion")), table_of(link))

    def _connectors(self, element: ElementTree.Element) -> dict[str, Connector]:
        found = element.iterfind(f"{{{SSD}}}Connectors/{{{SSD}}}Connector")
        return {c.get("name", ""): Connector(c.get("kind", ""), quantity_of(c, self.units)) for c in found}

    def _dictionary(self, element: ElementTree.Element) -> dict[str, Quantity | None]:
        """Units of the signals of a dictionary, which is inside the element or in a file."""
        source = element.get("source")
        root = element.find(f"{{{SSB}}}SignalDictionary")
        if source is not None:
            root = parsed(self.package.read(source, self.base), source, DICTIONARY)
        if root is None:
            raise FmuImportError(f"Signal dictionary {element.get('name')!r} is empty", "Export the SSP again")
        known = {**self.units, **defined_units(root, SSB)}
        return {e.get("name", ""): quantity_of(e, known) for e in root.iterfind(f"{{{SSB}}}DictionaryEntry")}
