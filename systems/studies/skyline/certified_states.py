"""Certificates of returned rig states. A state that fails is solved again from a cold start, or rejected."""

from __future__ import annotations

from collections.abc import Sequence

from ropeway.components.errors import EquilibriumError
from ropeway.systems.studies.skyline.carriage_model import Solved, SpanModel
from ropeway.systems.studies.skyline.station_solver import Stations


def certified(solution: Sequence[Solved]) -> list[Solved]:
    """Certify solved states; a state that fails is solved again from a cold start.

    Raises
    ------
    EquilibriumError
        A state fails again. The error names the check.
    """
    answers = list(solution)
    places: dict[SpanModel, list[int]] = {}
    for i, solved in enumerate(solution):
        places.setdefault(solved.at, []).append(i)
    for at, members in places.items():
        if at.certificate([solution[i].point for i in members]).failed is None:
            continue
        for i in members:
            if at.certificate([solution[i].point]).failed is not None:
                answers[i] = _solved_again(solution[i])
    return answers


def _solved_again(failed: Solved) -> Solved:
    solution = failed
    if failed.case is not None:
        at = failed.at
        solution = Stations(at.rig, by_height=at.by_height, compiled=at.compiled).solve(*failed.case)
    try:
        solution.at.certificate([solution.point]).require(solution.at.model)
    except EquilibriumError as error:
        location = "" if solution.case is None else f" at station {solution.case[0]:g} m"
        raise EquilibriumError(
            f"{error.cause}{location}",
            "Choose a station nearby, or change lengths or the payload slightly",
            error.component,
        ) from error
    return solution
