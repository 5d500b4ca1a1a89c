"""Certificates of rig states: laws of shoes, of carriages on them and of logs, and detection of faults."""

from dataclasses import replace

import pytest

import ropeway as rw
from ropeway.systems.statics.certificate.checks import ROPE_SUM, Certificate
from ropeway.systems.studies.skyline.carriage_model import Place, Solved
from ropeway.systems.studies.skyline.certified_states import certified
from ropeway.systems.studies.skyline.station_solver import Stations

SKY = rw.Rope(mass_per_length=2.9, axial_stiffness=29e6, breaking_load=480e3)
LINE = rw.Rope(mass_per_length=0.6, axial_stiffness=6.5e6, breaking_load=95e3)
ON = 139.8
"""A station on the shoe [m]."""


def rig(**how: object) -> rw.SkylineRig:
    how.setdefault("mainline", LINE)
    return rw.standing_skyline(
        None,
        headspar=rw.HeadSpar("head", at=(0.0, 55.0)),
        supports=[rw.IntermediateSupport("jack", at=(140.0, 32.0), radius=2.0)],
        tailspar=rw.TailSpar("tail", at=(300.0, -6.0)),
        skyline=SKY,
        tension=55e3,
        carriage=rw.Carriage("car", mass=380.0),
        **how,  # type: ignore[arg-type]
    )


def certificate(solved: Solved, **how: float) -> Certificate:
    """The certificate of a solved state after a change in one of its vectors: name=value."""
    point = solved.point.copy()
    for name, value in how.items():
        kind, k = solved.at.slot(name.replace("__", "."))
        point.vector(kind)[k] += value
    return solved.at.certificate([point])


@pytest.mark.parametrize("how", [{}, {"mainline": None}, {"mainline": None, "holding": "horizontal"}])
@pytest.mark.parametrize("station", [60.0, 137.5, ON, 140.6, 220.0])
@pytest.mark.parametrize("payload", [0.0, 1900.0])
def test_states_near_and_on_a_shoe_satisfy_their_laws(how: dict[str, object], station: float, payload: float) -> None:
    solved = Stations(rig(**how)).solve(station, payload)
    checks = solved.at.certificate([solved.point]).checks
    assert all(check.holds for check in checks)
    assert {check.name.partition(":")[0] for check in checks} >= {"CarriageOnShoe" if solved.at.on == 0 else "Carriage"}
    assert not [check.name for check in checks if check.name.startswith("other")]
    assert max(check.value for check in checks if not check.lower) < 1e-10


@pytest.mark.parametrize(
    ("station", "change", "check"),
    [
        (ON, {"car__z": 1e-6}, "CarriageOnShoe: the carriage is on the shoe"),
        (ON, {"car__payload": 0.01}, "CarriageOnShoe: forces on the carriage along the shoe"),
        (ON, {"car__b_x": 1e-6}, "CarriageOnShoe: tangency of the rope, z"),
        (ON, {"car__b_rope": 1e-6}, "CarriageOnShoe: length of rope on the shoe"),
        (220.0, {"jack__a_z": 1e-5}, "IntermediateSupport: tangency of the rope, x"),
        (220.0, {"jack__a_x": 1e-6}, "IntermediateSupport: tangency of the rope, z"),
        (220.0, {"jack__b_rope": 1e-6}, "IntermediateSupport: length of rope on the shoe"),
        (220.0, {"jack_mainline__a_rope": 1e-6}, "IntermediateSupport: length of rope on the shoe"),
        (60.0, {"car__payload": 0.01}, "Carriage: forces on the carriage, z"),
        (60.0, {"head_car__length_start": 1e-5}, ROPE_SUM),
    ],
)
def test_each_fault_is_detected(station: float, change: dict[str, float], check: str) -> None:
    solved = Stations(rig()).solve(station, 1900.0)
    assert solved.held_by == "mainline"
    assert check in [found.name for found in certificate(solved, **change).checks if not found.holds]


def test_contact_of_a_log_by_an_independent_formula() -> None:
    """On a slope, on the rounding of its vertex, past it, and free."""
    ground = rw.Profile([-20.0, 90.0, 100.0, 220.0], [-14.0, -12.0, -5.0, -2.0])
    log = rw.Log("log", mass=600.0, length=9.0, friction=0.4, rounding=2.0)
    held = rw.standing_skyline(
        ground,
        headspar=rw.HeadSpar("head", station=0.0, height=28.0),
        tailspar=rw.TailSpar("tail", station=200.0, height=12.0),
        skyline=SKY,
        mainline=LINE,
        tension=50e3,
        carriage=rw.Carriage("car", mass=380.0),
        turn=rw.Turn(log, LINE, 4.0),
    )
    dragged, wanted = set(), "Log: normal force or gap is zero"
    for station in (40.0, 60.0, 80.0, 90.0, 100.0, 102.0, 104.0, 120.0, 160.0):
        solved = Stations(held).solve(station, 600.0)
        checks = {check.name: check for check in solved.at.certificate([solved.point]).checks}
        assert checks[wanted].value < 1e-8
        assert all(check.holds for check in checks.values())
        dragged.add(solved["log.ground_force"] > 1.0)
        raised = {check.name: check for check in certificate(solved, log__ground_z=1e-3).checks}
        if solved["log.ground_force"] > 1.0:
            assert raised[wanted].value == pytest.approx(1e-3, rel=0.5)
    assert dragged == {True, False}


def test_a_state_that_fails_is_solved_again_or_rejected() -> None:
    held = rig()
    good = [Stations(held).solve(x, 1500.0) for x in (50.0, ON, 90.0)]
    bad = good[2].point.copy()
    bad.z[good[2].at.model.z.index["car.z"]] += 0.3
    spoiled = replace(good[2], point=bad, outputs=good[2].at.outputs(bad))
    found = certified([good[0], spoiled, good[1]])
    assert found[0] is good[0]
    assert found[2] is good[1]
    assert found[1]["car.z"] == pytest.approx(good[2]["car.z"], abs=1e-9)
    with pytest.raises(rw.EquilibriumError, match="distance of a span's end from its support"):
        certified([replace(spoiled, case=None)])
    assert good[1].at.place == Place(0, 0)


def test_the_start_of_a_run_is_certified() -> None:
    solved = Stations(rig()).solve(ON, 1500.0)
    assert solved.at.rest(solved.point)["car.z"] == solved["car.z"]
    bad = solved.point.copy()
    bad.z[solved.at.model.z.index["car.a_x"]] += 1e-5
    with pytest.raises(rw.EquilibriumError, match="fails its check"):
        solved.at.rest(bad)
