"""The largest payload at one station: bracket and root of the smallest margin as a function of the payload."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from ropeway.components.errors import EquilibriumError, OutOfReachError
from ropeway.systems.rigs.skyline_rig import SkylineRig
from ropeway.systems.studies.skyline.carriage_model import Solved
from ropeway.systems.studies.skyline.certified_states import certified
from ropeway.systems.studies.skyline.clearances import rope_clearance
from ropeway.systems.studies.skyline.limits import ROPE_CLEARANCE, LoadLimits, Margins, is_lowered
from ropeway.systems.studies.skyline.load_path import carriage_height
from ropeway.systems.studies.skyline.root_selection import Effort
from ropeway.systems.studies.skyline.station_row import StationRow, station_row
from ropeway.systems.studies.skyline.station_solver import NO_EQUILIBRIUM, Stations

MOST = 1e7
"""Largest reported payload [kg], for a payload without a limit."""

_ZERO = 1e-10
"""Margin that counts as zero: the search ends there without closing its bracket."""

_GUESSES = 6
"""Most guesses before the bracket is closed safely."""

_EXACT = 1e-7
"""Largest final margin of a continuous margin function."""

_GAPS = (0.2, 0.5, 1.0, 2.0, 4.0, 0.05, 5e-3, 5e-4)
"""Depths below the chord [m] at which an empty carriage is tried first."""
_LOWEST = 1e-6
"""Tolerance of the lowest height of an empty carriage, relative to the gap below the chord."""

_RAISED = tuple(0.05 * 2.0**k for k in range(12))
"""Height increments [m] tried until the skyline clears the ground."""

_FIRST = 1000.0
"""The first payload tried [kg]: the same at each station, so that stations are independent."""


class Trial(NamedTuple):
    """A tried payload: the limit with the smallest margin, the solved state and that margin, None without an
    equilibrium; the `margins` of all limits that have been evaluated."""

    limit: str
    solved: Solved | None = None
    margin: float | None = None
    margins: Mapping[str, float] = MappingProxyType({})

    @property
    def within(self) -> bool:
        """Whether the trial is an equilibrium within all limits."""
        return self.margin is not None and self.margin >= 0.0

    @property
    def ordinate(self) -> float:
        """Value of the function in the root search: the margin, at least -0.999; -1 without an equilibrium."""
        return -1.0 if self.margin is None else max(self.margin, -0.999)


class PayloadSearch:
    """The largest payload at each station within limits, independent of other stations. `strict`: each tried state is
    certified; `compiled`: in compiled code."""

    def __init__(self, rig: SkylineRig, limits: LoadLimits, *, strict: bool = False, compiled: bool = False) -> None:
        self.rig, self.limits, self.margins, self.strict = rig, limits, Margins(rig, limits), strict
        self.lowered = limits.clearance is not None and is_lowered(rig)
        self.solver = Stations(rig, by_height=self.lowered, compiled=compiled)
        self.compiled = compiled

    def at(self, station: float) -> StationRow:
        """The row of a station. If the final state fails its certificate, the search is repeated with each tried state
        certified; a state that fails counts as no equilibrium."""
        try:
            return self._largest_row(station)
        except EquilibriumError:
            return PayloadSearch(self.rig, self.limits, strict=True, compiled=self.compiled)._largest_row(station)

    def _largest_row(self, station: float) -> StationRow:
        if self.limits.clearance is None or not self.lowered:
            return self._row(station, *self._largest(station, None))
        height = carriage_height(self.rig, station, self.limits.clearance)
        mass, best = self._largest(station, height)
        if (mass, best.limit) == (0.0, NO_EQUILIBRIUM):
            height, lowest = self._lowest(station, height)
            mass, best = lowest._largest(station, height)
        if self._rope_clearance(best) < self.limits.rope_clearance - 1e-6:
            mass, best = self._raised(station, height)
        return self._row(station, mass, best)

    def _row(self, station: float, mass: float, best: Trial) -> StationRow:
        values = {} if best.solved is None else station_row(certified([best.solved])[0], station)
        return {"station": station, "payload": mass, "limited_by": best.limit, **values}

    def _rope_clearance(self, best: Trial) -> float:
        """Clearance of the skyline in a solved state [m]; inf without a state."""
        ground = self.rig.terrain
        if best.solved is None or ground is None:
            return np.inf
        return rope_clearance(best.solved, ground)

    def _room(self, station: float, height: float) -> float:
        """Distance from a height of the carriage up to the chord of its span [m]."""
        return self.rig.chord(self.rig.span_of(station), station) - height

    def _lowest(self, station: float, height: float) -> tuple[float, PayloadSearch]:
        """The lowest height of the empty carriage at or above `height`, and a search that starts there. It cannot be
        lowered further next to a support, or where the rope paid out sags in other spans. Returns `height` if no
        equilibrium is found."""
        depth = self._room(station, height)
        # Independent of other stations.
        search = PayloadSearch(self.rig, self.limits, strict=self.strict, compiled=self.compiled)
        last = Trial(NO_EQUILIBRIUM)

        def hangs(gap: float, effort: Effort) -> bool:
            """Whether the carriage can hang at a gap below the chord [m]. Each try starts from the last success."""
            nonlocal last
            trial = search._try(station, 0.0, height + depth - gap, effort)
            last = last if trial.solved is None else trial
            return trial.solved is not None

        gaps = [gap for gap in _GAPS if gap < depth]
        low = next((gap for effort in (Effort.QUICK, Effort.FULL) for gap in gaps if hangs(gap, effort)), None)
        if low is None:
            return height, search
        ratio = 1.3
        while low < depth:  # shorter steps on failure; isolated failures are skipped
            deeper = min(ratio * low, depth)
            if hangs(deeper, Effort.NEAR) or (ratio > 1.1 and hangs(deeper, Effort.QUICK)):
                low = deeper
            elif ratio > 1.0 + _LOWEST:
                ratio **= 0.5
            else:
                # An end of states outside a limit would give no payload: it needs a full search.
                efforts = (Effort.QUICK,) if last.within else (Effort.QUICK, Effort.FULL)
                deep = [gap for gap in (1.1 * low, *gaps) if low < gap < depth]
                lower_gap = next((gap for effort in efforts for gap in deep if hangs(gap, effort)), None)
                if lower_gap is None:
                    break
                low, ratio = lower_gap, 1.3
        return height + depth - low, search

    def _raised(self, station: float, height: float) -> tuple[float, Trial]:
        """The payload with the carriage raised until the skyline clears the ground. If that is impossible, a payload of
        0 with the state of the empty carriage."""

        @cache
        def raised(extra: float) -> tuple[float, Trial]:
            return self._largest(station, height + extra)

        def rope_gap(extra: float) -> float:
            _, trial = raised(extra)
            return -np.inf if trial.solved is None else self._rope_clearance(trial) - self.limits.rope_clearance

        top = self._room(station, height) - 0.05
        # Stepwise from below: near the chord another limit may allow no payload, or no equilibrium exists.
        steps = [0.0, *(step for step in _RAISED if step < top), max(top, 0.0)]
        sufficient = next((k for k, step in enumerate(steps) if k > 0 and rope_gap(step) >= 0.0), None)
        if sufficient is None:
            return 0.0, self._try(station, 0.0, height)._replace(limit=ROPE_CLEARANCE)
        extra = float(brentq(lambda e: max(rope_gap(e), -1e3), steps[sufficient - 1], steps[sufficient], xtol=1e-6))
        mass, trial = raised(extra)
        return mass, trial._replace(limit=ROPE_CLEARANCE) if mass > 0.0 else trial

    def _largest(self, station: float, height: float | None) -> tuple[float, Trial]:
        """The largest payload [kg] and its state."""
        tried: dict[float, Trial] = {}

        def trial(mass: float, effort: Effort = Effort.FULL) -> Trial:
            if mass not in tried:
                tried[mass] = self._try(station, mass, height, effort)
            return tried[mass]

        low, empty = 0.0, trial(0.0)
        if empty.limit == NO_EQUILIBRIUM and empty.solved is None and height is None:
            # Lines can lift the empty carriage off its skyline, but not a heavier one.
            low = next((mass for mass in np.geomspace(50.0, 12.8e3, 9) if trial(float(mass)).within), 0.0)
        if not trial(low).within:
            return 0.0, empty
        if self.rig.kind.runs_out_by_gravity and empty.solved is not None and empty.solved.held_by == "clamp":
            return 0.0, empty._replace(limit="does not run out by gravity")
        high = max(_FIRST, 2.0 * low)
        while trial(high).within:
            step = (high - low) * _steps_left(trial(low).margins, trial(high).margins)
            low, high = high, high + min(max(1.1 * step, 0.1 * high), 3.0 * high)
            if high > MOST:
                return low, tried[low]._replace(limit="nothing")
        for _ in range(4):
            while trial(high, Effort.QUICK).solved is None and high - low > 1e-3:  # down to an equilibrium
                middle = 0.5 * (low + high)
                low, high = (middle, high) if trial(middle, Effort.QUICK).within else (low, middle)
            if trial(high).solved is not None:
                break
            further = [mass for mass in (low + 1.0, low + max(0.02 * low, 2.0)) if trial(mass).within]
            if not further:
                return low, tried[low]._replace(limit=self._end_of_states(tried[high].limit, height))
            low = further[-1]
            high = 1.5 * low
            while trial(high).within and high < MOST:
                low, high = high, 1.5 * high

        def ordinate(mass: float) -> float:
            value = trial(mass).ordinate
            return value if abs(value) > _ZERO else 0.0

        low, high = _narrowed(trial, tried, low, high)
        mass = float(brentq(ordinate, low, high, xtol=1e-7, rtol=1e-11))
        if abs(trial(mass).ordinate) <= _EXACT:
            return mass, tried[mass]
        # The margin is discontinuous, for example between mainline and clamp: the payload is on the inner side.
        inner = max(m for m, known in tried.items() if known.within and m <= mass)
        outer = tried[min(m for m in tried if m > inner)]
        return inner, tried[inner]._replace(limit=outer.limit)

    def _end_of_states(self, limit: str, height: float | None) -> str:
        """Limit of a payload above which no state exists. For a running skyline at a given tension it is the haulback:
        with more sag its ropes add more weight than lift."""
        if limit == NO_EQUILIBRIUM and not self.rig.kind.keeps_length and height is None:
            return f"{self.rig.kind.carrying_rope} tension"
        return limit

    def _try(self, station: float, mass: float, height: float | None, effort: Effort = Effort.FULL) -> Trial:
        try:
            solved = self.solver.solve(station, mass, height, effort=effort)
            if self.strict:
                (solved,) = certified([solved])
        except OutOfReachError as error:
            return Trial(error.limit)
        except EquilibriumError:
            return Trial(NO_EQUILIBRIUM)
        limit, margin, margins = self.margins.least(solved)
        return Trial(limit, solved, margin, margins)


def _steps_left(before: Mapping[str, float], now: Mapping[str, float]) -> float:
    """How many more steps like the last lead to a limit, by each limit's own margin."""
    falling = ((margin, before[name] - margin) for name, margin in now.items() if name in before)
    return min((margin / max(fall, 1e-9) for margin, fall in falling), default=np.inf)


