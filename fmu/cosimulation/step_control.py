"""Communication steps controlled by an error estimate."""

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
    """Control of the communication step of a master.

    A step is repeated with a smaller size if its error is too large, if a discrete connection changes within it, or if
    a slave rejects it. Slaves must be able to restore their state. With "coupling error" slaves that cannot take a
    smaller next step instead.

    Parameters
    ----------
    method : {"Richardson", "coupling error"}
        "Richardson" takes each step as a whole and as two halves, whose difference estimates the error of the outputs.
        "coupling error" takes the difference of the inputs at the end of a step from the values used: it costs less,
        and covers the inputs only.
    tolerance : float, default 1e-4
        Relative to a variable or its nominal, whichever is larger.
    least : float, default 1e-4
        Smallest step [s].
    most : float, default 10
        Largest step [s].

    Raises
    ------
    InputError
        An unknown method, a value that is not positive, or a smallest step above the largest.

    Examples
    --------
    >>> rw.fmu.StepControl("Richardson", tolerance=1e-5).most
    10.0
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
    """Takes controlled steps.

    `size`: the next step [s]; `repeated`: number of repeated steps; `inexact`: ends of smallest steps that missed the
    tolerance.
    """

    coupling: Coupling
    control: StepControl
    size: float
    repeated: int = 0
    inexact: list[float] = field(default_factory=list)

    def __post_init__(self) -> None:
        if self.control.method == "Richardson" and not self.coupling.can_restore:
            raise InputError(
                "Steps cannot be repeated: a slave cannot restore its state",
                'Use StepControl("coupling error"), or add the slave with kind="ModelExchange"',
            )
        self.size = min(max(self.size, self.control.least), self.control.most)

    def step(self, time: float, until: float) -> float:
        """One step from a time towards the end; returns the time reached.

        It is shorter where an FMU ends the run. Raises FmuRunError.
        """
        left = until - time
        size = left if left <= 1.001 * self.size else min(self.size, 0.5 * left)  # avoids a tiny last step
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
                    error = math.inf  # a switch takes effect at the end of a step: a shorter step is more accurate
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
