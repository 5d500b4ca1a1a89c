"""The largest payload at one station: bracket and root of the smallest margin over the payload."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import brentq

from ropeway.components.errors import EquilibriumError, OutOfReachError
from ropeway.systems.rigs.skyline_rig import RigKind, SkylineRig
from ropeway.systems.studies.skyline.carriage_model import Solved
from ropeway.systems.studies.skyline.certified_states import certified
from ropeway.systems.studies.skyline.load_path import carriage_height, least_rope_clearance, rope_clearance, row
from ropeway.systems.studies.skyline.root_selection import Effort
from ropeway.systems.studies.skyline.station_solver import Stations

StationRow = dict[str, Any]
LimitMargin = Callable[[StationRow, Solved], float]
"""How far a solved station stays from a limit, in parts of it; negative beyond it."""

MOST = 1e7
"""A payload [kg] that no limit stops is reported as this."""

NO_EQUILIBRIUM = "no equilibrium"
"""What limits a payload where there is nothing else to say."""

ROPE_CLEARANCE = "rope clearance"
"""The margin that costs most: found only where it can be the smallest."""

_ALIKE = 1e-9
"""Margins that differ by less are one: of guylines that stand alike the first is named."""

_ZERO = 1e-10
"""A margin so small is none: the search ends there, without a try to close its bracket."""

_EXACT = 1e-7
"""A margin that is continuous ends within this of zero."""

_GAPS = (0.2, 0.5, 1.0, 2.0, 4.0, 0.05, 5e-3, 5e-4)
"""Depths below the chord [m] at which an empty carriage is tried first."""
_LOWEST = 1e-6
"""How exactly the lowest height of an empty carriage is found, in parts of the gap below the chord."""

_RAISED = tuple(0.05 * 2.0**k for k in range(12))
"""Heights [m] by which a carriage is raised for the skyline to clear the ground."""

_FIRST = 1000.0
"""The first payload tried [kg]: the same at each station, so that no answer depends on another."""


class Tried(NamedTuple):
    """A payload tried: the smallest margin, -1 where there is no equilibrium, its name, and the solved station."""

    margin: float
    limit: str
    solved: Solved | None


class PayloadSearch:
    """The largest payload at each station by itself. clearance: to which the yarder lowers the skyline [m]."""

    def __init__(
        self,
        rig: SkylineRig,
        margins: dict[str, LimitMargin],
        clearance: float | None,
        of_rope: float,
        *,
        strict: bool = False,
    ) -> None:
        self.rig, self.margins, self.clearance, self.of_rope, self.strict = rig, margins, clearance, of_rope, strict
        self.solver = Stations(rig, by_height=clearance is not None)

    def at(self, station: float) -> StationRow:
        """The row of a station. Where the state that is found fails its certificate, each one that is tried is
        certified: beyond the last that holds there is no equilibrium."""
        try:
            return self._found(station)
        except EquilibriumError:
            return PayloadSearch(self.rig, self.margins, self.clearance, self.of_rope, strict=True)._found(station)

    def _found(self, station: float) -> StationRow:
        if self.clearance is None:
            return self._row(station, *self._largest(station, None))
        height = carriage_height(self.rig, station, self.clearance)
        mass, best = self._largest(station, height)
        if (mass, best.limit) == (0.0, NO_EQUILIBRIUM):
            height, lowest = self._lowest(station, height)
            mass, best = lowest._largest(station, height)
        if self._rope_clearance(best) < self.of_rope - 1e-6:
            mass, best = self._raised(station, height)
        return self._row(station, mass, best)

    def _row(self, station: float, mass: float, best: Tried) -> StationRow:
        values = {} if best.solved is None else row(certified([best.solved])[0], station)
        return {"station": station, "payload": mass, "limited_by": best.limit, **values}

    def _rope_clearance(self, best: Tried) -> float:
        """Of the skyline in a solved state [m]; inf where there is none."""
        ground = self.rig.terrain
        if best.solved is None or ground is None:
            return np.inf
        return rope_clearance(best.solved, ground)

    def _rope_may_limit(self, solved: Solved, least: float) -> bool:
        """Whether the skyline's clearance can be a margin smaller than the least of the others."""
        ground = self.rig.terrain
        return ground is None or (least_rope_clearance(solved, ground) - self.of_rope) / 10.0 <= least + _ALIKE

    def _room(self, station: float, height: float) -> float:
        """From a height of the carriage up to the chord of its span [m]."""
        return self.rig.chord(self.rig.span_of(station), station) - height

    def _lowest(self, station: float, height: float) -> tuple[float, PayloadSearch]:
        """The height to which the empty carriage can be lowered, and a search that starts from there: beside a support,
        and where the rope paid out hangs in other spans, it does not come down further. The height itself where it
        goes nowhere."""
        room = self._room(station, height)
        alone = PayloadSearch(
            self.rig, self.margins, self.clearance, self.of_rope, strict=self.strict
        )  # that it counts on nothing else
        margin = -1.0

        def hangs(gap: float, effort: Effort) -> bool:
            """Whether it can hang this far below the chord [m]; each is started from the last that can."""
            nonlocal margin
            tried = alone._try(station, 0.0, height + room - gap, effort)
            margin = margin if tried.solved is None else tried.margin
            return tried.solved is not None

        gaps = [gap for gap in _GAPS if gap < room]
        low = next((gap for effort in (Effort.QUICK, Effort.FULL) for gap in gaps if hangs(gap, effort)), None)
        if low is None:
            return height, alone
        ratio = 1.3
        while low < room:  # down by steps, shorter ones where there is nothing, and over what only seems an end
            deeper = min(ratio * low, room)
            if hangs(deeper, Effort.NEAR) or (ratio > 1.1 and hangs(deeper, Effort.QUICK)):
                low = deeper
            elif ratio > 1.0 + _LOWEST:
                ratio **= 0.5
            else:
                # An end beyond a limit would leave no payload: it is believed after a full search only.
                efforts = (Effort.QUICK,) if margin >= 0.0 else (Effort.QUICK, Effort.FULL)
                deep = [gap for gap in (1.1 * low, *gaps) if low < gap < room]
                beyond = next((gap for effort in efforts for gap in deep if hangs(gap, effort)), None)
                if beyond is None:
                    break
                low, ratio = beyond, 1.3
        return height + room - low, alone

    def _raised(self, station: float, height: float) -> tuple[float, Tried]:
        """With the carriage raised until the skyline itself clears the ground; where that is impossible, a payload of 0
        with the state of the empty carriage."""

        def short(extra: float) -> float:
            _, found = self._largest(station, height + extra)
            return -np.inf if found.solved is None else self._rope_clearance(found) - self.of_rope

        top = self._room(station, height) - 0.05
        # By steps from below: near the chord another limit can leave no payload, or there is no equilibrium.
        steps = [0.0, *(step for step in _RAISED if step < top), max(top, 0.0)]
        enough = next((k for k, step in enumerate(steps) if k > 0 and short(step) >= 0.0), None)
        if enough is None:
            return 0.0, self._try(station, 0.0, height)._replace(limit="rope clearance")
        extra = float(brentq(lambda e: max(short(e), -1e3), steps[enough - 1], steps[enough], xtol=1e-6))
        mass, found = self._largest(station, height + extra)
        return mass, found._replace(limit="rope clearance") if mass > 0.0 else found

    def _largest(self, station: float, height: float | None) -> tuple[float, Tried]:
        """The largest payload [kg], and the state with it."""
        tried: dict[float, Tried] = {}

        def least(mass: float, effort: Effort = Effort.FULL) -> float:
            if mass not in tried:
                tried[mass] = self._try(station, mass, height, effort)
            return tried[mass].margin

        low = 0.0
        if least(low) == -1.0 and height is None and tried[low].limit == NO_EQUILIBRIUM:
            # Lines that lift the empty carriage off its skyline let a heavier one down on it.
            low = next((mass for mass in np.geomspace(50.0, 12.8e3, 9) if least(float(mass)) >= 0.0), 0.0)
        if least(low) < 0.0:
            return 0.0, tried[0.0]
        empty = tried[0.0].solved
        if self.rig.kind is RigKind.GRAVITY and empty is not None and empty.held_by == "clamp":
            return 0.0, tried[0.0]._replace(limit="does not run out by gravity")
        high = max(_FIRST, 2.0 * low)
        while least(high) >= 0.0:
            step = (high - low) * max(least(high), 0.0) / max(least(low) - least(high), 1e-9)
            low, high = high, high + min(max(1.1 * step, 0.1 * high), 3.0 * high)
            if high > MOST:
                return low, tried[low]._replace(limit="nothing")
        for _ in range(4):
            while least(high, Effort.QUICK) == -1.0 and high - low > 1e-3:  # come down to where there is an equilibrium
                middle = 0.5 * (low + high)
                low, high = (middle, high) if least(middle, Effort.QUICK) >= 0.0 else (low, middle)
            if least(high) != -1.0:
                break
            further = [mass for mass in (low + 1.0, 1.02 * low) if least(mass) >= 0.0]
            if not further:
                limit = tried[high].limit
                if limit == NO_EQUILIBRIUM and self.rig.kind is RigKind.RUNNING and height is None:
                    limit = "haulback tension"  # deeper, its ropes weigh more than they lift
                return low, tried[low]._replace(limit=limit)
            low = further[-1]
            high = 1.5 * low
            while least(high) >= 0.0 and high < MOST:
                low, high = high, 1.5 * high
        mass = float(brentq(lambda m: least(m) if abs(least(m)) > _ZERO else 0.0, low, high, xtol=1e-7, rtol=1e-11))
        least(mass)
        if abs(tried[mass].margin) <= _EXACT:
            return mass, tried[mass]
        # The margin jumps, as where the mainline takes over from the clamp: the payload stays on the inner side.
        inner = max(m for m, found in tried.items() if found.margin >= 0.0 and m <= mass)
        outer = tried[min(m for m in tried if m > inner)]
        return inner, tried[inner]._replace(limit=outer.limit)

    def _try(self, station: float, mass: float, height: float | None, effort: Effort = Effort.FULL) -> Tried:
        try:
            solved = self.solver.solve(station, mass, height, effort=effort)
            if self.strict:
                (solved,) = certified([solved])
        except OutOfReachError as error:
            return Tried(-1.0, error.limit, None)
        except EquilibriumError:
            return Tried(-1.0, NO_EQUILIBRIUM, None)
        values = row(solved, station, lines=False)
        found = {name: margin(values, solved) for name, margin in self.margins.items() if name != ROPE_CLEARANCE}
        least = min(found.values())
        if ROPE_CLEARANCE in self.margins and self._rope_may_limit(solved, least):
            found[ROPE_CLEARANCE] = self.margins[ROPE_CLEARANCE](values, solved)
            least = min(least, found[ROPE_CLEARANCE])
        name = next(n for n, margin in found.items() if margin <= least + _ALIKE)
        return Tried(max(least, -0.999), name, solved)
