"""A report as one HTML file that needs nothing else, or as a PDF printed by a browser."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import date
from functools import cached_property
from importlib.resources import files
from pathlib import Path
from typing import Any

from ropeway.components.argument_checks import checked
from ropeway.components.errors import InputError, WriteError
from ropeway.components.whole_files import whole
from ropeway.systems.reporting.blocks import Section, Table, Text
from ropeway.systems.reporting.browser import print_to_pdf, require_browser
from ropeway.systems.reporting.style import Style, Units


@checked
@dataclass(frozen=True)
class Project:
    """The project of a report; all values are any text.

    Parameters
    ----------
    title, place, client, author, remark : str, optional
        Texts in the head of the report.

    Examples
    --------
    >>> rw.Project(title="Corridor 7", place="Bear Creek").title
    'Corridor 7'
    """

    title: str = ""
    place: str = ""
    client: str = ""
    author: str = ""
    remark: str = ""


@dataclass(frozen=True)
class ReportOptions:
    """Options of all reports: the `project`; `units`, "metric" or "imperial"; `labels` in another language, by the keys
    of `ropeway.systems.reporting.labels`; `more` sections after those of the study. Raises InputError."""

    project: Project | None = None
    units: Units = "metric"
    labels: Mapping[str, str] | None = None
    more: Sequence[Section] = ()

    @cached_property
    def style(self) -> Style:
        """Words and units. Raises InputError."""
        return Style(self.units, {} if self.labels is None else self.labels)


def write_report(path: str | Path, title: str, sections: Sequence[Section], options: ReportOptions) -> Path:
    """Write a report as HTML, or as PDF where the path ends with .pdf; returns the path. Raises InputError,
    WriteError."""
    require_report_path(path)
    page = html(title, sections, options)
    with whole(path) as file:
        if Path(path).suffix.lower() == ".pdf":
            print_to_pdf(page, file)
        else:
            file.write_text(page, encoding="utf-8", newline="\n")
    return Path(path)


def require_report_path(path: str | Path) -> None:
    """Raises InputError, WriteError where no report can be written to a path: asked before a study, none is lost."""
    target = Path(path)
    if target.suffix.lower() not in (".html", ".htm", ".pdf"):
        raise InputError(f"{path} is no report", "Let its name end with .html or .pdf")
    if not target.parent.is_dir():
        raise WriteError(f"{target} cannot be written: there is no folder {target.parent}", "Make the folder first")
    if target.suffix.lower() == ".pdf":
        require_browser()


def html(title: str, sections: Sequence[Section], options: ReportOptions) -> str:
    """A report as one page with its scripts. Raises InputError where a package is missing."""
    try:
        import jinja2
        from plotly.offline import get_plotlyjs
    except ImportError as error:
        raise InputError("Reports need jinja2 and plotly", "pip install ropeway[report]") from error
    style, project = options.style, options.project or Project()
    templates = files("ropeway.systems.reporting") / "templates"
    read = {name: (templates / name).read_text(encoding="utf-8") for name in ("report.html", "report.css", "report.js")}
    environment = jinja2.Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True)
    environment.filters["data"] = _script_data
    every = [_about(project, style), *sections, *options.more]
    return environment.from_string(read["report.html"]).render(
        title=project.title or title,
        subtitle=title if project.title else "",
        style=style,
        sections=every,
        css=read["report.css"],
        script=read["report.js"],
        plotly=get_plotlyjs(),
    )


def warnings_of(texts: Sequence[str], style: Style) -> Section:
    """The section of warnings."""
    notes = Text(tuple(texts), warning=True) if texts else Text((style.text("no_warnings"),))
    return Section(style.text("warnings"), (notes,))


def values_of(rows: Sequence[tuple[str, str]], style: Style) -> Table:
    """A table of quantities and their values."""
    return Table((style.text("quantity"), style.text("value")), rows)


def _about(project: Project, style: Style) -> Section:
    from ropeway import __version__

    known = [(key, getattr(project, key)) for key in ("title", "place", "client", "author", "remark")]
    rows = [(style.text(key), value) for key, value in known if value]
    rows += [
        (style.text("date"), date.today().isoformat()),
        (style.text("software"), f"ropeway {__version__}"),
        (style.text("units"), style.text(style.units)),
    ]
    return Section(style.text("project"), (Table((), rows, style.text("rounding")),))


def _script_data(value: Any) -> Any:
    """A value as JSON inside a script element."""
    from markupsafe import Markup

    text = json.dumps(value, ensure_ascii=False, separators=(",", ":"), allow_nan=False)
    return Markup(text.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029"))
