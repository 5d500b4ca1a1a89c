"""The running skyline: its weightless closed form, and the balance of its carriage."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import root

import ropeway as rw

G = 9.80665


def rig(mass_per_length: float, tension: float = 60e3) -> rw.SkylineRig:
    rope = rw.Rope(mass_per_length=mass_per_length, axial_stiffness=15e6, breaking_load=300e3)
    return rw.running_skyline(
        None,
        headspar=rw.HeadSpar("head", at=(0.0, 15.0)),
        tailspar=rw.TailSpar("tail", at=(220.0, -25.0)),
        haulback=rope,
        mainline=rope,
        tension=tension,
        carriage=rw.Carriage("carriage", mass=500.0),
    )


@pytest.mark.parametrize("station", [40.0, 110.0, 180.0])
def test_weightless_closed_form(station: float) -> None:
    """Straight lines: T + M towards the headspar, 2 T towards the tail block, and the load."""
    row = rw.load_path(rig(1e-9), 2000.0, [station]).iloc[0]

    def balance(u: np.ndarray) -> list[float]:
        z, m = u
        to_head = np.array([-station, 15.0 - z]) / np.hypot(station, 15.0 - z)
        to_tail = np.array([220.0 - station, -25.0 - z]) / np.hypot(220.0 - station, -25.0 - z)
        return list((to_head * (60e3 + m) + to_tail * 120e3 - np.array([0.0, 2500.0 * G])) / 1e5)

    z, m = root(balance, [row.carriage_z + 0.1, row.mainline_pull * 1.01], tol=1e-14).x
    assert row.carriage_z == pytest.approx(z, rel=1e-9)
    assert row.mainline_pull == pytest.approx(m, rel=1e-9)
    assert row.skyline_tension == pytest.approx(60e3, rel=1e-9)
    assert row.headspar_tension == pytest.approx(60e3, rel=1e-9)


def test_a_given_height_sets_the_haulback_tension() -> None:
    free = rw.load_path(rig(1.4), 2000.0, [110.0]).iloc[0]
    ground = rw.Profile([0.0, 110.0, 220.0], [0.0, free.carriage_z - 7.0, -30.0])
    rope = rw.Rope(mass_per_length=1.4, axial_stiffness=15e6, breaking_load=300e3)
    again = rw.running_skyline(
        ground,
        headspar=rw.HeadSpar("head", at=(0.0, 15.0)),
        tailspar=rw.TailSpar("tail", at=(220.0, -25.0)),
        haulback=rope,
        mainline=rope,
        tension=10e3,
        carriage=rw.Carriage("carriage", mass=500.0),
    )
    row = rw.load_path(again, 2000.0, [110.0], height=7.0).iloc[0]
    assert row.haulback_tension == pytest.approx(60e3, rel=1e-9)
    assert row.mainline_pull == pytest.approx(free.mainline_pull, rel=1e-9)


def test_a_carriage_beyond_its_rest_point_is_a_typed_error() -> None:
    rope = rw.Rope(mass_per_length=1.4, axial_stiffness=15e6, breaking_load=300e3)
    uphill = rw.running_skyline(
        None,
        headspar=rw.HeadSpar("head", at=(0.0, 0.0)),
        tailspar=rw.TailSpar("tail", at=(170.0, 60.0)),
        haulback=rope,
        mainline=rope,
        tension=30e3,
        carriage=rw.Carriage("carriage", mass=500.0),
    )
    with pytest.raises(rw.OutOfReachError, match="beyond its rest point") as error:
        rw.load_path(uphill, 4000.0, [160.0])
    assert "haulback" in error.value.remedy
    # In a payload study this is a limit: a heavier carriage would run back from the station.
    row = rw.payload(uphill, stations=[160.0]).limiting
    assert row.limited_by == "rest point"
    assert 0.0 < row.payload < 4000.0
    rw.load_path(uphill, row.payload, [160.0])
    with pytest.raises(rw.OutOfReachError):
        rw.load_path(uphill, 1.01 * row.payload + 1.0, [160.0])
    heavy = replace(uphill, carriage=rw.Carriage("carriage", mass=4500.0))
    row = rw.payload(heavy, stations=[160.0]).limiting
    assert (row.payload, row.limited_by) == (0.0, "rest point")


def test_a_clamped_carriage_is_rejected() -> None:
    rope = rw.Rope(mass_per_length=1.4, axial_stiffness=15e6, breaking_load=300e3)
    with pytest.raises(rw.InputError, match="clamped"):
        rw.running_skyline(
            None,
            headspar=rw.HeadSpar("head", at=(0.0, 0.0)),
            tailspar=rw.TailSpar("tail", at=(170.0, 60.0)),
            haulback=rope,
            mainline=rope,
            tension=30e3,
            carriage=rw.Carriage("carriage", mass=500.0, clamped=True),
        )


def test_largest_load_of_a_haulback_at_any_depth() -> None:
    """Its ropes add more weight than lift before they are vertical: less than 2 T L / x of weightless ropes."""
    row = rw.payload(rig(1.4, tension=20e3), stations=[110.0]).limiting
    assert row.limited_by == "haulback tension"
    assert 0.5 * 80e3 < (row.payload + 500.0) * G < 0.95 * 80e3
    rw.load_path(rig(1.4, tension=20e3), row.payload, [110.0])
    with pytest.raises(rw.EquilibriumError):
        rw.load_path(rig(1.4, tension=20e3), 1.01 * row.payload, [110.0])


def test_a_tailhold_is_rejected() -> None:
    one = rig(1.4)
    held = replace(one.tailspar, tailhold=rw.Tailhold("stump", at=(240.0, -30.0)))
    with pytest.raises(rw.InputError, match="no skyline for Tailhold 'stump'"):
        rw.running_skyline(
            None,
            headspar=one.headspar,
            tailspar=held,
            haulback=one.skyline,
            mainline=one.skyline,
            tension=30e3,
            carriage=one.carriage,
        )


def test_a_haulback_too_weak_for_the_load_is_a_typed_error() -> None:
    with pytest.raises(rw.EquilibriumError, match="carries less than") as error:
        rw.load_path(rig(1.4, tension=8e3), 4000.0, [110.0])
    heavy = replace(rig(1.4, tension=8e3), carriage=rw.Carriage("carriage", mass=4500.0))
    row = rw.payload(heavy, stations=[110.0]).limiting
    assert (row.payload, row.limited_by) == (0.0, "haulback tension")
    assert "Raise" in error.value.remedy
