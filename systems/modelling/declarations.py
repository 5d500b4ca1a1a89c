"""Declarations of a system: its components, their connections, the loads on its ropes, and its weather."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ropeway.components.argument_checks import checked
from ropeway.components.carriage_on_shoe import CarriageOnShoe
from ropeway.components.component import Component
from ropeway.components.environment import Environment
from ropeway.components.errors import InputError
from ropeway.components.ground import Ground
from ropeway.components.intermediate_support import IntermediateSupport
from ropeway.components.load import Load
from ropeway.components.map_frame import MapFrame
from ropeway.components.node import Node
from ropeway.components.schedule import Schedule
from ropeway.components.span import Span


@dataclass(frozen=True)
class Hung:
    """A load on consecutive spans, `at` [m, unstretched] from end a of the first span.

    On a single span it is fixed at that distance until the line moves; on several spans it is fixed to the rope.
    """

    load: Load
    spans: tuple[Span, ...]
    at: float


@dataclass(frozen=True)
class Feed:
    """Loads that enter at the first support of a run, every `spacing` metres of unstretched rope.

    `masses` [kg] are used in order and repeated; each load has the same `drag_area` [m2]. The loads are taken off at
    the last support. On an endless rope `around` loads circulate.
    """

    spans: tuple[Span, ...]
    spacing: float
    masses: tuple[float, ...]
    around: int | None = None
    prefix: str = ""
    drag_area: float = 0.0


class Declarations:
    """Content of a `System`.

    `connections`: the seat of each rope end; `supplies`: the source of each supply; `links`: the source of each
    connected input; `precedences`: precedence among the control sheaves of each subsystem, "" being those of the system
    itself; `temperature`: that at which its ropes are strung; `environment`: its weather, None where that is of no
    account; `ground`: the ground under it, `map_frame`: where its axes lie on a map, None if unknown.
    """

    def __init__(self, name: str, gravity: float, precedence: str, temperature: float) -> None:
        self.name = name
        self.gravity = gravity
        self.temperature = temperature
        self.environment: Environment | None = None
        self.precedences = {"": precedence}
        self.components: dict[str, Component] = {}
        self.connections: dict[tuple[str, str], tuple[str, str]] = {}
        self.supplies: dict[str, str] = {}
        self.links: dict[tuple[str, str], tuple[str, str]] = {}
        self.hung: list[Hung] = []
        self.feeds: list[Feed] = []
        self.origins: dict[str, str] = {}
        self.seated: set[tuple[str, str]] = set()  # the seats in `connections`
        self.ground: Ground | None = None
        self.map_frame: MapFrame | None = None

    @property
    def load_names(self) -> set[str]:
        """Names of the loads that hang where the user says."""
        return {h.load.name for h in self.hung}

    @checked
    def origin(self, name: str, text: str = "{}") -> str:
        """File and line of the user's code that added a component, in a text.

        Parameters
        ----------
        name : str
            Name of the component.
        text : str, default "{}"
            Text around file and line.

        Returns
        -------
        str
            The text; empty if there is no such code.
        """
        origin = self.origins.get(name)
        return text.format(origin) if origin else ""


_ALONG = 1e-9
"""Sine of an angle to the line below which wind does not blow across it."""


def north_of(system: Declarations) -> float:
    """Direction of the y axis, clockwise from grid north where the system has a map, else 0 [degrees]."""
    frame = system.map_frame
    return 0.0 if frame is None else (frame.azimuth - 90.0) % 360.0


def thin_ropes(system: Declarations) -> list[str]:
    """Names of ropes without a diameter."""
    ropes = {c.rope.name: c.rope.diameter for c in system.components.values() if isinstance(c, Span)}
    return [name for name, diameter in ropes.items() if diameter is None]


def require_weather(system: Declarations) -> None:
    """Raises InputError for wind or ice on a rope without a diameter, and for wind across a shoe."""
    environment = system.environment
    if environment is None:
        return
    thin = thin_ropes(system)
    if thin and environment.needs_diameter:
        raise InputError(
            f"Environment {environment.name!r} has wind or ice; rope {thin[0]!r} of {system.name!r} has no diameter",
            "Give the rope a diameter",
        )
    shoe = next((c for c in system.components.values() if _has_shoe(c)), None)
    if isinstance(shoe, Node) and blows_across(environment, north_of(system)):
        raise InputError(
            f"The wind of environment {environment.name!r} blows across {shoe.described}, whose shoe lies in the plane "
            "of the line",
            "Give the support no radius, or let the wind blow along the line",
        )


def _has_shoe(component: object) -> bool:
    if isinstance(component, CarriageOnShoe):
        return True
    return isinstance(component, IntermediateSupport) and component.radius > 0.0


def blows_across(environment: Environment, north: float) -> bool:
    """Whether there is wind with a component along y."""
    pressure, coming = environment.pressure, environment.wind_from
    strong = max(pressure.speeds) if isinstance(pressure, Schedule) else pressure
    angles = coming.speeds if isinstance(coming, Schedule) else (coming,)
    return strong > 0.0 and any(abs(math.cos(math.radians(a - north))) > _ALONG for a in angles)
