"""The form of a component, which is all that its equations depend on: components of one form share them."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, fields
from typing import Any, TypeVar

_Kind = TypeVar("_Kind")


def by_values(component: Any) -> Hashable:
    """All values of a component as a key; the component itself if a value has no hash."""
    try:
        hash(component)
    except TypeError:
        return _Alone(component)
    return component


@dataclass(frozen=True, slots=True, eq=False)
class _Alone:
    """A key that equals only itself. It holds the component, so that no other object reuses its address."""

    component: Any


def form_of(part: Any) -> Hashable:
    """Key of a part, such as a drive: its type and what determines its equations.

    A class states that in its own `structure`; for others all values count. Frozen dataclasses compare and hash by
    these.
    """
    return (type(part), part.structure) if "structure" in vars(type(part)) else part


def remade(component: Any, kind: type[_Kind]) -> _Kind:
    """A component of another kind with the values of this one."""
    return kind(**{f.name: getattr(component, f.name) for f in fields(component)})
