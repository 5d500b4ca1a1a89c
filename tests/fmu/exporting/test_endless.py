"""An exported endless rope keeps its loads both ways, and an FMU from the course of a run goes on with it."""

from pathlib import Path

import fmpy
import numpy as np
import pandas as pd
import pytest

import ropeway as rw
from ropeway.fmu import export
from support.fmus import ROPE, short_line

TURNING = rw.Schedule((0.0, 22.0, 24.0, 70.0, 71.0, 120.0), (1.3, 1.3, -1.8, -1.8, 1.1, 1.1))


def test_an_endless_rope_that_reverses(tmp_path: Path) -> None:
    rows = [("d", 0, 0, 0, "control"), ("o", 66, 0, 2, "idler"), ("r", 130, 2, 4, "return"), ("b", 61, 4, 2, "idler")]
    table = pd.DataFrame(rows, columns=["name", "x", "y", "z", "kind"])
    line = rw.endless(ROPE, table, tension=57e3, speed=TURNING, load_mass=(240.0, 110.0, 170.0), load_spacing=38.0)
    start = rw.simulate(line, 90.0, every=45.0).at(67.0)  # loads have come round backwards
    result = rw.simulate(line, 120.0, start=start, every=4.0)
    fmu = export(start, tmp_path / "loop.fmu", "3.0")
    names = ["o_r.tension_a", "r.slide"]
    found = fmpy.simulate_fmu(str(fmu), stop_time=120.0, output_interval=4.0, output=names)
    for name in names:
        assert found[name] == pytest.approx(result.frame[name].to_numpy(), rel=1e-8, abs=1e-8)
    assert result.events["event"].value_counts().to_dict().keys() == {"crossing forward", "crossing backward"}


@pytest.mark.slow
def test_an_fmu_from_a_running_line_keeps_its_clocks(tmp_path: Path) -> None:
    rule = rw.ThresholdResponse(low=41e3, high=49e3, increment=0.01, period=1.3, delay=0.9)
    line = short_line(response=rule)
    run = rw.simulate(line, 25.0)
    fmu = export(run.at(11.4), tmp_path / "later.fmu", "2.0")
    frame = fmpy.simulate_fmu(str(fmu), stop_time=13.6, output_interval=0.1, output=["c1.tension_in", "c1.travel"])
    resumed = rw.simulate(line, 13.6, start=run.at(11.4), every=0.1)
    assert (resumed.events["event"] == "response").sum() >= 3
    for name in ("c1.tension_in", "c1.travel"):
        assert np.abs(frame[name] / resumed.frame[name].to_numpy() - 1.0).max() < 1e-8
    stopped = rw.simulate(line, 3.0, interventions=[rw.Intervention(1.0, "emergency stop")])
    with pytest.raises(rw.InputError, match="emergency stop"):
        export(stopped.at(2.0), tmp_path / "stopped.fmu")
