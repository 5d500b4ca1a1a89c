"""An FMU in a process of its own: whatever it does there, the session goes on."""

from __future__ import annotations

import json
import os
import pickle
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import weakref
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from multiprocessing.spawn import get_executable
from typing import Any, NoReturn

import numpy as np

from ropeway.components.errors import InputError
from ropeway.fmu.errors import FmuError, FmuImportError, FmuRunError, FmuVariableError
from ropeway.fmu.importing.fmu_file import Fmu
from ropeway.fmu.importing.instance import KEPT, require_kind
from ropeway.fmu.importing.interface import FmuInterface
from ropeway.fmu.importing.slave_messages import SHARED, Ahead, Answer, decoded, framed, received
from ropeway.fmu.importing.variable_types import Value
from ropeway.systems.interrupts import WAIT, stop_if_interrupted

_ERRORS = {error.__name__: error for error in (FmuImportError, FmuRunError, FmuVariableError, InputError)}
_EXCEPTIONS = {
    0xC0000005: " (access violation)",
    0xC0000006: " (page that cannot be read)",
    0xC00000FD: " (stack overflow)",
    0xC0000409: " (abort)",
}
"""Exceptions of Windows that end a process (NTSTATUS)."""
_STARTING = 60.0
"""Longest time for the start of the process, before it loads the FMU [s]."""
_ENDING = 5.0
"""Longest time for the end of a process after its last answer [s]."""
_WINDOWS = os.name == "nt"
_OWN_GROUP = getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0)
_MAIN = "import json, sys; sys.path[:] = json.loads(sys.argv.pop()); from {0} import main; main()"


class IsolatedSlave:
    """An FMU in a process of its own; `OpenFmu` describes its methods.

    A crash, an exit or a call beyond `fmu.timeout` is a FmuRunError, and the process is ended. Raises FmuImportError.
    """

    def __init__(self, fmu: Fmu, name: str, kind: str, tolerance: float) -> None:
        require_kind(fmu, kind)
        self._fmu, self._name = fmu, name
        self.time = 0.0
        self.ended: str | None = None
        self._ahead = Ahead()
        self.log: list[str] = []
        folder = tempfile.mkdtemp(prefix="ropeway-")
        try:
            fmu.unpack(folder)
            self._process, self._socket = _started(folder)
        except BaseException:
            shutil.rmtree(folder, ignore_errors=True)
            raise
        self._ended = weakref.finalize(self, _end, self._process, self._socket, folder)
        try:
            self._receive("start", _STARTING)
            interface = FmuInterface(*(getattr(fmu, f.name) for f in fields(FmuInterface)))
            can = self._call("open", interface, name, kind, tolerance)
        except FmuRunError as error:
            self._ended()
            raise FmuImportError(f"{fmu.path.name} cannot be instantiated: {error.cause}", error.remedy) from error
        except BaseException:
            self._ended()
            raise
        self.can_restore, self.can_interpolate, self.varies_steps = can

    def enter(self, start: float, values: Mapping[str, object], stop: float | None = None) -> None:
        self._call("enter", start, self._fmu.values(values), stop)

    def leave(self) -> None:
        self._call("leave")

    def set(self, values: Mapping[str, object]) -> None:
        if values:
            self._call("set", values)

    def read(self, names: Sequence[str]) -> list[Value]:
        found: list[Value] = self._call("read", names) if names else []
        return found

    def get(self, names: Sequence[str]) -> np.ndarray:
        if not names:
            return np.empty(0)
        found = self._ahead.values if self._ahead.names == tuple(names) else None
        values = np.array(self._call("get", names) if found is None else found)
        if values.shape != (len(names),):
            raise self._unreadable("get")
        return values

    def derivatives(self, outputs: Sequence[str], inputs: Mapping[str, float]) -> np.ndarray:
        return np.array(self._call("derivatives", outputs, inputs), dtype=float)

    def step(self, size: float, start: Mapping[str, float], end: Mapping[str, float]) -> None:
        found = self._call("step", size, start, end)
        self._ahead.values = found if isinstance(found, np.ndarray) and len(found) else None

    def save(self) -> Any:
        return self._call("save")

    def restore(self, state: Any) -> None:
        self._call("restore", state)

    def forget(self, state: Any) -> None:
        if self._ended.alive:
            self._call("forget", state)

    def close(self) -> None:
        """Ends the process, after a regular end of the FMU if it can."""
        if not self._ended.alive:
            return
        try:
            self._call("close", allowed=_ENDING)
            self._process.wait(_ENDING)
        except (FmuError, subprocess.TimeoutExpired):
            pass
        finally:
            self._ended()

    def _call(self, method: str, *arguments: Any, allowed: float | None = None) -> Any:
        """Calls a method in the process. Raises FmuError, InputError, Interrupted."""
        if not self._ended.alive:
            raise self._error("has no process any more", "Open it again")
        self._ahead.note(method, arguments)
        limit = self._fmu.timeout if allowed is None else allowed
        try:
            self._send(framed(pickle.dumps((method, arguments), pickle.HIGHEST_PROTOCOL)), method, limit)
            answer = self._receive(method, limit)
        except BaseException:  # also a Ctrl-C: its answer would be taken for that of the next call
            self._ended()
            raise
        self.time, self.ended = answer.time, answer.ended
        if answer.log:
            self.log += answer.log
            del self.log[: -2 * KEPT]
        if answer.error is not None:
            raise self._passed_on(method, answer.error)
        return answer.value

    def _passed_on(self, method: str, attributes: dict[str, Any]) -> FmuError | InputError:
        """An error that the process has sent."""
        try:
            return _ERRORS[attributes["type"]](**{n: v for n, v in attributes.items() if n != "type"})
        except (TypeError, KeyError):
            return self._unreadable(method)

    def _unreadable(self, method: str) -> FmuRunError:
        cause = f"sent an answer to the call {method!r} that cannot be read"
        return self._error(cause, "Its FMU may have damaged the memory of its process")

    def _send(self, message: bytes, what: str, limit: float | None) -> None:
        left = message
        try:
            while left:
                left = left[self._waited(self._socket.send, left, what, limit) :]
        except ConnectionError:
            self._lost(what)

    def _receive(self, what: str, limit: float | None) -> Answer:
        try:
            message = received(lambda size: self._waited(self._socket.recv, size, what, limit))
        except ConnectionError:
            message = None
        if message is None:
            self._lost(what)
        try:
            return decoded(message)
        except (ValueError, KeyError, TypeError) as error:
            raise self._unreadable(what) from error

    def _waited(self, action: Callable[[Any], Any], argument: Any, what: str, limit: float | None) -> Any:
        """The result of an action on the socket, which gives up after `WAIT`. Raises FmuRunError, Interrupted."""
        begin: float | None = None
        while True:
            try:
                return action(argument)
            except TimeoutError:
                stop_if_interrupted()
                begin = time.monotonic() - WAIT if begin is None else begin
                if limit is not None and time.monotonic() - begin >= limit:
                    cause = f"did not answer the call {what!r} within {limit:g} s: its process was ended"
                    raise self._error(cause, "The FMU hangs, or needs a longer timeout") from None

    def _lost(self, what: str) -> NoReturn:
        """Raises FmuRunError: the process has ended by itself."""
        try:
            code = self._process.wait(_ENDING)
        except subprocess.TimeoutExpired:
            code = 0
        raise self._error(
            f"ended its process {_how(code)} in the call {what!r}", "The fault is in the FMU: report it to its maker"
        )

    def _error(self, what: str, remedy: str) -> FmuRunError:
        tail = f". Its log: {' | '.join(self.log[-3:])}" if self.log else ""
        cause = f"{self._name!r} ({self._fmu.path.name}) {what} at t = {self.time:.9g} s{tail}"
        return FmuRunError(cause, remedy, time=self.time, fatal=True)


