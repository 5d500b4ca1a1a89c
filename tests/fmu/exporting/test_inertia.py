"""FMUs of systems with inertia run as `simulate` does."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fmpy import simulate_fmu

import ropeway as rw
from ropeway.fmu import Slave, load
from support.drives import hydraulic_drive
from support.fmus import corridor
from support.held_carriage import held_carriage

INERTIA = rw.Inertia()
RAMP = rw.Schedule((0.0, 0.25, 0.75, 9.0), (0.0, 0.0, 1.0, 1.0))
NAMES = ["head_carriage.tension_a", "carriage.z", "carriage.velocity_x"]


@pytest.fixture(scope="module")
def rest() -> rw.Equilibrium:
    """A carriage on a skyline, held by a mainline whose drum can turn."""
    rope = rw.Rope(mass_per_length=2.4, axial_stiffness=24.026e6, breaking_load=450e3)
    return held_carriage(rope)[1]


@pytest.fixture(scope="module")
def path(make: Any, rest: rw.Equilibrium) -> Path:
    found: Path = make(
        "inertia", rest, "2.0", inertia=INERTIA, inputs=["mainline.speed", "carriage.dropped"], outputs=NAMES
    )
    return found


def test_a_drum_speeds_up_and_a_payload_is_dropped(path: Path, rest: rw.Equilibrium) -> None:
    drop = [rw.Intervention(1.0, "payload dropped", "carriage")]
    system = rest.model.system
    more: dict[str, Any] = {"start": rest, "inertia": INERTIA, "interventions": drop, "tolerance": 1e-8}
    right = rw.simulate(system, 1.5, every=0.25, inputs={"mainline.speed": RAMP}, **more).frame
    with Slave(load(path)) as slave:
        slave.enter(0.0, {"mainline.speed": 0.0, "carriage.dropped": 0.0})
        slave.leave()
        found = [slave.get(NAMES)]
        for i in range(6):
            t, dropped = 0.25 * i, i >= 4
            begin, end = (
                {"mainline.speed": float(RAMP.at(t)), "carriage.dropped": float(dropped)} for t in (t, t + 0.25)
            )
            slave.step(0.25, begin, end)
            found.append(slave.get(NAMES))
    values = np.array(found)
    assert values == pytest.approx(right[NAMES].to_numpy(), rel=1e-5, abs=1e-5)
    assert values[-1, 0] < 0.95 * values[3, 0]


def test_other_masses_start_to_move_in_both_kinds_of_fmu(path: Path) -> None:
    """A heavier payload falls, as the start is the equilibrium of the one that was exported."""
    runs = [
        simulate_fmu(
            str(path),
            fmi_type=kind,
            stop_time=1.0,
            output_interval=0.25,
            start_values={"carriage.payload": 900.0},
            output=NAMES,
            relative_tolerance=1e-7,
        )
        for kind in ("CoSimulation", "ModelExchange")
    ]
    heights = [np.interp([0.0, 0.5, 1.0], run["time"], run["carriage.z"]) for run in runs]
    assert heights[0] == pytest.approx(heights[1], abs=1e-4)
    assert heights[0][-1] < heights[0][0] - 0.1


SPEED = rw.Schedule((0.0, 1.5, 2.0, 30.0), (2.0, 2.0, -2.0, -2.0))
ROPE = rw.Rope(mass_per_length=2.4, axial_stiffness=24.026e6, breaking_load=450e3)


def fed_line(speed: float | rw.Schedule) -> rw.System:
    """Two spans over a sheave, with loads that are put on and run over it."""
    s = rw.System("fed")
    idler = rw.Sheave("s", at=(90.0, 2.0, 1.0), inertia=100.0, friction=0.01)
    ends = rw.Drum("d", at=(0.0, 0.0), speed=speed), rw.Drum("e", at=(180.0, 0.0), tension=90e3, inertia=100.0)
    s.feed(s.string(ROPE, ends[0], idler, ends[1], length=180.0), spacing=35.0, masses=(300.0, 200.0))
    return s


@pytest.fixture(scope="module")
def fed(make: Any) -> Path:
    found: Path = make("fed_inertia", fed_line(SPEED), "3.0", inertia=INERTIA, tolerance=1e-8)
    return found


@pytest.fixture(scope="module")
def right() -> rw.Result:
    """The run of `fed` in compiled code."""
    return rw.simulate(fed_line(SPEED), 4.0, every=0.5, inertia=INERTIA, tolerance=1e-8, compiled=True)


CROSSED = ["d_s.tension_a", "s_e.tension_b", "s.rope_speed", "s.travel", "s.loads_passed"]


def test_loads_cross_supports_as_in_compiled_code(fed: Path, right: rw.Result) -> None:
    assert right.events["event"].tolist() == ["crossing forward", "crossing backward"]
    with Slave(load(fed)) as slave:
        slave.enter(0.0, {})
        slave.leave()
        found = [slave.get(CROSSED)]
        for _ in range(8):
            slave.step(0.5, {}, {})
            found.append(slave.get(CROSSED))
    values = np.array(found)
    assert values[:, :4] == pytest.approx(right.frame[CROSSED[:4]].to_numpy(), rel=1e-6, abs=1e-6)
    assert values[:, 4].max() == values[0, 4] + 1 == values[-1, 4] + 1


def test_loads_cross_supports_in_model_exchange(fed: Path, right: rw.Result) -> None:
    run = simulate_fmu(
        str(fed),
        fmi_type="ModelExchange",
        stop_time=4.0,
        output_interval=0.5,
        output=CROSSED[:2],
        relative_tolerance=1e-6,
    )
    last = [np.flatnonzero(np.abs(run["time"] - t) < 1e-9)[-1] for t in right.frame.index]
    for name in CROSSED[:2]:
        assert run[name][last] == pytest.approx(right.frame[name].to_numpy(), rel=1e-3)


def test_a_load_is_lost_where_its_mass_becomes_zero(make: Any) -> None:
    s = rw.System("turn")
    (span,) = s.string(ROPE, rw.Anchor("a", at=(0.0, 0.0)), rw.Anchor("b", at=(240.0, 0.0)), length=240.55)
    for name, at in (("turn", 120.0), ("log", 100.0)):
        s.hang(rw.Load(name, mass=500.0), span, at=at)
    lost = [rw.Intervention(0.5, "load lost", "log")]
    right = rw.simulate(s, 1.5, every=0.5, inertia=INERTIA, interventions=lost, tolerance=1e-8).frame["a_b.tension_a"]
    found = []
    with Slave(load(make("lost", s, "2.0", inertia=INERTIA, tolerance=1e-8))) as slave:
        slave.enter(0.0, {})
        slave.leave()
        for mass in (500.0, 0.0, 0.0):
            slave.step(0.5, {"log.mass": mass}, {"log.mass": mass})
            found.append(slave.get(["a_b.tension_a"])[0])
    assert found[1:] == pytest.approx(right.to_numpy()[2:], rel=1e-6)


def test_what_the_core_does_not_have_and_rigs_are_refused(tmp_path: Path) -> None:
    s = rw.System("powered")
    middle = rw.ControlSheave("c", at=(90.0, 1.0), speed=1.0, drive=hydraulic_drive())
    ends = rw.Drum("d", at=(0.0, 0.0), speed=1.0), rw.Drum("e", at=(180.0, 0.0), tension=90e3)
    s.feed(s.string(ROPE, ends[0], middle, ends[1], length=180.0), spacing=40.0, masses=300.0)
    s.connect(middle.supply, s.add(rw.HydraulicPowerUnit("unit", pump_flow=12e-3, engine_power=80e3)).outlet)
    with pytest.raises(rw.fmu.FmuExportError, match=r"run over its supports, .*share a power unit"):
        rw.fmu.export(s, tmp_path / "line.fmu", platforms=(), inertia=INERTIA)
    with pytest.raises(rw.InputError, match="has no inertia"):
        rw.fmu.export(corridor(), tmp_path / "rig.fmu", platforms=(), inertia=INERTIA)
