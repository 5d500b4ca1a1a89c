"""Exact derivatives against central differences of whole solves and runs."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

import ropeway as rw
from support.drives import hydraulic_drive

ROPE = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)


def idlers(tension: float = 30e3) -> rw.System:
    s = rw.System("idlers")
    nodes = [rw.Anchor("a", at=(0, 0)), rw.Sheave("s1", at=(100, 5), friction=0.01), rw.Sheave("s2", at=(210, 2, 8))]
    spans = s.string(ROPE, *nodes, rw.Anchor("b", at=(300, 12)), tension=tension)
    s.hang(rw.Load("l1", mass=400.0), spans, at=150.0)
    s.hang(rw.Load("l2", mass=300.0), spans[2], at=50.0)
    return s


def difference(at: Callable[[float], np.ndarray], value: float, h: float) -> np.ndarray:
    """Central difference, extrapolated to cancel the error in h squared."""
    near, far = ((at(value + d) - at(value - d)) / (2.0 * d) for d in (h, 2.0 * h))
    return (4.0 * near - far) / 3.0


STEPS = {
    "l1.mass": 0.1,
    "l2.mass": 0.1,
    "s1.z": 1e-2,
    "s2.x": 1e-2,
    "a_s1.length": 1e-3,
    "gravity": 1e-3,
    "s1_s2.mass_per_length": 1e-3,
    "s1_s2.compliance": 1e-11,
    "s1.friction": 1e-4,
}


def test_statics_equal_central_differences() -> None:
    eq = rw.equilibrium(idlers())
    of = ["s1_s2.tension_a", "l1.z", "a.tension", "s2.wrap", "l2.x", "s2.support_force"]
    frame = rw.sensitivities(eq, of=of, to=list(STEPS))
    assert list(frame.index) == of
    assert list(frame.columns) == list(STEPS)
    for name, h in STEPS.items():

        def at(value: float, name: str = name) -> np.ndarray:
            moved = rw.equilibrium(eq.model, parameters={name: value}, start=eq)
            return np.array([moved[o] for o in of])

        expected = difference(at, eq[name], h)
        np.testing.assert_allclose(frame[name], expected, rtol=1e-5, atol=1e-7 * np.abs(expected).max(), err_msg=name)


def test_derivatives_in_wind_equal_central_differences() -> None:
    s = rw.System("blown", temperature=15.0)
    rope = replace(ROPE, diameter=0.0286, drag_coefficient=1.1)
    nodes = [rw.Anchor("a", at=(0, 0)), rw.Sheave("s1", at=(100, 5)), rw.Anchor("b", at=(210, 2, 8))]
    spans = s.string(rope, *nodes, tension=30e3)
    s.hang(rw.Load("l1", mass=400.0, drag_area=1.5), spans, at=150.0)
    eq = rw.equilibrium(s, environment=rw.Environment("wind", temperature=5.0, wind_pressure=400.0, wind_from=20.0))
    of = ["a.tension", "l1.z", "l1.y", "s1.support_force"]
    steps = {"l1.mass": 0.1, "temperature": 1e-2, "wind_pressure": 0.1, "s1.z": 1e-2}
    frame = rw.sensitivities(eq, of=of, to=list(steps))
    for name, h in steps.items():

        def at(value: float, name: str = name) -> np.ndarray:
            moved = rw.equilibrium(eq.model, parameters={name: value}, start=eq)
            return np.array([moved[o] for o in of])

        np.testing.assert_allclose(frame[name], difference(at, eq[name], h), rtol=1e-5, err_msg=name)


def test_derivative_of_the_pretension_of_an_empty_rope() -> None:
    s = rw.System("empty")
    nodes = [rw.Anchor("a", at=(0, 0)), rw.Sheave("s", at=(100, 5)), rw.Anchor("b", at=(210, 2))]
    s.string(ROPE, *nodes, tension=30e3)
    frame = rw.sensitivities(rw.equilibrium(s), of="a.tension", to="a.pretension")
    assert frame.loc["a.tension", "a.pretension"] == pytest.approx(1.0, rel=1e-9)


def test_pretension_equals_differences_of_strung_ropes() -> None:
    of = ["a.tension", "s2.wrap", "l1.z"]

    def at(tension: float) -> np.ndarray:
        eq = rw.equilibrium(idlers(tension))
        return np.array([eq[o] for o in of])

    frame = rw.sensitivities(rw.equilibrium(idlers()), of=of, to="a.pretension")
    np.testing.assert_allclose(frame["a.pretension"], difference(at, 30e3, 10.0), rtol=1e-6)


def test_stiffness_and_weight_of_a_rope_in_all_its_spans() -> None:
    eq = rw.equilibrium(idlers())
    of, spans = ["s1_s2.tension_a", "l1.z"], ["a_s1", "s1_s2", "s2_b"]
    frame = rw.sensitivities(eq, of=of, to=["a.axial_stiffness", "a.mass_per_length"])
    assert frame.attrs["per"] == {"a.axial_stiffness": "N", "a.mass_per_length": "kg/m"}
    for name, parameter, h in (
        ("a.axial_stiffness", "compliance", 1e4),
        ("a.mass_per_length", "mass_per_length", 1e-3),
    ):

        def at(value: float, parameter: str = parameter) -> np.ndarray:
            own = 1.0 / value if parameter == "compliance" else value
            moved = rw.equilibrium(eq.model, parameters={f"{span}.{parameter}": own for span in spans}, start=eq)
            return np.array([moved[o] for o in of])

        value = ROPE.axial_stiffness if parameter == "compliance" else ROPE.mass_per_length
        np.testing.assert_allclose(frame[name], difference(at, value, h), rtol=1e-5)


def test_pretension_of_a_skyline_without_its_carriage() -> None:
    def rig(tension: float) -> rw.System:
        return rw.standing_skyline(
            None,
            headspar=rw.HeadSpar("head", at=(0.0, 0.0)),
            supports=[rw.IntermediateSupport("jack", at=(110.0, -2.0))],
            tailspar=rw.TailSpar("tail", at=(200.0, -20.0)),
            skyline=ROPE,
            tension=tension,
            carriage=rw.Carriage("carriage", mass=300.0),
            holding="horizontal",
        ).system(station=60.0, payload=1500.0)

    of = ["carriage.z", "head.tension"]
    eq = rw.equilibrium(rig(60e3))
    frame = rw.sensitivities(eq, of=of, to="head.pretension")

    def at(tension: float) -> np.ndarray:
        moved = rw.equilibrium(rig(tension))
        return np.array([moved[o] for o in of])

    np.testing.assert_allclose(frame["head.pretension"], difference(at, 60e3, 20.0), rtol=1e-5)


def test_units_of_derivatives() -> None:
    frame = rw.sensitivities(rw.equilibrium(idlers()), of=["l1.z", "a.tension"], to=["l1.mass", "a.pretension"])
    assert frame.attrs["units"] == {"l1.z": "m", "a.tension": "N"}
    assert frame.attrs["per"] == {"l1.mass": "kg", "a.pretension": "N"}


DRIVE = hydraulic_drive(displacement=250e-6, relief_pressure=300e5, pump_flow=16e-3, inertia=2000.0)
RAMP = rw.Schedule((0.0, 12.5, 17.0, 100.0), (1.0, 1.0, 1.03, 1.03))
MASSES = tuple(200.0 + 10.0 * ((37 * i) % 29) for i in range(20))
SUPPORTS = pd.DataFrame(
    [
        ("start", 0.0, 0.0, "drum"),
        ("s1", 70.0, 9.0, "idler"),
        ("s2", 150.0, 15.0, "idler"),
        ("c1", 220.0, 24.0, "control"),
        ("s3", 300.0, 28.0, "idler"),
        ("c2", 370.0, 31.0, "control"),
        ("s4", 450.0, 36.0, "idler"),
        ("end", 520.0, 32.0, "drum"),
    ],
    columns=["name", "x", "z", "kind"],
).assign(y=0.0)
RUN_STEPS = {
    "l6.mass": 0.1,
    "s3.z": 1e-3,
    "c1.speed": 1e-5,
    "c2.speed": 1e-5,
    "start.tension": 2.0,
    "start.pretension": 2.0,
    "c2.response_time": 1e-4,
    "c2.inertia": 2.0,
    "c2.response_gain": 1e-10,
}


def line(
    tension: float = 45e3, drive: rw.HydraulicDrive | None = None, response: rw.ProportionalResponse | None = None
) -> rw.System:
    return rw.monocable(
        ROPE, SUPPORTS, tension=tension, load_mass=MASSES, load_spacing=35.0, drive=drive, response=response
    )


def run(system: rw.System, name: str = "", value: float = 0.0, until: float = 60.0) -> rw.Result:
    """A run with a changed value of one quantity."""
    model = rw.assemble(system)
    inputs: dict[str, float | rw.Schedule] = {"c2.speed": RAMP}
    start = None
    if name == "c2.speed":
        inputs[name] = rw.Schedule(RAMP.times, [v + value - 1.0 for v in RAMP.speeds])
    elif name == "c1.speed":
        inputs[name] = value
    elif name:
        start = rw.equilibrium(model, parameters={name: value})
    return rw.simulate(model, until, every=7.5, inputs=inputs, start=start, tolerance=1e-10)


def compare(system: Callable[[float], rw.System], of: Sequence[str], to: Sequence[str], until: float = 60.0) -> None:
    base = run(system(45e3), until=until)
    assert (base.events["event"] == "crossing forward").sum() >= 5
    frame = rw.sensitivities(base, of=of, to=to)
    assert list(frame.index) == list(base.frame.index)
    start = rw.equilibrium(base.model)
    masses = dict(zip(base.runs[0].loads.names, base.runs[0].loads.mass, strict=True))
    for name in to:

        def at(value: float, name: str = name) -> np.ndarray:
            moved = run(system(value)) if name == "start.pretension" else run(system(45e3), name, value, until)
            return moved.frame[list(of)].to_numpy()

        value = 45e3 if name == "start.pretension" else masses[name[:-5]] if name.endswith(".mass") else start[name]
        expected = difference(at, float(value), RUN_STEPS[name])
        found = frame.xs(name, axis=1, level="to")[list(of)].to_numpy()
        for i, output in enumerate(of):
            scale = np.abs(expected[:, i]).max()
            assert np.abs(found[:, i] - expected[:, i]).max() <= 1e-5 * scale, (output, name)


def test_a_run_with_crossings_equals_central_differences() -> None:
    of = ["c1.tension_out", "c2.tension_in", "c2.power", "s3.travel"]
    compare(line, of, ["l6.mass", "s3.z", "c1.speed", "c2.speed", "start.pretension"])


def test_derivatives_through_delayed_samples_and_drive_states() -> None:
    response = rw.ProportionalResponse(gain=4e-6, period=1.0, delay=0.7)
    of = ["c1.tension_out", "c2.power", "c1.travel"]
    compare(
        lambda tension: line(tension, DRIVE, response),
        of,
        ["l6.mass", "start.tension", "c2.response_time", "c2.response_gain"],
        until=30.0,
    )


@pytest.mark.slow
def test_derivatives_through_drives_at_their_limit() -> None:
    """The engine's power limits the force: speeds and tensions are coupled, and crossings disturb both."""
    weak = replace(DRIVE, engine_power=12e3)
    base = run(line(drive=weak), until=30.0)
    assert base.frame["c2.power_limited"].max() == 1.0
    compare(lambda tension: line(tension, weak), ["c2.power", "c2.travel"], ["l6.mass", "c2.inertia"], until=30.0)


