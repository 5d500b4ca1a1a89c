"""The section of a report with the forces on supports over all load cases."""

from __future__ import annotations

import pandas as pd

from ropeway.systems.reporting.blocks import Section, Table
from ropeway.systems.reporting.style import Side, Style

_COLUMNS: tuple[tuple[str, str, str, Side], ...] = (
    ("bearing_load", "max", "highest_force", "up"), ("vertical_force", "max", "highest_vertical", "up"),
    ("vertical_force", "min", "lowest_vertical", "down"), ("horizontal_force", "max", "highest_horizontal", "up"),
    ("roller_force", "max", "highest_roller", "up"),
)  # fmt: skip
"""Forces: column of the table of supports, its extreme, label and direction of rounding."""


def supports_section(table: pd.DataFrame, style: Style) -> Section:
    """Extremes of each rope at each support over all rows of a table of supports."""
    rows = []
    for (support, rope), own in table.groupby(["support", "rope"], sort=False):
        angles = own["deflection"].dropna()
        least, most = (None, None) if angles.empty else (angles.min(), angles.max())
        forces = [style.number(getattr(own[c], how)(), "force", side) for c, how, _, side in _COLUMNS]
        reserve = own["lift_off_reserve"].min()
        rows.append(
            (
                str(support), str(rope), style.number(least, "angle", "down"), style.number(most, "angle", "up"),
                *forces, style.number(reserve, "number", "down"),
            )
        )  # fmt: skip
    head = (
        style.text("support"), style.text("rope"), style.head("least_break_angle", "angle"),
        style.head("largest_break_angle", "angle"), *(style.head(label, "force") for _, _, label, _ in _COLUMNS),
        style.text("lift_off_reserve"),
    )  # fmt: skip
    return Section(style.text("supports"), (Table(head, rows, style.text("reserve_note"), texts=2),))
