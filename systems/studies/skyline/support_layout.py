"""Positions and heights of intermediate supports: an exact search over candidates with the exact statics."""

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
from ropeway.systems.rigs.skyline_rig import SkylineRig
from ropeway.systems.studies.skyline.limits import LoadLimits
from ropeway.systems.studies.skyline.load_path import stations_of
from ropeway.systems.studies.skyline.support_trial import Stop, SupportTrial, TrialRigs


@checked
@dataclass(frozen=True)
class Candidate:
    """A tree or a possible site of a support.

    Parameters
    ----------
    name : str
        Name of the support.
    station : float
        Station of the support [m].
    heights : sequence of float
        Possible heights [m].

    Raises
    ------
    InputError
        A height is missing or not positive.

    Examples
    --------
    >>> rw.Candidate("spruce", 120.0, (8.0, 6.0)).heights
    (6.0, 8.0)
    """

    name: str
    station: float
    heights: tuple[float, ...]

    def __post_init__(self) -> None:
        check.name(self.name, "Candidate")
        check.number(self.station, f"Candidate {self.name!r}", "station", "m")
        object.__setattr__(self, "heights", tuple(sorted(float(h) for h in self.heights)))
        if not self.heights:
            raise InputError(f"Candidate {self.name!r} has no height", "Give at least one height [m]")
        for height in self.heights:
            check.positive(height, f"Candidate {self.name!r}", "height", "m")

    def support(self, height: float) -> IntermediateSupport:
        """The support of this candidate.

        Parameters
        ----------
        height : float
            Height over the ground [m].

        Returns
        -------
        IntermediateSupport
            A support at the candidate's station.
        """
        return IntermediateSupport(self.name, station=self.station, height=height)


@checked
@dataclass(frozen=True, eq=False)
class SupportPlan:
    """The supports of a skyline, as `rw.optimise_supports` returns them.

    Parameters
    ----------
    rig : SkylineRig
        The rig with these supports.
    supports : tuple of IntermediateSupport
        The supports; for an infeasible corridor, those with which most stations pass.
    feasible : bool
        Whether the payload passes all stations.
    limited_by : str
        The limit that stops an infeasible payload; "" otherwise.
    station : float
        Station of that limit [m]; NaN otherwise.
    tried : int
        Number of rigs examined.

    Examples
    --------
    >>> candidates = [rw.Candidate("spruce", 120.0, (6.0, 8.0))]
    >>> plan = rw.optimise_supports(rig, candidates, payload=1000.0, stations=[150.0])
    >>> plan.feasible
    True
    """

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
    """Candidates at equal spacing in a range without other restrictions.

    Parameters
    ----------
    start, end : float
        Stations of the first and, at most, of the last candidate [m].
    spacing : float
        Spacing of the candidates [m].
    heights : sequence of float
        Possible heights of each candidate [m].

    Returns
    -------
    tuple of Candidate
        Candidates support_1, support_2, ...

    Raises
    ------
    InputError
        The range is empty, or the spacing is not positive.

    Examples
    --------
    >>> [candidate.station for candidate in rw.support_range(100.0, 120.0, 10.0, [6.0, 8.0])]
    [100.0, 110.0, 120.0]
    """
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
    compiled: bool = False,
) -> SupportPlan:
    """Find the least number of supports, then the least sum of their heights, with which a payload passes.

    The search examines sets of candidates in order of their size, and the heights of a set in order of their sum. The
    result is exact for the given candidates. Each state that decides the result is certified. An infeasible corridor is
    a valid result (`feasible` False).

    Parameters
    ----------
    rig : SkylineRig
        A standing skyline given by its tension; its own supports are ignored.
    candidates : sequence of Candidate
        Possible sites and heights.
    payload : float
        Payload [kg].
    clearance : float, default 0.0
        Least height of the load over the ground [m].
    rope_clearance : float, default 0.0
        Least height of the loaded skyline over the ground [m].
    safety_factor : float, default 3.0
        Minimum breaking load over highest tension, of all ropes.
    stations : sequence of float, optional
        Stations that the payload must pass [m]; by default about every 5 m.
    most : int, default 3
        Largest number of supports to examine.
    compiled : bool, default False
        Whether to solve in compiled code, which needs a C compiler at first use: the same result.

    Returns
    -------
    SupportPlan
        The supports, or the limit that stops the payload.

    Raises
    ------
    InputError
        The rig is not a standing skyline given by its tension, or has no terrain; or a candidate is outside its spars.
    CompiledError, CompilerError, WriteError
        Of `compiled`: the core does not support this rig, has no compiler, or its cache cannot be written.

    Examples
    --------
    >>> rig = rw.standing_skyline(
    ...     rw.Profile([0.0, 150.0, 300.0], [0.0, 12.0, 0.0]), headspar=rw.HeadSpar("head", station=0.0, height=15.0),
    ...     tailspar=rw.TailSpar("tail", station=300.0, height=15.0), skyline="RHOL-IWRC 29", tension=70e3,
    ...     carriage=rw.Carriage("carriage", mass=450.0),
    ... )
    >>> plan = rw.optimise_supports(rig, [rw.Candidate("spruce", 150.0, (6.0, 10.0))], payload=1500.0)
    >>> plan.feasible, plan.height
    (True, 6.0)
    """
    _require_choice(rig, candidates, payload, most)
    check.positive(safety_factor, rig.name, "safety_factor")
    check.number(clearance, rig.name, "clearance", "m")
    check.number(rope_clearance, rig.name, "rope_clearance", "m")
    ordered = sorted(candidates, key=lambda c: c.station)
    limits = LoadLimits(safety_factor, safety_factor, clearance, rope_clearance)
    search = _Search(rig, payload, limits, stations_of(rig, stations), compiled=compiled)
    options = {c.name: {h: c.support(h) for h in c.heights} for c in ordered}
    for count in range(min(most, len(ordered)) + 1):
        best: tuple[float, tuple[IntermediateSupport, ...]] | None = None
        for chosen in combinations(ordered, count):
            if any(a.station == b.station for a, b in combinations(chosen, 2)):
                continue
            search.rigs.prepare([list(options[c.name].values()) for c in chosen])
            for total, heights in _by_sum(chosen):
                if best is not None and total >= best[0]:
                    break
                supports = tuple(options[c.name][h] for c, h in zip(chosen, heights, strict=True))
                if search.passes(supports):
                    best = (total, supports)
                    break
        if best is not None:
            return SupportPlan(with_supports(rig, best[1]), best[1], True, "", np.nan, search.tried)
    return search.furthest()


