"""The way of isolation on Windows, as far as it can be tried elsewhere.

Windows passes no open files to a process: a socket is shared by data on the standard input. Here a socket is handed
over through a local one under a path, which those data name.
"""

import os
import socket
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from ropeway.fmu import FmuImportError, Slave, load
from ropeway.fmu.importing import isolated_slave

FROM_SHARE = """
import socket, threading, time
start = threading.Thread.start
def first(self):  # a thread that is started runs before the one that started it goes on
    start(self)
    time.sleep(0.2)
threading.Thread.start = first
def fromshare(data):
    with socket.socket(socket.AF_UNIX) as other:
        other.connect(data.decode())
        return socket.socket(fileno=socket.recv_fds(other, 1, 1)[1][0])
socket.fromshare = fromshare
"""


class Shared(socket.socket):
    """A socket with the method of Windows."""

    folder: Path

    def share(self, process: int) -> bytes:
        """Data by which a process gets a copy."""
        path = self.folder / f"{process}.socket"
        own, waiting = os.dup(self.fileno()), socket.socket(socket.AF_UNIX)
        waiting.bind(str(path))
        waiting.listen(1)

        def hand_over() -> None:
            with waiting, waiting.accept()[0] as other:
                socket.send_fds(other, [b"."], [own])
                os.close(own)

        threading.Thread(target=hand_over, daemon=True).start()
        return str(path).encode()


@pytest.fixture
def windows(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[list[dict[str, Any]]]:
    """Isolated slaves start as on Windows; the arguments of their processes."""
    (tmp_path / "sitecustomize.py").write_text(FROM_SHARE)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    monkeypatch.setattr(isolated_slave, "_WINDOWS", True)
    monkeypatch.setattr(isolated_slave, "_OWN_GROUP", 0x200)
    asked: list[dict[str, Any]] = []
    start = subprocess.Popen

    def pair() -> tuple[socket.socket, socket.socket]:
        with socket.socket() as waiting:  # as Windows makes it
            waiting.bind(("127.0.0.1", 0))
            waiting.listen(1)
            ours = socket.create_connection(waiting.getsockname())
            theirs = waiting.accept()[0]
        return ours, Shared(fileno=theirs.detach())

    def started(command: list[str], **how: Any) -> Any:
        asked.append(how)
        return start(command, **{**how, "creationflags": 0})

    monkeypatch.setattr(isolated_slave.socket, "socketpair", pair)
    monkeypatch.setattr(isolated_slave.subprocess, "Popen", started)
    with tempfile.TemporaryDirectory() as short:  # paths of sockets are limited
        monkeypatch.setattr(Shared, "folder", Path(short), raising=False)
        yield asked


def test_a_slave_runs_and_ends(windows: list[dict[str, Any]], hostile: Path) -> None:
    fmu = load(hostile, isolated=True, timeout=20.0)
    for _ in range(3):  # the process may not read more of its input than the socket's data
        with Slave(fmu) as slave:
            slave.enter(0.0, {"u1": 2.0})
            slave.leave()
            slave.step(0.5, {"u1": 2.0}, {"u1": 2.0})
            assert slave.get(["y1", "t"]).tolist() == [2.0, 0.5]
            process = slave._slave._process  # type: ignore[union-attr]
        assert process.returncode is not None
    assert [how["creationflags"] for how in windows] == [0x200] * 3
    assert all(how["pass_fds"] == () and "start_new_session" not in how for how in windows)


def test_a_process_that_dies(windows: list[dict[str, Any]], hostile: Path) -> None:
    with pytest.raises(FmuImportError, match="ended its process by"):
        Slave(load(hostile, isolated=True), "segfault")


@pytest.mark.parametrize(
    ("code", "words"),
    [
        (3, "by exit(3)"),
        (0xC0000005, "by exception 0xC0000005 (access violation)"),
        (0xC00000FD, "by exception 0xC00000FD (stack overflow)"),
        (0xC0000135, "by exception 0xC0000135"),
    ],
)
def test_codes_are_named(code: int, words: str) -> None:
    assert isolated_slave._how(code) == words


def test_modules_load_without_what_only_unix_has() -> None:
    """`resource`, `fcntl`, `pwd` and the like are missing, and signals but those of Windows."""
    script = """
import signal, sys
for name in ("resource", "fcntl", "pwd", "grp", "termios"):
    sys.modules[name] = None
for name in ("SIGKILL", "SIGALRM", "SIGHUP", "SIGBUS", "SIGUSR1"):
    delattr(signal, name)
import os
for name in ("fork", "killpg", "setsid", "getuid"):
    delattr(os, name)
import ropeway as rw
import ropeway.fmu.importing.isolated_slave, ropeway.fmu.importing.slave_process, ropeway.fmu.importing.local_slave
import ropeway.systems.studies.sweeps.journal, ropeway.systems.native.compiler
rw.fmu.CoSimulation(1.0)
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
