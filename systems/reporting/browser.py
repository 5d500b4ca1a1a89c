"""PDF by a browser's print: what is on paper is what is on the screen."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from ropeway.components.errors import InputError, WriteError

_NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome", "msedge", "microsoft-edge")
_PLACES = (
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
    "/Applications/Microsoft Edge.app/Contents/MacOS/Microsoft Edge",
    r"C:\Program Files\Google\Chrome\Application\chrome.exe",
    r"C:\Program Files (x86)\Google\Chrome\Application\chrome.exe",
    r"C:\Program Files (x86)\Microsoft\Edge\Application\msedge.exe",
    r"C:\Program Files\Microsoft\Edge\Application\msedge.exe",
)
_SECONDS = 180.0


def print_to_pdf(page: str, path: Path) -> None:
    """Print a page in HTML to a PDF file. Raises InputError where there is no browser, WriteError where it fails."""
    browser = require_browser()
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder) / "report.html", Path(folder) / "report.pdf"
        source.write_text(page, encoding="utf-8")
        command = [
            browser, "--headless", "--disable-gpu", "--no-pdf-header-footer", "--window-size=1100,1500",
            f"--user-data-dir={folder}/profile", "--virtual-time-budget=20000", f"--print-to-pdf={target}",
        ]  # fmt: skip
        if sys.platform == "linux" and os.geteuid() == 0:  # Chromium refuses to run as root otherwise
            command.append("--no-sandbox")
        try:
            done = subprocess.run([*command, source.as_uri()], capture_output=True, timeout=_SECONDS, check=False)
        except (OSError, subprocess.TimeoutExpired) as error:
            raise WriteError(f"{browser} cannot print: {error}", "Write .html and print that") from error
        if not target.is_file():
            said = done.stderr.decode(errors="replace").strip().splitlines()[-1:]
            raise WriteError(f"{browser} made no PDF: {''.join(said)}", "Write .html and print that")
        shutil.copyfile(target, path)


def require_browser() -> str:
    """The browser that prints. Raises InputError where there is none."""
    browser = next(_browsers(), None)
    if browser is None:
        raise InputError(
            "No browser was found that can print the report to PDF",
            "Install Chromium, Chrome or Edge, or name one in the environment variable ROPEWAY_BROWSER; or write .html",
        )
    return browser


def _browsers() -> Iterator[str]:
    """Browsers of this machine, the one that the user names first."""
    named = os.environ.get("ROPEWAY_BROWSER")
    if named:
        yield named
    yield from (found for name in _NAMES if (found := shutil.which(name)))
    yield from (place for place in _PLACES if Path(place).is_file())
