"""Derivatives of load paths against central differences of rigs that are built anew."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import ropeway as rw

SKYLINE = rw.Rope(mass_per_length=2.4, axial_stiffness=24e6, breaking_load=450e3)
MAINLINE = rw.Rope(mass_per_length=0.73, axial_stiffness=8e6, breaking_load=120e3)
STATIONS = [60.0, 220.0]
OF = ["skyline_tension", "headspar_tension", "highest_tension", "sag", "deflection", "carriage_z", "mainline_tension"]


def standing(**changes: Any) -> rw.SkylineRig:
    tail = changes.pop("tail_z", -20.0)
    parts: dict[str, Any] = {"skyline": SKYLINE, "tension": 70e3, "mainline": MAINLINE} | changes
    return rw.standing_skyline(
        None,
        headspar=rw.HeadSpar("head", at=(0.0, 15.0)),
        supports=[rw.IntermediateSupport("jack", at=(140.0, 2.0), radius=parts.pop("radius", 0.0))],
        tailspar=rw.TailSpar("tail", at=(300.0, tail)),
        carriage=rw.Carriage("carriage", mass=450.0),
        **parts,
    )


def difference(at: Callable[[float], np.ndarray], value: float, h: float) -> np.ndarray:
    """Central difference, extrapolated to cancel the error in h squared."""
    near, far = ((at(value + d) - at(value - d)) / (2.0 * d) for d in (h, 2.0 * h))
    return (4.0 * near - far) / 3.0


def agree(frame: Any, name: str, expected: np.ndarray) -> None:
    found = frame.xs(name, axis=1, level="to").to_numpy()
    assert np.all(np.abs(found - expected) <= 1e-5 * np.abs(expected).max(axis=0)), name


@pytest.mark.parametrize("radius", [0.0, 4.0])
def test_a_standing_skyline_equals_central_differences(radius: float) -> None:
    rig = standing(radius=radius)
    length = rig.length

    def path(one: rw.SkylineRig, payload: float = 2000.0, shift: float = 0.0) -> np.ndarray:
        return rw.load_path(one, payload, [x + shift for x in STATIONS])[OF].to_numpy()

    def strung(**changes: Any) -> np.ndarray:
        return path(standing(radius=radius, tension=None, **{"length": length, **changes}))

    expected = {
        "payload": difference(lambda v: path(rig, v), 2000.0, 1.0),
        "station": difference(lambda v: path(rig, shift=v), 0.0, 0.01),
        "tension": difference(lambda v: path(standing(radius=radius, tension=v)), 70e3, 20.0),
        "length": difference(lambda v: strung(length=v), float(length or 0.0), 1e-3),
        "skyline.axial_stiffness": difference(lambda v: strung(skyline=replace(SKYLINE, axial_stiffness=v)), 24e6, 1e4),
        "mainline.mass_per_length": difference(
            lambda v: strung(mainline=replace(MAINLINE, mass_per_length=v)), 0.73, 1e-3
        ),
    }
    if radius == 0.0:  # the slope of a shoe follows the chords of a rig that is built anew
        expected["tail.z"] = difference(lambda v: strung(tail_z=v), -20.0, 1e-2)
    frame = rw.sensitivities(rig, of=OF, to=list(expected), payload=2000.0, stations=STATIONS)
    assert list(frame.index) == STATIONS
    assert frame.attrs["units"]["sag"] == "m"
    assert frame.attrs["per"]["mainline.mass_per_length"] == "kg/m"
    for name, values in expected.items():
        agree(frame, name, values)


def test_a_running_skyline_and_its_height_equal_central_differences() -> None:
    ground = rw.Profile([-10.0, 310.0], [-30.0, -45.0])

    def running(tension: float) -> rw.SkylineRig:
        return rw.running_skyline(
            ground,
            headspar=rw.HeadSpar("head", at=(0.0, 15.0)),
            tailspar=rw.TailSpar("tail", at=(300.0, 10.0)),
            haulback=MAINLINE,
            tension=tension,
            mainline=MAINLINE,
            carriage=rw.Carriage("carriage", mass=400.0),
        )

    of = ["sag", "mainline_pull", "carriage_z"]
    frame = rw.sensitivities(running(40e3), of=of, to=["tension", "payload"], payload=500.0, stations=STATIONS)
    for name, value, h in (("tension", 40e3, 20.0), ("payload", 500.0, 1.0)):

        def at(v: float, name: str = name) -> np.ndarray:
            rig, load = (running(v), 500.0) if name == "tension" else (running(40e3), v)
            return rw.load_path(rig, load, STATIONS)[of].to_numpy()

        agree(frame, name, difference(at, value, h))
    raised = rw.sensitivities(running(40e3), of=of, to="height", payload=500.0, stations=STATIONS, height=25.0)
    agree(
        raised,
        "height",
        difference(lambda v: rw.load_path(running(40e3), 500.0, STATIONS, height=v)[of].to_numpy(), 25.0, 1e-2),
    )


def test_names_that_a_rig_does_not_have() -> None:
    rig = standing(tension=60e3)
    with pytest.raises(rw.UnknownNameError, match=r"jack\.z"):
        rw.sensitivities(rig, of="sag", to="jack.height", payload=500.0, stations=[60.0])
    with pytest.raises(rw.UnknownNameError, match="clearance"):
        rw.sensitivities(rig, of="clearance", to="payload", payload=500.0, stations=[60.0])
    with pytest.raises(rw.UnknownNameError, match="has no haulback"):
        rw.sensitivities(rig, of="sag", to="haulback.axial_stiffness", payload=500.0, stations=[60.0])
    with pytest.raises(rw.InputError, match="those of a rig"):
        rw.sensitivities(rw.equilibrium(rig.system(0, 60.0)), of="carriage.z", to="carriage.payload", payload=5.0)
