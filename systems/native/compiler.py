"""A C compiler for shared libraries: `cc` if available, else the one of the ziglang package.

ziglang also compiles for the other platforms. The environment variables CC and CFLAGS select the compiler for this
platform and add flags.
"""

from __future__ import annotations

import importlib.util
import os
import platform as machines
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Protocol

from ropeway.components.errors import CompilerError, InputError
from ropeway.systems.interrupts import stop_if_interrupted

_TARGETS = {
    "x86_64-linux": "x86_64-linux-gnu.2.17",
    "aarch64-linux": "aarch64-linux-gnu.2.17",
    "x86-linux": "x86-linux-gnu.2.17",
    "x86_64-windows": "x86_64-windows-gnu",
    "x86-windows": "x86-windows-gnu",
    "x86_64-macos": "x86_64-macos",
    "aarch64-macos": "aarch64-macos",
}
PLATFORMS = tuple(_TARGETS)
"""Platforms that a library can be compiled for."""


FLAGS = ("-O2", "-fno-math-errno", "-g0", "-std=c99", "-fvisibility=hidden")
"""What each file is compiled with. Nothing reads errno, and without it a square root is one instruction."""
_MACHINES = {"amd64": "x86_64", "arm64": "aarch64"}
_SYSTEMS = {"darwin": "macos", "win32": "windows"}


def host() -> str:
    """Name of this platform."""
    machine = machines.machine().lower()
    return f"{_MACHINES.get(machine, machine)}-{_SYSTEMS.get(sys.platform, sys.platform)}"


def resolved(platforms: Sequence[str]) -> tuple[str, ...]:
    """Names of platforms, with "host" replaced. Raises InputError."""
    names = dict.fromkeys(host() if name == "host" else name for name in platforms)
    for name in names:
        if name not in _TARGETS and name != host():
            raise InputError(f"Platform {name!r} is unknown", f"Choose from host, {', '.join(_TARGETS)}")
    return tuple(names)


def suffix(platform: str) -> str:
    """File suffix of a shared library."""
    return ".dll" if "windows" in platform else ".dylib" if "macos" in platform else ".so"


def command(platform: str) -> list[str]:
    """Command of the compiler for a platform. Raises CompilerError if there is none."""
    own = os.environ.get("CC") or shutil.which("cc")
    if platform == host() and own:
        return shlex.split(own)
    if importlib.util.find_spec("ziglang") is None:
        raise CompilerError(f"No C compiler for {platform}", 'Install one: pip install "ropeway[fmu]"')
    return [sys.executable, "-m", "ziglang", "cc", "-target", _TARGETS[platform]]


class KeptObjects(Protocol):
    """Objects that were compiled before."""

    def take(self, objects: Mapping[str, str]) -> list[str]:
        """Puts those that are kept in place, by source; returns the sources of the others."""

    def keep(self, objects: Mapping[str, str], sources: Iterable[str]) -> None:
        """Keeps those of some sources."""


def object_command(platform: str) -> list[str]:
    """Command of the compiler with its flags. Raises CompilerError."""
    more = shlex.split(os.environ.get("CFLAGS", "")) if platform == host() else []
    return [*command(platform), *FLAGS, "-I.", *([] if "windows" in platform else ["-fPIC"]), *more]


def compile_library(
    folder: Path, sources: Sequence[str], platform: str, library: Path, kept: KeptObjects | None = None
) -> None:
    """Compile C files in a folder to a shared library, in parallel, but objects that are kept.

    Raises CompilerError with the compiler's messages, Interrupted.
    """
    windows = "windows" in platform
    run = object_command(platform)
    linked = list(sources)
    if "ziglang" not in run:  # zig compiles its files in parallel, and keeps them
        objects = {name: f"{platform}-{name}.o" for name in sources}
        missing = linked if kept is None else kept.take(objects)
        _run([[*run, "-c", name, "-o", objects[name]] for name in missing], folder, platform)
        if kept is not None:
            kept.keep(objects, missing)
        linked = list(objects.values())
    _run([[*run, "-shared", *linked, "-o", str(library.resolve()), *([] if windows else ["-lm"])]], folder, platform)


def _run(commands: Sequence[Sequence[str]], folder: Path, platform: str) -> None:
    """Runs commands in parallel, one per processor. Raises CompilerError, Interrupted."""
    waiting, running = list(reversed(commands)), list[_Running]()
    try:
        while waiting or running:
            while waiting and len(running) < (os.cpu_count() or 1):
                running.append(_Running(waiting.pop(), folder, platform))
            stop_if_interrupted()
            for one in [one for one in running if one.ended()]:
                running.remove(one)
            time.sleep(0.005)
    finally:
        for one in running:
            one.kill()


class _Running:
    """A running compiler. Raises CompilerError."""

    def __init__(self, command: Sequence[str], folder: Path, platform: str) -> None:
        self._platform = platform
        # A file: a full pipe would block the process.
        self._messages = tempfile.TemporaryFile("w+", errors="replace")  # noqa: SIM115  # closed when the process ends
        try:
            self._process = subprocess.Popen(
                command, cwd=folder, stdout=subprocess.DEVNULL, stderr=self._messages, start_new_session=True
            )
        except OSError as error:
            self._messages.close()
            remedy = "Correct the environment variable CC, or unset it"
            raise CompilerError(f"The compiler for {platform} cannot be started: {error}", remedy) from error

    def ended(self) -> bool:
        """Whether the process ended. Raises CompilerError if it failed."""
        if self._process.poll() is None:
            return False
        with self._messages as messages:
            messages.seek(0)
            message = messages.read()
        if self._process.returncode != 0:
            raise CompilerError(
                f"Compiling for {self._platform} failed: {message.strip()[-2000:]}",
                "Read the compiler's message; export with platforms=() to obtain the sources",
            )
        return True

    def kill(self) -> None:
        """Ends the process and its child processes."""
        with suppress(ProcessLookupError):
            if os.name == "posix":
                os.killpg(self._process.pid, signal.SIGKILL)
            else:
                self._process.kill()
        self._process.wait()
        self._messages.close()