def _narrowed(
    trial: Callable[[float], Trial], tried: Mapping[float, Trial], low: float, high: float
) -> tuple[float, float]:
    """A bracket narrowed by guesses: margins of single limits are smooth where the smallest of all has kinks."""
    for _ in range(_GUESSES):
        mass = _guess(tried, low, high)
        if not low < mass < high:
            break
        found = trial(mass)
        low, high = (mass, high) if found.within else (low, mass)
        if abs(found.ordinate) <= _ZERO:
            break
    return low, high


def _guess(tried: Mapping[float, Trial], low: float, high: float) -> float:
    """The least payload at which one of the limits that are exceeded at `high` is reached, by inverse interpolation
    through its three smallest different margins so far; NaN without one."""
    roots = []
    for name, over in tried[high].margins.items():
        if over < 0.0:
            # Payloads with equal margins, as of an empty carriage that is held, say nothing of where it is zero.
            known = {trial.margins[name]: mass for mass, trial in tried.items() if name in trial.margins}
            margins, masses = np.array(sorted(known.items(), key=lambda point: abs(point[0]))[:3]).T
            away = margins - margins[:, None]
            np.fill_diagonal(away, 1.0)
            share = np.where(np.eye(len(margins), dtype=bool), 1.0, margins / away).prod(axis=1)
            roots.append(float(share @ masses))
    return min(roots, default=np.nan)
