"""What is fitted: a system at rest, a rig at stations, or a run, each as a source of states with derivatives."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence

import numpy as np

from ropeway.systems.studies.sensitivity.linearisation import LinearState
from ropeway.systems.studies.sensitivity.reading import Reading


class States(ABC):
    """The states of a measured table, prepared for a fit."""

    @abstractmethod
    def predict(self, values: Mapping[str, float]) -> list[LinearState]:
        """All states for values of the free quantities, with derivatives by these. Raises EquilibriumError,
        SimulationError, InputError for a value that a quantity cannot have."""

    @abstractmethod
    def reading(self, state: int, name: str) -> Reading:
        """A measured quantity in a state. Raises UnknownNameError."""

    @abstractmethod
    def points(self, state: int, span: str, at: np.ndarray) -> Reading:
        """Heights of a span's rope at places (n, 2) [m] in plan; NaN for a y that is not known. Raises
        UnknownNameError."""

    @abstractmethod
    def candidates(self, state: int) -> Sequence[str]:
        """Quantities of a state that could be measured."""

    @abstractmethod
    def label(self, state: int) -> str:
        """A state in words, for messages."""


class Source(ABC):
    """A system or rig by the names of its quantities."""

    name: str

    @abstractmethod
    def role(self, name: str) -> str:
        """GIVEN for a quantity that is known in each row, MEASURED for a result. Raises UnknownNameError."""

    @abstractmethod
    def unit(self, name: str) -> str:
        """SI unit of a quantity. Raises UnknownNameError."""

    @abstractmethod
    def declared(self, name: str) -> float:
        """Declared value of a quantity that can be free. Raises UnknownNameError, InputError."""

    @abstractmethod
    def states(self, free: Sequence[str], given: Sequence[str], values: np.ndarray, time: np.ndarray | None) -> States:
        """The states of given values (states, givens), or of a series at times (states,) [s]. Raises InputError."""
