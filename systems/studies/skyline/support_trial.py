"""Rigs that the search for supports examines: the payload moved along each until a limit stops it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ropeway.components.errors import EquilibriumError
from ropeway.components.intermediate_support import IntermediateSupport
from ropeway.systems.modelling.empty_rope import lengths_between
from ropeway.systems.rigs.rig_builder import with_supports
from ropeway.systems.rigs.skyline_rig import SkylineRig
from ropeway.systems.studies.skyline.carriage_model import Solved
from ropeway.systems.studies.skyline.certified_states import certified
from ropeway.systems.studies.skyline.limits import LeastMargin, LoadLimits, Margins, margins_of
from ropeway.systems.studies.skyline.station_solver import NO_EQUILIBRIUM, Stations


class Stop(NamedTuple):
    """The limit that stops a payload, and its station [m]."""

    limit: str
    station: float


class TrialRigs:
    """A rig over different supports: points in its corridor, without friction.

    All with as many supports have the same equations, so they have the names of the first one's supports; its models
    serve for them. The empty skyline has the same length between the same two points in each.
    """

    def __init__(self, rig: SkylineRig) -> None:
        self._rig = rig
        self._likes: dict[int, SkylineRig] = {}
        self._placed: dict[tuple[IntermediateSupport, str], IntermediateSupport] = {}
        self._lengths: dict[tuple[tuple[float, ...], tuple[float, ...]], float] = {}

    def prepare(self, sites: Sequence[Sequence[IntermediateSupport]]) -> None:
        """Solves the empty spans between the possible supports of each site and those of the next."""
        rig = self._rig
        points = [[rig.headspar.at], *([s.placed(rig.terrain).at for s in site] for site in sites)]
        points += [[node.at] for node in rig.ends[rig.spans :]]
        new = {(a, b) for here, there in pairwise(points) for a in here for b in there} - self._lengths.keys()
        if not new or rig.tension is None:
            return
        ordered = sorted(new)
        starts, ends = np.array(ordered).transpose(1, 0, 2)
        rope = rig.skyline
        weight, height = rope.mass_per_length * rig.gravity, rig.headspar.at[2]
        lengths = lengths_between(starts, ends, weight, rope.strain, rig.tension, height)
        self._lengths.update(zip(ordered, lengths.tolist(), strict=True))

    def over(self, supports: Sequence[IntermediateSupport]) -> tuple[SkylineRig, SkylineRig]:
        """The rig over supports, and the one like it. Raises InputError, SlackRopeError, EquilibriumError."""
        first = self._likes.get(len(supports))
        if first is None or not supports:
            first = self._likes[len(supports)] = with_supports(self._rig, supports)
            return first, first
        named = [self._named(own, its.name) for own, its in zip(supports, first.supports, strict=True)]
        points = [self._rig.headspar.at, *(s.at for s in named), *(n.at for n in self._rig.ends[self._rig.spans :])]
        length = sum(self._lengths[span] for span in pairwise(points))
        return with_supports(self._rig, named, None if math.isnan(length) else length), first

    def _named(self, support: IntermediateSupport, name: str) -> IntermediateSupport:
        """A support in its place, with the name of another."""
        key = support, name
        if key not in self._placed:
            self._placed[key] = replace(support.placed(self._rig.terrain), name=name)
        return self._placed[key]


class SupportTrial:
    """A rig that the search examines, with its payload at stations. Its models are those of a rig `like` it."""

    def __init__(
        self, rig: SkylineRig, like: SkylineRig, payload: float, limits: LoadLimits, *, compiled: bool = False
    ) -> None:
        self._payload, self._limits, self._margins = payload, limits, Margins(rig, limits)
        self._solver = Stations(rig, like=like, compiled=compiled)
        self._states: dict[float, tuple[Solved, LeastMargin]] = {}

    def __len__(self) -> int:
        return len(self._states)

    def stop_at(self, station: float) -> Stop | None:
        """What stops the payload at a station; None if the uncertified state there holds all limits."""
        try:
            solved = self._solver.solve(station, self._payload)
        except EquilibriumError:
            return Stop(NO_EQUILIBRIUM, station)
        least = self._margins.least(solved)
        stop = self._certified_stop(station, solved, least) if least.margin < 0.0 else None
        if stop is None:
            self._states[station] = solved, least
        return stop

    def named(self, limit: str, rig: SkylineRig) -> str:
        """The name of a limit of this trial for its supports as `rig` has them."""
        names = zip(self._margins.of, margins_of(rig, self._limits), strict=True)
        return dict(names).get(limit, limit)

    def stop_of_states(self) -> Stop | None:
        """The first state so far that fails its certificate or a limit; None if all pass."""
        stops = (self._certified_stop(x, *state) for x, state in self._states.items())
        return next((stop for stop in stops if stop is not None), None)

    def _certified_stop(self, station: float, solved: Solved, least: LeastMargin) -> Stop | None:
        """What stops the payload in a state as certified; None if it passes."""
        try:
            (state,) = certified([solved])
        except EquilibriumError:
            return Stop(NO_EQUILIBRIUM, station)
        if state is not solved:
            least = self._margins.least(state)
        return Stop(least.limit, station) if least.margin < 0.0 else None
