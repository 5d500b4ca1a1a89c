"""A diesel engine with its pump, by itself."""

import numpy as np
import pytest

import ropeway as rw

SETTINGS = {
    "rated_power": 60e3,
    "rated_speed": 230.0,
    "inertia": 2.0,
    "displacement": 25e-6,
    "relief_pressure": 350e5,
}


def run(load: rw.Schedule | float, until: float = 20.0, **changes: float) -> rw.Result:
    s = rw.System("power")
    s.add(rw.DieselHydraulicUnit("unit", **{**SETTINGS, **changes}))
    return rw.simulate(s, until, every=0.02, inputs={"unit.load_power": load}, tolerance=1e-9)


def test_speed_under_load_in_closed_form() -> None:
    """A straight governor and a flat torque: speed ratio r of power share s solves r (1 + droop - r) = s droop."""
    share, droop = 0.7, 0.08
    last = run(share * 60e3 * 0.88, drag=0.0, torque_rise=0.0, efficiency=0.88, droop=droop).frame.iloc[-1]
    ratio = ((1.0 + droop) + np.sqrt((1.0 + droop) ** 2 - 4.0 * share * droop)) / 2.0
    assert last["unit.speed"] == pytest.approx(230.0 * ratio, rel=1e-9)
    assert last["unit.power"] == pytest.approx(share * 60e3, rel=1e-9)
    assert last["unit.flow"] == pytest.approx(25e-6 * last["unit.speed"] * 0.95, rel=1e-12)
    assert last["unit.pressure"] == pytest.approx(350e5, rel=1e-9)


def test_droop_is_the_speed_increase_without_load() -> None:
    last = run(0.0, drag=0.0).frame.iloc[-1]
    assert last["unit.speed"] == pytest.approx(1.08 * 230.0, rel=1e-3)
    assert last["unit.torque"] == pytest.approx(0.0, abs=1e-2)


def test_energy_goes_into_load_and_rotation() -> None:
    result = run(rw.Schedule((0.0, 2.0, 4.0, 20.0), (0.0, 0.0, 40e3, 10e3)))
    f, t = result.frame, result.frame.index.to_numpy()
    given = np.trapezoid(f["unit.power"] - f["unit.load_power"] / 0.88, t)
    stored = 0.5 * 2.0 * np.diff(f["unit.speed"].iloc[[0, -1]] ** 2)[0]
    assert given == pytest.approx(stored, rel=1e-3)


def test_a_braking_line_speeds_the_engine_up() -> None:
    result = run(-15e3)
    f = result.frame
    assert result.events["event"].tolist() == ["engine overspeed"]
    assert f["unit.speed"].iloc[-1] > 1.08 * 230.0
    assert f["unit.power"].iloc[-1] == pytest.approx(-15e3 * 0.88, rel=1e-2)
    assert f["unit.rack"].iloc[-1] == pytest.approx(0.0, abs=1e-6)


def test_a_lugged_engine_loses_pressure_and_is_reported() -> None:
    result = run(rw.Schedule((0.0, 2.0, 3.0, 20.0), (0.0, 0.0, 70e3, 70e3)), until=10.0)
    events = result.events
    assert events["event"].tolist() == ["engine lugged down"]
    assert events["component"].tolist() == ["unit"]
    last = result.frame.iloc[-1]
    assert 0.6 < last["unit.speed_ratio"] < 0.8
    assert last["unit.given_power"] == pytest.approx(last["unit.pressure"] * last["unit.flow"], rel=1e-6)
    assert last["unit.given_power"] == pytest.approx(0.88 * last["unit.power"], rel=1e-4)
    assert last["unit.given_power"] < 55e3


def test_a_system_without_a_rope_has_no_report() -> None:
    result = run(0.0, until=1.0)
    for ask in (result.summary, result.plot, result.plot_line):
        with pytest.raises(rw.InputError, match="'power' has no rope"):
            ask()


@pytest.mark.parametrize(
    ("name", "value", "word"),
    [
        ("rated_power", 0.0, "rated_power"),
        ("droop", 0.0, "droop"),
        ("drag", -0.1, "drag"),
        ("efficiency", 1.1, "at most 1"),
        ("charge_pressure", 400e5, "below the relief pressure"),
        ("inertia", float("nan"), "inertia"),
    ],
)
def test_bad_values(name: str, value: float, word: str) -> None:
    with pytest.raises(rw.InputError, match=word):
        rw.DieselHydraulicUnit("unit", **{**SETTINGS, name: value})
