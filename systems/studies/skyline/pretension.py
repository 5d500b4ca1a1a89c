"""Rigging of a skyline: unstretched length and pretension for a desired loaded state, and the pretension that remains
after a new rope has settled."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
import pandas as pd
from scipy.optimize import brentq

from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.environment import Environment
from ropeway.components.errors import EquilibriumError, InputError
from ropeway.components.guyed_spar import GuyedSpar
from ropeway.components.rope import Elastic
from ropeway.systems.interrupts import interruptible
from ropeway.systems.rigs.bare_skyline import bare_tension
from ropeway.systems.rigs.skyline_rig import SkylineRig, studied_in
from ropeway.systems.studies.skyline.carriage_model import Solved
from ropeway.systems.studies.skyline.certified_states import certified
from ropeway.systems.studies.skyline.rope_tensions import highest_tension, warn_of_overload
from ropeway.systems.studies.skyline.station_row import sag_columns, station_row
from ropeway.systems.studies.skyline.station_solver import Stations


@checked
@dataclass(frozen=True, eq=False)
class SetUp:
    """Length and pretension of a skyline, as `rw.set_up` returns them.

    Parameters
    ----------
    rig : SkylineRig
        The rig with that length.
    length : float
        Unstretched length of the skyline [m].
    tension : float
        Tension of the bare rope at the headspar [N].
    loaded : dict
        Row of `rw.load_path` in the desired state.

    Examples
    --------
    >>> rig = rw.standing_skyline(
    ...     None, headspar=rw.HeadSpar("head", at=(0.0, 15.0)), tailspar=rw.TailSpar("tail", at=(300.0, -20.0)),
    ...     skyline="RHOL-IWRC 29", tension=70e3, carriage=rw.Carriage("carriage", mass=450.0),
    ... )
    >>> round(rw.set_up(rig, station=150.0, payload=2000.0, deflection=6.0).tension)
    32466
    """

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
    environment: Environment | None = None,
    compiled: bool = False,
) -> SetUp:
    """Solve for the unstretched length of a skyline that gives a desired loaded state.

    Parameters
    ----------
    rig : SkylineRig
        The rig; its own length and tension are ignored.
    station : float
        Station of the carriage [m].
    payload : float
        Payload [kg].
    tension : float, optional
        Desired highest tension of the skyline [N]. Give either this or `deflection`.
    deflection : float, optional
        Desired sag below the chord [% of the span].
    environment : Environment, optional
        Weather of the loaded state, instead of that of the rig. The tension of the bare rope is that of stringing.
    compiled : bool, default False
        Whether to solve in compiled code, which needs a C compiler at first use: the same result.

    Returns
    -------
    SetUp
        Length, tension of the bare rope, and the loaded state.

    Raises
    ------
    InputError
        Both or neither of tension and deflection are given, or the rig is a running skyline.
    EquilibriumError
        No length gives the desired state.
    CompiledError, CompilerError, WriteError
        Of `compiled`: the core does not support this rig, has no compiler, or its cache cannot be written.

    Examples
    --------
    >>> rig = rw.standing_skyline(
    ...     None, headspar=rw.HeadSpar("head", at=(0.0, 15.0)), tailspar=rw.TailSpar("tail", at=(300.0, -20.0)),
    ...     skyline="RHOL-IWRC 29", tension=70e3, carriage=rw.Carriage("carriage", mass=450.0),
    ... )
    >>> round(rw.set_up(rig, station=150.0, payload=2000.0, tension=150e3).loaded["deflection"], 2)
    4.95
    """
    _require_one_target(rig, payload, tension, deflection)
    rig = studied_in(rig, environment)
    state = partial(at, rig, station=station, payload=payload, like=_like(rig), compiled=compiled)
    wanted, value = (tension, _highest) if deflection is None else (deflection, _deflection)
    name, sign = ("highest tension", -1.0) if deflection is None else ("deflection", 1.0)

    def residual(length: float) -> float:
        return value(state(length=length)) - float(wanted or 0.0)

    chords = float(np.linalg.norm(np.diff(rig.points, axis=0), axis=1).sum())
    strain = rig.skyline.strain.at(rig.skyline.breaking_load)
    inextensible = rig.skyline.strain.none
    low = chords * (1.0 + 1e-6) if inextensible else chords / (1.0 + 0.9 * strain)
    high = chords * 1.001
    while sign * residual(high) < 0.0:
        high = chords + 2.0 * (high - chords)
        if high > 3.0 * chords:
            break
    for end, length, sense in (("shortest", low, 1.0), ("longest", high, -1.0)):
        if sense * sign * (excess := residual(length)) > 0.0:
            raise EquilibriumError(
                f"{rig.name}: no length gives {name} {wanted:g} with {payload:g} kg at {station:g} m",
                f"With the {end} skyline it is {excess + float(wanted or 0.0):.4g}",
            )
    length = float(brentq(residual, low, high, xtol=1e-11, rtol=1e-14))
    rigged = replace(rig, length=length, tension=None)
    (solved,) = certified([state(length=length)])
    warn_of_overload([solved], [station])
    loaded = station_row(solved, station)
    return SetUp(rigged, length, bare_tension(rigged), loaded)


def _require_one_target(rig: SkylineRig, payload: float, tension: float | None, deflection: float | None) -> None:
    """Raises InputError for invalid arguments of `set_up`."""
    if not rig.kind.keeps_length:
        raise InputError(f"{rig.name} has no skyline of its own", "Its tension is set: running_skyline(tension=)")
    if (tension is None) == (deflection is None):
        raise InputError("set_up needs either tension or deflection", "Give one of them")
    check.not_negative(payload, rig.name, "payload", "kg")
    if deflection is not None:
        check.positive(deflection, rig.name, "deflection")
    if tension is not None:
        check.positive(tension, rig.name, "highest_tension")
        if tension >= rig.skyline.breaking_load:
            raise InputError(
                f"{rig.name}: {tension:g} N is above the minimum breaking load {rig.skyline.breaking_load:g} N",
                "Reduce the tension or choose a stronger rope",
            )


def _highest(solved: Solved) -> float:
    """Highest tension of the skyline [N]."""
    return highest_tension(solved, "skyline")


def _deflection(solved: Solved) -> float:
    """Sag over span [%]."""
    return sag_columns(solved)["deflection"]


def at(
    rig: SkylineRig,
    length: float,
    station: float,
    payload: float,
    *,
    like: SkylineRig | None = None,
    compiled: bool = False,
) -> Solved:
    """A solved state of a rig with another length of the skyline; `like`: the rig whose models serve for it."""
    return Stations(replace(rig, length=length, tension=None), like=like, compiled=compiled).solve(station, payload)


def _like(rig: SkylineRig) -> SkylineRig | None:
    """The rig, where its models serve for all lengths of its skyline: what lies on a shoe, grips a saddle or holds a
    spar depends on the length."""
    if any(support.radius > 0.0 or support.friction > 0.0 for support in rig.supports):
        return None
    if any(isinstance(spar, GuyedSpar) for spar in (rig.headspar, rig.tailspar)):
        return None
    return replace(rig, tension=None)


@checked
@interruptible
def tension_history(rig: SkylineRig, turns: Sequence[tuple[float, float]]) -> pd.DataFrame:
    """Tensions of a new rope that settles under its first turns.

    The highest tension so far determines the construction stretch, which is permanent. The rope is elastic below that
    tension (Lyons 2008). The rig's length or tension is that of the rope before its first load, already stretched by
    the pretension.

    Parameters
    ----------
    rig : SkylineRig
        A rig with a skyline that has `stretch=ConstructionStretch(...)`.
    turns : sequence of (float, float)
        Station [m] and payload [kg] of each turn, in order.

    Returns
    -------
    DataFrame
        One row per turn: station, payload, highest_tension under it, peak (highest tension so far), permanent
        (construction stretch so far [m]), bare_tension at the headspar afterwards [N].

    Raises
    ------
    InputError
        The rope has no construction stretch, or a turn exceeds its minimum breaking load.
    EquilibriumError
        There is no equilibrium at a station.

    Examples
    --------
    >>> rope = rw.Rope.named("RHOL-IWRC 29", stretch=rw.ConstructionStretch())
    >>> rig = rw.standing_skyline(
    ...     None, headspar=rw.HeadSpar("head", at=(0.0, 15.0)), tailspar=rw.TailSpar("tail", at=(300.0, -20.0)),
    ...     skyline=rope, tension=70e3, carriage=rw.Carriage("carriage", mass=450.0),
    ... )
    >>> rw.tension_history(rig, [(150.0, 2000.0), (150.0, 2000.0)])["bare_tension"].round(-2).tolist()
    [45100.0, 45100.0]
    """
    k = rig.skyline.strain.c2
    if k <= 0.0:
        raise InputError(
            f"{rig.name}: the skyline has no construction stretch", "Give it stretch=ConstructionStretch()"
        )
    used = replace(rig, skyline=replace(rig.skyline, stretch=Elastic()), tension=None)
    new = rig.length or 0.0

    def length_after(peak: float) -> float:
        return new * (1.0 + k * peak * peak)

    def pretension_residual(peak: float) -> float:
        return bare_tension(replace(used, length=length_after(peak))) - peak

    limit = rig.skyline.breaking_load
    peak = float(brentq(pretension_residual, 0.0, limit, xtol=1e-7))  # the pretension itself
    rows, like = [], _like(used)
    for station, mass in turns:
        check.not_negative(mass, rig.name, "payload", "kg")
        highest = highest_tension(certified([at(used, length_after(peak), station, mass, like=like)])[0], "skyline")
        if highest > peak:

            def peak_residual(trial: float, station: float = station, mass: float = mass) -> float:
                return highest_tension(at(used, length_after(trial), station, mass, like=like), "skyline") - trial

            if peak_residual(limit) > 0.0:
                raise InputError(
                    f"{rig.name}: {mass:g} kg at {station:g} m pull the skyline above its minimum breaking load "
                    f"{limit:g} N",
                    "Reduce the payload or choose a stronger rope",
                )
            peak = float(brentq(peak_residual, peak, highest, xtol=1e-7))
            highest = highest_tension(certified([at(used, length_after(peak), station, mass, like=like)])[0], "skyline")
        bare = bare_tension(replace(used, length=length_after(peak)))
        rows.append(
            {
                "station": station,
                "payload": mass,
                "highest_tension": highest,
                "peak": peak,
                "permanent": length_after(peak) - new,
                "bare_tension": bare,
            }
        )
    return pd.DataFrame(rows)
