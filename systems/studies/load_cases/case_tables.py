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

    `tensions`: a row for each rope; `supports`: for each rope at each support, of a rig in its extreme states;
    `clearances`: for each span, None without a ground."""

    tensions: pd.DataFrame
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
    ropes, supports, spans = _Columns(tables.tensions), _Columns(tables.supports), None
    if tables.clearances is not None:
        spans = _Columns(tables.clearances)
    rows = []
    for case in cases:
        row = _weather(case, strung)
        used = ropes.extreme(case.name, "utilisation", 1.0)
        for name in ("safety_factor", "rope", "span", "highest_tension", "safety", "utilisation"):
            row[name] = ropes.value(used, name)
        row["lowest_tension"] = ropes.value(ropes.extreme(case.name, "lowest_tension", -1.0), "lowest_tension")
        for column, sign, name in (("bearing_load", 1.0, "highest_bearing_load"), ("least_force", -1.0, "least_force")):
            at = supports.extreme(case.name, column, sign, but=ALL)
            row |= {name: supports.value(at, column), f"{name}_at": supports.value(at, "support")}
        if spans is not None:
            ends = [(spans.extreme(case.name, name, -1.0), name) for name in ("rope_clearance", "load_clearance")]
            least, at = min((spans.value(k, name), k) for k, name in ends if k is not None)
            row |= {"least_clearance": least, "least_clearance_at": spans.value(at, "span")}
        rows.append(row)
    return with_units(pd.DataFrame(rows, index=pd.Index([case.name for case in cases], name="case")))


class _Columns:
    """Columns of a table as arrays, and its rows by case."""

    def __init__(self, table: pd.DataFrame) -> None:
        self._columns = {name: table[name].to_numpy() for name in table.columns}
        self._rows = table.groupby("case", sort=False).indices

    def extreme(self, case: str, column: str, sign: float, but: str = "") -> int | None:
        """The row with the largest (sign 1) or least (-1) value of a case, without those of rope `but`; None without a
        value."""
        rows = self._rows[case]
        values = sign * self._columns[column][rows]
        values = np.where(np.isnan(values) | ((self._columns["rope"][rows] == but) if but else False), -np.inf, values)
        k = int(np.argmax(values))
        return int(rows[k]) if values[k] > -np.inf else None

    def value(self, row: int | None, column: str) -> Any:
        """A value; NaN without a row."""
        return np.nan if row is None else self._columns[column][row]


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
