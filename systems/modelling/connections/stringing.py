"""A rope strung over supports: its spans, their lengths, and the seats that they are connected to."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

from ropeway.components import check
from ropeway.components.component import Seat
from ropeway.components.errors import InputError
from ropeway.components.node import Node
from ropeway.components.rope import Rope, hanging_limit
from ropeway.components.span import Span
from ropeway.systems.modelling.empty_rope import lengths_for_tension, lengths_for_total


class Strung(NamedTuple):
    """Spans of a rope over `nodes`; each begins at a seat of `leaving` and ends at one of `arriving`."""

    nodes: tuple[Node, ...]
    spans: tuple[Span, ...]
    leaving: tuple[Seat, ...]
    arriving: tuple[Seat, ...]


def string_over(
    rope: Rope,
    over: Sequence[Node | Seat],
    *,
    gravity: float,
    length: float | None,
    tension: float | None,
    name: str | None,
) -> Strung:
    """The spans of a rope of a length [m] or tension [N] over supports. Raises InputError, SlackRopeError."""
    if len(over) < 2:
        raise InputError(f"A rope needs two supports, not {len(over)}", "Give its ends and the supports between them")
    arriving = [seat if isinstance(seat, Seat) else seat.arriving for seat in over]
    nodes = [_node_of(seat) for seat in arriving]
    if (length is None) == (tension is None):
        raise InputError("string needs either length or tension", "Give one of them")
    for node, seat in zip(nodes[1:-1], arriving[1:-1], strict=True):
        if node.through(seat) is None:
            raise InputError(
                f"{node.described} is an end support, not an intermediate one",
                "End the rope there, or use a sheave",
            )
    for before, after in pairwise(nodes):
        if before.at == after.at:
            raise InputError(f"{before.described} and {after.described} have the same position", "Move one of them")
    points = [node.at for node in nodes]
    prefix = "" if name is None else f"{name}_"
    names = [f"{prefix}{a.name}_{b.name}" for a, b in pairwise(nodes)]
    weight = rope.mass_per_length * gravity
    if length is not None:
        check.positive(length, f"Rope {names[0]} ...", "length", "m")
        lengths = lengths_for_total(points, weight, rope.strain, length, names)
    else:
        check.positive(tension or 0.0, f"Rope {names[0]} ...", "tension", "N")
        lengths = lengths_for_tension(points, weight, rope.strain, tension or 0.0, names)
    spans = tuple(Span(name, rope=rope, length=float(d)) for name, d in zip(names, lengths, strict=True))
    _require_strength(spans, nodes, gravity)
    leaving = [nodes[0].leaving if isinstance(over[0], Node) else over[0]]
    leaving += [node.through(seat) or seat for node, seat in zip(nodes[1:-1], arriving[1:-1], strict=True)]
    return Strung(tuple(nodes), spans, tuple(leaving), tuple(arriving[1:]))


def _require_strength(spans: Sequence[Span], nodes: Sequence[Node], gravity: float) -> None:
    """Raises InputError for a span whose own weight breaks its rope."""
    for span, a, b in zip(spans, nodes[:-1], nodes[1:], strict=True):
        height = abs(a.at[2] - b.at[2])
        if max(height, span.length / 2.0) > hanging_limit(span.rope, gravity):
            need = max(height, span.length / 2.0) * span.rope.mass_per_length * gravity
            raise InputError(
                f"Span {span.name!r}: the weight of the rope causes at least {need:.6g} N, above its minimum "
                f"breaking load {span.rope.breaking_load:.6g} N",
                "Choose a stronger rope or a shorter span",
            )


def _node_of(seat: Seat) -> Node:
    """The node of a seat. Raises InputError if it has no position yet."""
    node = seat.owner
    if not isinstance(node, Node):
        raise InputError(f"{node.name!r} is not a support", "Give supports, or their seats")
    _ = node.position
    return node
