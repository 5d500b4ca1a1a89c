"""Compiled libraries and objects, kept for the next time: in the user's cache folder, or the one that ROPEWAY_CACHE
names.

A library's name is a hash of its sources or of what determines them, the compiler with its version and flags, and the
processor. It is moved into
place when it is complete, with a digest of its content in its name, which is checked before it is loaded: another
process that compiles the same, or a file that was cut off, does no harm.
"""

from __future__ import annotations

import ctypes
import os
import platform
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import suppress
from functools import lru_cache
from hashlib import sha256
from pathlib import Path
from typing import NamedTuple

from ropeway.components.errors import CompilerError, Interrupted, WriteError
from ropeway.systems.interrupts import WAIT, stop_if_interrupted
from ropeway.systems.native import compiler


def cache_folder() -> Path:
    """Where compiled libraries are kept."""
    own = os.environ.get("ROPEWAY_CACHE")
    if own:
        return Path(own)
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA", Path.home() / "AppData/Local")) / "ropeway" / "cache"
    if sys.platform == "darwin":
        return Path.home() / "Library/Caches/ropeway"
    return Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "ropeway"


class CacheInfo(NamedTuple):
    """A cache: its folder, the number of libraries in it, and their size [bytes]."""

    folder: Path
    libraries: int
    size: int


def cache_info() -> CacheInfo:
    """The libraries that are kept."""
    files = _libraries()
    return CacheInfo(cache_folder(), len(files), sum(file.stat().st_size for file in files))


def clear_cache() -> int:
    """Removes all libraries that are kept; returns how many. Raises WriteError."""
    files = _libraries()
    try:
        for file in files:
            file.unlink(missing_ok=True)
    except OSError as error:
        raise _not_writable(error) from error
    return len(files)


def _libraries() -> list[Path]:
    folder = cache_folder()
    suffixes = (compiler.suffix(compiler.host()), OBJECT)
    return sorted(path for path in folder.glob("ropeway-*") if path.suffix in suffixes) if folder.is_dir() else []


def library(files: Mapping[str, str]) -> ctypes.CDLL:
    """The shared library of C files, by name, compiled where it is not kept yet. Raises CompilerError, WriteError,
    Interrupted."""
    return named_library(repr(tuple(sorted(files.items()))), lambda: files)


def named_library(mark: str, files: Callable[[], Mapping[str, str]]) -> ctypes.CDLL:
    """As `library`, of files that `mark` determines: they are made only where the library is not kept yet."""
    name, folder = sha256(repr((mark, _compiler_mark())).encode()).hexdigest()[:32], cache_folder()
    try:
        return _loaded(name, str(folder))
    except _NotKeptError:
        _built(dict(files()), folder, name)
    try:
        return _loaded(name, str(folder))
    except _NotKeptError:
        raise CompilerError(
            f"The library that was just compiled is no longer in {folder}",
            "Call it again, while nothing empties the cache",
        ) from None


class _NotKeptError(Exception):
    """A library is not in the cache."""


def libraries(files: Sequence[Mapping[str, str]]) -> list[ctypes.CDLL]:
    """As `library`, for several sets of files, compiled side by side."""
    if len(files) < 2:
        return [library(each) for each in files]
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        running = [pool.submit(library, each) for each in files]
        try:
            while wait(running, WAIT).not_done:
                stop_if_interrupted()
        except Interrupted:
            pool.shutdown(cancel_futures=True)
            raise
    return [one.result() for one in running]


@lru_cache(maxsize=1024)
def _loaded(name: str, folder: str) -> ctypes.CDLL:
    path = _kept(Path(folder), name)
    if path is None:
        raise _NotKeptError
    try:
        return ctypes.CDLL(str(path))
    except OSError as error:
        raise CompilerError(
            f"The compiled library {path} cannot be loaded: {error}", "Empty the cache: ropeway cache clear"
        ) from error


def _digest(content: bytes) -> str:
    return sha256(content).hexdigest()[:16]


def _kept(folder: Path, name: str) -> Path | None:
    """A library of a name with all that was written."""
    for path in folder.glob(f"ropeway-{name}-*"):
        with suppress(OSError):
            if path.stem.endswith(f"-{_digest(path.read_bytes())}"):
                return path
    return None


def _built(files: dict[str, str], kept: Path, name: str) -> None:
    """Compiles files to a library. Raises CompilerError, WriteError, Interrupted."""
    with tempfile.TemporaryDirectory(prefix="ropeway-") as folder:
        for own, text in files.items():
            (Path(folder) / own).write_text(text)
        made = Path(folder) / f"library{compiler.suffix(compiler.host())}"
        compiler.compile_library(Path(folder), [n for n in files if n.endswith(".c")], compiler.host(), made)
        content = made.read_bytes()
    _put(kept, name, content, compiler.suffix(compiler.host()))


def read_object(name: str) -> bytes | None:
    """The content of a compiled object that is kept, by the hash of what it is made from."""
    path = _kept(cache_folder(), name)
    return None if path is None else path.read_bytes()


def keep_object(name: str, content: bytes) -> None:
    """Keeps a compiled object. Raises WriteError."""
    _put(cache_folder(), name, content, OBJECT)


OBJECT = ".o"
"""Suffix of compiled objects."""


def _put(kept: Path, name: str, content: bytes, suffix: str) -> None:
    """Writes a file of the cache. Raises WriteError."""
    path = kept / f"ropeway-{name}-{_digest(content)}{suffix}"
    try:
        kept.mkdir(parents=True, exist_ok=True)
        number, part = tempfile.mkstemp(dir=kept, prefix=".part-")
        try:
            with os.fdopen(number, "wb") as file:
                file.write(content)
            Path(part).chmod(0o755)
            try:
                Path(part).replace(path)
            except PermissionError:
                if _kept(kept, name) is None:  # else another process has made it, and Windows keeps what is in use
                    raise
        finally:
            Path(part).unlink(missing_ok=True)
    except OSError as error:
        raise _not_writable(error) from error


def _not_writable(error: OSError) -> WriteError:
    return WriteError(
        f"The cache of compiled libraries, {cache_folder()}, cannot be written: {error.strerror or error}",
        "Name another folder by the environment variable ROPEWAY_CACHE",
    )


def _compiler_mark() -> str:
    """The compiler and its version, flags, and the processor. Raises CompilerError."""
    return repr((*version_of(tuple(compiler.command(compiler.host()))), os.environ.get("CFLAGS", ""), processor()))


@lru_cache(maxsize=8)
def version_of(command: tuple[str, ...]) -> tuple[str, ...]:
    """A compiler's command, flags and version. Raises CompilerError."""
    try:
        with tempfile.TemporaryDirectory(prefix="ropeway-") as folder:  # some leave a file where they run
            said = subprocess.run(
                [*command, "--version"], cwd=folder, capture_output=True, text=True, check=False, timeout=60.0
            )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise CompilerError(
            f"The compiler cannot be started: {error}", "Correct the environment variable CC, or unset it"
        ) from error
    return (*command, *compiler.FLAGS, said.stdout)


@lru_cache(maxsize=1)
def processor() -> str:
    """What tells this processor from others."""
    parts = [platform.system(), platform.machine(), platform.processor()]
    with suppress(OSError):
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        parts += sorted({line for line in lines if line.startswith(("model name", "flags", "Features"))})
    return "\n".join(parts)
