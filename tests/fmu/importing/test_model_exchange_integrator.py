"""FMUs for Model Exchange moved by the integrator here: events of state and time."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import ropeway as rw
from ropeway.fmu import CoSimulation, FmuRunError, Slave, load
from support.examples import example_fmu
from support.fmus import example_line
from support.masses import mass_fmu

GRAVITY, BOUNCE, KICK_TIME, KICK = 9.81, 0.8, 1.52, 2.0
BALL = {"x": 1.0, "gravity": GRAVITY, "bounce": BOUNCE, "floor": 0.0, "kick_time": KICK_TIME, "kick": KICK}


def ball(times: np.ndarray) -> np.ndarray:
    """Height and speed of a ball that bounces and is kicked once, by its parabolas."""
    begin, x, v, kicked, rows = 0.0, 1.0, 0.0, False, []
    for t in times:
        while True:
            landing = begin + (v + np.sqrt(v * v + 2.0 * GRAVITY * x)) / GRAVITY
            event = landing if kicked else min(landing, KICK_TIME)
            if event > t:
                break
            d = event - begin
            x, v, begin = x + v * d - GRAVITY * d * d / 2.0, v - GRAVITY * d, event
            if event == landing:
                x, v = 0.0, -BOUNCE * v
            else:
                v, kicked = v + KICK, True
        d = t - begin
        rows.append((x + v * d - GRAVITY * d * d / 2.0, v - GRAVITY * d))
    return np.array(rows)


def run(path: Path, step: float, until: float, start: dict[str, float], kind: str = "ModelExchange") -> pd.DataFrame:
    together = CoSimulation(step)
    together.add("one", path, start=start, kind=kind)  # type: ignore[arg-type]
    return together.run(until)


@pytest.mark.parametrize("step", [0.1, 3.1])
def test_a_ball_bounces_and_is_kicked(mass: Path, step: float) -> None:
    frame = run(mass, step, 3.1, BALL)
    assert np.abs(frame[["one.x", "one.v"]].to_numpy() - ball(frame.index.to_numpy())).max() < 1e-9


def test_without_events_as_in_co_simulation(mass: Path) -> None:
    start = {"x": 1.0, "spring": 4.0, "damper": 0.3}
    by_us, by_it = (run(mass, 0.1, 5.0, start, kind) for kind in ("ModelExchange", "CoSimulation"))
    assert by_us.to_numpy() == pytest.approx(by_it.to_numpy(), abs=1e-8)


def test_an_fmu_for_model_exchange_only(mass: Path, tmp_path: Path) -> None:
    path = mass_fmu(tmp_path / "mass.fmu", co_simulates=False)
    together = CoSimulation(0.1)
    assert together.add("one", path, start=BALL).kinds == ("ModelExchange",)
    assert together.run(3.1).equals(run(mass, 0.1, 3.1, BALL))


@pytest.mark.parametrize("keeps_states", [True, False])
def test_restored_before_an_event(tmp_path: Path, keeps_states: bool) -> None:
    path = mass_fmu(tmp_path / "mass.fmu", keeps_states=keeps_states)
    with Slave(load(path), "ball", "ModelExchange") as slave:
        slave.enter(0.0, BALL)
        slave.leave()
        kept = slave.save()
        slave.step(0.4, {}, {})
        slave.restore(kept)
        assert slave.time == 0.0
        slave.step(2.0, {}, {})
        first = slave.get(["x", "v"])
        assert first == pytest.approx(ball(np.array([2.0]))[0], abs=1e-9)
        if keeps_states:
            slave.restore(kept)
            slave.step(2.0, {}, {})
            assert np.array_equal(slave.get(["x", "v"]), first)
        else:
            with pytest.raises(FmuRunError, match=r"'ball' .* cannot restore t = 0 s, as it .* had an event since"):
                slave.restore(kept)
        slave.forget(kept)


@pytest.mark.parametrize("name", ["line2", "line3", "driven"])
def test_loads_cross_as_in_co_simulation(name: str, request: pytest.FixtureRequest) -> None:
    """Crossings are events of state, the responses of `driven` tick by the clock."""
    path = request.getfixturevalue(name)
    tight = 1e-6 if name == "driven" else 1e-9
    by_us, by_it = (run(path, 0.73, 58.4, {}, kind) for kind in ("ModelExchange", "CoSimulation"))
    columns = [c for c in by_us.columns if "tension_in" in c or "travel" in c]
    scale = by_it[columns].abs().max()
    assert len(columns) > 3
    assert ((by_us[columns] - by_it[columns]).abs().max() / scale).max() < tight


def test_inputs_that_jump(line2: Path) -> None:
    with Slave(load(line2), "line", "ModelExchange") as slave:
        slave.enter(0.0, {})
        slave.leave()
        slave.step(30.0, {"c1.speed": 1.0}, {"c1.speed": 1.0})
        slave.step(30.0, {"c1.speed": 1.01}, {"c1.speed": 1.01})
        jump = rw.Schedule((0.0, 30.0, 30.0 + 1e-6, 60.0), (1.0, 1.0, 1.01, 1.01))
        last = rw.simulate(example_line(), 60.0, inputs={"c1.speed": jump}).frame.iloc[-1]
        names = ["c1.tension_in", "c1.tension_out", "c1.travel"]
        assert slave.get(names) == pytest.approx(last[names].to_numpy(), rel=1e-6)


def test_too_many_loads_in_a_span_are_reported(line2: Path) -> None:
    with Slave(load(line2), "line", "ModelExchange") as slave:
        slave.enter(0.0, {})
        slave.leave()
        far = {"c1.speed": 60.0, "c2.speed": -60.0}
        with pytest.raises(FmuRunError, match=r"'line' \(line2\.fmu\) .* Its log: "):
            slave.step(60.0, far, far)


def van_der_pol(time: float, x: np.ndarray) -> list[float]:
    return [x[1], 1000.0 * (1.0 - x[0] ** 2) * x[1] - x[0]]


def roberts(time: float, y: np.ndarray) -> list[float]:
    slow, back, fast = 0.04 * y[0], 1e4 * y[1] * y[2], 3e7 * y[1] ** 2
    return [back - slow, slow - back - fast, fast]


@pytest.mark.parametrize("step", [5.0, 200.0])
def test_a_stiff_oscillator(tmp_path: Path, step: float) -> None:
    """An explicit method takes a hundred thousand steps: the call limit below is a thousandth of its calls."""
    path, calls = example_fmu(tmp_path, "vanderpol"), 0
    with Slave(load(path), "one", "ModelExchange") as slave:
        slave.enter(0.0, {"mu": 1000.0})
        slave.leave()
        rates = slave._slave._integrator._rates  # type: ignore[union-attr]

        def counted(time: float, states: np.ndarray) -> np.ndarray:
            nonlocal calls
            calls += 1
            return rates(time, states)

        slave._slave._integrator._rates = counted  # type: ignore[union-attr, method-assign]
        for _ in range(round(200.0 / step)):
            slave.step(step, {}, {})
        found = slave.get(["x0", "x1"])
    wanted = solve_ivp(van_der_pol, (0.0, 200.0), [2.0, 0.0], method="LSODA", rtol=1e-11, atol=1e-12).y[:, -1]
    assert found == pytest.approx(wanted, rel=1e-7)
    assert calls < 1500


def test_a_stiff_reaction_with_events(tmp_path: Path) -> None:
    """The third substance passes a level, later the first one."""
    path = example_fmu(tmp_path, "roberts")
    exact = solve_ivp(roberts, (0.0, 40.0), [1.0, 0.0, 0.0], "Radau", rtol=1e-10, atol=1e-13, dense_output=True)
    times = [brentq(lambda t: exact.sol(t)[2] - 0.01, 0.0, 2.0), brentq(lambda t: exact.sol(t)[0] - 0.9, 1.0, 20.0)]
    for step, count in ((40.0, 2), (0.5, 81)):
        frame = run(path, step, 40.0, {})
        assert len(frame) == count
        assert frame[["one.y1", "one.y2", "one.y3"]].iloc[-1].to_numpy() == pytest.approx(exact.y[:, -1], rel=1e-6)
    levels = frame["one.levels"]
    assert [levels[levels >= level].index[0] for level in (2, 3)] == [np.ceil(t / 0.5) * 0.5 for t in times]
    with Slave(load(path), "one", "ModelExchange") as slave:
        slave.enter(0.0, {})
        slave.leave()
        slave.step(times[1] - 1e-5, {}, {})
        assert slave.get(["levels"]) == [2.0]
        slave.step(2e-5, {}, {})
        assert slave.get(["levels"]) == [3.0]


def test_a_ball_that_comes_to_rest(tmp_path: Path) -> None:
    """After eleven bounces its speed is below 0.1 m/s."""
    frame = run(example_fmu(tmp_path, "ball"), 0.3, 3.0, {})
    fall = np.sqrt(2.0 / GRAVITY)
    bounces = fall * (1.0 + 2.0 * np.cumsum([0.0, *0.7 ** np.arange(1, 11)]))
    assert frame["one.bounces"].to_list() == np.searchsorted(bounces, frame.index).tolist()
    assert frame.iloc[-1].to_list() == [0.0, 0.0, 11.0]


def test_a_staircase_ends_the_run(tmp_path: Path) -> None:
    frame = run(example_fmu(tmp_path, "stair"), 0.5, 20.0, {"last": 4.0})
    assert frame["one.counter"].to_list() == [1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 4.0, 4.0, 5.0]
    assert "ends the run at t = 4 s" in frame.attrs["ended"]
