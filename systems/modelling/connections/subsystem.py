"""A system as a part of another: its components under dotted names."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from ropeway.components import check
from ropeway.components.check import PartName
from ropeway.components.component import Component
from ropeway.components.errors import InputError
from ropeway.components.node import Node
from ropeway.components.span import Span
from ropeway.systems.modelling.declarations import Declarations


@dataclass(frozen=True, eq=False)
class Subsystem(Mapping[str, Component]):
    """Components of a system that was added to another, by their own names.

    `part["c1"].supply` is a port of the component `name.c1`.
    """

    name: str
    components: Mapping[str, Component]

    def __repr__(self) -> str:
        return f"<Subsystem {self.name!r}: {len(self.components)} components>"

    def __getitem__(self, name: str) -> Component:
        return self.components[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.components)

    def __len__(self) -> int:
        return len(self.components)


def renamed(component: Component, prefix: str) -> Component:
    """A component with a dotted name."""
    name = PartName(f"{prefix}.{component.name}")
    if isinstance(component, Node):
        return replace(component, name=name, label=f"{prefix}.{component.label}")
    return replace(component, name=name)


def include(outer: Declarations, inner: Declarations, name: str | None, origin: str) -> Subsystem:
    """Adds the declarations of a system to another, with dotted names. Raises InputError."""
    if name is None:
        raise InputError(f"System {inner.name!r} needs a name to become a part of {outer.name!r}", "Give name=")
    check.name(name, "Subsystem")
    if inner is outer:
        raise InputError(f"System {outer.name!r} cannot be a part of itself", "Add another system")
    for what in ("gravity", "temperature", "environment"):
        if getattr(inner, what) != getattr(outer, what):
            raise InputError(f"{inner.name!r} has another {what} than {outer.name!r}", f"Use the same {what}")
    taken = [n for n in (*outer.components, *outer.load_names) if n == name or n.startswith(f"{name}.")]
    if taken:
        raise InputError(f"The name {name!r} is taken by {taken[0]!r}", "Give each part its own name")
    return _included(outer, inner, name, origin)


def _included(outer: Declarations, inner: Declarations, prefix: str, origin: str) -> Subsystem:

    def named(name: str) -> str:
        return PartName(f"{prefix}.{name}")

    own = {name: renamed(component, prefix) for name, component in inner.components.items()}
    spans = {c: own[c.name] for c in inner.components.values() if isinstance(c, Span)}

    def there(on: tuple[Span, ...]) -> tuple[Span, ...]:
        return tuple(s for s in (spans[span] for span in on) if isinstance(s, Span))

    outer.components |= {c.name: c for c in own.values()}
    outer.connections |= {(named(a), end): (named(b), seat) for (a, end), (b, seat) in inner.connections.items()}
    outer.seated |= {(named(owner), seat) for owner, seat in inner.seated}
    outer.supplies |= {named(drive): named(unit) for drive, unit in inner.supplies.items()}
    outer.links |= {(named(a), i): (named(b), o) for (a, i), (b, o) in inner.links.items()}
    for hung in inner.hung:
        load = replace(hung.load, name=named(hung.load.name))
        outer.hung.append(replace(hung, load=load, spans=there(hung.spans)))
    outer.feeds += [replace(feed, spans=there(feed.spans), prefix=f"{prefix}.{feed.prefix}") for feed in inner.feeds]
    outer.origins |= {c.name: origin for c in own.values()}
    outer.precedences |= {f"{prefix}.{group}" if group else prefix: p for group, p in inner.precedences.items()}
    return Subsystem(prefix, own)
