"""The independent oracle of rigs converges from straight ropes to the states of the library."""

from __future__ import annotations

import numpy as np
import pytest

import ropeway as rw
from ropeway.systems.studies.skyline.station_solver import Stations
from support.rig_search import as_unknowns, existing, misses

SKY = rw.Rope(mass_per_length=2.2, axial_stiffness=23e6, breaking_load=390e3)
LINE = rw.Rope(mass_per_length=0.65, axial_stiffness=6.8e6, breaking_load=112e3)
GROUND = rw.Profile([-50, 0, 110, 180, 240, 300], [3, 0, -26, -30, -18, -14])
CARRIAGE = rw.Carriage("car", mass=420.0, depth=1.0)


def guyed(name: str, station: float, behind: float) -> rw.GuyedSpar:
    base = GROUND.elevation_at(station)
    ways = [(behind, -14.0), (behind, 14.0), (-0.7 * behind, 17.0), (-0.7 * behind, -17.0)]
    guys = tuple(
        rw.Guyline(f"{name}_g{i}", rope=SKY, at=(station + dx, dy, GROUND.elevation_at(station + dx)), pretension=12e3)
        for i, (dx, dy) in enumerate(ways)
    )
    return rw.GuyedSpar(name, foot=(station, base), height=13.0, guylines=guys)


def both_guyed() -> rw.SkylineRig:
    return rw.standing_skyline(
        GROUND, headspar=guyed("head", 0.0, -24.0), tailspar=guyed("tail", 240.0, 24.0), skyline=SKY, tension=60e3,
        mainline=LINE, haulback=LINE, haulback_tension=9e3, haulback_block=rw.Block("block", station=240.0, height=3.0),
        carriage=CARRIAGE,
    )  # fmt: skip


def with_log() -> rw.SkylineRig:
    log = rw.Log("log", mass=1.0, length=9.0, friction=0.5, centre=0.4)
    return rw.standing_skyline(
        GROUND, headspar=rw.HeadSpar("head", station=0.0, height=9.0),
        supports=[rw.IntermediateSupport("jack", station=110.0, height=12.0, radius=1.5)],
        tailspar=rw.TailSpar("tail", station=240.0, height=11.0), skyline=SKY, tension=60e3, mainline=LINE,
        carriage=CARRIAGE, turn=rw.Turn(log, LINE, 4.0),
    )  # fmt: skip


def running() -> rw.SkylineRig:
    return rw.running_skyline(
        GROUND, headspar=rw.HeadSpar("head", station=0.0, height=12.0), tailspar=guyed("tail", 240.0, 24.0),
        haulback=LINE, mainline=LINE, tension=24e3, carriage=CARRIAGE,
    )  # fmt: skip


@pytest.mark.parametrize(("rig", "station"), [(both_guyed(), 150.0), (with_log(), 60.0), (running(), 90.0)])
def test_the_oracle_confirms_the_state_and_its_laws(rig: rw.SkylineRig, station: float) -> None:
    payload = 1400.0
    row = rw.load_path(rig, payload, [station]).iloc[0]
    found = existing(rig, station, payload)
    assert found is not None
    assert found.z == pytest.approx(row.carriage_z, abs=1e-6)
    assert found.hold == pytest.approx(row.mainline_pull, rel=1e-6)
    law, u = as_unknowns(Stations(rig).solve(station, payload), station, payload, None)
    assert not misses(law, u)
    moved = u.copy()
    moved[law.at[law.car].start + 2] += 1e-4
    assert {miss.split()[0] for miss in misses(law, moved)} >= {"closure"}


def test_ropes_of_fixed_length_have_a_symmetric_stiffness() -> None:
    """Without friction the forces have a potential."""
    rig = both_guyed()
    law, u = as_unknowns(Stations(rig).solve(150.0, 1400.0), 150.0, 1400.0, None)
    stiffness = law.stiffness(u)
    assert np.abs(stiffness - stiffness.T).max() < 1e-8 * np.abs(stiffness).max()
    assert np.linalg.eigvalsh(0.5 * (stiffness + stiffness.T)).min() > 0.0


def test_the_oracle_has_no_state_for_a_load_that_a_haulback_cannot_lift() -> None:
    rig = running()
    with pytest.raises(rw.EquilibriumError):
        rw.load_path(rig, 14000.0, [90.0])
    assert existing(rig, 90.0, 14000.0) is None
