"""Reports: their numbers are those of the frames, limits are on the safe side, words and units can be replaced."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import ropeway as rw
from ropeway.systems.reporting import browser as printing
from ropeway.systems.reporting.blocks import Section, Text
from support import call_objects as objects, maps
from support.pages import Page


@pytest.fixture(scope="module")
def study() -> rw.PayloadStudy:
    return rw.payload(objects.rig(), stations=[30.0, 70.0, 150.0, 200.0], clearance=0.5)


@pytest.fixture(scope="module")
def page(study: rw.PayloadStudy, tmp_path_factory: pytest.TempPathFactory) -> Page:
    project = rw.Project(title="Slope <7>", place="Bärental", client="A & B", author="N. N.", remark="first draft")
    return Page(study.report(tmp_path_factory.mktemp("report") / "study.html", project=project))


def test_a_payload_report_has_the_numbers_of_the_frame(page: Page, study: rw.PayloadStudy) -> None:
    rows = page.rows("Table of stations")
    assert len(rows) == len(study.frame)
    for row, (_, own) in zip(rows, study.frame.iterrows(), strict=True):
        assert float(row["Station [m]"]) == own["station"]
        assert 0.0 <= own["payload"] - float(row["Payload [kg]"]) < 1.0
        assert row["Limited by"] == own["limited_by"]
        assert -0.1 < own["highest_tension"] / 1e3 - float(row["skyline [kN]"]) <= 1e-6
        assert 0.0 <= own["clearance"] - float(row["Clearance [m]"]) < 0.1
    worst = study.limiting
    (headline,) = page.paragraphs["Payload"]
    assert f"{int(study.payload)} kg, limited at station {worst['station']:.1f} m by {worst['limited_by']}" in headline


def test_it_says_what_was_asked_and_for_whom(page: Page, study: rw.PayloadStudy) -> None:
    about = {row[0]: row[1] for row in page.tables["Project"][0]}
    assert about["Title"] == "Slope <7>"
    assert about["Client"] == "A & B"
    assert about["Made with"] == f"ropeway {rw.__version__}"
    assert pd.Timestamp(about["Date"]).year >= 2025
    ropes = {row["Use"]: row for row in page.rows("Inputs", 1)}
    assert set(ropes) == {"skyline", "mainline"}
    assert float(ropes["skyline"]["Safe working load (SWL) [kN]"]) == 150.0
    inputs = {row["Quantity"]: row["Value"] for row in page.rows("Inputs")}
    assert inputs["Tension of the bare rope at the headspar"] == "60.0 kN"
    assert inputs["Clearance asked of the load"] == "0.5 m"


def test_supports_anchors_and_set_up(page: Page, study: rw.PayloadStudy) -> None:
    rig, frame = study.rig, study.frame
    supports = {row["Support"]: row for row in page.rows("Supports")}
    assert list(supports) == ["head", "jack", "tail"]
    jack = supports["jack"]
    assert (jack["Height [m]"], jack["Saddle"]) == ("8.0", "point saddle")
    assert (
        float(jack["Highest force [kN]"]) >= frame["jack_force"].max() / 1e3 > float(jack["Highest force [kN]"]) - 0.1
    )
    angles = np.degrees(frame["jack_break_angle"])
    assert float(jack["Least break angle [°]"]) == pytest.approx(angles.min() - 0.05, abs=0.0501)
    assert float(jack["Largest break angle [°]"]) == pytest.approx(angles.max() + 0.05, abs=0.0501)
    anchors = {row["Anchor"]: row for row in page.rows("Anchors")}
    assert float(anchors["tail"]["Highest tension [kN]"]) >= frame["tailspar_tension"].max() / 1e3
    lengths = {row["Quantity"]: row["Value"] for row in page.rows("Rope lengths and set-up")}
    assert lengths["Unstretched length"] == f"{rig.length:.2f} m"
    assert lengths["Tension of the bare rope"] == "60.0 kN"


def test_the_player_moves_the_carriage_where_the_frame_says(page: Page, study: rw.PayloadStudy) -> None:
    assert page.player["frames"] == [f"Station {x:.1f} m" for x in study.frame["station"]]
    for i, (_, row) in enumerate(study.frame.iterrows()):
        x, z = page.moving(-1, i)
        assert (x[0], z[0]) == pytest.approx((row["carriage_x"], row["carriage_z"]), abs=1e-3)
        sky_x, sky_z = page.moving(0, i)
        at = np.isclose(sky_x, row["carriage_x"], atol=1e-3)
        assert sky_z[at] == pytest.approx(row["carriage_z"], abs=1e-3)
    beside = dict(page.player["values"])
    assert beside["Payload"] == [f"{int(p)} kg" for p in study.frame["payload"]]
    assert page.player["start"] == int(study.frame["payload"].argmin())
    assert page.charts["tensions"]["layout"]["shapes"][0]["type"] == "line"


def test_it_needs_nothing_from_elsewhere(page: Page) -> None:
    assert all(source.startswith(("data:", "#")) for source in page.sources)


def test_imperial_units_other_words_and_more_sections(study: rw.PayloadStudy, tmp_path: Path) -> None:
    words = {"payload": "Nutzlast", "stations": "Stationen", "limited_by": "Begrenzt durch"}
    more = [Section("Weather", (Text(("Calm.",)),))]
    page = Page(study.report(tmp_path / "a.html", units="imperial", labels=words, more=more))
    rows = page.rows("Stationen")
    for row, (_, own) in zip(rows, study.frame.iterrows(), strict=True):
        assert 0.0 <= own["payload"] / rw.units.POUND - float(row["Nutzlast [lb]"]) < 1.0
        assert float(row["skyline [kip]"]) >= own["highest_tension"] / rw.units.KIP
        assert row["Begrenzt durch"] == own["limited_by"]
    assert page.paragraphs["Weather"] == ["Calm."]
    with pytest.raises(rw.UnknownNameError, match="no label 'paylod'"):
        study.report(tmp_path / "b.html", labels={"paylod": "Nutzlast"})
    with pytest.raises(rw.InputError, match="units"):
        study.report(tmp_path / "b.html", units="nautical")  # type: ignore[arg-type]


def test_the_report_of_a_run(tmp_path: Path) -> None:
    result = objects.run()
    page = Page(result.report(tmp_path / "run.html"))
    summary = result.summary()
    spans = {row["Span"]: row for row in page.rows("Spans")}
    for name, own in summary.spans.iterrows():
        shown = float(spans[str(name)]["Highest tension [kN]"])
        assert shown - 0.1 < own["highest_tension"] / 1e3 <= shown + 1e-9
    assert page.player["frames"][-1] == "Time 4.0 s"
    line = result.at(4.0)
    x, z = page.moving(1, -2 + len(page.player["frames"]) + 1)
    assert z == pytest.approx(line.loads["z"].to_numpy(), abs=1e-3)
    assert x == pytest.approx(line.loads["x"].to_numpy(), abs=1e-3)
    counted = {row["Event"]: int(row["Count"]) for row in page.rows("Events")}
    assert counted == result.events["event"].value_counts().to_dict()
    legs = page.rows("Staking out")
    assert [float(leg["Horizontal distance [m]"]) for leg in legs] == [90.0, 95.0]
    assert float(legs[0]["Slope distance [m]"]) == pytest.approx(np.hypot(90.0, 4.0), abs=0.005)


def test_reports_of_load_path_inhaul_schedule_and_fmus(tmp_path: Path) -> None:
    rig = objects.rig()
    frame = rw.load_path(rig, 900.0, stations=[60.0, 150.0])
    page = Page(rw.load_path_report(rig, 900.0, frame, tmp_path / "path.html"))
    assert [float(row["Station [m]"]) for row in page.rows("Load path")] == [60.0, 150.0]
    assert page.moving(-1, 1)[1][0] == pytest.approx(frame["carriage_z"].iloc[1], abs=1e-3)
    run = rw.inhaul(rig, payload=900.0, start=50.0, end=40.0, every=1.0)
    page = Page(run.report(tmp_path / "inhaul.html"))
    assert page.player["frames"][0] == "Time 0.0 s"
    assert dict(page.player["values"])["Station"][0] == "50.0 m"
    plan = objects.plan()
    page = Page(plan.report(tmp_path / "plan.html"))
    speeds = page.rows("Speeds over time")
    assert [float(row["d [m/s]"]) for row in speeds] == pytest.approx(plan.schedules["d"].speeds, abs=1e-3)
    assert page.rows("Objectives")[0]["optimised"].endswith(" kN")
    outputs = pd.DataFrame({"a.x": [0.0, 1.0, 4.0], "a.n": [1, 2, 3]}, index=pd.Index([0.0, 0.5, 1.0], name="time"))
    outputs.attrs["units"] = {"a.x": "m", "a.n": "1"}
    page = Page(rw.fmu.run_report(outputs, tmp_path / "fmu.html"))
    assert page.rows("Outputs")[0] == {
        "Output": "a.x", "Unit": "m", "First": "0", "Last": "4", "Lowest": "0", "Highest": "4",
    }  # fmt: skip


def test_limits_that_are_exceeded_are_warnings(tmp_path: Path) -> None:
    frame = rw.load_path(objects.rig(), 9000.0, stations=[70.0])
    page = Page(rw.load_path_report(objects.rig(), 9000.0, frame, tmp_path / "path.html"))
    assert any(
        "skyline: the highest tension" in text and "safe working load" in text for text in page.paragraphs["Warnings"]
    )


def test_what_is_missing_is_named(study: rw.PayloadStudy, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(rw.InputError, match=r"end with .html or .pdf"):
        study.report(tmp_path / "report.docx")
    with pytest.raises(rw.InputError, match="not a load path"):
        rw.load_path_report(objects.rig(), 900.0, study.frame[["station"]], tmp_path / "x.html")
    monkeypatch.setattr(printing, "_browsers", lambda: iter(()))
    with pytest.raises(rw.InputError, match="Install Chromium, Chrome or Edge"):
        study.report(tmp_path / "report.pdf")
    monkeypatch.setitem(sys.modules, "jinja2", None)
    with pytest.raises(rw.InputError, match=r"pip install ropeway\[report\]"):
        study.report(tmp_path / "report.html")
    assert list(tmp_path.iterdir()) == []


def test_a_rig_on_a_map_is_staked_out_by_its_coordinates(tmp_path: Path) -> None:
    rig = maps.rig()
    page = Page(rw.load_path_report(rig, 1200.0, maps.path(), tmp_path / "path.html"))
    shown = {row["Name"]: row for row in page.rows("Staking out")}
    for _, own in rw.places(rig).iterrows():
        row = shown[own["label"]]
        assert (float(row["Easting"]), float(row["Northing"])) == pytest.approx(
            (own["easting"], own["northing"]), abs=0.006
        )
        if not pd.isna(own["azimuth"]):
            assert float(row["Azimuth [°]"]) == pytest.approx(own["azimuth"], abs=0.006)
    assert page.charts["map"]["data"][1]["x"] == pytest.approx(rw.places(rig)["easting"].tolist(), abs=0.5)
    result = rw.simulate(maps.line(), 2.0)
    supports = {row["Support"]: row for row in Page(result.report(tmp_path / "line.html")).rows("Supports")}
    for name, own in rw.places(maps.line()).iterrows():
        assert float(supports[str(name)]["Easting"]) == pytest.approx(own["easting"], abs=0.006)
