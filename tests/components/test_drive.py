"""The hydraulic drive by itself: limits, efficiencies, bad input."""

import math

import casadi as ca
import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import ropeway as rw
from ropeway.components.smooth import clip, clip_above
from support import drives

SETTINGS = {**drives.SETTINGS, "pump_flow": 6e-3}


@given(st.floats(-5.0, 5.0), st.floats(0.1, 3.0))
def test_clip_is_exact_away_from_the_corner_and_never_above(x: float, limit: float) -> None:
    y = float(clip_above(x, limit))
    assert y <= limit * (1.0 + 1e-12)
    if x < 0.98 * limit:
        assert y == pytest.approx(x, abs=1e-12)
    if x > 1.02 * limit:
        assert y == pytest.approx(limit, rel=1e-12)
    assert float(clip(-x, limit, limit)) == pytest.approx(-float(clip(x, limit, limit)), abs=1e-15)


def test_clip_has_a_continuous_slope() -> None:
    x = ca.SX.sym("x")
    slope = ca.Function("slope", [x], [ca.jacobian(clip_above(x, 2.0), x)])
    values = np.array([float(slope(v)) for v in np.linspace(1.9, 2.1, 2001)])
    assert np.abs(np.diff(values)).max() < 2e-3
    assert values[0] == 1.0
    assert values[-1] == 0.0


def motion(
    drive: rw.HydraulicDrive, *, speed: float, command: float, tension_in: float, tension_out: float
) -> dict[str, float]:
    """A control sheave with this drive between two ropes: outputs of its equations."""
    sheave = rw.ControlSheave("c", at=(0.0, 0.0), drive=drive)
    s = rw.System("bench")
    rope = rw.Rope(mass_per_length=1.0, axial_stiffness=20e6, breaking_load=500e3)
    ends = rw.Drum("a", at=(-50.0, 0.0), tension=tension_in), rw.Drum("b", at=(50.0, 0.0), tension=tension_out)
    s.string(rope, ends[0], sheave, ends[1], tension=40e3)
    extra = {"c.command": command} if drive.command_lag > 0.0 else {}
    eq = rw.equilibrium(s, parameters={"c.rope_speed": speed, "c.speed": command, **extra})
    return {
        name: eq[f"c.{name}"]
        for name in (
            "drive_force",
            "pressure",
            "flow",
            "hydraulic_power",
            "power",
            "relief_open",
            "flow_limited",
            "power_limited",
            "tension_in",
            "tension_out",
        )
    }


def test_below_its_limits_it_balances_the_tension_difference() -> None:
    drive = rw.HydraulicDrive(**SETTINGS)
    m = motion(drive, speed=0.5, command=0.5, tension_in=45e3, tension_out=35e3)
    assert m["drive_force"] == pytest.approx(m["tension_in"] - m["tension_out"], rel=1e-9)
    assert not m["relief_open"]
    assert not m["flow_limited"]
    assert not m["power_limited"]


def test_losses_reduce_driving_and_increase_braking_force() -> None:
    drive = rw.HydraulicDrive(**SETTINGS, mechanical_efficiency=0.9, volumetric_efficiency=0.8)
    pulling = motion(drive, speed=0.5, command=0.5, tension_in=45e3, tension_out=35e3)
    braking = motion(drive, speed=0.5, command=0.5, tension_in=35e3, tension_out=45e3)
    mechanical = pulling["drive_force"] * 0.5
    assert pulling["hydraulic_power"] == pytest.approx(mechanical / (0.9 * 0.8), rel=1e-9)
    assert braking["hydraulic_power"] == pytest.approx(braking["drive_force"] * 0.5 * 0.9 * 0.8, rel=1e-9)
    assert braking["hydraulic_power"] < 0.0 < pulling["hydraulic_power"]
    assert pulling["pressure"] > braking["pressure"]


def test_relief_valve_limits_the_force() -> None:
    drive = rw.HydraulicDrive(**{**SETTINGS, "relief_pressure": 20e5, "engine_power": 1e6})
    m = motion(drive, speed=0.5, command=0.5, tension_in=60e3, tension_out=35e3)
    assert m["drive_force"] == pytest.approx(drive.relief_force, rel=1e-6)
    assert m["pressure"] == pytest.approx(20e5, rel=1e-6)
    assert m["relief_open"] == 1.0


