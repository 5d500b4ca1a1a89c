"""Loads on the ropes of a system: one hung where the user says, or a feed of them at a spacing."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

from ropeway.components import check
from ropeway.components.errors import InputError
from ropeway.components.load import Load
from ropeway.components.span import Span
from ropeway.systems.modelling.declarations import Declarations, Feed, Hung

MOST_LOADS = 10_000
"""Largest plausible number of loads on a rope; more indicate wrong units."""


def hang(system: Declarations, load: Load, on: tuple[Span, ...], at: float) -> None:
    """Clamps a load to consecutive spans, `at` [m, unstretched] from end a of the first. Raises InputError."""
    require_spans(system, on, f"Load {load.name!r}")
    for one, other in pairwise(on):
        here, there = system.connections.get((one.name, "b")), system.connections.get((other.name, "a"))
        if here is None or there is None or here[0] != there[0]:
            cause = f"Load {load.name!r}: {one.name!r} and {other.name!r} are not consecutive"
            raise InputError(cause, "Connect them first, and give them in order")
    if any(f.spans[0] in on or on[0] in f.spans for f in system.feeds):
        raise InputError(f"Load {load.name!r} hangs on a rope with a feed", "Use feed or hang on one rope, not both")
    check.number(at, f"Load {load.name!r}", "at", "m")
    length = math.fsum(s.length for s in on)
    if not 0.0 <= at <= length:
        raise InputError(
            f"Load {load.name!r} hangs at {at} m, outside {on[0].name}"
            + (f" ... {on[-1].name}" if len(on) > 1 else "")
            + f", whose unstretched length is {length:.6g} m",
            f"Choose at between 0 and {length:.6g} m",
        )
    if load.name in system.load_names or load.name in system.components:
        raise InputError(f"The name {load.name!r} is taken", "Give each load its own name")
    system.hung.append(Hung(load, on, float(at)))


def feed(
    system: Declarations, on: tuple[Span, ...], *, spacing: float, masses: float | Sequence[float], drag_area: float
) -> None:
    """Fills a rope with loads at a spacing [m, unstretched]. Raises InputError."""
    require_spans(system, on, "feed")
    check.positive(spacing, "feed", "spacing", "m")
    check.count(math.fsum(span.length for span in on) / spacing, "feed", "loads", MOST_LOADS)
    values = tuple(masses) if isinstance(masses, Sequence) else (masses,)
    if not values:
        raise InputError("feed has no masses", "Give one number or a sequence of numbers")
    for value in values:
        check.not_negative(value, "feed", "mass", "kg")
    check.not_negative(drag_area, "feed", "drag_area", "m2")
    if not any(values):
        raise InputError("feed has no load with a mass", "0 is a missing load; give other masses as well")
    if any(h.spans[0] in on for h in system.hung) or any(f.spans[0] in on for f in system.feeds):
        raise InputError("This rope carries loads already", "Use feed or hang on one rope, not both")
    system.feeds.append(Feed(on, float(spacing), tuple(float(v) for v in values), drag_area=float(drag_area)))


def require_spans(system: Declarations, spans: tuple[Span, ...], owner: str) -> None:
    """Raises InputError where there is no span, or one is not part of the system."""
    if not spans:
        raise InputError(f"{owner} has no span", "Give the spans of its rope")
    for span in spans:
        if system.components.get(span.name) is not span:
            raise InputError(f"Span {span.name!r} is not part of system {system.name!r}", "Add it first")
