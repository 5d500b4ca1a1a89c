"""What has a report: studies and runs, each with its own title and sections."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from pathlib import Path

from ropeway.components.argument_checks import checked
from ropeway.systems.reporting.blocks import Section
from ropeway.systems.reporting.document import Project, ReportOptions, write_report
from ropeway.systems.reporting.style import Style, Units


@checked
class Reported(ABC):
    """A result with a report. A subclass has `_report_title` and `_report_sections`."""

    @abstractmethod
    def _report_title(self, style: Style) -> str:
        """Title of the report."""

    @abstractmethod
    def _report_sections(self, style: Style) -> Sequence[Section]:
        """Sections of the report. Raises InputError where there is nothing to report."""

    def report(
        self,
        path: str | Path,
        *,
        project: Project | None = None,
        units: Units = "metric",
        labels: Mapping[str, str] | None = None,
        more: Sequence[Section] = (),
    ) -> Path:
        """Write the report: inputs, warnings, pictures that move, tables of supports, limits and events.

        Parameters
        ----------
        path : str or Path
            HTML, or PDF by a browser's print; needs the extra `report`.
        project : Project, optional
            Title, place, client, author and a remark.
        units : {"metric", "imperial"}, default "metric"
            Fitted and measured values are in SI units in either.
        labels : mapping, optional
            Words in place of those of `ropeway.systems.reporting.labels.ENGLISH`, by key.
        more : sequence of Section, optional
            Sections of your own after the others.

        Returns
        -------
        Path

        Raises
        ------
        InputError
            The name of the file, an option, or a missing package or browser.
        WriteError
            The file could not be written.
        """
        options = ReportOptions(project, units, labels, more)
        sections = self._report_sections(options.style)
        return write_report(path, self._report_title(options.style), sections, options)
