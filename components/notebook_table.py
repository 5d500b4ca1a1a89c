"""Tables that notebooks show."""

from __future__ import annotations

import html
from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd

_ROWS, _COLUMNS = 10, 9
"""Most rows and columns of a table in a notebook."""


def html_of(title: str, rows: pd.DataFrame | Sequence[Mapping[str, Any]]) -> str:
    """A title and the beginning of a table as HTML."""
    table = rows if isinstance(rows, pd.DataFrame) else pd.DataFrame(rows)
    shown = table.iloc[:_ROWS, :_COLUMNS]
    text = shown.to_html(index=False, border=0, float_format=lambda v: f"{v:.6g}", na_rep="")
    left = ""
    if shown.shape != table.shape:
        left = f"<p>{len(shown)} of {len(table)} rows, {shown.shape[1]} of {table.shape[1]} columns</p>"
    return f"<p><b>{html.escape(title)}</b></p>{text}{left}"
