"""The text of a project file: JSON that people read and edit, with the line of every value for error messages."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

from ropeway.components.errors import InputError

Json: TypeAlias = Any
"""What JSON holds: None, truth values, numbers, texts, lists, and dictionaries of these."""
Keys: TypeAlias = tuple[str | int, ...]
"""Where a value stands: names of fields and places in lists."""

_WIDTH = 110
_TOKEN = re.compile(r'"(?:[^"\\]|\\.)*"|[\[\]{}:,]|[^\s\[\]{}:,"]+')


@dataclass(frozen=True)
class ProjectText:
    """A file that has been read: its name in errors, its text without comments, and what that holds."""

    source: str
    text: str
    data: Json

    def error(self, keys: Keys, cause: str, remedy: str) -> InputError:
        """An error with file, line and field of a value."""
        field = ".".join(str(key) for key in keys)
        place = f"{self.source}, line {line_of(self.text, keys)}" + (f", {field}" if field else "")
        return InputError(f"{place}: {cause}", remedy)


def parsed(source: str, text: str) -> ProjectText:
    """A text in JSON; lines that begin with // are comments. Raises InputError with the line of what is no JSON."""
    plain = "\n".join("" if line.lstrip().startswith("//") else line for line in text.split("\n"))

    def pairs(found: list[tuple[str, Json]]) -> dict[str, Json]:
        names = [name for name, _ in found]
        for name in names:
            if names.count(name) > 1:
                raise InputError(f"{source}: {name!r} is given twice in one object", "Remove one of them")
        return dict(found)

    def constant(word: str) -> Json:
        raise InputError(f"{source}: {word} is no number of JSON", f'Write it in quotes, as "{float(word)}"')

    try:
        return ProjectText(source, plain, json.loads(plain, object_pairs_hook=pairs, parse_constant=constant))
    except json.JSONDecodeError as error:
        raise InputError(
            f"{source}, line {error.lineno}, column {error.colno}: {error.msg}",
            "Correct the text there, or the line before it: a comma or a quotation mark may be missing",
        ) from error
    except RecursionError as error:
        raise InputError(f"{source} is nested too deeply", "It is no project file") from error


def read_text(path: str | Path) -> str:
    """The text of a file. Raises InputError."""
    try:
        return Path(path).read_text(encoding="utf-8-sig")
    except FileNotFoundError as error:
        raise InputError(f"There is no file {path}", "Check the path") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{path} is no text in UTF-8", "Is it a project file?") from error
    except (OSError, ValueError) as error:
        reason = "it is a folder" if Path(path).is_dir() else getattr(error, "strerror", None) or str(error)
        raise InputError(f"{path} cannot be read: {reason}", "Check its path and who may read it") from error


def written(value: Json, indent: int = 0) -> str:
    """The text of a value: what fits on one line stands on one."""
    line = json.dumps(value, ensure_ascii=False, allow_nan=False)
    if len(line) + indent <= _WIDTH or not value or not isinstance(value, (list, dict)):
        return line
    pad = " " * (indent + 2)
    if isinstance(value, dict):
        inner = [f"{json.dumps(k, ensure_ascii=False)}: {written(v, indent + 2)}" for k, v in value.items()]
        return "{\n" + ",\n".join(pad + text for text in inner) + "\n" + " " * indent + "}"
    if all(isinstance(v, (int, float, str)) for v in value):
        return "[\n" + "\n".join(pad + text for text in _filled(value, indent + 2)) + "\n" + " " * indent + "]"
    return "[\n" + ",\n".join(pad + written(v, indent + 2) for v in value) + "\n" + " " * indent + "]"


def _filled(values: Sequence[Json], indent: int) -> Iterator[str]:
    """Scalars on as few lines as they need."""
    line = ""
    for k, value in enumerate(values):
        text = json.dumps(value, ensure_ascii=False, allow_nan=False) + ("," if k < len(values) - 1 else "")
        if line and len(line) + len(text) + 1 + indent > _WIDTH:
            yield line
            line = text
        else:
            line = f"{line} {text}" if line else text
    yield line


def line_of(text: str, keys: Keys) -> int:
    """The line of a value in a JSON text, from 1; of a field that is not there that of the object around it."""
    tokens = [(match[0], match.start()) for match in _TOKEN.finditer(text)]
    at = 0
    for key in keys:
        found = next((i for name, i in _members(tokens, at) if name == key), None)
        if found is None:
            break
        at = found
    return text.count("\n", 0, tokens[at][1]) + 1 if tokens else 1


def _members(tokens: Sequence[tuple[str, int]], at: int) -> Iterator[tuple[str | int, int]]:
    """Name or place, and the first token of the value, of each member of the object or list that starts at a token."""
    opening = tokens[at][0]
    if opening not in "[{":
        return
    depth, count, i = 0, 0, at
    fresh = True
    while i < len(tokens):
        token = tokens[i][0]
        if fresh and depth == 1 and token not in "]}":
            if opening == "{":
                yield json.loads(token), i + 2
                i += 2
                token = tokens[i][0]
            else:
                yield count, i
            count, fresh = count + 1, False
        if token in ("[", "{"):
            depth += 1
            fresh = fresh or depth == 1
        elif token in ("]", "}"):
            depth -= 1
            if depth == 0:
                return
        elif token == "," and depth == 1:
            fresh = True
        i += 1
