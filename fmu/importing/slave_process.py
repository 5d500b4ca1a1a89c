"""The process of an isolated slave: it runs the FMU and answers requests until its session ends."""

from __future__ import annotations

import os
import pickle
import shutil
import socket
import sys
from contextlib import suppress
from pathlib import Path
from threading import Thread
from typing import Any

from ropeway.components.errors import InputError, RopewayError
from ropeway.fmu.errors import FmuError
from ropeway.fmu.importing.interface import FmuInterface
from ropeway.fmu.importing.local_slave import LocalSlave
from ropeway.fmu.importing.slave_messages import LENGTH, SHARED, Ahead, Answer, encoded, framed, received


def main() -> None:
    """Serves the socket that the command line names, for the FMU in a folder that it names."""
    folder = Path(sys.argv[2])
    with suppress(ImportError):  # not on Windows
        import resource

        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))  # a crash is expected: no memory image
    with _connection(sys.argv[1]) as connection, suppress(ConnectionError):
        Thread(target=_end_with_session, args=(folder,), daemon=True).start()  # it reads the input from now on
        connection.sendall(framed(encoded(Answer(0.0, "ready"))))
        _Server(connection, folder).run()
    shutil.rmtree(folder, ignore_errors=True)  # the session may be gone


def _connection(name: str) -> socket.socket:
    if name == SHARED:
        size = LENGTH.unpack(_input(LENGTH.size))[0]
        return socket.fromshare(_input(size))  # type: ignore[attr-defined,no-any-return,unused-ignore]
    return socket.socket(fileno=int(name))


def _input(size: int) -> bytes:
    """So many bytes of the standard input, and not one more."""
    found = b""
    while len(found) < size and (more := os.read(0, size - len(found))):
        found += more
    return found


def _end_with_session(folder: Path) -> None:
    """Ends this process, also within a call of the FMU, when the session that started it is gone."""
    while os.read(0, 1 << 16):
        pass
    shutil.rmtree(folder, ignore_errors=True)
    os._exit(1)


class _Server:
    """Answers requests with the methods of a slave."""

    def __init__(self, connection: socket.socket, folder: Path) -> None:
        self._connection, self._folder = connection, folder
        self._slave: LocalSlave | None = None
        self._states: dict[int, Any] = {}
        self._logged, self._ahead = 0, Ahead()

    def run(self) -> None:
        """Answers until the slave is closed."""
        while (request := received(self._connection.recv)) is not None:
            method, arguments = pickle.loads(request)
            value, error = None, None
            self._ahead.note(method, arguments)
            try:
                value = (getattr(self, f"_{method}", None) or getattr(self._slave, method))(*arguments)
            except Exception as refusal:  # noqa: BLE001 - the session raises it
                error = _attributes(refusal)
            self._connection.sendall(framed(encoded(self._answer(value, error))))
            if method == "close":
                return

    def _answer(self, value: Any, error: dict[str, Any] | None) -> Answer:
        slave = self._slave
        if slave is None:
            return Answer(0.0, value, error)
        new = slave.log[max(len(slave.log) - (slave.noted - self._logged), 0) :] if slave.noted > self._logged else []
        self._logged = slave.noted
        return Answer(slave.time, value, error, tuple(new), slave.ended)

    def _open(self, fmu: FmuInterface, name: str, kind: str, tolerance: float) -> list[bool]:
        self._slave = slave = LocalSlave(fmu, name, kind, tolerance, self._folder)
        return [slave.can_restore, slave.can_interpolate, slave.varies_steps]

    def _step(self, *arguments: Any) -> Any:
        self._slave.step(*arguments)  # type: ignore[union-attr]
        with suppress(FmuError):  # the values are asked for again
            return self._slave.get(self._ahead.names)  # type: ignore[union-attr]

    def _save(self) -> int:
        key = max(self._states, default=0) + 1
        self._states[key] = self._slave.save()  # type: ignore[union-attr]
        return key

    def _restore(self, key: int) -> None:
        self._slave.restore(self._states[key])  # type: ignore[union-attr]

    def _forget(self, key: int) -> None:
        self._slave.forget(self._states.pop(key))  # type: ignore[union-attr]

    def _derivatives(self, *arguments: Any) -> list[Any]:
        return self._slave.derivatives(*arguments).tolist()  # type: ignore[union-attr]


def _attributes(error: Exception) -> dict[str, Any]:
    """What the session needs to raise an error again."""
    if not isinstance(error, RopewayError):
        return {"type": "FmuRunError", "cause": f"The FMU's process failed: {error!r}", "remedy": "", "fatal": True}
    kind = "InputError" if isinstance(error, InputError) else "FmuRunError"
    kind = type(error).__name__ if isinstance(error, FmuError) else kind
    found: dict[str, Any] = {"type": kind, "cause": error.cause, "remedy": error.remedy}
    if isinstance(error, FmuError):
        found["variable"] = error.variable
    return found | {n: getattr(error, n) for n in ("time", "fatal") if hasattr(error, n)}
