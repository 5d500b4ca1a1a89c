"""Figures that notebooks show without a further word. matplotlib is imported when one is drawn."""

from __future__ import annotations

import io
from functools import cache
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def new_figure(**options: Any) -> Figure:
    """A figure of its own, outside pyplot, which notebooks show as PNG; `options` are those of matplotlib's Figure."""
    return _figure_class()(**options)


@cache
def _figure_class() -> type[Figure]:
    from matplotlib.figure import Figure

    class NotebookFigure(Figure):
        """A figure that shows itself in a notebook."""

        def _repr_png_(self) -> bytes:
            found = io.BytesIO()
            self.savefig(found, format="png", dpi=100)
            return found.getvalue()

    return NotebookFigure