def test_loads_hung_on_a_span_travel_with_the_rope() -> None:
    def hung(height: float) -> rw.Result:
        s = rw.System("hung")
        nodes = [
            rw.Drum("a", at=(0, 0), speed=0.5),
            rw.Sheave("s", at=(100, height)),
            rw.Drum("b", at=(200, 0), tension=30e3),
        ]
        spans = s.string(ROPE, *nodes, tension=30e3)
        s.hang(rw.Load("l1", mass=400.0), spans[0], at=60.0)
        s.hang(rw.Load("l2", mass=300.0), spans[1], at=50.0)
        return rw.simulate(s, 50.0, every=10.0, tolerance=1e-10)

    base = hung(5.0)
    of = ["a.rope_tension", "l1.z", "s.travel"]
    frame = rw.sensitivities(base, of=of, to="s.z").xs("s.z", axis=1, level="to")
    model = base.model
    raised = [
        rw.simulate(model, 50.0, every=10.0, tolerance=1e-10, start=rw.equilibrium(model, parameters={"s.z": 5.0 + d}))
        for d in (1e-3, -1e-3)
    ]
    for t in frame.index:
        high, low = (r.at(t) for r in raised)
        for name in of[:2]:
            assert frame.loc[t, name] == pytest.approx((high[name] - low[name]) / 2e-3, rel=1e-5)
    assert frame["s.travel"].iloc[0] == 0.0


