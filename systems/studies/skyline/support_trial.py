"""A rig that the search for supports examines: the payload moved along it until a limit stops it."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

from ropeway.components.errors import EquilibriumError
from ropeway.systems.rigs.skyline_rig import SkylineRig
from ropeway.systems.studies.skyline.carriage_model import Solved
from ropeway.systems.studies.skyline.certified_states import certified
from ropeway.systems.studies.skyline.limits import LeastMargin, LoadLimits, Margins, margins_of
from ropeway.systems.studies.skyline.station_solver import NO_EQUILIBRIUM, Stations


class Stop(NamedTuple):
    """The limit that stops a payload, and its station [m]."""

    limit: str
    station: float


class SupportTrial:
    """A rig that the search examines, with its payload at stations.

    All trials with as many supports have the same equations. Their models are those of the first one, `like`, with its
    supports moved; each support has the name of that in its place.
    """

    def __init__(
        self, rig: SkylineRig, like: SkylineRig, payload: float, limits: LoadLimits, *, compiled: bool = False
    ) -> None:
        supports = [replace(own, name=its.name) for own, its in zip(rig.supports, like.supports, strict=True)]
        moved = replace(rig, supports=tuple(supports))
        self._payload, self._limits, self._margins = payload, limits, Margins(moved, limits)
        self._solver = Stations(moved, like=like, compiled=compiled)
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
