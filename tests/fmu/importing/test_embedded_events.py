"""FMUs with state and time events as components: inside one run, with a line that they drive."""

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import ropeway as rw
from ropeway.components.external_events import ExternalPoint
from ropeway.fmu import FmuImportError, component
from support.examples import example_fmu
from support.fmus import short_line, with_units

GRAVITY, E = 9.81, 0.7


def alone(path: Path, **parameters: float) -> rw.System:
    s = rw.System("alone")
    s.add(component("c", path, parameters=parameters))
    return s


def test_a_bouncing_ball(tmp_path: Path) -> None:
    """Bounces at the times of the closed form; between them parabolas."""
    result = rw.simulate(alone(example_fmu(tmp_path, "ball"), e=E), 1.3, every=0.1, tolerance=1e-9)
    fall = np.sqrt(2.0 / GRAVITY)
    bounces = fall * np.array([1.0, 1.0 + 2.0 * E])
    assert result.events["time"].to_numpy() == pytest.approx(bounces, abs=1e-7)
    assert result.events["component"].tolist() == ["c", "c"]
    up = GRAVITY * fall * E ** np.arange(1, 3)  # speeds after each bounce
    for t, h, n in zip(result.frame.index, result.frame["c.h"], result.frame["c.bounces"], strict=True):
        k = int(np.searchsorted(bounces, t + 1e-9)) - 1
        if np.abs(bounces - t).min() > 1e-6:
            since = t - bounces[k] if k >= 0 else t
            exact = up[k] * since - GRAVITY * since**2 / 2.0 if k >= 0 else 1.0 - GRAVITY * t * t / 2.0
            assert h == pytest.approx(exact, abs=3e-7)
            assert n == k + 1


def test_a_staircase_drives_a_line_until_it_ends(tmp_path: Path) -> None:
    """The speed of a sheave rises at time events; loads cross in between; the FMU ends the run."""
    path = with_units(example_fmu(tmp_path, "stair"), tmp_path / "speed.fmu", {"counter": "m/s"})
    line = short_line()
    stair = line.add(component("stair", path, parameters={"width": 10.0, "last": 3.0}))
    line.connect(stair.output("counter"), line.components["c1"].input("speed"))
    result = rw.simulate(line, 60.0, every=2.0)
    assert result.frame.index[-1] == 30.0
    assert result.events.iloc[-1][["time", "component", "event"]].tolist() == [30.0, "stair", "end of the run"]
    assert result.frame["c1.travel"].iloc[-1] == pytest.approx(10.0 * (1 + 2 + 3), rel=1e-9)
    steps = rw.Schedule((0.0, 10.0, 10.0 + 1e-6, 20.0, 20.0 + 1e-6, 30.0), (1.0, 1.0, 2.0, 2.0, 3.0, 3.0))
    alike = rw.simulate(short_line(), 30.0, every=2.0, inputs={"c1.speed": steps})
    own = result.events[result.events["component"] != "stair"]
    assert len(own) > 5
    assert own["time"].to_numpy() == pytest.approx(alike.events["time"].to_numpy(), abs=1e-5)
    assert result.frame["c1.tension_in"].iloc[3] == pytest.approx(alike.frame["c1.tension_in"].iloc[3], rel=1e-6)
    again = rw.simulate(line, 60.0, every=2.0)
    assert np.array_equal(again.frame["c1.tension_in"], result.frame["c1.tension_in"])


def roberts(time: float, y: np.ndarray) -> list[float]:
    slow, back, fast = 0.04 * y[0], 1e4 * y[1] * y[2], 3e7 * y[1] ** 2
    return [back - slow, slow - back - fast, fast]


def test_a_stiff_reaction(tmp_path: Path) -> None:
    exact = solve_ivp(roberts, (0.0, 6.0), [1.0, 0.0, 0.0], "Radau", rtol=1e-10, atol=1e-13, dense_output=True)
    times = [brentq(lambda t: exact.sol(t)[2] - 0.01, 0.0, 2.0), brentq(lambda t: exact.sol(t)[0] - 0.9, 1.0, 6.0)]
    result = rw.simulate(alone(example_fmu(tmp_path, "roberts")), 6.0, every=2.0, tolerance=1e-8)
    assert result.events["time"].to_numpy() == pytest.approx(times, rel=1e-5)
    assert result.frame.iloc[-1][["c.y1", "c.y2", "c.y3"]].to_numpy() == pytest.approx(exact.y[:, -1], rel=1e-5)
    assert result.frame["c.levels"].tolist() == [0.0, 2.0, 2.0, 3.0]


def test_events_may_be_ignored(tmp_path: Path) -> None:
    s = rw.System("falls")
    s.add(component("c", example_fmu(tmp_path, "ball"), ignore_events=True))
    result = rw.simulate(s, 1.0, every=0.5)
    assert result.frame["c.h"].iloc[-1] == pytest.approx(1.0 - GRAVITY / 2.0, abs=1e-6)
    assert result.events.empty


def test_an_fmu_that_cannot_save_its_state(tmp_path: Path) -> None:
    path = example_fmu(tmp_path, "ball", keeps_states=False)
    with pytest.raises(FmuImportError, match=r"ball\.fmu has events and cannot save its state") as error:
        component("c", path)
    assert "CoSimulation" in error.value.remedy


def test_derivatives_of_an_fmu_with_events(tmp_path: Path) -> None:
    """Central differences, in each mode."""
    c = component("c", example_fmu(tmp_path, "roberts"))
    y = np.array([0.9, 1e-5, 0.1])
    found = c.function.jacobian()(0.0, y, [], [], 0, 0, 0)
    assert c.external_events is not None
    assert c.external_events.margin(ExternalPoint(0.0, y, np.zeros(0), 0)) < 0.0
    exact = [[-0.04, 1e4 * y[2], 1e4 * y[1]], [0.04, -1e4 * y[2] - 6e7 * y[1], -1e4 * y[1]], [0.0, 6e7 * y[1], 0.0]]
    assert found[1].full() == pytest.approx(np.array(exact), rel=1e-6, abs=1e-7)
