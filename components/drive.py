"""Drives of control sheaves: ideal, or a hydraulic motor with its limits.

Chapters 4 to 6 of Turk's thesis (1988) treat hydraulically driven intermediate supports. Only their headings are
available: the equations here are our own, from the textbook relations of a hydrostatic drive.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, ClassVar, NamedTuple

from ropeway.components.argument_checks import checked
from ropeway.components.variable import Energies, Limit, Variable

STANDSTILL = 0.01
"""Width of the smooth transition between driving and braking [m/s]."""


class DriveMotion(NamedTuple):
    """Effect of a drive on its sheave.

    Parameters
    ----------
    speed : float or symbol
        Speed of the rope [m/s].
    force : float or symbol
        Force on the rope [N].
    rates : mapping of str, optional
        Time derivatives of the drive's states.
    outputs : mapping of str, optional
        Outputs of the drive.

    Examples
    --------
    >>> rw.DriveMotion(speed=1.0, force=2e3, outputs={"power": 2e3}).outputs["power"]
    2000.0
    """

    speed: Any
    force: Any
    rates: Mapping[str, Any] = MappingProxyType({})
    outputs: Mapping[str, Any] = MappingProxyType({})


@dataclass(frozen=True, slots=True)
class Drive(ABC):
    """Base class of drives. A drive of your own is a frozen dataclass that inherits from this one.

    Its equations read `v`: its own variables; `tension_in`, `tension_out` and `bearing_load` of the sheave [N], the
    input `speed` [m/s], the `correction` of the response [m/s], `brake` (1: applied); and, with a power unit, the
    shares `flow_share` and `power_share`.

    Examples
    --------
    >>> issubclass(rw.HydraulicDrive, rw.Drive)
    True
    """

    rope_speed: ClassVar[str] = "speed"
    """Variable of the sheave with the actual or the commanded rope speed."""
    shares: ClassVar[tuple[str, ...]] = ()
    """Outputs of a power unit that it uses."""

    @abstractmethod
    def motion(self, v: Any) -> DriveMotion:
        """Motion of the rope, on symbols.

        Parameters
        ----------
        v : object
            Variables of the drive and its sheave, as attributes.

        Returns
        -------
        DriveMotion
            Rope speed, force on the rope, rates and outputs of the drive.
        """

    def variables(self, force: float, speed: float) -> tuple[Variable, ...]:
        """Variables that the drive adds to its sheave.

        Parameters
        ----------
        force : float
            Typical tension, for nominals [N].
        speed : float
            Rope speed at the start [m/s].

        Returns
        -------
        tuple of Variable
            By default none.
        """
        return ()

    def limits(self) -> tuple[Limit, ...]:
        """Outputs that must stay within bounds.

        Returns
        -------
        tuple of Limit
            Each is reported as an event when its output leaves the bounds.
        """
        return ()

    def demand(self, v: Any) -> Mapping[str, Any]:
        """Demand on a power unit, on symbols.

        Parameters
        ----------
        v : object
            Variables of the drive and its sheave, as attributes.

        Returns
        -------
        mapping of str
            `flow` [m3/s] and `power` [W]; by default none.
        """
        return {}

    def energies(self, read: Callable[[str], Any]) -> Energies:
        """Kinetic energy and losses over a run; see `Component.energies`.

        Parameters
        ----------
        read : callable
            `read(name)` returns a variable of the sheave over time.

        Returns
        -------
        Energies
            Arrays over the records of the run.
        """
        return Energies()


@checked
@dataclass(frozen=True, slots=True)
class IdealDrive(Drive):
    """Turns its sheave at the commanded speed, whatever the force.

    Examples
    --------
    >>> rw.ControlSheave("c1", at=(180.0, 14.0)).drive
    IdealDrive()
    """

    def motion(self, v: Any) -> DriveMotion:
        return DriveMotion((v.speed + v.correction) * (1 - v.brake), v.tension_in - v.tension_out)
