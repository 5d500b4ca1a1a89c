"""Declarations of a system: its components, their connections, and the loads on its ropes."""

from __future__ import annotations

from dataclasses import dataclass

from ropeway.components.component import Component
from ropeway.components.environment import Environment
from ropeway.components.ground import Ground
from ropeway.components.load import Load
from ropeway.components.map_frame import MapFrame
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
