"""Messages between an isolated slave and its process, over a pair of sockets.

Requests are pickled. Answers are not, as the process runs foreign code: they are an array of numbers, or JSON.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

LENGTH = struct.Struct("<I")
"""Length of a message, before it."""
SHARED = "shared"
"""Instead of the number of a socket: the standard input begins with how Windows shares it, as a message."""
_HEAD = struct.Struct("<?d")
"""Of an answer: whether it is JSON; time of the slave."""
_BYTES = "bytes in hexadecimal"


class Answer(NamedTuple):
    """An answer at the slave's time [s].

    `value`: what the method returned; `error`: attributes of its error; `log`: new messages of the FMU; `ended`: why
    the FMU ended the run.
    """

    time: float
    value: Any = None
    error: dict[str, Any] | None = None
    log: tuple[str, ...] = ()
    ended: str | None = None


class Ahead:
    """What the first `get` after a step asks for: from then on the answer to a step has these `values` of `names`.

    Both sides note each request, so that they agree on the names.
    """

    def __init__(self) -> None:
        self.names: tuple[str, ...] = ()
        self.values: np.ndarray | None = None
        self._stepped = False

    def note(self, method: str, arguments: tuple[Any, ...]) -> None:
        """Notes a request."""
        self.values = None
        if method == "get" and self._stepped:
            self.names = tuple(arguments[0])
        self._stepped = method == "step"


def framed(message: bytes) -> bytes:
    """A message after its length."""
    return LENGTH.pack(len(message)) + message


def received(read: Callable[[int], bytes]) -> bytes | None:
    """The next message, None at the end of the stream. `read` returns at most so many bytes."""
    data = read(1 << 16)
    while data:
        if len(data) >= LENGTH.size and len(data) >= LENGTH.size + LENGTH.unpack_from(data)[0]:
            return data[LENGTH.size :]
        more = read(1 << 20)
        if not more:
            return None
        data += more
    return None


def encoded(answer: Answer) -> bytes:
    """An answer as bytes."""
    if isinstance(answer.value, np.ndarray) and not answer.log and answer.ended is None:
        return _HEAD.pack(False, answer.time) + answer.value.tobytes()
    value = answer.value.tolist() if isinstance(answer.value, np.ndarray) else answer.value
    if value is None and answer.error is None and not answer.log and answer.ended is None:
        return _HEAD.pack(False, answer.time)
    if isinstance(value, list):
        value = [{_BYTES: v.hex()} if isinstance(v, bytes) else v for v in value]
    text = json.dumps({"value": value, "error": answer.error, "log": answer.log, "ended": answer.ended})
    return _HEAD.pack(True, answer.time) + text.encode()


def decoded(message: bytes) -> Answer:
    """An answer from bytes. Raises ValueError."""
    if len(message) < _HEAD.size:
        raise ValueError("the message is too short")
    is_json, time = _HEAD.unpack_from(message)
    if not is_json:
        return Answer(time, np.frombuffer(message, offset=_HEAD.size))
    found = json.loads(message[_HEAD.size :])
    value = found["value"]
    if isinstance(value, list):
        value = [bytes.fromhex(v[_BYTES]) if isinstance(v, dict) else v for v in value]
    return Answer(time, value, found["error"], tuple(found["log"]), found["ended"])