def _how(code: int) -> str:
    """How a process has ended, by its exit code: negative after a signal, large after an exception of Windows."""
    if code < 0:
        return f"by signal {-code} ({signal.strsignal(-code)})"
    return f"by exit({code})" if code < 1 << 31 else f"by exception 0x{code:08X}{_EXCEPTIONS.get(code, '')}"


def _started(folder: str) -> tuple[subprocess.Popen[bytes], socket.socket]:
    """A process for the FMU in a folder, and the socket to it.

    Its standard input is a lifeline: it ends with the session. Ctrl-C in a terminal does not reach it. Windows passes
    on no open files: the socket is shared with the process by its number, through the standard input.
    """
    ours, theirs = socket.socketpair()
    name = SHARED if _WINDOWS else str(theirs.fileno())
    main = _MAIN.format("ropeway.fmu.importing.slave_process")
    command = [get_executable(), "-c", main, name, folder, json.dumps(sys.path)]
    process = None
    alone: dict[str, Any] = {"creationflags": _OWN_GROUP} if _WINDOWS else {"start_new_session": True}
    try:
        process = subprocess.Popen(
            command, stdin=subprocess.PIPE, pass_fds=() if _WINDOWS else (theirs.fileno(),), **alone
        )
        if _WINDOWS and process.stdin is not None:
            process.stdin.write(framed(theirs.share(process.pid)))  # type: ignore[attr-defined,unused-ignore]
            process.stdin.flush()
    except BaseException:
        ours.close()
        if process is not None:
            process.kill()
        raise
    finally:
        theirs.close()
    ours.settimeout(WAIT)
    return process, ours


def _end(process: subprocess.Popen[bytes], connection: socket.socket, folder: str) -> None:
    """Nothing of a slave is left: process, socket, folder."""
    connection.close()
    process.kill()
    if process.stdin is not None:
        process.stdin.close()
    process.wait()
    shutil.rmtree(folder, ignore_errors=True)
