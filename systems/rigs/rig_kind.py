"""Differences between the kinds of skyline rigs. Rigs and studies call the kind; they never compare kinds."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ropeway.components.carriage import Carriage
from ropeway.components.errors import InputError
from ropeway.components.guyed_spar import GuyedSpar
from ropeway.systems.modelling.system import System
from ropeway.systems.rigs import carriage_guess
from ropeway.systems.rigs.rig_parts import RigParts
from ropeway.systems.rigs.rope_paths import from_yarder, string_running_skyline, string_skyline


@dataclass(frozen=True)
class RigKind(ABC):
    """A kind of skyline rig: the rope that supports the carriage, the quantity that the yarder sets, and the carriage's
    hold."""

    name: ClassVar[str]
    """One word, as in "standing skyline"."""
    carrying_rope: ClassVar[str] = "skyline"
    """Loggers' name of the rope that supports the carriage. Its role in the model is "skyline" in every kind."""
    haulback_role: ClassVar[str] = "haulback"
    """Role in the model of the rope that pulls the carriage out."""
    keeps_length: ClassVar[bool] = True
    """Whether the carrying rope has a given length; otherwise its drum keeps a tension."""
    sets_height: ClassVar[bool] = True
    """Whether the yarder can lower and raise the carriage at a station."""
    drum_variable: ClassVar[str] = "travel"
    """Variable of the carrying rope's drum that sets this height."""
    has_clamp: ClassVar[bool] = True
    """Whether a clamp can hold the carriage on the carrying rope where the mainline would have to push."""
    runs_out_by_gravity: ClassVar[bool] = False
    """Whether the empty carriage runs out by gravity alone."""

    @abstractmethod
    def skyline_drum(self, rig: RigParts) -> str:
        """Name of the drum of the carrying rope."""

    @abstractmethod
    def string(self, system: System, rig: RigParts, carriage: Carriage, span: int, on: int | None) -> None:
        """Strings the carrying rope with the carriage in a span, or `on` a support."""

    @property
    def yarder_ropes(self) -> tuple[str, ...]:
        """Carrying ropes that run through a block at the headspar's top to a drum."""
        return (self.carrying_rope,)

    def tail_ropes(self, rig: RigParts) -> tuple[str, ...]:
        """Ropes that run through a block at the tailspar's top."""
        return () if rig.tailspar.tailhold is None else (self.carrying_rope,)

    def guess(
        self, rig: RigParts, span: int, station: float, payload: float, height: float | None
    ) -> carriage_guess.Start:
        """Initial guess of the carriage: on the ellipse of its span, or at a given `height` z [m]."""
        load, weight, ends = _weights(rig, span, payload)
        if height is not None:
            return carriage_guess.at_height(ends, station, weight, load, height)
        strain = rig.skyline.strain
        return carriage_guess.ellipse(rig.points, span, station, weight, strain, rig.length or 0.0, load)

    def require_parts(self, rig: RigParts) -> None:  # noqa: B027 most kinds can have all parts
        """Raises InputError for parts that do not belong to this kind of rig."""


@dataclass(frozen=True)
class Standing(RigKind):
    """Both ends of the skyline are fixed."""

    name = "standing"
    sets_height = False

    def skyline_drum(self, rig: RigParts) -> str:
        return ""

    def string(self, system: System, rig: RigParts, carriage: Carriage, span: int, on: int | None) -> None:
        string_skyline(system, rig, carriage, [rig.headspar], span, on)

    @property
    def yarder_ropes(self) -> tuple[str, ...]:
        return ()


@dataclass(frozen=True)
class Live(RigKind):
    """The skyline is on a drum of the yarder."""

    name = "live"

    def skyline_drum(self, rig: RigParts) -> str:
        return "skyline" if isinstance(rig.headspar, GuyedSpar) else rig.headspar.name

    def string(self, system: System, rig: RigParts, carriage: Carriage, span: int, on: int | None) -> None:
        head: Sequence[Any] = from_yarder(rig, "skyline", self.skyline_drum(rig))
        string_skyline(system, rig, carriage, head, span, on)


@dataclass(frozen=True)
class Gravity(Live):
    """A live skyline without a haulback (shotgun)."""

    name = "gravity"
    runs_out_by_gravity = True


@dataclass(frozen=True)
class Running(RigKind):
    """The haulback carries the carriage, at the tension that its drum keeps."""

    name = "running"
    carrying_rope = "haulback"
    haulback_role = "skyline"
    keeps_length = False
    drum_variable = "tension"
    has_clamp = False

    def skyline_drum(self, rig: RigParts) -> str:
        return "haulback"

    def string(self, system: System, rig: RigParts, carriage: Carriage, span: int, on: int | None) -> None:
        string_running_skyline(system, rig, carriage)

    def tail_ropes(self, rig: RigParts) -> tuple[str, ...]:
        return (self.carrying_rope,)

    def guess(
        self, rig: RigParts, span: int, station: float, payload: float, height: float | None
    ) -> carriage_guess.Start:
        load, weight, ends = _weights(rig, span, payload)
        return carriage_guess.running(ends, station, weight, load, rig.tension or 0.0, height)

    def require_parts(self, rig: RigParts) -> None:
        hold = rig.tailspar.tailhold
        if hold is not None:
            raise InputError(f"{rig.name} has no skyline for {hold.described}", "Remove the tailhold")


STANDING, LIVE, GRAVITY, RUNNING = Standing(), Live(), Gravity(), Running()


def _weights(rig: RigParts, span: int, payload: float) -> tuple[float, float, np.ndarray]:
    """Weight of carriage and payload [N], of the carrying rope [N/m], and the ends of a span (2, 3) [m]."""
    load = (rig.carriage.mass + payload) * rig.gravity
    return load, rig.skyline.mass_per_length * rig.gravity, rig.points[span : span + 2]