def test_a_load_that_is_not_on_the_line_has_no_derivative() -> None:
    base = rw.simulate(line(), 40.0, every=10.0)
    frame = rw.sensitivities(base, of="l1.z", to="s4.z")
    assert np.isfinite(frame.iloc[0, 0])
    assert np.isnan(frame.iloc[-1, 0])


@pytest.mark.parametrize(
    ("of", "to", "error", "words"),
    [
        ("a.tension", "a.tension", rw.InputError, "is a result"),
        ("a.tension", "l9.mass", rw.UnknownNameError, "l9"),
        ("a.tenson", "l1.mass", rw.UnknownNameError, "a.tension"),
        ("a.tension", "b.pretension", rw.UnknownNameError, "a.pretension"),
        ("a.tension", [], rw.InputError, "nothing to derive"),
    ],
)
def test_bad_requests(of: str, to: str, error: type[Exception], words: str) -> None:
    with pytest.raises(error, match=words):
        rw.sensitivities(rw.equilibrium(idlers()), of=of, to=to)


def test_a_system_must_be_solved_first() -> None:
    with pytest.raises(rw.InputError, match=r"solution is a System\. Give an Equilibrium or a Result"):
        rw.sensitivities(idlers(), of="a.tension", to="l1.mass")  # type: ignore[arg-type]


def test_an_emergency_stop_is_rejected() -> None:
    stop = rw.Intervention(time=5.0, action="emergency stop")
    result = rw.simulate(line(), 20.0, interventions=[stop])
    with pytest.raises(rw.InputError, match="emergency stop"):
        rw.sensitivities(result, of="c1.power", to="s3.z")