def test_engine_power_is_a_hyperbola() -> None:
    drive = rw.HydraulicDrive(**{**SETTINGS, "engine_power": 5e3})
    for speed in (0.3, 0.6, 0.9):
        m = motion(drive, speed=speed, command=speed, tension_in=70e3, tension_out=30e3)
        assert m["hydraulic_power"] == pytest.approx(5e3, rel=1e-4)
        assert m["power_limited"] == 1.0


def test_braking_without_recovery_is_not_limited_by_the_engine() -> None:
    limited = rw.HydraulicDrive(**{**SETTINGS, "engine_power": 5e3})
    burning = rw.HydraulicDrive(**{**SETTINGS, "engine_power": 5e3}, recovers=False)
    case = {"speed": 0.9, "command": 0.9, "tension_in": 30e3, "tension_out": 60e3}
    assert -motion(limited, **case)["drive_force"] < 12e3
    assert motion(burning, **case)["drive_force"] == pytest.approx(-30e3, rel=1e-3)


@given(
    st.floats(-1.5, 1.5),
    st.floats(-1.5, 1.5),
    st.floats(20e3, 90e3),
    st.floats(20e3, 90e3),
    st.floats(10e5, 300e5),
    st.floats(1e3, 8e4),
    st.booleans(),
)
@settings(max_examples=40)
def test_limits_hold_everywhere(speed, command, t_in, t_out, relief, power, recovers) -> None:
    drive = rw.HydraulicDrive(**{**SETTINGS, "relief_pressure": relief, "engine_power": power}, recovers=recovers)
    m = motion(drive, speed=speed, command=command, tension_in=t_in, tension_out=t_out)
    assert 0.0 <= m["pressure"] <= 1.001 * relief
    assert 0.0 <= m["flow"] <= 1.001 * SETTINGS["pump_flow"]
    assert m["hydraulic_power"] <= 1.001 * power
    if recovers:
        assert m["hydraulic_power"] >= -1.001 * power


def test_without_pressure_there_is_no_force_and_the_brake_holds() -> None:
    s = rw.System("bench")
    rope = rw.Rope(mass_per_length=1.0, axial_stiffness=20e6, breaking_load=500e3)
    sheave = rw.ControlSheave("c", at=(0.0, 0.0), drive=rw.HydraulicDrive(**SETTINGS))
    ends = rw.Drum("a", at=(-50.0, 0.0), tension=45e3), rw.Drum("b", at=(50.0, 0.0), tension=35e3)
    s.string(rope, ends[0], sheave, ends[1], tension=40e3)
    lost = rw.equilibrium(s, parameters={"c.pressure_lost": 1.0})
    assert abs(lost["c.drive_force"]) < 1.0
    held = rw.equilibrium(s, parameters={"c.pressure_lost": 1.0, "c.brake": 1.0})
    assert held["c.drive_force"] == pytest.approx(held["c.tension_in"] - held["c.tension_out"], rel=1e-9)


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("displacement", 0.0),
        ("gear_ratio", -1.0),
        ("sheave_radius", 0.0),
        ("relief_pressure", 0.0),
        ("pump_flow", -1e-3),
        ("engine_power", 0.0),
        ("inertia", 0.0),
        ("mechanical_efficiency", 1.2),
        ("volumetric_efficiency", 0.0),
        ("command_lag", -0.1),
        ("drag", math.nan),
        ("brake_force", 0.0),
    ],
)
def test_impossible_drives(field: str, value: float) -> None:
    with pytest.raises(rw.InputError, match=field) as error:
        rw.HydraulicDrive(**{**SETTINGS, field: value})
    assert error.value.remedy


def test_derived_values() -> None:
    drive = rw.HydraulicDrive(**SETTINGS)
    assert drive.volume_per_metre == pytest.approx(127e-6 * 20.0 / 0.5)
    assert drive.relief_force == pytest.approx(250e5 * drive.volume_per_metre * 0.92)
    assert drive.top_speed == pytest.approx(6e-3 * 0.95 / drive.volume_per_metre)
