"""The limits of a rig under load, and the margin of a solved state to each."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from ropeway.components.guyed_spar import GuyedSpar
from ropeway.components.intermediate_support import IntermediateSupport
from ropeway.components.node import Node
from ropeway.components.rope import Rope
from ropeway.systems.rigs.skyline_rig import SkylineRig
from ropeway.systems.studies.skyline.carriage_model import Solved
from ropeway.systems.studies.skyline.clearances import (
    front_clearance,
    least_rope_clearance,
    load_clearance,
    rope_clearance,
)
from ropeway.systems.studies.skyline.rope_tensions import (
    anchor_tension,
    break_angle,
    force_per_roller,
    guyline_tension,
    highest_tension,
    load_on,
)

LimitMargin = Callable[[Solved], float]
"""Margin of a solved state to a limit, relative to the limit (to 10 m for clearances); negative if exceeded."""

ROPE_CLEARANCE = "rope clearance"
"""The most expensive margin."""

_CLEARANCE = 10.0
"""Reference value of clearance margins [m]."""

_Named = Iterator[tuple[str, LimitMargin]]


@dataclass(frozen=True)
class LoadLimits:
    """Requested limits. `safety_factor` applies to the skyline, `other_safety_factor` to all other ropes (None: each
    rope's own). `clearance` of the load and `rope_clearance` of the skyline are heights over the ground [m]; None
    disables both. `lift_off`: the skyline must stay in its saddles, a guyed spar on its foot. `saddle_angle`: least and
    largest break angle of the skyline over its saddles [rad]. `roller_force`: largest force on each of the `rollers` at
    a support [N], one by default."""

    safety_factor: float
    other_safety_factor: float | None = None
    clearance: float | None = None
    rope_clearance: float = 0.0
    lift_off: bool = True
    saddle_angle: tuple[float, float] | None = None
    roller_force: float | None = None
    rollers: Mapping[str, int] = field(default_factory=dict)

    def working_load(self, rope: Rope) -> float:
        """Safe working load of a rope other than the skyline [N]."""
        factor = rope.safety_factor if self.other_safety_factor is None else self.other_safety_factor
        return rope.breaking_load / factor


def is_lowered(rig: SkylineRig) -> bool:
    """Whether a clearance sets the carriage's height: not for a standing skyline, and not with a log."""
    return rig.kind.sets_height and rig.turn is None


def margins_of(rig: SkylineRig, limits: LoadLimits) -> dict[str, LimitMargin]:
    """The margin of each limit by its name."""
    return dict(
        margin for subject in (_tensions, _clearances, _supports, _spars, _tailhold) for margin in subject(rig, limits)
    )


_ALIKE = 1e-9
"""Tolerance of equal margins: of symmetric guylines the first is named."""


class LeastMargin(NamedTuple):
    """The limit with the smallest margin in a state, and that margin. `margins`: of all limits by name; of the ropes'
    clearance only where it can be the smallest."""

    limit: str
    margin: float
    margins: Mapping[str, float]


class Margins:
    """The margins of a rig's solved states to its limits."""

    def __init__(self, rig: SkylineRig, limits: LoadLimits) -> None:
        self._ground, self._rope_clearance = rig.terrain, limits.rope_clearance
        self.of = margins_of(rig, limits)

    def least(self, solved: Solved) -> LeastMargin:
        """The smallest margin of a state, of alike ones the first."""
        margins = {name: margin(solved) for name, margin in self.of.items() if name != ROPE_CLEARANCE}
        least = min(margins.values())
        if ROPE_CLEARANCE in self.of and self._rope_may_limit(solved, least):
            margins[ROPE_CLEARANCE] = self.of[ROPE_CLEARANCE](solved)
            least = min(least, margins[ROPE_CLEARANCE])
        first = next(name for name, margin in margins.items() if margin <= least + _ALIKE)
        return LeastMargin(first, least, margins)

    def _rope_may_limit(self, solved: Solved, least: float) -> bool:
        """Whether the skyline's clearance can be the smallest margin."""
        if self._ground is None:
            return True
        bound = least_rope_clearance(solved, self._ground) - self._rope_clearance
        return bound / _CLEARANCE <= least + _ALIKE


def _tensions(rig: SkylineRig, limits: LoadLimits) -> _Named:
    strength = rig.skyline.breaking_load / limits.safety_factor
    yield f"{rig.kind.carrying_rope} tension", _upper(lambda s: highest_tension(s, "skyline"), strength)
    if rig.mainline is not None:
        yield (
            "mainline tension",
            _upper(lambda s: highest_tension(s, "mainline"), limits.working_load(rig.mainline)),
        )
    if rig.haulback is not None:
        yield (
            "haulback tension",
            _upper(lambda s: highest_tension(s, "haulback"), limits.working_load(rig.haulback)),
        )
    if rig.turn is not None:
        pull = f"{rig.carriage.name}.dropline_pull"
        yield "dropline tension", _upper(lambda s: s[pull], limits.working_load(rig.turn.dropline))
    block = rig.haulback_block
    if block is not None and block.capacity is not None:
        load = f"{block.name}.bearing_load"
        yield f"capacity of {block.name}", _upper(lambda s: s[load], block.capacity)


def _clearances(rig: SkylineRig, limits: LoadLimits) -> _Named:
    ground, wanted = rig.terrain, limits.clearance
    if ground is None or wanted is None or is_lowered(rig):
        return
    of_load = load_clearance if rig.turn is None else front_clearance
    yield "clearance", lambda s: (of_load(s, ground) - wanted) / _CLEARANCE
    yield ROPE_CLEARANCE, lambda s: (rope_clearance(s, ground) - limits.rope_clearance) / _CLEARANCE


def _supports(rig: SkylineRig, limits: LoadLimits) -> _Named:
    strength = rig.skyline.breaking_load / limits.safety_factor
    for support in rig.supports:
        if limits.lift_off:
            yield f"lift-off at {support.name}", _compression(f"{support.name}.support_force", strength)
        yield from _capacity(support, support.capacity)
        yield from _saddle(support, limits)


def _saddle(support: IntermediateSupport, limits: LoadLimits) -> _Named:
    name = support.name
    if limits.saddle_angle is not None:
        least, most = limits.saddle_angle
        yield f"least break angle at {name}", lambda s: (break_angle(s, support) - least) / most
        yield f"break angle at {name}", _upper(lambda s: break_angle(s, support), most)
    if limits.roller_force is not None:
        count = limits.rollers.get(name, 1)
        yield f"roller force at {name}", _upper(lambda s: force_per_roller(s, support, count), limits.roller_force)


def _spars(rig: SkylineRig, limits: LoadLimits) -> _Named:
    strength = rig.skyline.breaking_load / limits.safety_factor
    for spar in (rig.headspar, rig.tailspar):
        yield from _capacity(spar, spar.capacity)
        if not isinstance(spar, GuyedSpar):
            continue
        if limits.lift_off:
            yield f"lift-off of {spar.name}", _compression(f"{spar.name}.compression", strength)
        for guy in spar.guylines:
            yield f"guyline {guy.name}", _guyline(guy.name, spar, limits.working_load(guy.rope))


def _tailhold(rig: SkylineRig, limits: LoadLimits) -> _Named:
    hold = rig.tailspar.tailhold
    if hold is not None and hold.capacity is not None:
        yield f"capacity of {hold.name}", _upper(anchor_tension, hold.capacity)


def _upper(value: Callable[[Solved], float], limit: float) -> LimitMargin:
    """Margin of a value with an upper limit."""
    return lambda s: 1.0 - value(s) / limit


def _compression(output: str, strength: float) -> LimitMargin:
    """Margin of a force that must stay compressive, relative to the working load of the skyline."""
    return lambda s: s[output] / strength


def _capacity(stand: Node, capacity: float | None) -> _Named:
    if capacity is not None:
        yield f"capacity of {stand.name}", _upper(lambda s: load_on(s, stand), capacity)


def _guyline(name: str, spar: GuyedSpar, limit: float) -> LimitMargin:
    return _upper(lambda s: guyline_tension(s, name, spar), limit)
