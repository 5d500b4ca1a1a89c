"""Runs in the compiled core equal runs with IDAS; unsupported features are rejected."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
import pandas as pd
import pytest

import ropeway as rw
from ropeway.components.response import PRECEDENCES
from support.compiled import require_alike

ROPE = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)
TURNING = rw.Schedule((0.0, 20.0, 24.0, 60.0), (1.5, 1.5, -1.2, -1.2))


def line(drive: rw.Drive | None = None, *, kept: bool = True, friction: float = 0.02) -> rw.System:
    """Six spans: two control sheaves with responses, a rough idler, a feed of loads, a constant-tension drum."""
    response = rw.ThresholdResponse(low=40e3, high=50e3, increment=0.02, period=2.0, delay=1.0)
    own = rw.IdealDrive() if drive is None else drive
    nodes = (
        rw.Drum("a", at=(0.0, 0.0), speed=1.0),
        rw.Sheave("s1", at=(95.0, 3.0, 8.0)),
        rw.ControlSheave("c2", at=(190.0, 0.0, 12.0), speed=1.0, response=response, drive=own),
        rw.Sheave("s3", at=(300.0, -2.0, 25.0), friction=friction),
        rw.Sheave("s4", at=(390.0, 0.0, 27.0)),
        rw.ControlSheave("c5", at=(480.0, 2.0, 32.0), speed=1.0, response=response, drive=own),
        rw.Drum("b", at=(570.0, 0.0, 33.0), **({"tension": 45e3} if kept else {"speed": 1.0})),
    )
    system = rw.System("compiled")
    system.feed(system.string(ROPE, *nodes, tension=45e3), spacing=61.0, masses=(250.0, 320.0, 0.0, 280.0))
    return system


SPEEDS = ("a.speed", "c2.speed", "c5.speed")


@pytest.mark.parametrize("kept", [True, False])
def test_a_run_with_responses_and_an_emergency_stop(kept: bool) -> None:
    stop = [rw.Intervention(41.0, "brake", "c2"), rw.Intervention(55.0, "emergency stop", deceleration=0.5)]
    runs = [
        rw.simulate(line(kept=kept), 60.0, interventions=stop, compiled=compiled, every=0.7)
        for compiled in (True, False)
    ]
    require_alike(*runs)
    assert {"response", "crossing forward", "load put on", "brake", "emergency stop"} <= set(runs[0].events["event"])
    assert runs[0].certificate["holds"].all()


def test_a_run_forwards_and_backwards() -> None:
    speeds = dict.fromkeys(SPEEDS, TURNING)
    compiled, integrated = (rw.simulate(line(), 60.0, inputs=speeds, compiled=c) for c in (True, False))
    require_alike(compiled, integrated)
    assert {"crossing forward", "crossing backward", "load taken off"} <= set(compiled.events["event"])


def test_a_run_resumes_a_compiled_one() -> None:
    whole = rw.simulate(line(), 40.0, compiled=True)
    rest = rw.simulate(line(), 15.0, start=whole.at(25.0), compiled=True)
    names = [name for name in whole.frame if name.endswith((".tension_in", ".tension_out"))]
    np.testing.assert_allclose(rest.frame[names].iloc[-1], whole.frame[names].iloc[-1], rtol=1e-8)


@pytest.mark.parametrize(("speed", "at"), [(1.0, 80.0), (-1.0, 125.0)])
def test_a_load_held_at_a_hold_down(speed: float, at: float) -> None:
    system = rw.System("valley")
    h, m = rw.Sheave("h", at=(100.0, 0.0), hold_down=True), rw.Sheave("m", at=(200.0, 15.0))
    ends = rw.Drum("d0", at=(0.0, 20.0), speed=speed), rw.Drum("d1", at=(300.0, 0.0), tension=60e3)
    spans = system.string(ROPE, ends[0], h, m, ends[1], tension=60e3)
    system.hang(rw.Load("l1", mass=400.0), spans, at=at)
    runs = [rw.simulate(system, 40.0, every=0.5, compiled=compiled) for compiled in (True, False)]
    assert "load held" in set(runs[1].events["event"])
    require_alike(*runs)


@pytest.mark.parametrize("power", [2e5, 3e3])
def test_hydraulic_drives_within_and_at_their_limits(power: float) -> None:
    drive = rw.HydraulicDrive(
        displacement=1e-4, gear_ratio=20.0, sheave_radius=0.6, relief_pressure=3e7, pump_flow=0.02, engine_power=power,
        inertia=500.0, drag=200.0,
    )  # fmt: skip
    require_alike(*(rw.simulate(line(drive), 12.0, compiled=compiled) for compiled in (True, False)))


def test_a_drive_that_turns_at_the_limit_of_its_pump() -> None:
    """Its reference speed leaves the smooth corner of the limit within a millisecond of the start."""
    drive = rw.HydraulicDrive(
        displacement=1e-4, gear_ratio=20.0, sheave_radius=0.6, relief_pressure=3e7, pump_flow=3.48e-3, engine_power=2e5,
        inertia=1000.0, drag=400.0,
    )  # fmt: skip
    runs = [
        rw.simulate(line(drive), 2.0, inputs={"c2.speed": -1.98}, compiled=compiled, tolerance=1e-8)
        for compiled in (True, False)
    ]
    assert 0.98 * drive.top_speed < 1.0 < 1.02 * drive.top_speed
    require_alike(*runs)


@dataclass(frozen=True, slots=True)
class Sluggish(rw.Drive):
    """A drive whose speed follows its command by a law that is not linear."""

    rope_speed: ClassVar[str] = "rope_speed"
    share: float = 0.4

    @property
    def structure(self) -> float:
        return self.share

    def variables(self, force: float, speed: float) -> tuple[rw.Variable, ...]:
        return (rw.Variable("rope_speed", rw.Kind.STATE, "m/s", "speed", 0.7 * speed, kept_at_rest=True),)

    def motion(self, v: Any) -> rw.DriveMotion:
        miss = v.speed + v.correction - v.rope_speed
        return rw.DriveMotion(v.rope_speed, v.tension_in - v.tension_out, {"rope_speed": miss * (self.share + miss**2)})


@pytest.mark.parametrize("drive", [Sluggish(), Sluggish(share=40.0)])
def test_a_drive_with_a_law_of_its_own(drive: rw.Drive) -> None:
    speeds = dict.fromkeys(SPEEDS, rw.Schedule((0.0, 6.0, 6.3, 20.0), (1.0, 1.4, 0.2, 0.9)))
    runs = [rw.simulate(line(drive), 20.0, inputs=speeds, compiled=c, tolerance=1e-8) for c in (True, False)]
    require_alike(*runs)
    assert "response" in set(runs[0].events["event"])


@pytest.mark.parametrize("precedence", PRECEDENCES)
def test_responses_with_each_precedence(precedence: str) -> None:
    response = rw.ThresholdResponse(low=44e3, high=46e3, increment=0.01, period=1.5, hold=1.0)
    table = pd.DataFrame(
        {
            "name": [f"n{i}" for i in range(8)],
            "x": np.arange(8) * 80.0,
            "y": 0.0,
            "z": [0.0, 4.0, 9.0, 10.0, 16.0, 17.0, 25.0, 27.0],
            "kind": ["drum", "control", "idler", "control", "control", "idler", "control", "drum"],
        }
    )
    system = rw.monocable(
        ROPE, table, tension=45e3, load_mass=300.0, load_spacing=45.0, response=response, precedence=precedence
    )
    runs = [rw.simulate(system, 30.0, every=4.0, compiled=compiled) for compiled in (True, False)]
    require_alike(*runs)
    assert (runs[0].events["event"] == "response").sum() > 8


@pytest.mark.parametrize("response", [{"target": 46e3}, {}, {"period": 2.5}])
def test_rules_with_constants_of_their_own(response: dict[str, float]) -> None:
    rule = rw.ProportionalResponse(gain=2e-6, **response)
    system = line()
    for name in ("c2", "c5"):
        system.components[name] = replace(system.components[name], response=rule)
    require_alike(*(rw.simulate(system, 12.0, every=3.0, compiled=compiled) for compiled in (True, False)))


def test_quantities_of_a_compiled_run_are_those_of_its_model() -> None:
    run = rw.simulate(line(), 20.0, compiled=True, every=0.5)
    again = replace(run, compiled=False)
    np.testing.assert_allclose(run.full_frame, again.full_frame, rtol=1e-11, atol=1e-7)
    np.testing.assert_allclose(run.frame, again.frame, rtol=1e-11, atol=1e-7)
    assert list(run.frame) == list(again.frame)
    assert run.certificate["holds"].all()


def test_threads_on_one_model_give_identical_results() -> None:
    model = rw.assemble(line())
    start = rw.equilibrium(model)

    def run(_: int) -> bytes:
        result = rw.simulate(model, 12.0, start=start, compiled=True, progress=False)
        return b"".join(record.z.tobytes() + record.x.tobytes() for record in result.records)

    alone = run(0)
    with ThreadPoolExecutor(8) as pool:
        assert set(pool.map(run, range(8))) == {alone}


def test_drives_that_share_a_power_unit() -> None:
    """IDAS integrates them; the quantities of the unit are sums over its drives."""
    drive = rw.HydraulicDrive(
        displacement=1e-4, gear_ratio=20.0, sheave_radius=0.6, relief_pressure=3e7, pump_flow=0.02, engine_power=2e5,
        inertia=500.0, drag=200.0,
    )  # fmt: skip
    system = line(drive)
    unit = system.add(rw.HydraulicPowerUnit("unit", pump_flow=4e-3, engine_power=2e4))
    for name in ("c2", "c5"):
        system.connect(system.components[name].supply, unit.outlet)
    runs = [rw.simulate(system, 4.0, compiled=compiled, tolerance=1e-8) for compiled in (True, False)]
    require_alike(*runs)
    shares = [run.frame[["unit.flow_share", "unit.flow_demand"]].to_numpy() for run in runs]
    np.testing.assert_allclose(shares[0], shares[1], rtol=1e-6)
