"""Compiled objects that many libraries share, kept in the cache of `binary_cache`.

An object's name is a hash of its source, of the headers of its folder that it includes, of the compiler's command and
version, and of the processor.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from contextlib import suppress
from hashlib import sha256
from pathlib import Path

from ropeway.components.errors import WriteError
from ropeway.systems.native import binary_cache, compiler

_INCLUDE = re.compile(r'^\s*#\s*include\s*"([^"]+)"', re.MULTILINE)


class ObjectCache:
    """Objects of the sources in a folder for a platform, except the source `own`, which serves one library only.
    Raises CompilerError."""

    def __init__(self, folder: Path, platform: str, own: str) -> None:
        self._folder, self._own = folder, own
        version = binary_cache.version_of(tuple(compiler.command(platform)))
        self._mark = repr((compiler.object_command(platform), version, binary_cache.processor()))
        self._texts: dict[str, str] = {}

    def take(self, objects: Mapping[str, str]) -> list[str]:
        """Puts the objects of sources that are kept into the folder, under their names; returns the other sources."""
        missing = []
        for source, name in objects.items():
            content = None if source == self._own else binary_cache.read_object(self._key(source))
            if content is None:
                missing.append(source)
            else:
                (self._folder / name).write_bytes(content)
        return missing

    def keep(self, objects: Mapping[str, str], sources: Iterable[str]) -> None:
        """Keeps the objects of some sources, where the cache can be written: a library can do without."""
        with suppress(WriteError):
            for source in sources:
                if source != self._own:
                    binary_cache.keep_object(self._key(source), (self._folder / objects[source]).read_bytes())

    def _key(self, source: str) -> str:
        """Name of a source's object."""
        seen, waiting = dict[str, str](), [source]
        while waiting:
            name = waiting.pop()
            if name not in seen and (self._folder / name).is_file():
                seen[name] = self._text(name)
                waiting += _INCLUDE.findall(seen[name])
        return sha256(repr((sorted(seen.items()), self._mark)).encode()).hexdigest()[:32]

    def _text(self, name: str) -> str:
        if name not in self._texts:
            self._texts[name] = (self._folder / name).read_text()
        return self._texts[name]
