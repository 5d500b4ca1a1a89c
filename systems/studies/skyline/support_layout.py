"""Where intermediate supports stand, and how high: an exact search over candidates with the exact statics."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from ropeway.components import check
from ropeway.components.annotation_checks import Undefined
from ropeway.components.argument_checks import checked
from ropeway.components.errors import EquilibriumError, InputError, SlackRopeError
from ropeway.components.intermediate_support import IntermediateSupport
from ropeway.systems.interrupts import interruptible
from ropeway.systems.rigs.rig_builder import with_supports
from ropeway.systems.rigs.skyline_rig import RigKind, SkylineRig
from ropeway.systems.studies.skyline.load_path import row, stations_of
from ropeway.systems.studies.skyline.payload import margins_of
from ropeway.systems.studies.skyline.payload_search import LimitMargin
from ropeway.systems.studies.skyline.station_solver import Stations


@checked
@dataclass(frozen=True)
class Candidate:
    """A tree or a place where a support can stand: its `station` [m] and the `heights` that it allows [m].

    Raises InputError."""

    name: str
    station: float
    heights: tuple[float, ...]

    def __post_init__(self) -> None:
        check.name(self.name, "Candidate")
        check.number(self.station, f"Candidate {self.name!r}", "station", "m")
        object.__setattr__(self, "heights", tuple(sorted(float(h) for h in self.heights)))
        if not self.heights:
            raise InputError(f"Candidate {self.name!r} allows no height", "Give at least one height [m]")
        for height in self.heights:
            check.positive(height, f"Candidate {self.name!r}", "height", "m")

    def support(self, height: float) -> IntermediateSupport:
        """The support that it makes."""
        return IntermediateSupport(self.name, station=self.station, height=height)


@checked
@dataclass(frozen=True, eq=False)
class SupportPlan:
    """The supports found. `feasible`: whether the payload passes with them; if not, `supports` is the trial that
    came furthest, and `limited_by` and `station` say what stopped it where. `tried`: rigs looked at."""

    rig: SkylineRig
    supports: tuple[IntermediateSupport, ...]
    feasible: bool
    limited_by: str
    station: Undefined
    tried: int

    @property
    def height(self) -> float:
        """Sum of the heights [m]."""
        return float(sum(s.height or 0.0 for s in self.supports))


@checked
def support_range(start: float, end: float, spacing: float, heights: Sequence[float]) -> tuple[Candidate, ...]:
    """Candidates every `spacing` metres from `start` to `end`: a range in which supports may stand freely.
    Raises InputError."""
    check.positive(spacing, "support_range", "spacing", "m")
    if not start <= end:
        raise InputError(f"support_range goes from {start:g} m to {end:g} m", "Give the lower station first")
    check.count((end - start) / spacing, "support_range", "candidates", 10_000)
    stations = np.arange(start, end + 1e-9 * spacing, spacing)
    return tuple(Candidate(f"support_{i}", float(x), tuple(heights)) for i, x in enumerate(stations, 1))


@checked
@interruptible
def optimise_supports(
    rig: SkylineRig,
    candidates: Sequence[Candidate],
    *,
    payload: float,
    clearance: float = 0.0,
    rope_clearance: float = 0.0,
    safety_factor: float = 3.0,
    stations: Sequence[float] | np.ndarray | None = None,
    most: int = 3,
) -> SupportPlan:
    """The least number of supports, then the least sum of their heights, that lets a payload [kg] pass all
    `stations` [m] within tensions, lift-off and clearances [m]; `most`: the largest number looked at.

    rig: a standing skyline given by its tension, whose own supports are left out. Every set of candidates is
    looked at, fewest first, and in a set all heights in order of their sum: the answer is exact for the
    candidates given. An infeasible corridor is an answer (`feasible` False). Raises InputError.
    """
    if rig.kind is not RigKind.STANDING or rig.tension is None:
        raise InputError(f"{rig.name} is not a standing skyline given by its tension", "Make it with tension=")
    if rig.terrain is None:
        raise InputError(f"{rig.name} has no terrain", "Give it a Profile")
    check.not_negative(payload, rig.name, "payload", "kg")
    if len({c.name for c in candidates}) < len(candidates):
        raise InputError("Two candidates have one name", "Give each a name of its own")
    low, high = rig.points[0, 0], rig.points[rig.spans, 0]
    for c in candidates:
        if not low < c.station < high:
            raise InputError(
                f"Candidate {c.name!r} at {c.station:g} m is outside the spars", f"Between {low:g} m and {high:g} m"
            )
    check.positive(safety_factor, rig.name, "safety_factor")
    check.number(clearance, rig.name, "clearance", "m")
    check.number(rope_clearance, rig.name, "rope_clearance", "m")
    if most < 0:
        raise InputError(f"{rig.name}: most is {most!r}", "Give the largest number of supports looked at, 0 or more")
    where = stations_of(rig, stations)
    ordered = sorted(candidates, key=lambda c: c.station)
    search = _Search(rig, payload, (clearance, rope_clearance), safety_factor, where)
    for count in range(min(most, len(ordered)) + 1):
        best: tuple[float, tuple[IntermediateSupport, ...]] | None = None
        for chosen in combinations(ordered, count):
            if any(a.station == b.station for a, b in combinations(chosen, 2)):
                continue
            for total, heights in _by_sum(chosen):
                if best is not None and total >= best[0]:
                    break
                supports = tuple(c.support(h) for c, h in zip(chosen, heights, strict=True))
                if search.passes(supports):
                    best = (total, supports)
                    break
        if best is not None:
            return SupportPlan(with_supports(rig, best[1]), best[1], True, "", np.nan, search.tried)
    return search.furthest()


def _by_sum(chosen: Sequence[Candidate]) -> Iterator[tuple[float, tuple[float, ...]]]:
    """All heights of a set of candidates, least sum first."""
    grids = np.meshgrid(*(c.heights for c in chosen), indexing="ij")
    if not grids:
        yield 0.0, ()
        return
    every = np.stack([g.ravel() for g in grids], axis=1)
    for heights in every[np.argsort(every.sum(axis=1), kind="stable")]:
        yield float(heights.sum()), tuple(float(h) for h in heights)


class _Search:
    """Whether a payload passes with some supports. The stations that stopped others are asked first."""

    def __init__(
        self,
        rig: SkylineRig,
        payload: float,
        clearances: tuple[float, float],
        safety_factor: float,
        stations: np.ndarray,
    ) -> None:
        self.rig, self.payload, self.clearances, self.safety = rig, payload, clearances, safety_factor
        self.stations = [float(x) for x in stations]
        self.blame = dict.fromkeys(self.stations, 0)
        self.tried = 0
        self.best: tuple[int, SkylineRig, tuple[IntermediateSupport, ...], str, float] | None = None

    def passes(self, supports: tuple[IntermediateSupport, ...]) -> bool:
        """Asks station by station, those that stopped most trials first, until one is stopped."""
        self.tried += 1
        try:
            rig = with_supports(self.rig, supports)
        except (SlackRopeError, EquilibriumError):
            return False
        margins = margins_of(rig, self.safety, self.safety, self.clearances, True)
        solver = Stations(rig)
        for done, x in enumerate(sorted(self.stations, key=lambda x: (-self.blame[x], x))):
            reason = self._stopped(solver, margins, x)
            if reason is not None:
                self.blame[x] += 1
                if self.best is None or done > self.best[0]:
                    self.best = (done, rig, supports, reason, x)
                return False
        return True

    def _stopped(self, solver: Stations, margins: dict[str, LimitMargin], x: float) -> str | None:
        try:
            solved = solver.solve(x, self.payload)
        except EquilibriumError:
            return "no equilibrium"
        values = row(solved, x, lines=False)
        name, margin = min(((n, f(values, solved)) for n, f in margins.items()), key=lambda found: found[1])
        return name if margin < 0.0 else None

    def furthest(self) -> SupportPlan:
        """The answer where nothing passes."""
        if self.best is None:
            return SupportPlan(self.rig, (), False, "slack rope", np.nan, self.tried)
        _, rig, supports, reason, station = self.best
        return SupportPlan(rig, supports, False, reason, station, self.tried)
