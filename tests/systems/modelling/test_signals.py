"""Inputs that other components drive."""

from dataclasses import replace

import numpy as np
import pytest

import ropeway as rw
from ropeway.components.component import Port
from support.fmus import HYDRAULIC, WEAK_UNIT, fed_line, open_line, short_line

ROPE = rw.Rope(mass_per_length=1.0, axial_stiffness=20e6, breaking_load=500e3)
STRONG = rw.DieselHydraulicUnit(
    "unit",
    rated_power=1e9,
    rated_speed=200.0,
    inertia=1e9,
    displacement=1e-4,
    relief_pressure=350e5,
    volumetric_efficiency=1.0,
)


def follower() -> rw.System:
    """A separate sheave with an ideal drive follows the sheave of the line."""
    s = short_line(drive=HYDRAULIC)
    other = rw.ControlSheave("c2", at=(50.0, 0.0))
    ends = rw.Drum("d0", at=(0.0, 0.0), tension=40e3), rw.Drum("d1", at=(100.0, 0.0), tension=40e3)
    s.string(ROPE, ends[0], other, ends[1], tension=40e3)
    s.connect(s.components["c1"].output("rope_speed"), other.input("speed"))
    return s


def test_a_driven_sheave_follows() -> None:
    frame = rw.simulate(follower(), 20.0, every=0.5, inputs={"c1.speed": 1.1}, tolerance=1e-9).frame
    assert frame["c1.travel"].iloc[-1] > 20.0
    assert frame["c2.travel"].to_numpy() == pytest.approx(frame["c1.travel"].to_numpy(), abs=1e-7)


def test_a_strong_unit_is_constant_flow_and_pressure() -> None:
    fed = rw.simulate(fed_line(STRONG), 20.0, tolerance=1e-8).frame
    flow = fed["unit.flow"].iloc[0]
    drive = replace(HYDRAULIC, pump_flow=flow, brake_force=1e5)
    own = rw.simulate(short_line(drive=drive), 20.0, tolerance=1e-8).frame
    names = [n for n in own.columns if n.startswith("c1.") and n in fed]
    scale = own[names].abs().max().clip(lower=1e-3)
    assert ((fed[names] - own[names]).abs().max() / scale).max() < 1e-5


def test_a_weak_unit_slows_the_line() -> None:
    frame = rw.simulate(fed_line(WEAK_UNIT), 20.0, inputs={"c1.speed": 1.5}).frame
    volume = 1e-4 * 20.0 / 0.5
    top = 0.95 * frame["unit.flow"].iloc[-1] / volume
    assert frame["c1.rope_speed"].iloc[-1] == pytest.approx(top, rel=1e-3)
    assert top < 1.3


def test_a_report_of_a_run_with_crossings() -> None:
    """A load at a support to within rounding is on its span."""
    lost = rw.Intervention(1.0, "pressure lost", "c1")
    spans = rw.simulate(fed_line(WEAK_UNIT), 5.0, interventions=[lost]).summary().spans
    assert (spans["largest_sag"] > 0.5).all()


def test_ports_that_do_not_match() -> None:
    s = fed_line(STRONG)
    c1, unit = s.components["c1"], s.components["unit"]

    def rejected(one: Port, other: Port, match: str) -> None:
        with pytest.raises(rw.InputError, match=match):
            s.connect(one, other)

    rejected(unit.output("flow"), c1.input("speed"), r"unit\.flow is in m3/s, c1\.speed in m/s")
    rejected(unit.output("flow"), c1.input("pump_flow"), "connected twice")
    rejected(unit.output("flow"), unit.output("pressure"), "Connect an output to an input")
    rejected(unit.input("load_power"), c1.input("speed"), "Connect an output to an input")
    with pytest.raises(rw.UnknownNameError, match="has no input 'pressure'"):
        unit.input("pressure")
    with pytest.raises(rw.UnknownNameError, match="has no output or state 'load_power'"):
        unit.output("load_power")
    with pytest.raises(rw.InputError, match="not part of system"):
        rw.System("other").connect(unit.output("flow"), c1.input("pump_flow"))


def test_an_emergency_stop_needs_the_command() -> None:
    with pytest.raises(rw.InputError, match=r"cannot ramp down 'c2\.speed'"):
        rw.simulate(follower(), 5.0, interventions=[rw.Intervention(1.0, "emergency stop")])


def test_an_emergency_stop_keeps_other_inputs() -> None:
    stop = rw.Intervention(2.0, "emergency stop", deceleration=1.0)
    inputs = {"c1.relief_pressure": 350e5, "c1.pump_flow": 0.02}
    frame = rw.simulate(open_line(), 8.0, inputs=inputs, interventions=[stop]).frame
    assert frame["c1.rope_speed"].iloc[-1] == pytest.approx(0.0, abs=1e-3)
    assert np.ptp(frame["c1.pump_flow"]) == 0.0
