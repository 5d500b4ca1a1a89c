"""Supports of a line from a table: name, x, y, z, kind."""

from __future__ import annotations

import difflib
import math
from collections.abc import Mapping
from dataclasses import fields
from typing import Any

import numpy as np
import pandas as pd

from ropeway.components import table
from ropeway.components.drive import Drive
from ropeway.components.errors import InputError
from ropeway.components.hydraulic_drive import HydraulicDrive
from ropeway.components.identifier import identifier
from ropeway.components.map_columns import in_map_unit
from ropeway.components.map_frame import MapFrame
from ropeway.components.response import ProportionalResponse, Response, ThresholdResponse

KINDS = ("anchor", "drum", "idler", "control", "return")
"""Kinds of support of a mono-cable line. A return is the wheel where the rope reverses."""

MOST = 10_000
"""Largest number of supports of a line. A longer table is probably a terrain."""

_LAYOUT = table.TableLayout(
    {"name": None, "x": "m", "y": "m", "z": "m", "kind": None},
    "name,x,y,z,kind\nvalley,0,0,0,drum\ns1,108.3,0,11.5,idler\nmountain,204.9,0,19.6,drum",
)
_MAP_LAYOUT = table.TableLayout(
    {"name": None, "easting": "m", "northing": "m", "z": "m", "kind": None},
    "name,easting,northing,z,kind,crs\nvalley,2600100,1200200,846,drum,EPSG:2056\ns1,2600180,1200270,857.5,idler,",
)
"""Supports in map coordinates; a column crs can name their system."""
_PARTS: Mapping[str, tuple[type, ...]] = {
    "drive": (HydraulicDrive,),
    "response": (ThresholdResponse, ProportionalResponse),
}
"""Parts of a control sheave with values in a table, in columns such as drive.relief_pressure."""
_WORDS = {"true": 1.0, "yes": 1.0, "false": 0.0, "no": 0.0}


def read_supports(
    source: table.Source, *, endless: bool = False, crs: str | None = None
) -> tuple[pd.DataFrame, MapFrame | None]:
    """The checked table of supports in the order of the rope, and its map frame.

    Parameters
    ----------
    source : str, Path or DataFrame
        Columns name, x, y, z [m], kind, see `docs/files.md`; or easting and northing instead of x and y.
    endless : bool, default False
        Whether the rope is endless: it begins and ends at the first support, a control sheave.
    crs : str, optional
        Projected coordinate system of the supports; x and y are then eastings and northings, in its unit where their
        headers have none. By default the value of a column crs.

    Returns
    -------
    supports : DataFrame
        Columns name (an identifier), label (the name as given), x, y, z [m], kind, place (in the source, for errors),
        and those of drive.* and response.*, NaN for blank cells.
    map_frame : MapFrame or None
        The line's axes on the map: x runs from the first support to the one farthest from it in plan. None for a table
        in local coordinates.

    Raises
    ------
    InputError
        With file, line and column.
    """
    read = table.read(source, _LAYOUT, _MAP_LAYOUT)
    if len(read) < 2:
        raise read.error("it has 1 support", "A line has at least two")
    if len(read) > MOST:
        raise read.error(f"it has {len(read)} supports", f"A line has at most {MOST}. Is it a table of the terrain?")
    own = [key for key in read.keys if key.startswith(tuple(f"{part}." for part in _PARTS))]
    _check_fields(read, own)
    labels, kinds = read.texts("name"), [kind.casefold() for kind in read.texts("kind")]
    supports = pd.DataFrame({"name": _names(read, labels), "label": labels})
    words = [key for key in own if _holds_words(read, key)]
    held = [key for key in own if key not in words]
    on_map = read.layout is _MAP_LAYOUT
    plan = ("easting", "northing") if on_map else ("x", "y")
    supports[["x", "y", "z", *held]] = read.numbers(*plan, "z", optional=held)
    for key in words:
        supports[key] = [_WORDS.get(text.casefold(), math.nan) for text in read.texts(key)]
    supports["kind"] = kinds
    supports["place"] = [f"{read.source}, {line}" for line in read.lines]
    _check_kinds(read, labels, kinds, endless)
    for key in own:
        unused = supports.index[supports[key].notna() & (supports["kind"] != "control")]
        if len(unused):
            i = int(unused[0])
            raise read.error(f"{labels[i]!r} is not a control sheave", "Leave its cell blank", i, key)
    crs = crs or _named_crs(read) or ""
    if not (crs or on_map):
        return supports, None
    supports[["x", "y"]] = in_map_unit(read, crs, plan, "z", supports[["x", "y"]].to_numpy())
    return supports, _in_own_axes(read, supports, crs)


