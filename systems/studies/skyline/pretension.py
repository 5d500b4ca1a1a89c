"""How to rig a skyline: its unstretched length and pretension for a wanted loaded state, and what is left of the
pretension once a new rope has settled."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd
from scipy.optimize import brentq

from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.errors import EquilibriumError, InputError
from ropeway.components.rope import Elastic
from ropeway.systems.interrupts import interruptible
from ropeway.systems.rigs.bare_skyline import bare_tension
from ropeway.systems.rigs.skyline_rig import RigKind, SkylineRig
from ropeway.systems.studies.skyline.carriage_model import Solved
from ropeway.systems.studies.skyline.certified_states import certified
from ropeway.systems.studies.skyline.load_path import highest_of, row
from ropeway.systems.studies.skyline.station_solver import Stations


@checked
@dataclass(frozen=True, eq=False)
class SetUp:
    """How to rig a skyline: `length` unstretched [m], `tension` of the bare rope at the headspar [N], the `rig`
    with that length, and `loaded`, the row of its load path in the wanted state."""

    rig: SkylineRig
    length: float
    tension: float
    loaded: dict[str, Any]


@checked
@interruptible
def set_up(
    rig: SkylineRig,
    *,
    station: float,
    payload: float,
    tension: float | None = None,
    deflection: float | None = None,
) -> SetUp:
    """The unstretched length of a skyline for which a payload [kg] at a station [m] gives a highest tension [N],
    or a deflection [percent of the span]. Raises InputError, and EquilibriumError where no length gives it."""
    if rig.kind is RigKind.RUNNING:
        raise InputError(f"{rig.name} has no skyline of its own", "Its tension is set: running_skyline(tension=)")
    if (tension is None) == (deflection is None):
        raise InputError("set_up needs either tension or deflection", "Give one of them")
    check.not_negative(payload, rig.name, "payload", "kg")
    column, wanted = ("highest_tension", tension) if deflection is None else ("deflection", deflection)
    check.positive(wanted or 0.0, rig.name, column)
    if tension is not None and tension >= rig.skyline.breaking_load:
        raise InputError(
            f"{rig.name}: {tension:g} N is above the minimum breaking load {rig.skyline.breaking_load:g} N",
            "Ask for less tension or take a stronger rope",
        )
    chords = float(np.linalg.norm(np.diff(rig.points, axis=0), axis=1).sum())
    strain = rig.skyline.strain.at(rig.skyline.breaking_load)
    inextensible = rig.skyline.strain == (0.0, 0.0)

    def miss(length: float) -> float:
        return float(row(at(rig, length, station, payload), station)[column]) - float(wanted or 0.0)

    low = chords * (1.0 + 1e-6) if inextensible else chords / (1.0 + 0.9 * strain)
    high = chords * 1.001
    sign = 1.0 if column == "deflection" else -1.0
    while sign * miss(high) < 0.0:
        high = chords + 2.0 * (high - chords)
        if high > 3.0 * chords:
            break
    for end, length, sense in (("shortest", low, 1.0), ("longest", high, -1.0)):
        if sense * sign * (off := miss(length)) > 0.0:
            raise EquilibriumError(
                f"{rig.name}: no length gives {column.replace('_', ' ')} {wanted:g} with {payload:g} kg at "
                f"{station:g} m",
                f"With the {end} skyline it is {off + float(wanted or 0.0):.4g}",
            )
    length = float(brentq(miss, low, high, xtol=1e-11, rtol=1e-14))
    ready = replace(rig, length=length, tension=None)
    loaded = row(certified([at(rig, length, station, payload)])[0], station)
    return SetUp(ready, length, bare_tension(ready), loaded)


def at(rig: SkylineRig, length: float, station: float, payload: float) -> Solved:
    """A state of a rig with another length of the skyline."""
    return Stations(replace(rig, length=length, tension=None)).solve(station, payload)


@checked
@interruptible
def tension_history(rig: SkylineRig, turns: Sequence[tuple[float, float]]) -> pd.DataFrame:
    """A new rope settling: one row for each turn (station [m], payload [kg]) in order.

    Columns: station, payload, highest_tension under it, peak (highest tension so far), permanent (construction
    stretch pulled out so far [m]), bare_tension at the headspar afterwards [N]. Construction stretch is that of
    the highest tension ever seen in the rope, it stays, and the rope is elastic below that tension (Lyons 2008).
    The skyline needs `stretch=ConstructionStretch(...)`; the rig's length or tension counts for the rope before
    its first load, which the pretension has stretched already. Raises InputError, EquilibriumError.
    """
    k = rig.skyline.strain.c2
    if k <= 0.0:
        raise InputError(
            f"{rig.name}: the skyline has no construction stretch", "Give it stretch=ConstructionStretch()"
        )
    used = replace(rig, skyline=replace(rig.skyline, stretch=Elastic()), tension=None)
    new = rig.length or 0.0

    def grown(peak: float) -> float:
        return new * (1.0 + k * peak * peak)

    def settled(peak: float) -> float:
        return bare_tension(replace(used, length=grown(peak))) - peak

    limit = rig.skyline.breaking_load
    peak = float(brentq(settled, 0.0, limit, xtol=1e-7))  # the pretension itself
    rows = []
    for station, mass in turns:
        check.not_negative(mass, rig.name, "payload", "kg")
        highest = highest_of(certified([at(used, grown(peak), station, mass)])[0], "skyline")
        if highest > peak:

            def virgin(trial: float, station: float = station, mass: float = mass) -> float:
                return highest_of(at(used, grown(trial), station, mass), "skyline") - trial

            if virgin(limit) > 0.0:
                raise InputError(
                    f"{rig.name}: {mass:g} kg at {station:g} m pull the skyline above its minimum breaking load "
                    f"{limit:g} N",
                    "Take less load or a stronger rope",
                )
            peak = float(brentq(virgin, peak, highest, xtol=1e-7))
            highest = highest_of(certified([at(used, grown(peak), station, mass)])[0], "skyline")
        bare = bare_tension(replace(used, length=grown(peak)))
        rows.append(
            {
                "station": station,
                "payload": mass,
                "highest_tension": highest,
                "peak": peak,
                "permanent": grown(peak) - new,
                "bare_tension": bare,
            }
        )
    return pd.DataFrame(rows)
