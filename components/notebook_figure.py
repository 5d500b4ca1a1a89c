"""Figures that notebooks show without a further word. matplotlib is imported when one is drawn."""

from __future__ import annotations

import io
from functools import cache
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def new_figure(**options: Any) -> Figure:
    """A figure of its own, outside pyplot, which notebooks show as PNG; `options` are those of matplotlib's Figure.

    Its texts are literal: a $ in a name begins no formula.
    """
    return _figure_class()(**options)


@cache
def _figure_class() -> type[Figure]:
    from matplotlib import rc_context
    from matplotlib.figure import Figure
    from matplotlib.text import Text

    class NotebookFigure(Figure):
        """A figure that shows itself in a notebook."""

        def draw(self, renderer: Any) -> None:
            for text in self.findobj(Text):
                text.set_parse_math(False)
            with rc_context({"text.parse_math": False}):  # of labels of ticks that are made as they are drawn
                super().draw(renderer)

        def _repr_png_(self) -> bytes:
            found = io.BytesIO()
            self.savefig(found, format="png", dpi=100)
            return found.getvalue()

    return NotebookFigure
