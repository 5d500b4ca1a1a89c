"""The report of a fit."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ropeway.systems.reporting.blocks import Chart, Section, Table, Text, axis, curve, dots
from ropeway.systems.reporting.document import warnings_of
from ropeway.systems.reporting.style import Style

if TYPE_CHECKING:
    from ropeway.systems.studies.fitting.fit_data import FitData

_COLOURS = ("#1f77b4", "#ff7f0e", "#2ca02c", "#9467bd", "#8c564b", "#bcbd22")


def fit_sections(fit: FitData, style: Style) -> list[Section]:
    """The sections of a fit's report; values are in SI units, as in its frame."""
    lost = [style.text("fit_unidentifiable", combination=str(one)) for one in fit.unidentifiable]
    return [
        warnings_of([*fit.notes, *lost], style),
        Section(style.text("fit"), (_quantities(fit, style), Text((fit.suggestion,)))),
        Section(style.text("fit_correlations"), (_correlations(fit, style),)),
        Section(style.text("fit_values"), tuple(_charts(fit, style))),
        Section(style.text("fit_suggestions"), (_suggestions(fit, style),)),
    ]


def _quantities(fit: FitData, style: Style) -> Table:
    head = tuple(
        style.text(key) for key in ("quantity", "value", "standard_error", "fit_interval", "fit_declared", "unit")
    )
    rows = [
        (
            str(name), f"{row['value']:.6g}", _number(row["standard_error"]),
            f"{row['low']:.6g} ... {row['high']:.6g}" if np.isfinite(row["standard_error"]) else "-",
            f"{row['declared']:.6g}", str(row["unit"]),
        )
        for name, row in fit.frame.iterrows()
    ]  # fmt: skip
    return Table(head, rows)


def _number(value: float) -> str:
    return f"{value:.3g}" if np.isfinite(value) else "∞"


def _correlations(fit: FitData, style: Style) -> Table:
    names = [str(name) for name in fit.frame.index]
    rows = [
        (name, *(f"{v:.2f}" if np.isfinite(v) else "-" for v in row))
        for name, row in zip(names, fit.correlations.to_numpy(), strict=True)
    ]
    return Table((style.text("quantity"), *names), rows)


def _charts(fit: FitData, style: Style) -> list[Chart]:
    """Measured and predicted values of each column."""
    over = "time [s]" if fit.measured.index.name == "time" else style.text("fit_row")
    found = []
    for i, (column, colour) in enumerate(zip(fit.measured.columns, _COLOURS, strict=False)):
        there = fit.measured[column].notna()
        x = fit.measured.index[there].to_numpy(float)
        traces = [
            dots(x, fit.measured.loc[there, column], style.text("fit_measured"), colour, size=5),
            curve(x, fit.predicted.loc[there, column], style.text("fit_predicted"), "#333333"),
        ]
        unit = fit.measured.attrs["units"][column]
        axes = {"xaxis": axis(over), "yaxis": axis(f"{column} [{unit}]"), "height": 260}
        found.append(Chart(f"fit_{i}", traces, axes))
    return found


def _suggestions(fit: FitData, style: Style) -> Table:
    head = tuple(style.text(key) for key in ("quantity", "fit_state", "fit_sigma", "fit_helps", "fit_falls_to"))
    rows = [
        (row.quantity, row.state, f"{row.sigma:g} {row.unit}", row.helps, f"{100.0 * row.error_falls_to:.0f} %")
        for row in fit.suggestions.itertuples()
    ]
    return Table(head, rows, texts=2)
