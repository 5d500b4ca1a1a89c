"""A rig in all load cases: its carriage at stations along the corridor, in the weather of each case."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ropeway.components.errors import EquilibriumError, InputError, UnknownNameError
from ropeway.systems.interrupts import stop_if_interrupted
from ropeway.systems.progress_bar import bar
from ropeway.systems.rigs.skyline_rig import SkylineRig, studied_in
from ropeway.systems.studies.load_cases.load_case import LoadCase
from ropeway.systems.studies.skyline.carriage_model import Solved
from ropeway.systems.studies.skyline.certified_states import certified
from ropeway.systems.studies.skyline.load_path import stations_of
from ropeway.systems.studies.skyline.rope_tensions import warn_of_overload
from ropeway.systems.studies.skyline.station_solver import Stations

_STATIONS = 20
"""Stations of a corridor besides those at its supports."""
_BESIDE = 0.05
"""Distance of a station from a support [m]: the carriage presses on it most beside it."""


def rig_stations(rig: SkylineRig, stations: Sequence[float] | np.ndarray | None) -> np.ndarray:
    """The given stations [m]; by default about 20 over all spans, and both sides of each support. Raises
    InputError."""
    if stations is not None:
        return stations_of(rig, stations)
    x = rig.points[: rig.spans + 1, 0]
    inner = x[1:-1]
    return np.union1d(np.linspace(x[0], x[-1], _STATIONS + 2)[1:-1], np.concatenate([inner - _BESIDE, inner + _BESIDE]))


def payload_of(rig: SkylineRig, loading: str, own: Mapping[str, float], full: float) -> float:
    """Payload of a loading [kg]. Raises UnknownNameError."""
    known = {"empty": 0.0, "full": full, **own}
    if loading not in known:
        raise UnknownNameError(f"{rig.name} has no loading {loading!r}", f"Choose {', '.join(known)}")
    return float(known[loading])


def require_payloads(rig: SkylineRig, own: Mapping[str, object]) -> dict[str, float]:
    """The user's loadings of a rig, payloads [kg]. Raises InputError."""
    found = {}
    for name, mass in own.items():
        if isinstance(mass, bool) or not isinstance(mass, (int, float)) or not 0.0 <= mass < np.inf:
            raise InputError(f"Loading {name!r} of {rig.name} is {mass!r}", "Give the payload of the carriage in kg")
        found[name] = float(mass)
    return found


def rig_states(
    rig: SkylineRig, cases: Sequence[LoadCase], payloads: Sequence[float], stations: np.ndarray
) -> list[list[Solved]]:
    """In each case the rig with its carriage at all stations. Raises InputError, and EquilibriumError that names the
    case."""
    found = []
    with bar("load cases", len(cases)) as advance:
        for case, payload in zip(cases, payloads, strict=True):
            try:
                found.append(rig_path(studied_in(rig, case.environment), payload, stations))
            except EquilibriumError as error:
                cause = f"Load case {case.name!r}: {error.cause}"
                raise EquilibriumError(cause, error.remedy, error.component) from error
            advance(len(found))
    return found


def rig_path(rig: SkylineRig, payload: float, stations: np.ndarray) -> list[Solved]:
    """The rig with its carriage at all stations. Raises EquilibriumError."""
    solver, solved = Stations(rig), []
    for x in stations.tolist():
        stop_if_interrupted()
        solved.append(solver.solve(x, payload))
    found = certified(solved)
    warn_of_overload(found, stations)
    return found
