"""FMUs of systems with inertia run as `simulate` does."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fmpy import simulate_fmu

import ropeway as rw
from ropeway.fmu import Slave, load
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


def test_loads_over_supports_and_rigs_are_refused(tmp_path: Path) -> None:
    line = rw.System("fed")
    rope = rw.Rope(mass_per_length=2.4, axial_stiffness=24.026e6, breaking_load=450e3)
    ends = rw.Drum("d", at=(0.0, 0.0), speed=1.0), rw.Drum("e", at=(180.0, 0.0), tension=90e3)
    line.feed(
        line.string(rope, ends[0], rw.Sheave("s", at=(90.0, 1.0)), ends[1], length=180.0), spacing=40.0, masses=300.0
    )
    with pytest.raises(rw.fmu.FmuExportError, match="run over its supports"):
        rw.fmu.export(line, tmp_path / "line.fmu", platforms=(), inertia=INERTIA)
    with pytest.raises(rw.InputError, match="has no inertia"):
        rw.fmu.export(corridor(), tmp_path / "rig.fmu", platforms=(), inertia=INERTIA)