def _require_choice(rig: SkylineRig, candidates: Sequence[Candidate], payload: float, most: int) -> None:
    """Raises InputError for a rig that cannot have other supports, and for invalid candidates."""
    if rig.kind.sets_height or rig.tension is None:
        raise InputError(f"{rig.name} is not a standing skyline given by its tension", "Make it with tension=")
    if rig.terrain is None:
        raise InputError(f"{rig.name} has no terrain", "Give it a Profile")
    check.not_negative(payload, rig.name, "payload", "kg")
    if len({c.name for c in candidates}) < len(candidates):
        raise InputError("Two candidates have the same name", "Give each a unique name")
    low, high = rig.points[0, 0], rig.points[rig.spans, 0]
    for c in candidates:
        if not low < c.station < high:
            raise InputError(
                f"Candidate {c.name!r} at {c.station:g} m is outside the spars", f"Choose {low:g} m to {high:g} m"
            )
    if most < 0:
        raise InputError(f"{rig.name}: most is {most!r}", "Give the largest number of supports to examine, 0 or more")


def _by_sum(chosen: Sequence[Candidate]) -> Iterator[tuple[float, tuple[float, ...]]]:
    """All combinations of heights of a set of candidates, least sum first."""
    grids = np.meshgrid(*(c.heights for c in chosen), indexing="ij")
    if not grids:
        yield 0.0, ()
        return
    every = np.stack([g.ravel() for g in grids], axis=1)
    for heights in every[np.argsort(every.sum(axis=1), kind="stable")]:
        yield float(heights.sum()), tuple(float(h) for h in heights)


class _Search:
    """Test of supports for a payload. Stations that stopped most earlier trials are solved first."""

    def __init__(
        self, rig: SkylineRig, payload: float, limits: LoadLimits, stations: np.ndarray, *, compiled: bool
    ) -> None:
        self.rig, self.payload, self.limits, self.compiled = rig, payload, limits, compiled
        self.failures = dict.fromkeys((float(x) for x in stations), 0)
        self.tried = 0
        self.best: tuple[int, tuple[IntermediateSupport, ...], Stop] | None = None
        self.rigs = TrialRigs(rig)

    def passes(self, supports: tuple[IntermediateSupport, ...]) -> bool:
        """Solves station by station until one stops the payload."""
        self.tried += 1
        try:
            rig, like = self.rigs.over(supports)
        except (SlackRopeError, EquilibriumError):
            return False
        trial = SupportTrial(rig, like, self.payload, self.limits, compiled=self.compiled)
        stations = sorted(self.failures, key=lambda x: (-self.failures[x], x))
        stop = next((stop for stop in map(trial.stop_at, stations) if stop is not None), None) or trial.stop_of_states()
        if stop is None:
            return True
        self.failures[stop.station] += 1
        if self.best is None or len(trial) > self.best[0]:
            own = with_supports(self.rig, supports)
            self.best = (len(trial), supports, stop._replace(limit=trial.named(stop.limit, own)))
        return False

    def furthest(self) -> SupportPlan:
        """The result if no supports pass."""
        if self.best is None:
            return SupportPlan(self.rig, (), False, "slack rope", np.nan, self.tried)
        _, supports, stop = self.best
        return SupportPlan(with_supports(self.rig, supports), supports, False, stop.limit, stop.station, self.tried)
