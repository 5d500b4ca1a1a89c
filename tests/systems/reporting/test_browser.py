"""Reports in a real browser without a network: no error, the slider and the button move the picture, PDF."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import pytest

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
