"""Communication steps as long as an error allows."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal, get_args

import numpy as np

from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.errors import InputError
from ropeway.fmu.cosimulation.coupling import Coupling
from ropeway.fmu.errors import FmuRunError

Method = Literal["Richardson", "coupling error"]


@checked
@dataclass(frozen=True)
class StepControl:
    """How a master chooses the time between two communication points, between `least` and `most` [s].

    method: "Richardson" takes each step whole and as two halves, which differ by the error of the outputs; "coupling
    error" takes for the error by how much inputs at the end of a step differ from those that the slaves were given:
    less work, but it sees the inputs only. tolerance: relative to a variable or its nominal, whichever is larger.
    A step with a larger error, in which a Boolean or other discrete connection changes, or that a slave refuses, is
    repeated shorter, down to `least`. Slaves must be able to go back in time; with "coupling error" those that cannot
    take the next step shorter instead. Raises InputError.
    """

    method: Method
    tolerance: float = 1e-4
    least: float = 1e-4
    most: float = 10.0

    def __post_init__(self) -> None:
        for name in ("tolerance", "least", "most"):
            check.positive(getattr(self, name), "StepControl", name)
        if self.method not in get_args(Method):
            raise InputError(f"method is {self.method!r}", f"Choose from {', '.join(map(repr, get_args(Method)))}")
        if self.least > self.most:
            raise InputError(f"least is {self.least:g} s, most {self.most:g} s", "Exchange them")


@dataclass
class Stepper:
    """Takes steps under a control. `size` is the next one [s]; `repeated` counts steps taken again, `inexact` holds the
    ends of those that missed the tolerance though they were the least."""

    coupling: Coupling
    control: StepControl
    size: float
    repeated: int = 0
    inexact: list[float] = field(default_factory=list)

    def __post_init__(self) -> None:
        if self.control.method == "Richardson" and not self.coupling.can_restore:
            raise InputError(
                "Steps cannot be repeated: there is a slave that cannot go back in time",
                'Use StepControl("coupling error"), or add the slave with kind="ModelExchange"',
            )
        self.size = min(max(self.size, self.control.least), self.control.most)

    def step(self, time: float, until: float) -> float:
        """One step from a time towards the end, shorter where an FMU ends the run; returns the time reached. Raises
        FmuRunError."""
        left = until - time
        size = left if left <= 1.001 * self.size else min(self.size, 0.5 * left)  # no sliver at the end
        if not self.coupling.can_restore:
            self.coupling.step(size)
            error = self._missed()
            self._adapt(size, error, 2.0)
            return self._reached(until, error)
        limit = 2.0
        with self.coupling.saved() as back:
            while True:
                self.coupling.held.switched = False
                try:
                    error = self._halves(size, back) if self.control.method == "Richardson" else self._whole(size)
                except FmuRunError as refusal:
                    if refusal.fatal or size <= self.control.least:
                        raise
                    error = math.inf
                if self.coupling.held.switched and size > self.control.least:
                    error = math.inf  # a switch acts at the end of a step: a shorter step is nearer to its time
                self._adapt(size, error, limit)
                if error <= 1.0 or size <= self.control.least:
                    return self._reached(until, error)
                back()
                self.repeated += 1
                size, limit = self.size, 1.0

    def _reached(self, until: float, error: float) -> float:
        reached = self.coupling.time
        if abs(until - reached) <= 1e-9 * self.size:
            reached = self.coupling.time = until
        if error > 1.0:
            self.inexact.append(reached)
        return reached

    def _adapt(self, size: float, error: float, limit: float) -> None:
        order = self.coupling.scheme.order + (self.control.method == "Richardson")
        factor = 0.9 * max(error, 1e-9) ** (-1.0 / order)
        self.size = min(max(size * min(max(factor, 0.2), limit), self.control.least), self.control.most)

    def _whole(self, size: float) -> float:
        self.coupling.step(size)
        return self._missed()

    def _missed(self) -> float:
        return self._relative(self.coupling.missed, self.coupling.values, self.coupling.input_nominals)

    def _halves(self, size: float, back: Callable[[], None]) -> float:
        coupling = self.coupling
        coupling.step(size)
        whole = coupling.outputs()
        back()
        for half in (0.5 * size, 0.5 * size):
            if coupling.ended is None:
                coupling.step(half)
        halves = coupling.outputs()
        return self._relative(np.abs(whole - halves), halves, coupling.nominals) / (2**coupling.scheme.order - 1)

    def _relative(self, miss: np.ndarray, values: np.ndarray, nominals: np.ndarray) -> float:
        if not len(miss):
            return 0.0
        error = float(np.max(miss / (self.control.tolerance * np.maximum(nominals, np.abs(values)))))
        return error if math.isfinite(error) else math.inf
