"""Columns of a load path as readings of a solved rig, which have derivatives."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ropeway.components.errors import UnknownNameError
from ropeway.components.guyed_spar import GuyedSpar
from ropeway.systems.modelling.dae_model import nearest
from ropeway.systems.studies.sensitivity.reading import Reading
from ropeway.systems.studies.skyline.carriage_model import Solved
from ropeway.systems.studies.skyline.rope_tensions import guyline_ends
from ropeway.systems.studies.skyline.station_row import UNITS

_LINES = ("mainline", "haulback")


def rig_reading(solved: Solved, name: str) -> Reading:
    """The reading of a column of a load path, or of a dotted quantity of the rig's model. Raises UnknownNameError for
    one that has no derivative."""
    column = rig_columns(solved).get(name)
    if column is not None:
        return column()
    at = solved.at
    tables = at.model.tables.values()
    if "." in name and any(name in table.index for table in tables):
        return Reading((name,))
    known = [*rig_columns(solved), *at.model.y.names, *at.model.z.names]
    raise UnknownNameError(f"{at.rig.name!r} has no reading {name!r} with derivatives", nearest(name, known))


def unit_of_reading(solved: Solved, name: str) -> str:
    """Unit of a reading. Raises UnknownNameError."""
    reading = rig_reading(solved, name)
    if "." in name:
        kind, k = solved.slot(reading.names[0])
        return solved.at.model.tables[kind].units[k]
    return UNITS.get(name, "N")


def rig_columns(solved: Solved) -> dict[str, Callable[[], Reading]]:
    """The columns that a rig has, each as a function that makes its reading."""
    rig, run = solved.at.rig, solved.at.model.runs[solved.at.skyline]
    carriage, spans, nodes = rig.carriage.name, run.spans, [node.name for node in run.nodes]
    ends = [f"{span.name}.tension_{end}" for span in spans for end in "ab"]
    first = nodes.index(rig.headspar.name) if rig.headspar.name in nodes else 0
    last = nodes.index(rig.tailspar.name) - 1
    found: dict[str, Callable[[], Reading]] = {
        **{f"carriage_{axis}": _single(f"{carriage}.{axis}") for axis in "xyz"},
        "skyline_tension": lambda: _highest(solved, [f"{carriage}.tension_a", f"{carriage}.tension_b"]),
        "highest_tension": lambda: _highest(solved, ends),
        "headspar_tension": _single(ends[2 * first]),
        "tailspar_tension": _single(ends[2 * last + 1]),
        "anchor_tension": _single(ends[-1]),
        "sag": lambda: _sag(solved, share=False),
        "deflection": lambda: _sag(solved, share=True),
        **{f"{support.name}_force": _single(f"{support.name}.support_force") for support in rig.supports},
    }
    if solved.held_by == "holding":
        found["mainline_pull"] = _single(f"{carriage}.holding")
    for line in _LINES:
        runs = [r for r, role in zip(solved.at.model.runs, solved.at.roles, strict=True) if role == line]
        if not runs:
            if line == "mainline" and solved.held_by == "clamp":
                found |= dict.fromkeys(("mainline_pull", "mainline_tension", "mainline_highest"), _slack(carriage))
            continue
        own = [f"{span.name}.tension_{end}" for span in runs[0].spans for end in "ab"]
        found[f"{line}_pull"] = _single(f"{carriage}.{line}_pull")
        found[f"{line}_tension"] = _single(f"{line}.rope_tension")
        found[f"{line}_highest"] = lambda own=own: _highest(solved, own)  # type: ignore[misc]
    for spar, prefix in ((rig.headspar, "spar"), (rig.tailspar, "tailspar")):
        if isinstance(spar, GuyedSpar):
            found[f"{prefix}_compression"] = _single(f"{spar.name}.compression")
            found[f"{prefix}_lean"] = _single(f"{spar.name}.lean")
            for guy in spar.guylines:
                ends = guyline_ends(guy.name, spar)
                found[f"{guy.name}_tension"] = lambda ends=ends: _highest(solved, ends)  # type: ignore[misc]
    return found


def _single(name: str) -> Callable[[], Reading]:
    return lambda: Reading((name,))


def _slack(carriage: str) -> Callable[[], Reading]:
    """A rope that does not pull."""
    return lambda: Reading((f"{carriage}.z",), lambda values: 0.0 * values)


def _highest(solved: Solved, names: list[str]) -> Reading:
    """The highest of some values."""
    return Reading((max(names, key=solved.__getitem__),))


def _sag(solved: Solved, *, share: bool) -> Reading:
    """The sag of the carriage below the chord of its span [m], or its share of the span [%]."""
    rig, name = solved.at.rig, solved.at.rig.carriage.name
    k = solved.at.span if solved.at.on is None else rig.span_of(solved[f"{name}.x"])
    stands = [stand.name for stand in rig.stands[k : k + 2]]
    placed = all(_has(solved, f"{stand}.z") for stand in stands)
    fixed = np.array([rig.stands[k + i].at for i in (0, 1)])

    def sag(values: np.ndarray) -> np.ndarray:
        x, z = values[:2]
        (xa, ya, za), (xb, yb, zb) = values[2:].reshape(2, 3) if placed else fixed
        below = za + (zb - za) * (x - xa) / (xb - xa) - z
        if share:
            below = 100.0 * below / np.sqrt((xb - xa) ** 2 + (yb - ya) ** 2)
        return np.array([below])

    more = [f"{stand}.{axis}" for stand in stands for axis in "xyz"] if placed else []
    return Reading((f"{name}.x", f"{name}.z", *more), sag)


def _has(solved: Solved, name: str) -> bool:
    return any(name in table.index for table in solved.at.model.tables.values())
