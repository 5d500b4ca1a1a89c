"""Reports as a reader sees them: their tables and data by a parser, or in a headless browser."""

from __future__ import annotations

import base64
import json
from collections.abc import Iterator
from contextlib import contextmanager
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np


class Page(HTMLParser):
    """The tables of a report by section, and the data of its charts and player."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.tables: dict[str, list[list[list[str]]]] = {}
        self.paragraphs: dict[str, list[str]] = {}
        self.charts: dict[str, Any] = {}
        self.player: dict[str, Any] = {}
        self.sources: list[str] = []
        self._section, self._inside, self._script = "", "", ""
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        known = dict(attrs)
        self.sources += [str(known[key]) for key in ("src", "href") if key in known]
        self._inside, self._script = tag, ""
        if tag == "script":
            self._script = known.get("data-chart") or known.get("class") or ""
        elif tag == "section":
            self._section = ""
        elif tag == "table":
            self.tables.setdefault(self._section, []).append([])
        elif tag == "tr":
            self.tables[self._section][-1].append([])
        elif tag in ("td", "th"):
            self.tables[self._section][-1][-1].append("")

    def handle_data(self, data: str) -> None:
        if self._inside == "h2":
            self._section += data.strip()
        elif self._inside in ("td", "th"):
            self.tables[self._section][-1][-1][-1] += data.strip()
        elif self._inside == "p":
            self.paragraphs.setdefault(self._section, []).append(data.strip())
        elif self._inside == "script" and self._script == "data":
            self.player = json.loads(data)
        elif self._inside == "script" and self._script:
            self.charts[self._script] = json.loads(data)

    def handle_endtag(self, tag: str) -> None:
        self._inside = ""

    def rows(self, section: str, table: int = 0) -> list[dict[str, str]]:
        """Rows of a table by the heads of its columns."""
        head, *rows = self.tables[section][table]
        return [dict(zip(head, row, strict=True)) for row in rows]

    def moving(self, trace: int, frame: int) -> tuple[np.ndarray, np.ndarray]:
        """Points of a moving trace in a frame."""
        own = self.player["moving"][trace]
        start, end = ([0, *own["ends"]][frame + i] for i in (0, 1))
        x, y = (np.frombuffer(base64.b64decode(own[axis]), dtype="<f4")[start:end] for axis in "xy")
        return x, y


@contextmanager
def browser() -> Iterator[Any]:
    """A headless Chromium without a network."""
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service

    options = webdriver.ChromeOptions()
    for argument in ("--headless=new", "--no-sandbox", "--disable-gpu", "--window-size=1200,1600"):
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    driver = webdriver.Chrome(options=options, service=Service("/usr/bin/chromedriver"))
    try:
        driver.execute_cdp_cmd("Network.enable", {})
        driver.execute_cdp_cmd(
            "Network.emulateNetworkConditions",
            {"offline": True, "latency": 0, "downloadThroughput": 0, "uploadThroughput": 0},
        )
        yield driver
    finally:
        driver.quit()
