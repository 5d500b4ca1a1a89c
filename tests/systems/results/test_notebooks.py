"""Output in notebooks: tables and figures of systems, rigs, profiles, results and studies; animations."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import ropeway as rw
from support import call_objects as objects


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (objects.line, ("ControlSheave", "mono-cable line", "90, 0, 12")),
        (objects.rest, ("Equilibrium", "a.rope_tension")),
        (objects.run, ("Result", "time [s]", "9 of 34 columns")),
        (objects.rig, ("SkylineRig", "IntermediateSupport", "125")),
        (lambda: rw.payload(objects.rig(), stations=[70.0]), ("PayloadStudy", "payload [kg]", "skyline tension")),
        (objects.plan, ("SchedulePlan", "d.speed [m/s]")),
    ],
)
def test_objects_show_a_table(make: object, words: tuple[str, ...]) -> None:
    text = make()._repr_html_()  # type: ignore[operator]
    for word in words:
        assert word in text
    assert "&lt;" in text  # of the angle brackets of a name


def test_figures_have_a_png_representation() -> None:
    ground = objects.GROUND
    for figure in (ground.plot(), objects.rig().plot(), objects.rig().plot(view="3d"), objects.line().plot("3d"),
                   objects.line().plot(), objects.run().plot()):  # fmt: skip
        assert figure._repr_png_().startswith(b"\x89PNG")  # type: ignore[attr-defined]
    (line,) = [p for p in ground.plot().axes[0].get_lines() if len(p.get_xdata()) == len(ground.station)]
    assert np.array_equal(line.get_ydata(), ground.elevation)
    bare = next(p for p in objects.rig().plot().axes[0].get_lines() if p.get_label() == "bare skyline")
    head = objects.rig().headspar.at
    assert (bare.get_xdata()[0], bare.get_ydata()[0]) == pytest.approx((head[0], head[2]), abs=1e-6)
    with pytest.raises(rw.InputError, match="Choose"):
        objects.rig().plot(view="plan")
    with pytest.raises(rw.InputError, match="String a rope"):
        rw.System("empty").plot()


def test_names_with_dollars_are_no_formulas(tmp_path: Path) -> None:
    span, case = objects.one_span(), rw.Environment("$\\frac storm$ at 5$")
    figure = rw.load_cases(span, [case]).plot()
    axis = figure.axes[-1]
    axis.set_xticks([0.0], ["$not a formula"])  # its label is made when the figure is drawn
    figure.savefig(tmp_path / "cases.svg")
    assert "$\\frac storm$ at 5$" in figure.axes[0].get_legend().get_texts()[0].get_text()
    assert not figure.axes[0].title.get_parse_math()


def test_animation_of_a_run_as_gif_and_page(tmp_path: Path) -> None:
    with Image.open(objects.run().animate(tmp_path / "run.gif", frames=4)) as picture:
        assert picture.n_frames == 4
    assert "data-player" in objects.run().animate(tmp_path / "run.html").read_text()
    with pytest.raises(rw.InputError, match=r"gif, .mp4 or .html"):
        objects.run().animate(tmp_path / "run.avi")
