"""Emergency stops: peaks against a chain of springs and masses, limits, tables and pictures."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest
from scipy.integrate import solve_ivp

import ropeway as rw
from support.call_objects import line as small_line

ROPE = rw.Rope(mass_per_length=2.4, axial_stiffness=24.026e6, breaking_load=450e3)


def straight(speed: float) -> rw.System:
    """Two level spans from drum to drum with four loads, under almost no gravity."""
    rows = [("a", 0.0, 0.0, 0.0, "drum"), ("s", 200.0, 0.0, 1e-3, "idler"), ("b", 400.0, 0.0, 0.0, "drum")]
    supports = pd.DataFrame(rows, columns=["name", "x", "y", "z", "kind"])
    return rw.monocable(ROPE, supports, tension=100e3, speed=speed, load_mass=500.0, load_spacing=100.0, gravity=1e-3)


def chain_peak(speed: float, deceleration: float, until: float) -> float:
    """Highest tension of a straight rope with masses whose first end stops, while the other end keeps its tension."""
    line = rw.equilibrium(straight(speed))
    loads = line.loads.merge(pd.DataFrame({"span": ["a_s", "s_b"], "offset": [0.0, line["a_s.length"]]}))
    place = np.sort((loads["distance"] + loads["offset"]).to_numpy())
    length = line["a_s.length"] + line["s_b.length"]
    cuts = np.concatenate([[0.0], place, [length]])
    pieces, rope = np.diff(cuts), ROPE.mass_per_length
    kept = rw.equilibrium(straight(speed))["s_b.tension_b"]
    stiffness, strain = ROPE.axial_stiffness / pieces, kept / ROPE.axial_stiffness
    mass = np.zeros((len(cuts), len(cuts)))
    for i, piece in enumerate(pieces):
        mass[i : i + 2, i : i + 2] += rope * piece * np.array([[2.0, 1.0], [1.0, 2.0]]) / 6.0
    mass[1:-1, 1:-1] += 500.0 * np.eye(len(place))
    stop = speed / deceleration
    own, ahead = mass[1:, 1:], mass[1:, 0]

    def rates(t: float, state: np.ndarray) -> np.ndarray:
        u = np.concatenate([[_driven(t)], state[: len(cuts) - 1]])
        tension = kept + stiffness * np.diff(u)
        force = np.append(tension[1:], kept) - tension
        force -= ahead * (-deceleration * (1.0 + strain) if t < stop else 0.0)
        return np.concatenate([state[len(cuts) - 1 :], np.linalg.solve(own, force)])

    def _driven(t: float) -> float:
        t = min(t, stop)
        return (1.0 + strain) * (speed * t - deceleration * t * t / 2.0)

    moving = np.full(len(cuts) - 1, speed * (1.0 + strain))
    start = np.concatenate([np.zeros(len(cuts) - 1), moving])
    found = solve_ivp(rates, (0.0, until), start, max_step=5e-3, rtol=1e-7, atol=1e-9)
    driven = np.array([_driven(t) for t in found.t])
    tensions = kept + stiffness[:, None] * np.diff(np.vstack([driven, found.y[: len(cuts) - 1]]), axis=0)
    return float(tensions.max())


@pytest.mark.parametrize("compiled", [False, True])
def test_peaks_are_those_of_a_chain_of_masses(compiled: bool) -> None:
    undamped = rw.Inertia(damping=1e-6)
    stops = rw.emergency_stop(straight(1.0), [2.0], settle=1.0, every=0.02, inertia=undamped, compiled=compiled)
    row = stops.frame.iloc[0]
    rise = chain_peak(1.0, 2.0, 1.5) - 100e3
    assert row["highest_tension"] - 100e3 == pytest.approx(rise, rel=0.02)
    assert row["dynamic_factor"] == pytest.approx(1.0 + rise / 100e3, rel=2e-3)
    assert row["stopping_distance"] == pytest.approx(0.25, rel=1e-3)


def test_table_and_picture() -> None:
    stops = rw.emergency_stop(small_line(), [4.0, 0.2], settle=2.0)
    frame = stops.frame
    assert frame.index.tolist() == [0.2, 4.0]
    assert frame["stopping_time"].tolist() == pytest.approx([4.0, 0.2])
    assert frame["stopping_distance"].to_numpy() == pytest.approx(0.8**2 / 2.0 / frame.index.to_numpy(), rel=1e-3)
    assert frame["highest_tension"].is_monotonic_increasing
    assert frame["swing"].is_monotonic_increasing
    # The softer the stop, the nearer to equilibrium.
    assert 1.0 < frame["dynamic_factor"].iloc[0] < 1.05
    assert frame["share_of_SWL"].to_numpy() == pytest.approx(frame["highest_tension"] / 150e3)
    assert not frame["slack"].any()
    hard = stops.results[1]
    factors, summary = hard.dynamic_factor(), hard.summary()
    assert factors.loc["a_c", "kind"] == "rope"
    assert summary.spans["dynamic_factor"].max() == pytest.approx(frame["dynamic_factor"].iloc[1])
    assert "Largest dynamic factor" in str(summary)
    assert "peaks between them" not in str(summary)
    assert (hard.swing()["swing"] >= 0.0).all()
    assert "deceleration [m/s2]" in stops._repr_html_()
    figure = stops.plot()
    assert len(figure.axes) == 4
    plt.close(figure)


def test_no_tension_is_quoted_after_a_slack_rope() -> None:
    s = rw.System("drop", terrain=rw.Profile([-10.0, 250.0], [-20.0, -20.0]))
    (span,) = s.string(ROPE, rw.Anchor("a", at=(0.0, 0.0)), rw.Anchor("b", at=(240.0, 0.0)), length=240.55)
    s.hang(rw.Load("hook", 100.0), span, at=120.275)
    s.hang(rw.Load("turn", 2500.0), span, at=120.275)
    lost = rw.Intervention(0.5, "load lost", "turn")
    result = rw.simulate(s, until=4.0, every=0.05, inertia=rw.Inertia(nodes=6), interventions=[lost])
    slack = result.events[result.events["event"] == "slack rope"]
    assert len(slack)
    assert result.slack_time == slack["time"].iloc[0]
    assert result.dynamic_factor()["at"].max() <= result.slack_time
    text = str(result.summary())
    assert f"goes slack at {result.slack_time:.2f} s" in text
    assert result.summary().spans["at"].max() <= result.slack_time


def test_a_turn_swings_beyond_its_limit() -> None:
    """The mainline of a carriage stops: its turn swings on."""
    s = rw.System("skyline")
    carriage = rw.Carriage("carriage", at=(90.0, -38.0), mass=4000.0, swing=0.1)
    turn = rw.Joint("turn", at=(90.0, -48.0), mass=300.0)
    drum = rw.Drum("drum", at=(0.0, 0.0), speed=rw.Schedule([0.0, 9.0, 10.0, 10.1, 20.0], [0.0, 1.5, 1.5, 0.0, 0.0]))
    s.string(ROPE, rw.Anchor("a", at=(0.0, 0.0)), carriage, rw.Anchor("b", at=(200.0, -60.0)), length=210.5)
    s.string(ROPE, carriage.dropline, turn, length=10.0)
    s.string(ROPE, drum, carriage.mainline, length=95.0)
    start = rw.equilibrium(s)
    result = rw.simulate(s, 12.0, every=0.1, start=start, inertia=rw.Inertia())
    swings = result.events[result.events["event"] == "swing beyond limit"]
    assert swings["component"].iloc[0] == "carriage"
    assert swings["value"].iloc[0] > 0.1
    angle = result.full_frame["carriage.dropline_angle"]
    assert angle.loc[:9.5].max() < 0.1
    # As far as the energy of its speed lifts it, and not twice as far: the mainline lets the carriage rebound a little.
    rigid = 1.5 / np.sqrt(9.80665 * 10.0)
    assert rigid < angle.max() < 1.8 * rigid
    assert result.swing().empty  # no load hangs on a rope


def test_rejected_stops() -> None:
    for wrong in ([], [0.0], [-1.0], [float("nan")]):
        with pytest.raises(rw.InputError, match="deceleration"):
            rw.emergency_stop(small_line(), wrong)
    still = straight(0.0)
    with pytest.raises(rw.InputError, match="No drive moves"):
        rw.emergency_stop(still)
    with pytest.raises(rw.InputError, match="without inertia"):
        rw.simulate(small_line(), 1.0).dynamic_factor()
