"""What a system declares: its components, how they are joined, and the loads on its ropes."""

from __future__ import annotations

from dataclasses import dataclass

from ropeway.components.component import Component
from ropeway.components.ground import Ground
from ropeway.components.load import Load
from ropeway.components.map_frame import MapFrame
from ropeway.components.span import Span


@dataclass(frozen=True)
class Hung:
    """A load on consecutive spans: `at` [m, unstretched] from the first span's end a. On a single span it
    is pinned at that distance until the line moves; on several it has its place on the rope."""

    load: Load
    spans: tuple[Span, ...]
    at: float


@dataclass(frozen=True)
class Feed:
    """Loads that come in at a run's first support, every `spacing` metres of unstretched rope, with `masses`
    [kg] used in order and repeated; they are taken off at its last support. On an endless rope there are
    `around` loads, and they go round."""

    spans: tuple[Span, ...]
    spacing: float
    masses: tuple[float, ...]
    around: int | None = None
    prefix: str = ""


class Declarations:
    """What `System` holds. `connections`: the seat of each rope end; `supplies`: the power unit of each drive; `links`:
    the source of each driven input; `precedences`: who acts first among the control sheaves of each subsystem, ""
    being those of the system itself. `ground`: what lies under it, `map_frame`: where its axes lie on a map; None where
    that is unknown."""

    def __init__(self, name: str, gravity: float, precedence: str) -> None:
        self.name = name
        self.gravity = gravity
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