def _named_crs(read: table.Table) -> str | None:
    """The coordinate system in column crs, in one or more cells. Raises InputError for two different ones."""
    named = set(filter(None, read.texts("crs"))) if "crs" in read.keys else set()
    if len(named) > 1:
        raise read.error(f"its supports are in {' and in '.join(sorted(named))}", "Give all in one coordinate system")
    return next(iter(named), None)


def _in_own_axes(read: table.Table, supports: pd.DataFrame, crs: str) -> MapFrame:
    """The line's axes on the map. Transforms x and y of the supports to them. Raises InputError."""
    east, north = supports["x"].to_numpy(), supports["y"].to_numpy()
    far = int(np.argmax(np.hypot(east - east[0], north - north[0])))
    if (east[far], north[far]) == (east[0], north[0]):
        raise read.error("all its supports are at one point of the map", "Give eastings and northings")
    start, end = ((float(east[k]), float(north[k])) for k in (0, far))
    frame = MapFrame.straight(crs, start, end)
    supports["x"], supports["y"] = frame.to_local(east, north)
    return frame


def _holds_words(read: table.Table, key: str) -> bool:
    """Whether a column holds yes or no."""
    texts = [text.casefold() for text in read.texts(key) if text]
    return bool(texts) and all(text in _WORDS for text in texts)


def _names(read: table.Table, labels: list[str]) -> list[str]:
    """Identifiers of the labels. Raises InputError for a blank label and for two labels with one identifier."""
    names: dict[str, int] = {}
    for i, label in enumerate(labels):
        if not label:
            raise read.error("a support has no name", "Name each support", i, "name")
        name = identifier(label)
        if name in names:
            first = labels[names[name]]
            cause = f"{label!r} is also the name of {read.lines[names[name]]}"
            if first != label:
                cause = f"{label!r} and {first!r} ({read.lines[names[name]]}) both become the name {name!r}"
            raise read.error(cause, "Give each support a unique name", i, "name")
        names[name] = i
    return list(names)


def _check_kinds(read: table.Table, labels: list[str], kinds: list[str], endless: bool) -> None:
    """Raises InputError for an unknown kind, or a kind at an invalid position."""
    for i, kind in enumerate(kinds):
        if kind not in KINDS:
            raise read.error(f"kind of {labels[i]!r} is {read.texts('kind')[i]!r}", f"Kinds are {', '.join(KINDS)}", i)
        end = i in (0, len(kinds) - 1) and not endless
        if end != (kind in ("anchor", "drum")) or (endless and i == 0 and kind != "control"):
            remedy = "Use an anchor or a drum at both ends, an idler, a control or a return elsewhere"
            if endless:
                remedy = "Use a control at the first support, idlers, controls or returns elsewhere"
            raise read.error(f"{labels[i]!r} is {kind} at position {i + 1} of {len(kinds)}", remedy, i)


def _check_fields(read: table.Table, own: list[str]) -> None:
    """Raises InputError for a column that is not a field of any drive or response."""
    for key in own:
        part, _, field = key.partition(".")
        known = sorted({f.name for kind in _PARTS[part] for f in fields(kind)})
        if field not in known:
            near = difflib.get_close_matches(field, known, n=1)
            remedy = f"Did you mean {part}.{near[0]}?" if near else f"It has {', '.join(known)}"
            raise read.error(f"a {part} has no {field!r}", remedy, table.HEADER, key)


def own_values(part: Drive | Response | None, row: Mapping[Any, Any], prefix: str) -> dict[str, Any]:
    """Fields of a drive or response from columns `prefix.field` of its support's row; blank cells give no value. Raises
    InputError for a value that the part does not use."""
    given = {
        str(column).removeprefix(f"{prefix}."): value
        for column, value in row.items()
        if str(column).startswith(f"{prefix}.") and not math.isnan(value)
    }
    known: dict[str, Any] = {}
    if part is not None and isinstance(part, _PARTS[prefix]):
        known = {f.name: f.type for f in fields(part)}
    for field in given:
        if field not in known:
            owner = f"the {prefix} of {row['label']!r}"
            has = f"no {field}" if known else "no values of its own" if part is None else f"no {field}: it is ideal"
            raise InputError(
                f"{row['place']}, column {prefix}.{field}: {owner} has {has}",
                f"Give {prefix}= as a {' or '.join(kind.__name__ for kind in _PARTS[prefix])}, or remove the column",
            )
    return {n: bool(v) if known[n] == "bool" else float(v) for n, v in given.items()}
