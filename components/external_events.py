"""Events of a component whose equations are code from outside, such as an FMU."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np


class ExternalPoint(NamedTuple):
    """A point of a component: time [s], states, inputs, and its mode, which stands for its discrete variables."""

    time: float
    states: np.ndarray
    inputs: np.ndarray
    mode: int


class Outcome(NamedTuple):
    """What an event changes: the mode, the states; and why the component ends the run, None if it does not."""

    mode: int
    states: np.ndarray
    ended: str | None


class ExternalEvents(ABC):
    """Events of a component; `states`, `inputs` are names of its variables, `mode` is that of its discrete variable."""

    states: Sequence[str]
    inputs: Sequence[str]
    mode: str

    @abstractmethod
    def margin(self, point: ExternalPoint) -> float:
        """Distance to the next state event, in the unit of its indicator: positive before it, else not."""

    @abstractmethod
    def next_time(self, mode: int) -> float:
        """Time of the next time event in a mode [s], infinite if there is none."""

    @abstractmethod
    def update(self, point: ExternalPoint) -> Outcome:
        """The event at a point."""
