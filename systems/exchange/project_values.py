"""Values of a project file: components and their parts as JSON, and back.

A dataclass is an object with its `type`, one of this library by its name, one of a user as module:class; a thing that
has a form of its own (a system, a rig, a result) is an object with its `kind`. Ropes stand in a table of their own and
are named where they are used. No file makes Python import anything: classes come from a table.
"""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import Field, dataclass, field, fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from ropeway.components.check import PartName
from ropeway.components.component import Component
from ropeway.components.errors import InputError, UnknownNameError
from ropeway.components.load import Load
from ropeway.components.rope import Rope
from ropeway.components.spar import Standing
from ropeway.systems.exchange.project_text import Json, Keys, ProjectText

_PACKAGE = "ropeway."
_NOT_FINITE = ("inf", "-inf", "nan")


@dataclass(frozen=True)
class FileKind:
    """A thing that has a form of its own in files: its name there, its class, how it is written and read."""

    name: str
    cls: type
    write: Callable[[Encoder, Any], dict[str, Json]]
    read: Callable[[Decoder, Mapping[str, Json], Keys], Any]
    is_one: Callable[[Any], bool] = lambda value: True


@dataclass
class Encoder:
    """Makes JSON of values. `ropes` are those met so far, `own` the classes of a user; `frames` the tables,
    which have files of their own in an archive."""

    kinds: Sequence[FileKind]
    classes: Mapping[str, type]
    ropes: dict[str, Rope] = field(default_factory=dict)
    own: dict[str, type] = field(default_factory=dict)
    frames: dict[str, pd.DataFrame] = field(default_factory=dict)

    def value(self, value: Any, owner: str) -> Json:
        """A value; `owner` names it in errors. Raises InputError for what a file cannot hold."""
        if value is None or isinstance(value, (bool, str)):
            return str(value) if isinstance(value, str) else value
        if isinstance(value, (float, np.floating)):
            return float(value) if math.isfinite(value) else str(float(value))
        if isinstance(value, (int, np.integer, np.bool_)):
            return value if isinstance(value, int) else value.item()
        if type(value) is Rope:
            return self.rope(value)
        kind = next((k for k in self.kinds if type(value) is k.cls and k.is_one(value)), None)
        if kind is not None:
            return {"kind": kind.name, **kind.write(self, value)}
        if isinstance(value, np.ndarray):
            return self.value(value.tolist(), owner)
        if isinstance(value, Mapping):
            if "type" in value or "kind" in value or not all(isinstance(key, str) for key in value):
                raise InputError(f"{owner}: its keys cannot be saved", 'Use texts other than "type" and "kind"')
            return {str(key): self.value(v, f"{owner}.{key}") for key, v in value.items()}
        if isinstance(value, (tuple, list)):
            return [self.value(v, owner) for v in value]
        if is_dataclass(value) and not isinstance(value, type):
            return self.part(value)
        raise InputError(
            f"{owner}: a {type(value).__name__} cannot be saved",
            "Save the rest, and add it in your script after loading",
        )

    def part(self, part: Any, leave_out: Sequence[str] = ()) -> dict[str, Json]:
        """A dataclass, without some of its fields and those that are not set."""
        name = self._type(type(part))
        found: dict[str, Json] = {"type": name}
        for f in fields(part):
            value = getattr(part, f.name)
            if f.init and f.name not in leave_out and not _follows(part, f, value):
                found[f.name] = self.value(value, f"{getattr(part, 'name', name)}.{f.name}")
        return found

    def rope(self, rope: Rope) -> str:
        """The name of a rope in the table of ropes."""
        for name, known in self.ropes.items():
            if known == rope:
                return name
        names = (rope.name if k == 1 else f"{rope.name} ({k})" for k in range(1, len(self.ropes) + 2))
        name = next(n for n in names if n not in self.ropes)
        self.ropes[name] = rope
        return name

    def table_of_ropes(self) -> dict[str, Json]:
        """The ropes met so far."""
        return {name: {n: v for n, v in self.part(rope).items() if n != "type"} for name, rope in self.ropes.items()}

    def _type(self, cls: type) -> str:
        if self.classes.get(cls.__name__) is cls:
            return cls.__name__
        if f"{cls.__module__}.".startswith(_PACKAGE) or "<" in cls.__qualname__:
            raise InputError(
                f"A {cls.__name__} cannot be saved", "Save the rest, and add it in your script after loading"
            )
        name = f"{cls.__module__}:{cls.__qualname__}"
        self.own[name] = cls
        return name


def _follows(part: Any, f: Field[Any], value: Any) -> bool:
    """Whether a field needs no place in the file: it is not set, or it follows from others."""
    if f.name == "label":
        return bool(value == part.name)
    if f.name == "at" and isinstance(part, Standing):
        return part.station is not None
    return value is None and f.default is None


