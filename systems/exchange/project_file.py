"""Project files: what a user has built, in readable JSON; and archives, which hold tables besides."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any

import pandas as pd

from ropeway.components.errors import InputError, RopewayError
from ropeway.components.rope import Rope
from ropeway.components.schedule import Schedule
from ropeway.components.whole_files import whole
from ropeway.systems.exchange import project_rig, project_system, result_kinds, study_inputs
from ropeway.systems.exchange.project_classes import CLASSES
from ropeway.systems.exchange.project_text import Json, Keys, ProjectText, parsed, read_text, written
from ropeway.systems.exchange.project_values import Decoder, Encoder, FileKind

VERSION = 1
"""Version of the schema that this library writes."""

MIGRATIONS: dict[int, Callable[[dict[str, Json]], dict[str, Json]]] = {}
"""For each older version what makes the content of a file one of the next version."""

_CONTENT = "content.json"
_DATE = (1980, 1, 1, 0, 0, 0)
"""Of all files in an archive, so that equal contents are equal bytes."""


def _read_schedule(decoder: Decoder, data: Mapping[str, Json], keys: Keys) -> Schedule:
    names = tuple(f.name for f in fields(Schedule))
    decoder.require_fields(data, keys, ("kind", *names), names)
    schedule: Schedule = decoder.made(Schedule, keys, {name: data[name] for name in names})
    return schedule


def _write_schedule(encoder: Encoder, schedule: Schedule) -> dict[str, Json]:
    return {"times": list(schedule.times), "speeds": list(schedule.speeds)}


KINDS = (
    *project_system.KINDS,
    *project_rig.KINDS,
    FileKind("schedule", Schedule, _write_schedule, _read_schedule),
    study_inputs.KIND,
    *result_kinds.KINDS,
)
"""What has a form of its own in files."""


def save_file(value: Any, path: str | Path, classes: Mapping[str, type]) -> Path:
    """Writes a value as JSON, or as an archive where it has tables. Raises InputError, WriteError."""
    encoder = Encoder(KINDS, {**CLASSES, **classes})
    content = encoder.part(value) if type(value) is Rope else encoder.value(value, type(value).__name__)
    of = {name: v for name, v in content.items() if name in ("kind", "type")} if isinstance(content, dict) else {}
    if not of:
        raise InputError(f"A {type(value).__name__} cannot be saved", "Save a system, a rig, a schedule or a result")
    ropes = {"ropes": encoder.table_of_ropes()} if encoder.ropes else {}
    text = written({"ropeway": VERSION, **of, **ropes, **content}) + "\n"
    with whole(path) as file:
        file.write_bytes(_archive(text, encoder.frames) if encoder.frames else text.encode())
    return Path(path)


def load_file(path: str | Path, classes: Mapping[str, type], components: Sequence[type]) -> Any:
    """What a file holds. Raises InputError with file, line and field."""
    frames: Mapping[str, pd.DataFrame] = {}
    if _is_archive(path):
        content, frames = _unpacked(path)
        text = parsed(f"{path}, {_CONTENT}", content)
    else:
        text = parsed(str(path), read_text(path))
    data = _migrated(text)
    own = {f"{cls.__module__}:{cls.__qualname__}": cls for cls in components}
    decoder = Decoder(text, KINDS, {**CLASSES, **classes}, own, Path(path).parent, frames=frames)
    decoder.table_of_ropes(data.get("ropes", {}))
    inner = {name: value for name, value in data.items() if name not in ("ropeway", "ropes")}
    try:
        return decoder.part(inner, ()) if "type" in inner else decoder.thing(inner, ())
    except RopewayError:
        raise
    except (TypeError, KeyError, IndexError, AttributeError, ValueError) as error:
        raise InputError(f"{path} is damaged: {type(error).__name__} {error}", "Compare it with a saved one") from error


def _migrated(text: ProjectText) -> dict[str, Json]:
    """The content of a file in the form of the present version. Raises InputError for a newer one."""
    data = text.data
    version = data.get("ropeway") if isinstance(data, dict) else None
    if not isinstance(version, int) or isinstance(version, bool) or version < 1:
        raise text.error(
            ("ropeway",), "this is no project file of ropeway", f'It begins with {{"ropeway": {VERSION}, ...}}'
        )
    if version > VERSION:
        raise text.error(
            ("ropeway",),
            f"the file is of version {version}, this ropeway reads versions up to {VERSION}",
            "Install a newer ropeway: pip install --upgrade ropeway",
        )
    while version < VERSION:
        data = {**MIGRATIONS[version](data), "ropeway": version + 1}
        version += 1
    return dict(data)


def _archive(text: str, frames: Mapping[str, pd.DataFrame]) -> bytes:
    """A zip file with the content and each table as Parquet."""
    _require_parquet()
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        members: list[tuple[str, bytes]] = [(_CONTENT, text.encode())]
        for name, frame in frames.items():
            table = io.BytesIO()
            frame.to_parquet(table)
            members.append((name, table.getvalue()))
        for name, data in members:
            archive.writestr(zipfile.ZipInfo(name, _DATE), data, zipfile.ZIP_DEFLATED)
    return packed.getvalue()


def _is_archive(path: str | Path) -> bool:
    try:
        with open(path, "rb") as file:
            return file.read(4) == b"PK\x03\x04"
    except (OSError, ValueError):
        return False


def _unpacked(path: str | Path) -> tuple[str, dict[str, pd.DataFrame]]:
    """Content and tables of an archive. Raises InputError."""
    _require_parquet()
    try:
        with zipfile.ZipFile(path) as archive:
            names = archive.namelist()
            if _CONTENT not in names:
                raise InputError(f"{path} has no {_CONTENT}", "It is no archive of ropeway")
            tables = {n: pd.read_parquet(io.BytesIO(archive.read(n))) for n in names if n.endswith(".parquet")}
            return archive.read(_CONTENT).decode(), tables
    except (zipfile.BadZipFile, OSError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"{path} is damaged: {error}", "Save it again") from error


def _require_parquet() -> None:
    try:
        import pyarrow  # noqa: F401
    except ImportError as error:
        raise InputError("Archives of results need pyarrow", "pip install ropeway[parquet]") from error
