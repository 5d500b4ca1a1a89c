"""Tables of the cases: tensions of ropes, forces on supports, clearances; and a row for each case."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from ropeway.components.rope import Rope
from ropeway.components.schedule import Schedule
from ropeway.systems.results.support_rows import ALL
from ropeway.systems.studies.load_cases.load_case import LoadCase

UNITS = {
    "temperature": "degC", "ice_thickness": "m", "wind_pressure": "Pa", "wind_from": "deg", "safety_factor": "1",
    "highest_tension": "N", "lowest_tension": "N", "safety": "1", "utilisation": "1", "station": "m",
    "highest_bearing_load": "N", "least_force": "N", "least_clearance": "m", "rope_clearance": "m",
    "load_clearance": "m",
}  # fmt: skip
"""Units of columns besides those of supports."""


class CaseTables(NamedTuple):
    """Tables of all cases, each with a column case.

    `ropes`: a row for each rope; `supports`: for each rope at each support, of a rig in its extreme states;
    `clearances`: for each span, None without a ground."""

    ropes: pd.DataFrame
    supports: pd.DataFrame
    clearances: pd.DataFrame | None


def with_units(frame: pd.DataFrame, known: dict[str, str] | None = None) -> pd.DataFrame:
    """A frame with the units of its columns."""
    units = UNITS | (known or {})
    frame.attrs["units"] = {column: units.get(column, "") for column in frame.columns}
    return frame


class RopeTension(NamedTuple):
    """Highest and lowest tension of a rope [N], and where the highest one is."""

    name: str
    rope: Rope
    highest: float
    lowest: float
    span: str
    station: float | None = None


def rope_rows(case: LoadCase, tensions: Sequence[RopeTension]) -> Iterator[dict[str, Any]]:
    """Rows of the ropes in a case: tensions, and how much of the allowed tension they use."""
    for found in tensions:
        factor = found.rope.safety_factor if case.safety_factor is None else case.safety_factor
        row: dict[str, Any] = {
            "case": case.name,
            "rope": found.name,
            "span": found.span,
            "highest_tension": found.highest,
            "lowest_tension": found.lowest,
            "safety": found.rope.breaking_load / found.highest if found.highest > 0.0 else np.inf,
            "safety_factor": factor,
            "utilisation": found.highest * factor / found.rope.breaking_load,
        }
        yield row if found.station is None else {**row, "station": found.station}


def summary(cases: Sequence[LoadCase], strung: float, tables: CaseTables) -> pd.DataFrame:
    """A row for each case: its weather and loading, and the extremes of ropes, supports and clearances."""
    rows = []
    ropes = {str(name): part for name, part in tables.ropes.groupby("case", sort=False)}
    own = tables.supports[tables.supports["rope"] != ALL]
    supports = {str(name): part for name, part in own.groupby("case", sort=False)}
    clear = tables.clearances
    spans = {} if clear is None else {str(name): part for name, part in clear.groupby("case", sort=False)}
    for case in cases:
        used = ropes[case.name].loc[ropes[case.name]["utilisation"].idxmax()]
        row: dict[str, Any] = {**_weather(case, strung), "safety_factor": used["safety_factor"]}
        row |= {key: used[key] for key in ("rope", "span", "highest_tension", "safety", "utilisation")}
        row["lowest_tension"] = ropes[case.name]["lowest_tension"].min()
        at = supports[case.name]
        for column, lowest, name in (
            ("bearing_load", False, "highest_bearing_load"),
            ("least_force", True, "least_force"),
        ):
            values = at[column].dropna()
            if len(values):
                k = values.idxmin() if lowest else values.idxmax()
                row |= {name: values[k], f"{name}_at": at.loc[k, "support"]}
        if case.name in spans:
            least = spans[case.name][["rope_clearance", "load_clearance"]].min(axis=1)
            row |= {"least_clearance": least.min(), "least_clearance_at": spans[case.name].loc[least.idxmin(), "span"]}
        rows.append(row)
    return with_units(pd.DataFrame(rows, index=pd.Index([case.name for case in cases], name="case")))


def _weather(case: LoadCase, strung: float) -> dict[str, Any]:
    """Values of a case's weather at rest."""
    weather = case.environment
    given = {"temperature": weather.temperature, "wind_pressure": weather.pressure, "wind_from": weather.wind_from}
    at = {name: v.at(0.0) if isinstance(v, Schedule) else v for name, v in given.items()}
    return {
        "loading": case.loading,
        "temperature": strung if at["temperature"] is None else at["temperature"],
        "ice_thickness": weather.ice_thickness,
        "wind_pressure": at["wind_pressure"],
        "wind_from": at["wind_from"],
    }
