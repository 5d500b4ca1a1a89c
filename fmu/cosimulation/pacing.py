"""Pacing of a run by the clock."""

from __future__ import annotations

import time

from ropeway.systems.interrupts import WAIT, stop_if_interrupted


class Pace:
    """Holds a run back to `factor` seconds of simulated time for each second of the clock; None: it is not held back.

    `late`: largest time by which the run was behind the clock [s].
    """

    def __init__(self, factor: float | None, start: float) -> None:
        self._factor, self._start, self._begin = factor, start, time.monotonic()
        self.late = 0.0

    def wait(self, reached: float) -> None:
        """Waits until the clock has reached a simulated time. Raises Interrupted."""
        if self._factor is None:
            return
        due = self._begin + (reached - self._start) / self._factor
        while (left := due - time.monotonic()) > 0.0:
            stop_if_interrupted()
            time.sleep(min(left, WAIT))
        self.late = max(self.late, -left)
