"""Figures of a line: curves, limits, names and scales."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
import pandas as pd
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import ropeway as rw
from ropeway.components.errors import RopewayWarning
from ropeway.components.rounding import at_least, at_most
from ropeway.systems.results.limit_lines import LimitLine, draw_limits

STRONG, WEAK = 640e3, 60e3
TURN = math.radians(37.0)


def supports(*, map_coordinates: bool) -> pd.DataFrame:
    """Zig-zag supports along x, or the same rotated and shifted to map coordinates."""
    rows = [
        ("low", 0.0, 0.0, 12.0, "drum"),
        ("post1", 95.0, 6.0, 20.0, "idler"),
        ("pull1", 190.0, 0.0, 26.0, "control"),
        ("post2", 280.0, -4.0, 31.0, "idler"),
        ("pull2", 385.0, 0.0, 33.0, "control"),
        ("high", 470.0, 0.0, 41.0, "drum"),
    ]
    table = pd.DataFrame(rows, columns=["name", "x", "y", "z", "kind"])
    if map_coordinates:
        turned = table["x"] + 1j * table["y"]
        turned = turned * np.exp(1j * TURN) + 2712345.0 + 1183456.0j
        table["x"], table["y"] = np.real(turned), np.imag(turned)
    return table


def run(breaking_load: float, *, map_coordinates: bool = False) -> rw.Result:
    rope = rw.Rope(mass_per_length=2.9, axial_stiffness=29e6, breaking_load=breaking_load, safety_factor=4.0)
    line = rw.monocable(
        rope,
        supports(map_coordinates=map_coordinates),
        tension=38e3,
        load_mass=(180.0, 260.0),
        load_spacing=31.0,
    )
    return rw.simulate(line, 12.0)


@pytest.fixture(scope="module")
def strong() -> rw.Result:
    return run(STRONG)


@pytest.fixture(scope="module")
def weak() -> rw.Result:
    with pytest.warns(RopewayWarning, match="times the rope's minimum breaking load"):
        return run(WEAK)


def labels(axis: Axes) -> list[str]:
    legend = axis.get_legend()
    return [] if legend is None else [text.get_text() for text in legend.get_texts()]


def curves(axis: Axes) -> dict[str, np.ndarray]:
    """Values of the named curves."""
    return {str(line.get_label()): np.asarray(line.get_ydata(), dtype=float) for line in axis.lines}


def names(axis: Axes) -> set[str]:
    return {text.get_text() for text in axis.texts}


def all_legends_are_drawn(axes: Sequence[Axes]) -> None:
    """Each entry of a legend belongs to a visible curve of its panel, or names limits that are not drawn."""
    for axis in axes:
        low, high = axis.get_ylim()
        for label, values in curves(axis).items():
            if label in labels(axis) and not label.startswith("not drawn"):
                shown = values[np.isfinite(values)]
                assert len(shown)
                assert ((shown >= low) & (shown <= high)).any(), label


def test_tensions_fill_their_panel_when_limits_are_far(strong: rw.Result) -> None:
    figure = strong.plot()
    top = figure.axes[0]
    ends = strong.full_frame.filter(regex=r"\.tension_[ab]$").to_numpy() / 1e3
    low, high = top.get_ylim()
    assert low == 0.0
    assert ends.max() <= high < 1.1 * ends.max()
    shown = curves(top)
    assert shown["highest of all spans"] == pytest.approx(ends.max(axis=1))
    assert shown["lowest of all spans"] == pytest.approx(ends.min(axis=1))
    assert "not drawn: SWL (MBL / 4) 160.0 kN, MBL 640.0 kN" in labels(top)
    all_legends_are_drawn(figure.axes)


def test_tensions_above_the_limits_are_in_the_panel_and_reported(weak: rw.Result) -> None:
    figure = weak.plot()
    top = figure.axes[0]
    highest = weak.full_frame.filter(regex=r"\.tension_[ab]$").max(axis=None)
    assert highest > WEAK
    assert top.get_ylim()[1] > highest / 1e3
    shown = curves(top)
    assert shown["SWL (MBL / 4) 15.0 kN"] == pytest.approx([15.0, 15.0])
    assert shown["MBL 60.0 kN"] == pytest.approx([60.0, 60.0])
    assert names(top) == {f"{at_least(highest / 1e3, 1)} kN: above MBL 60.0 kN"}
    all_legends_are_drawn(figure.axes)


def test_a_tension_beyond_all_limits_is_never_off_the_panel() -> None:
    axis = Figure().subplots()
    axis.plot([0.0, 1.0], [300.0, 905.0], label="rope")
    draw_limits(axis, [(905e3, [LimitLine(140e3, "SWL"), LimitLine(420e3, "MBL", style="-")])])
    assert axis.get_ylim()[1] > 905.0
    assert names(axis) == {"905.0 kN: above MBL 420.0 kN"}


def test_a_tension_at_its_limit_is_not_above_it() -> None:
    axis = Figure().subplots()
    draw_limits(axis, [(140e3 * (1.0 + 1e-9), [LimitLine(140e3, "SWL")])])
    assert names(axis) == set()


@pytest.mark.parametrize("map_coordinates", [False, True])
def test_the_plan_is_the_distance_sideways_whatever_the_coordinates(map_coordinates: bool) -> None:
    figure = run(STRONG, map_coordinates=map_coordinates).plot_line(6.0)
    plan = figure.axes[2]
    places = {
        round(float(line.get_xdata()[0])): float(line.get_ydata()[0])
        for line in plan.lines
        if line.get_marker() not in ("", "None")
    }
    along = np.cumsum([0.0, *np.hypot([95.0, 95.0, 90.0, 105.0, 85.0], [6.0, -6.0, -4.0, 4.0, 0.0])])
    assert list(places) == [round(x) for x in along]
    assert list(places.values()) == pytest.approx([0.0, 6.0, 0.0, -4.0, 0.0, 0.0], abs=1e-6)
    low, high = plan.get_ylim()
    assert -6.0 < low < -4.0
    assert 6.0 < high < 8.0


def test_a_straight_line_has_no_plan() -> None:
    table = supports(map_coordinates=False).assign(y=0.0)
    rope = rw.Rope(mass_per_length=2.9, axial_stiffness=29e6, breaking_load=STRONG)
    line = rw.monocable(rope, table, tension=38e3)
    assert len(rw.simulate(line, 1.0).plot_line().axes) == 2


def test_all_supports_have_names_and_loads_do_not_hide_the_rope(strong: rw.Result) -> None:
    figure = strong.plot_line(6.0)
    elevation = figure.axes[0]
    assert {"low", "post1", "pull1", "post2", "pull2", "high"} <= names(elevation)
    (loads,) = elevation.collections
    rope = next(line for line in elevation.lines if len(line.get_xdata()) > 10)
    assert loads.get_zorder() < rope.get_zorder()
    assert math.sqrt(float(loads.get_sizes().max())) < 7.0  # points, where the rope's line has 1.4
    count = int((strong.at(6.0).loads["mass"] > 0.0).sum())
    assert f"{count} loads, 180 to 260 kg" in labels(elevation)


def test_supports_reach_a_known_ground_only(strong: rw.Result) -> None:
    def posts(figure: Figure) -> list[tuple[float, float]]:
        upright = [line for line in figure.axes[0].lines if np.ptp(line.get_xdata()) == 0.0]
        return [tuple(line.get_ydata()) for line in upright if line.get_color() == "tab:brown"]

    assert posts(strong.plot_line(6.0)) == []
    ground = rw.Profile((-5.0, 200.0, 480.0), (3.0, 15.0, 30.0))
    figure = strong.plot_line(6.0, ground=ground)
    found = posts(figure)
    assert found[0] == pytest.approx((ground.elevation_at(0.0), 12.0))
    assert len(found) == 6
    assert "ground" in labels(figure.axes[0])
    with pytest.raises(rw.InputError, match="outside the profile"):
        strong.plot_line(6.0, ground=rw.Profile((0.0, 300.0), (3.0, 4.0)))


def test_the_tension_panel_of_a_line_has_the_limits(weak: rw.Result, strong: rw.Result) -> None:
    for result, drawn in ((weak, True), (strong, False)):
        axis = result.plot_line(6.0).axes[1]
        assert any(label.startswith("SWL") for label in curves(axis)) == drawn
        top = max(float(values.max()) for values in curves(axis).values() if len(values) > 10)
        assert axis.get_ylim()[1] > top


def test_powers_have_one_style_in_legend_and_plot_and_energies_are_in_kilowatt_hours(strong: rw.Result) -> None:
    figure = strong.plot_power()
    over_time, energies = figure.axes
    table = strong.power()
    total = next(line for line in over_time.lines if line.get_label() == "all drives")
    assert total.get_linestyle() == "-"
    power = strong.full_frame[["pull1.power", "pull2.power"]].sum(axis=1)
    assert total.get_ydata() == pytest.approx(power.to_numpy() / 1e3)
    assert "kWh" in energies.get_xlabel()
    widths = sorted(bar.get_width() for bar in energies.patches)
    expected = [
        *(table.loc[["pull1", "pull2"], "pulled"] / 3.6e6),
        *(-table.loc[["pull1", "pull2"], "recovered"] / 3.6e6),
    ]
    assert widths == pytest.approx(sorted(expected))


@pytest.fixture(scope="module")
def corridor() -> Callable[..., rw.SkylineRig]:
    ground = rw.Profile(
        (0.0, 40.0, 90.0, 150.0, 200.0, 240.0, 300.0), (520.0, 512.0, 497.0, 486.0, 482.0, 476.0, 455.0)
    )

    def rig(depth: float = 2.0) -> rw.SkylineRig:
        main = rw.Rope(mass_per_length=0.9, axial_stiffness=9e6, breaking_load=150e3)
        return rw.standing_skyline(
            ground,
            headspar=rw.HeadSpar("yarder", station=0.0, height=13.0),
            supports=[rw.IntermediateSupport("saddle", station=200.0, height=10.0)],
            tailspar=rw.TailSpar("beech", station=300.0, height=9.0),
            skyline=rw.Rope(mass_per_length=2.6, axial_stiffness=27e6, breaking_load=430e3),
            tension=62e3,
            mainline=main,
            haulback=main,
            haulback_tension=6e3,
            carriage=rw.Carriage("car", mass=380.0, depth=depth),
        )

    return rig


def test_a_payload_figure_states_its_assumptions(corridor: Callable[..., rw.SkylineRig]) -> None:
    study = rw.payload(corridor(), safety_factor=2.5, clearance=0.5, stations=np.arange(10.0, 300.0, 20.0))
    figure = study.plot()
    top, payloads, tensions = figure.axes
    title, given = figure.get_suptitle(), top.get_title()
    assert f"{math.floor(study.payload)} kg" in title
    assert study.limiting["limited_by"] in title
    for words in ("2.6 kg/m", "430.0 kN", "pretension 62 kN", "safety factor 2.5", "clearance 0.5 m", "380 kg"):
        assert words in given
    low, high = payloads.get_ylim()
    for limit in study.frame["limited_by"].unique():
        own = [line for line in payloads.lines if line.get_label() == f"limited by {limit}"]
        assert own
        assert all(low <= y <= high for line in own for y in line.get_ydata())
    drawn = sum(len(line.get_xdata()) for line in payloads.lines if line.get_linestyle() == "None")
    assert drawn == len(study.frame)
    assert f"SWL skyline (MBL / 2.5) {at_most(172.0, 1)} kN" in labels(tensions)
    all_legends_are_drawn([payloads, tensions])


def test_stations_without_a_payload_interrupt_the_curve(corridor: Callable[..., rw.SkylineRig]) -> None:
    study = rw.payload(corridor(depth=11.0), clearance=1.0, stations=np.arange(10.0, 300.0, 20.0))
    without_payload = (study.frame["payload"] == 0.0).to_numpy()
    assert without_payload.any()
    assert not without_payload.all()
    axis = study.plot().axes[1]
    curve = axis.lines[0].get_ydata()
    assert np.isnan(curve[without_payload]).all()
    crosses = [x for line in axis.lines if line.get_marker() == "x" for x in line.get_xdata()]
    assert sorted(crosses) == pytest.approx(study.frame["station"][without_payload])
    assert "no payload" in study.plot().get_suptitle()


def test_an_inhaul_has_safe_working_loads_and_legends_off_its_curves(corridor: Callable[..., rw.SkylineRig]) -> None:
    figure = rw.inhaul(corridor(), payload=900.0, start=180.0, end=60.0, every=2.0).plot()
    tensions = figure.axes[1]
    assert any(label.startswith("SWL skyline (MBL / 3) 143.3 kN") for label in labels(tensions))
    figure.draw_without_rendering()
    for axis in figure.axes[1:]:
        assert axis.get_legend().get_window_extent().y0 >= axis.get_window_extent().y1 - 2.0
    all_legends_are_drawn(figure.axes)
