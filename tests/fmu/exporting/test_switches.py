"""Brakes and losses of pressure as Boolean inputs of an FMU, against the same interventions of rw.simulate."""

from pathlib import Path
from typing import Literal

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.validation import validate_fmu

import ropeway as rw
from ropeway.fmu import Slave, export, load
from support.fmus import HYDRAULIC, RESPONSE, Opener, one_span, short_line

NAMES = ["c1.travel", "c1.tension_in", "c1.tension_out", "c1.power"]
ACTS = {
    5.0: ("brake", "brake", True),
    12.0: ("release", "brake", False),
    20.0: ("pressure lost", "pressure_lost", True),
}


@pytest.fixture(scope="module")
def braked(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("switches") / "line.fmu"
    return export(short_line(), path, "2.0", inputs=["c1.speed", "c1.brake"], outputs=["c1.travel"])


@pytest.mark.parametrize(("drive", "acts", "fmi"), [(None, 2, "2.0"), (HYDRAULIC, 3, "3.0")])
def test_as_interventions(
    tmp_path: Path, open_fmu: Opener, drive: rw.HydraulicDrive | None, acts: int, fmi: Literal["2.0", "3.0"]
) -> None:
    chosen = dict(list(ACTS.items())[:acts])
    line = short_line(drive=drive)
    interventions = [rw.Intervention(time, action, "c1") for time, (action, _, _) in chosen.items()]
    wanted = rw.simulate(line, 24.0, every=0.5, interventions=interventions).frame
    switches = sorted({f"c1.{name}" for _, name, _ in chosen.values()})
    path = export(line, tmp_path / "line.fmu", fmi, inputs=["c1.speed", *switches], tolerance=1e-8)
    assert validate_fmu(str(path)) == []
    assert set(load(path).variables.query("causality == 'input' and kind == 'Boolean'").index) == set(switches)
    one, rows = open_fmu(path), []
    one.initialize()
    for i in range(48):
        if 0.5 * i in chosen:
            _, name, on = chosen[0.5 * i]
            one.switch(f"c1.{name}", on)
            assert one.fmu.getBoolean([one.references[f"c1.{name}"]])[0] == on
        one.step(0.5 * i, 0.5)
        rows.append(one.get(*NAMES))
    times = 0.5 * np.arange(1, 49)
    away = ~np.isin(times, list(chosen))  # there rw.simulate shows what comes after
    last = wanted[~wanted.index.duplicated(keep="last")].loc[times[away], NAMES].to_numpy()
    scale = np.abs(last).max(axis=0)
    assert np.abs((np.array(rows)[away] - last) / scale).max() < 1e-5


@pytest.mark.parametrize(("drive", "fmi"), [(None, "2.0"), (HYDRAULIC, "3.0")])
def test_an_emergency_stop(
    tmp_path: Path, open_fmu: Opener, drive: rw.HydraulicDrive | None, fmi: Literal["2.0", "3.0"]
) -> None:
    """As the intervention: speeds with their corrections go down to zero, and responses end."""
    line = short_line(drive=drive, response=RESPONSE, speed=1.2)
    stop = rw.Intervention(7.3, "emergency stop", deceleration=0.4)
    wanted = rw.simulate(line, 15.0, every=0.1, tolerance=1e-8, interventions=[stop]).frame
    path = export(line, tmp_path / "line.fmu", fmi, emergency_stop=0.4, tolerance=1e-8)
    assert validate_fmu(str(path)) == []
    with Slave(load(path), kind="ModelExchange") as other:
        other.enter(0.0, {})
        other.leave()
        one = open_fmu(path)
        one.initialize()
        for begin, end in ((0.0, 7.3), (7.3, 9.1), (9.1, 15.0)):
            one.step(begin, end - begin)
            other.step(end - begin, {}, {})
            if end == 7.3:
                one.switch("emergency_stop", True)
                other.set({"emergency_stop": True})
                continue
            row = wanted.iloc[int(np.argmin(np.abs(wanted.index - end)))]
            for found in (one.get(*NAMES), other.get(NAMES)):
                assert found == pytest.approx(row[NAMES].to_numpy(), rel=2e-5, abs=2e-5)
        assert one.get("c1.power") == pytest.approx([0.0], abs=1e-3)
        one.switch("emergency_stop", False)  # it runs again, with its responses
        one.step(15.0, 3.0)
        assert one.get("c1.travel")[0] > wanted["c1.travel"].iloc[-1] + 2.0


def test_an_emergency_stop_needs_a_drive(tmp_path: Path) -> None:
    with pytest.raises(rw.InputError, match="has no drive with a commanded speed"):
        export(one_span(), tmp_path / "span.fmu", emergency_stop=1.0)


def test_in_model_exchange_only_at_events(braked: Path, open_fmu: Opener) -> None:
    one = open_fmu(braked, kind="ModelExchange")
    one.initialize()
    one.fmu.newDiscreteStates()
    rate = "der(c1.travel)"
    assert one.get(rate) == [1.0]
    one.fmu.enterContinuousTimeMode()
    with pytest.raises(FMICallException):
        one.switch("c1.brake", True)
    assert "cannot be set now" in one.log[-1]
    one.fmu.enterEventMode()
    one.switch("c1.brake", True)
    assert one.get(rate) == [0.0]


def test_braked_from_the_start(braked: Path, open_fmu: Opener) -> None:
    one = open_fmu(braked)
    one.switch("c1.brake", True)
    one.initialize()
    one.step(0.0, 2.0)
    assert one.get("c1.travel") == [0.0]
    one.switch("c1.brake", False)
    one.step(2.0, 2.0)
    assert one.get("c1.travel") == pytest.approx([2.0])


def test_switches_are_exported_on_request(driven: Path, line3: Path, open_fmu: Opener) -> None:
    for path in (driven, line3):
        one = open_fmu(path)
        assert "c1.brake" not in one.references
        for reference in (max(one.references.values()) + 1, one.references["c1.grip_lost"]):
            with pytest.raises(FMICallException):
                one.fmu.setBoolean([reference], [True])