@dataclass
class Decoder:
    """Makes values of JSON. `classes`: of this library by name; `own`: those that the caller supplies, by
    module:class; `folder`: of the file, from which relative paths count."""

    text: ProjectText
    kinds: Sequence[FileKind]
    classes: Mapping[str, type]
    own: Mapping[str, type]
    folder: Path = Path()
    ropes: Mapping[str, Rope] = field(default_factory=dict)
    frames: Mapping[str, pd.DataFrame] = field(default_factory=dict)

    def error(self, keys: Keys, cause: str, remedy: str) -> InputError:
        """An error with file, line and field."""
        return self.text.error(keys, cause, remedy)

    def value(self, data: Json, keys: Keys, hint: str = "") -> Any:
        """A value; `hint`: the annotation of its field. Raises InputError."""
        if isinstance(data, str):
            if re.search(r"\bRope\b", hint):
                return self.rope(data, keys)
            if data in _NOT_FINITE and not re.search(r"\bstr\b", hint):
                return float(data)
            return data
        if isinstance(data, list):
            return tuple(self.value(v, (*keys, i), hint) for i, v in enumerate(data))
        if isinstance(data, dict):
            if "kind" in data:
                return self.thing(data, keys)
            if "type" in data:
                return self.part(data, keys)
            return {name: self.value(v, (*keys, name), hint) for name, v in data.items()}
        return data

    def thing(self, data: Mapping[str, Json], keys: Keys) -> Any:
        """What has a form of its own, by its `kind`."""
        kind = next((k for k in self.kinds if k.name == data.get("kind")), None)
        if kind is None:
            cause = f"{data['kind']!r} is no kind of thing" if "kind" in data else "no kind is given"
            raise self.error((*keys, "kind"), cause, f"Kinds are {', '.join(k.name for k in self.kinds)}")
        return kind.read(self, data, keys)

    def part(self, data: Json, keys: Keys, **more: Any) -> Any:
        """A dataclass, with `more` of its fields. Raises InputError with file, line and field."""
        cls = self._class(data, keys)
        known = {f.name: str(f.type) for f in fields(cls) if f.init}
        self.require_fields(data, keys, ("type", *known))
        given = {n: self.value(v, (*keys, n), known[n]) for n, v in data.items() if n != "type"}
        return self.made(cls, keys, {**given, **more})

    def made(self, make: Callable[..., Any], keys: Keys, given: Mapping[str, Any]) -> Any:
        """What a class or function makes of arguments, an error with the line of the argument that it names."""
        if isinstance(make, type) and issubclass(make, (Component, Load)):  # of a subsystem
            given = {n: PartName(v) if n == "name" and isinstance(v, str) and "." in v else v for n, v in given.items()}
        try:
            return make(**given)
        except InputError as error:
            named = [n for n in given if re.search(rf"\b{re.escape(n)}\b", error.cause)]
            where = (*keys, max(named, key=len)) if named else keys
            raise self.error(where, error.cause, error.remedy) from error
        except TypeError as error:
            raise self.error(keys, str(error), "Correct the fields of this object") from error

    def rope(self, name: str, keys: Keys) -> Rope:
        """A rope of the file's table, or of the catalogue."""
        if name in self.ropes:
            return self.ropes[name]
        try:
            return Rope.named(name)
        except UnknownNameError as error:
            here = ", ".join(self.ropes) or "none"
            raise self.error(
                keys, f"there is no rope {name!r}", f"The file has {here}; or name one of rw.ropes()"
            ) from error

    def table_of_ropes(self, data: Json) -> None:
        """Reads the table of ropes."""
        table = self.require_object(data, ("ropes",))
        self.ropes = {
            name: self.part({"type": "Rope", **self.require_object(rope, ("ropes", name))}, ("ropes", name))
            for name, rope in table.items()
        }

    def require_object(self, data: Json, keys: Keys) -> Mapping[str, Json]:
        """An object. Raises InputError."""
        if not isinstance(data, dict):
            raise self.error(keys, "an object in braces is needed here", 'Write {"name": value, ...}')
        return data

    def require_list(self, data: Json, keys: Keys) -> Sequence[Json]:
        """A list. Raises InputError."""
        if not isinstance(data, list):
            raise self.error(keys, "a list in brackets is needed here", "Write [value, ...]")
        return data

    def require_fields(
        self, data: Mapping[str, Json], keys: Keys, known: Sequence[str], needed: Sequence[str] = ()
    ) -> None:
        """Raises InputError for a field that is not known, or missing."""
        for name in self.require_object(data, keys):
            if name not in known:
                near = difflib.get_close_matches(name, known, n=1)
                remedy = f"Is {near[0]} meant?" if near else f"It has {', '.join(known)}"
                raise self.error((*keys, name), "there is no such field", remedy)
        for name in needed:
            if name not in data:
                raise self.error(keys, f"{name} is missing", f"Give {name}")

    def _class(self, data: Json, keys: Keys) -> type:
        name = str(self.require_object(data, keys).get("type"))
        if name in self.classes:
            return self.classes[name]
        if ":" in name:
            found = self.own.get(name)
            alike = [cls for key, cls in self.own.items() if key.partition(":")[2] == name.partition(":")[2]]
            if found is not None or len(alike) == 1:
                return found or alike[0]
            module, _, cls = name.partition(":")
            raise self.error(
                (*keys, "type"),
                f"{cls} of {module} is a component of your own",
                f"Import it in your script and supply it: load(..., components=[{cls}])",
            )
        near = difflib.get_close_matches(name, list(self.classes), n=1)
        raise self.error(
            (*keys, "type"), f"there is no type {name!r}", f"Is {near[0]} meant?" if near else "Name a class of ropeway"
        )
