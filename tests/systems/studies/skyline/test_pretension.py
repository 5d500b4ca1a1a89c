"""Rigging of a skyline for a desired loaded state, and settling of a new rope."""

import numpy as np
import pytest

import ropeway as rw

ROPE = rw.Rope(mass_per_length=2.4, axial_stiffness=24e6, breaking_load=450.3e3)


def rig(rope: rw.Rope = ROPE, tension: float | None = None, length: float | None = None) -> rw.SkylineRig:
    return rw.standing_skyline(
        None,
        headspar=rw.HeadSpar("head", at=(0.0, 15.0)),
        supports=[rw.IntermediateSupport("jack", at=(180.0, 4.0))],
        tailspar=rw.TailSpar("tail", at=(330.0, -30.0)),
        skyline=rope,
        carriage=rw.Carriage("carriage", mass=400.0),
        tension=60e3 if tension is None and length is None else tension,
        length=length,
    )


def test_length_for_a_loaded_tension_and_for_a_deflection() -> None:
    found = rw.set_up(rig(), station=90.0, payload=2000.0, tension=140e3)
    path = rw.load_path(rig(length=found.length), 2000.0, [90.0]).iloc[0]
    assert path.highest_tension == pytest.approx(140e3, rel=1e-8)
    again = rig(tension=found.tension)
    assert again.length == pytest.approx(found.length, rel=1e-10)
    sagging = rw.set_up(rig(), station=90.0, payload=2000.0, deflection=6.0)
    assert sagging.loaded["sag"] == pytest.approx(0.06 * 180.0, rel=1e-8)


def test_impossible_states_are_rejected() -> None:
    with pytest.raises(rw.EquilibriumError, match=r"no length gives.* longest skyline"):
        rw.set_up(rig(), station=90.0, payload=2000.0, tension=2e3)
    with pytest.raises(rw.EquilibriumError, match=r"no length gives.* shortest skyline"):
        rw.set_up(rig(), station=90.0, payload=2000.0, deflection=0.2)
    with pytest.raises(rw.InputError, match="either tension or deflection"):
        rw.set_up(rig(), station=90.0, payload=2000.0)
    with pytest.raises(rw.InputError, match="breaking load"):
        rw.set_up(rig(), station=90.0, payload=2000.0, tension=1e6)
    with pytest.raises(rw.InputError, match="no construction stretch"):
        rw.tension_history(rig(), [(90.0, 1000.0)])


def test_turns_above_the_breaking_load_are_rejected() -> None:
    new = rig(rw.Rope(2.4, 24e6, 450.3e3, stretch=rw.ConstructionStretch(0.0414)))
    for turn, words in (((90.0, -1.0), "zero or more"), ((90.0, 1e5), "breaking load"), ((390.0, 1.0), "outside")):
        with pytest.raises(rw.InputError, match=words):
            rw.tension_history(new, [(90.0, 1000.0), turn])


def test_a_new_rope_settles_once() -> None:
    rope = rw.Rope(2.4, 24e6, 450.3e3, stretch=rw.ConstructionStretch(0.0414))
    turns = [(90.0, 500.0), (90.0, 2000.0), (90.0, 2000.0), (255.0, 1000.0), (90.0, 2500.0)]
    history = rw.tension_history(rig(rope), turns)
    assert (np.diff(history.permanent) >= -1e-12).all()
    assert (np.diff(history.bare_tension) <= 1e-6).all()
    assert history.bare_tension.iloc[1] < history.bare_tension.iloc[0] - 100.0
    # The same turn again, and a lighter one elsewhere, cause no more construction stretch.
    assert history.highest_tension.iloc[2] == pytest.approx(history.highest_tension.iloc[1], rel=1e-9)
    assert history.permanent.iloc[3] == pytest.approx(history.permanent.iloc[1], rel=1e-12)
    # On its first loading a settled rope is stretched by 0.0414 (T/MBL)^2 of its highest tension.
    peak = history.peak.iloc[-1] / 450.3e3
    assert history.permanent.iloc[-1] == pytest.approx(0.0414 * peak**2 * (rig(rope).length or 0.0), rel=1e-9)
