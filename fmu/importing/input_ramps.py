"""Inputs linear in time within a step of Co-Simulation: input derivatives (FMI 2.0), intermediate updates (3.0)."""

from __future__ import annotations

from collections.abc import Mapping
from ctypes import c_double, c_uint32
from typing import Any

from fmpy.fmi1 import FMICallException


class InputRamp:
    """Values of real inputs at intermediate times of a step (FMI 3.0)."""

    def __init__(self) -> None:
        self._refusal: FMICallException | None = None
        self._fmu: Any = None
        self._count, self._begin = 0, 0.0

    def begin(self, fmu: Any, time: float, references: Mapping[int, tuple[float, float]]) -> None:
        """Starts a ramp: the value at `time` and the rate of each reference."""
        self._fmu, self._begin, self._count = fmu, time, len(references)
        self._references = (c_uint32 * self._count)(*references)
        self._lines = list(references.values())

    def end(self) -> FMICallException | None:
        """Ends the ramp; returns the error of the first rejected value, if any."""
        self._count = 0
        refusal, self._refusal = self._refusal, None
        return refusal

    def update(self, environment: Any, time: float, wanted: bool, *_: Any) -> None:
        """FMI's callback fmi3IntermediateUpdate."""
        if not wanted or not self._count:
            return
        values = (c_double * self._count)(*(value + (time - self._begin) * rate for value, rate in self._lines))
        try:
            self._fmu.fmi3SetFloat64(self._fmu.component, self._references, self._count, values, self._count)
        except FMICallException as refusal:  # an exception cannot pass through the FMU
            self._refusal = self._refusal or refusal
