"""The certificate of rig states that are returned: those that fail are solved again from cold, or refused."""

from __future__ import annotations

from collections.abc import Sequence

from ropeway.components.errors import EquilibriumError
from ropeway.systems.studies.skyline.carriage_model import Solved, SpanModel
from ropeway.systems.studies.skyline.station_solver import Stations


def certified(found: Sequence[Solved]) -> list[Solved]:
    """Solved states, each with a certificate; a state that fails is solved again from cold.

    Raises
    ------
    EquilibriumError
        A state that was solved again fails as well: it names the check.
    """
    answers = list(found)
    places: dict[SpanModel, list[int]] = {}
    for i, solved in enumerate(found):
        places.setdefault(solved.at, []).append(i)
    for at, own in places.items():
        if at.certificate([found[i].point for i in own]).failed is None:
            continue
        for i in own:
            if at.certificate([found[i].point]).failed is not None:
                answers[i] = _again(found[i])
    return answers


def _again(failed: Solved) -> Solved:
    found = failed
    if failed.asked is not None:
        found = Stations(failed.at.rig, by_height=failed.at.by_height).solve(*failed.asked)
    try:
        found.at.certificate([found.point]).require(found.at.model)
    except EquilibriumError as error:
        where = "" if found.asked is None else f" at station {found.asked[0]:g} m"
        raise EquilibriumError(
            f"{error.cause}{where}",
            "Ask beside this station, or change lengths or the payload a little",
            error.component,
        ) from error
    return found
