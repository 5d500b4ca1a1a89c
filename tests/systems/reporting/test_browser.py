"""Reports in a real browser without a network: no error, the slider and the button move the picture, PDF."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rasterio

import ropeway as rw
from support import call_objects as objects
from support.pages import Page, browser

pytestmark = pytest.mark.browser

MOVING = """
const chart = document.getElementById(arguments[0]);
return chart.data[arguments[1]].x.concat(chart.data[arguments[1]].y);
"""


def set_slider(driver: Any, value: int) -> None:
    driver.execute_script(
        "const s = document.querySelector('.player input'); s.value = arguments[0];"
        "s.dispatchEvent(new Event('input'));",
        value,
    )


def test_a_payload_report_works_offline(tmp_path: Path) -> None:
    study = rw.payload(objects.rig(), stations=[30.0, 70.0, 150.0, 200.0], clearance=0.5)
    path = study.report(tmp_path / "study.html")
    page = Page(path)
    carriage = page.player["moving"][-1]["trace"]
    with browser() as driver:
        driver.get(path.as_uri())
        for i, (_, row) in enumerate(study.frame.iterrows()):
            set_slider(driver, i)
            x, z = driver.execute_script(MOVING, "profile", carriage)
            assert (x, z) == pytest.approx((row["carriage_x"], row["carriage_z"]), abs=1e-3)
            shown = driver.execute_script("return document.querySelector('.values td').textContent")
            assert shown == f"{int(row['payload'])} kg"
            mark = driver.execute_script("return document.getElementById('tensions').layout.shapes[0].x0")
            assert mark == pytest.approx(row["station"])
        driver.execute_script("document.querySelector('.player button').click()")
        time.sleep(0.5)
        assert driver.execute_script("return document.querySelector('.player .frame').textContent").startswith(
            "Station"
        )
        assert int(driver.execute_script("return document.querySelector('.player input').value")) > 0
        assert [entry for entry in driver.get_log("browser") if entry["level"] in ("SEVERE", "WARNING")] == []
        widths = driver.execute_script("return [document.body.scrollWidth, document.body.clientWidth]")
        assert widths[0] <= widths[1]


def test_thirty_minutes_of_a_long_line_are_small_and_move(tmp_path: Path) -> None:
    """24 spans with loads; 3 MB beyond the script of plotly."""
    from plotly.offline import get_plotlyjs

    supports = Path(rw.__file__).parent / "examples" / "line.csv"
    line = rw.monocable(rw.Rope.named("RHOL-IWRC 29"), supports, tension=45e3,
                        load_mass=300.0, load_spacing=50.0)  # fmt: skip
    result = rw.simulate(line, 1800.0, every=10.0)
    path = result.report(tmp_path / "line.html")
    assert path.stat().st_size - len(get_plotlyjs().encode()) < 3e6
    with browser() as driver:
        driver.get(path.as_uri())
        trace = Page(path).player["moving"][1]["trace"]
        before = driver.execute_script(MOVING, "line", trace)
        set_slider(driver, 40)
        assert driver.execute_script(MOVING, "line", trace) != before
        assert [entry for entry in driver.get_log("browser") if entry["level"] in ("SEVERE", "WARNING")] == []


def test_a_pdf_has_text_and_pages(tmp_path: Path) -> None:
    study = rw.payload(objects.rig(), stations=[70.0, 150.0])
    path = study.report(tmp_path / "study.pdf", project=rw.Project(title="Corridor seven"))
    data = path.read_bytes()
    assert data.startswith(b"%PDF")
    assert 2 <= data.count(b"/Type /Page\n") + data.count(b"/Type /Page ") + data.count(b"/Type/Page/") <= 8


def test_from_an_elevation_model_to_the_contractor(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The script of docs/reports.md: at most 12 lines to a report, a PDF, a GeoPackage and a DXF."""
    document = (Path(__file__).resolve().parents[3] / "docs" / "reports.md").read_text(encoding="utf-8")
    script = document.split("to the contractor")[1].split("```text\n")[1].split("```")[0]
    assert len([line for line in script.splitlines() if line.strip()]) <= 12
    east, north = np.meshgrid(2600050.0 + 4.0 * np.arange(110), 1200650.0 - 4.0 * np.arange(130))
    along = 0.6 * (east - 2600100.0) + 0.8 * (north - 1200200.0)
    heights = 846.0 - 0.27 * along + 9.0 * np.cos(along / 60.0)
    place = rasterio.Affine(4.0, 0.0, 2600048.0, 0.0, -4.0, 1200652.0)
    with rasterio.open(tmp_path / "dem.tif", "w", driver="GTiff", height=130, width=110, count=1, dtype="float64",
                       crs="EPSG:2056", transform=place) as file:  # fmt: skip
        file.write(heights, 1)
    monkeypatch.chdir(tmp_path)
    exec(compile(script, "docs/reports.md", "exec"), {})
    for name in ("corridor.html", "corridor.pdf", "corridor.gpkg", "corridor.dxf"):
        assert (tmp_path / name).stat().st_size > 10_000
    shown = {row["Name"]: row for row in Page(tmp_path / "corridor.html").rows("Staking out")}
    assert float(shown["jack"]["Easting"]) == pytest.approx(2600100.0 + 250.0 * 0.6, abs=0.2)
