"""Skyline rigs in files: as the call that makes them, so that a value can be edited and the rest follows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from functools import partial
from typing import Any

from ropeway.components.errors import InputError
from ropeway.components.guyed_spar import GuyedSpar
from ropeway.components.terrain import Profile
from ropeway.systems.exchange.project_text import Json, Keys, ProjectText
from ropeway.systems.exchange.project_values import Decoder, Encoder, FileKind
from ropeway.systems.rigs.rig_builder import build_rig
from ropeway.systems.rigs.rig_kind import GRAVITY, LIVE, RUNNING, STANDING, RigKind
from ropeway.systems.rigs.rig_parts import RigParts
from ropeway.systems.rigs.skyline_rig import SkylineRig

_NEEDED = ("headspar", "tailspar", "carriage")
_PLAIN = ("terrain", "haulback", "haulback_tension", "haulback_block", "mainline", "turn", "name", "gravity")
_WEATHER = ("temperature", "environment")
_ROPES = ("skyline", "haulback", "mainline")
_FIELDS = ("kind", *_NEEDED, *_PLAIN, *_WEATHER, "skyline", "supports", "tension", "length", "holding")


def kind_name(kind: RigKind) -> str:
    """How a file names a kind of rig."""
    return f"{kind.name} skyline"


def _write(encoder: Encoder, rig: SkylineRig) -> dict[str, Json]:
    """A rig without what follows from the rest: the length for a tension, places of spars on the terrain."""
    running = not rig.kind.keeps_length
    found: dict[str, Any] = {"name": rig.name, "gravity": rig.gravity, "temperature": rig.temperature}
    found["haulback" if running else "skyline"] = encoder.rope(rig.skyline)
    found["length" if rig.tension is None else "tension"] = rig.length if rig.tension is None else rig.tension
    ropes = ("mainline", *(() if running else ("haulback", "haulback_tension")))
    for name in (*ropes, "haulback_block", "turn", "environment"):
        if getattr(rig, name) is not None:
            found[name] = encoder.value(getattr(rig, name), f"{rig.name}.{name}")
    for name, node in (("headspar", rig.headspar), ("tailspar", rig.tailspar)):
        found[name] = encoder.part(node, ("blocks",) if isinstance(node, GuyedSpar) else ())
    if rig.supports:
        found["supports"] = [encoder.part(support) for support in rig.supports]
    found["carriage"] = encoder.part(rig.carriage, ("holding",))
    if rig.carriage.holding is not None:
        found["holding"] = rig.carriage.holding
    if rig.terrain is not None:
        found["terrain"] = encoder.part(rig.terrain)
    decoder = Decoder(
        ProjectText(rig.name, "", found), encoder.kinds, encoder.classes, encoder.own, ropes=encoder.ropes
    )
    if differs := _difference(encoder, rig, _read(rig.kind, decoder, found, ())):
        raise InputError(
            f"{rig.name}: its {differs} does not follow from its other values",
            "Save a rig as one of the four functions makes it; give length= instead of tension= to fix a length",
        )
    return found


def _read(kind: RigKind, decoder: Decoder, data: Mapping[str, Json], keys: Keys) -> SkylineRig:
    running = not kind.keeps_length
    decoder.require_fields(data, keys, _FIELDS, (*_NEEDED, "haulback" if running else "skyline"))
    given: dict[str, Any] = {}
    for name, value in data.items():
        if name == "terrain" and isinstance(value, str):
            given[name] = decoder.made(Profile.from_csv, (*keys, name), {"path": decoder.folder / value})
        elif name != "kind":
            given[name] = decoder.value(value, (*keys, name), "Rope" if name in _ROPES else "")
    if running:
        given["skyline"] = given.pop("haulback")
    given.setdefault("terrain", None)
    given.setdefault("name", kind_name(kind))
    rig: SkylineRig = decoder.made(partial(_made, kind), keys, given)
    return rig


def _made(kind: RigKind, *, holding: Any = "bisector", **parts: Any) -> SkylineRig:
    return build_rig(kind, RigParts(**parts), holding)


def _difference(encoder: Encoder, one: SkylineRig, other: SkylineRig) -> str | None:
    """The first field in which two rigs differ."""
    for f in fields(SkylineRig):
        a, b = getattr(one, f.name), getattr(other, f.name)
        if isinstance(a, Profile) and isinstance(b, Profile):
            if encoder.part(a) != encoder.part(b):
                return f.name
        elif a != b:
            return f.name
    return None


KINDS = tuple(
    FileKind(kind_name(kind), SkylineRig, _write, partial(_read, kind), lambda rig, kind=kind: rig.kind == kind)  # type: ignore[misc]
    for kind in (STANDING, LIVE, GRAVITY, RUNNING)
)
"""The four kinds of rig in files."""
