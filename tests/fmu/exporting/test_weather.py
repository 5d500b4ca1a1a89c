"""An FMU of a line in weather: temperature, wind pressure and direction are its inputs."""

from __future__ import annotations

from pathlib import Path

import fmpy
import numpy as np
import pandas as pd
import pytest

import ropeway as rw

ROPE = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3, diameter=0.0286)
INPUTS = ("temperature", "wind_pressure", "wind_from")
SHOWN = ("c.tension_in", "c.tension_out", "s_c.load_y", "low_s.vertical_b")


def line() -> rw.System:
    rows = [
        ("low", 0, 0, 0, "drum"),
        ("s", 80, 0, 7, "idler"),
        ("c", 160, 0, 13, "control"),
        ("high", 240, 0, 18, "drum"),
    ]
    supports = pd.DataFrame(rows, columns=["name", "x", "y", "z", "kind"])
    return rw.monocable(ROPE, supports, tension=45e3, load_mass=250.0, load_spacing=35.0, load_drag_area=1.2)


@pytest.fixture(scope="module")
def exported(tmp_path_factory: pytest.TempPathFactory) -> Path:
    start = rw.Environment("start", temperature=15.0, wind_pressure=50.0, wind_from=180.0, ice_thickness=0.004)
    path = tmp_path_factory.mktemp("weather") / "line.fmu"
    return rw.fmu.export(line().in_weather(start), path, inputs=INPUTS, outputs=SHOWN, tolerance=1e-9)


def test_inputs_have_units(exported: Path) -> None:
    about = fmpy.read_model_description(exported)
    units = {v.name: v.unit for v in about.modelVariables if v.causality == "input"}
    assert units == {"temperature": "degC", "wind_pressure": "Pa", "wind_from": "deg"}
    (celsius,) = (u for u in about.unitDefinitions if u.name == "degC")
    assert celsius.baseUnit.offset == pytest.approx(273.15)


def test_it_is_simulate_in_a_gust(exported: Path) -> None:
    """Loads cross the supports meanwhile, and the wind moves them too."""
    curves = {
        "temperature": rw.Schedule([0.0, 20.0], [15.0, -5.0]),
        "wind_pressure": rw.Schedule([0.0, 10.0, 20.0], [50.0, 400.0, 100.0]),
        "wind_from": rw.Schedule([0.0, 20.0], [180.0, 220.0]),
    }
    known = rw.simulate(line(), 20.0, environment=rw.Environment("gust", ice_thickness=0.004, **curves))
    assert len(known.events)
    signals = np.zeros(41, dtype=[("time", float), *((name, float) for name in INPUTS)])
    signals["time"] = np.linspace(0.0, 20.0, 41)
    for name, curve in curves.items():
        signals[name] = [curve.at(t) for t in signals["time"]]
    found = pd.DataFrame(
        fmpy.simulate_fmu(
            str(exported), stop_time=20.0, output_interval=1.0, input=signals, output=SHOWN, fmi_type="ModelExchange",
            relative_tolerance=1e-9,
        )
    ).groupby("time").last()  # fmt: skip
    found = found.reindex(known.frame.index, method="nearest", tolerance=1e-9)
    for name in SHOWN:
        scale = known.frame[name].abs().max()
        assert found[name].to_numpy() == pytest.approx(known.frame[name].to_numpy(), abs=1e-6 * scale), name


def test_co_simulation_in_a_colder_storm(exported: Path) -> None:
    storm = {"temperature": -20.0, "wind_pressure": 600.0, "wind_from": 200.0}
    known = rw.simulate(line(), 10.0, environment=rw.Environment("storm", ice_thickness=0.004, **storm))
    found = pd.DataFrame(
        fmpy.simulate_fmu(
            str(exported), stop_time=10.0, output_interval=1.0, start_values=storm, output=SHOWN,
            fmi_type="CoSimulation",
        )
    )  # fmt: skip
    for name in SHOWN:
        scale = known.frame[name].abs().max()
        assert found[name].to_numpy() == pytest.approx(known.frame[name].to_numpy(), abs=1e-6 * scale), name


def test_rigs_in_weather_are_refused(tmp_path: Path) -> None:
    ends = {"headspar": rw.HeadSpar("head", at=(0.0, 15.0)), "tailspar": rw.TailSpar("tail", at=(300.0, -20.0))}
    rig = rw.standing_skyline(None, **ends, skyline=ROPE, tension=70e3, carriage=rw.Carriage("carriage", mass=450.0))
    with pytest.raises(rw.InputError, match="has no weather"):
        rw.fmu.export(rig.in_weather(rw.Environment("cold", temperature=-20.0)), tmp_path / "rig.fmu")
