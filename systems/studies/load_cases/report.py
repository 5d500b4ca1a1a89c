"""The report of load cases."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import pandas as pd

from ropeway.components.errors import EquilibriumError, SlackRopeError
from ropeway.components.rope import Rope
from ropeway.systems.modelling.rope_path import find_runs
from ropeway.systems.reporting.blocks import Section, Table
from ropeway.systems.reporting.document import values_of, warnings_of
from ropeway.systems.reporting.style import Style
from ropeway.systems.results.result_report import ropes_table
from ropeway.systems.results.support_section import supports_section
from ropeway.systems.rigs.skyline_rig import SkylineRig
from ropeway.systems.rigs.stringing_table import report_table
from ropeway.systems.studies.skyline.reporting import rig_sections

if TYPE_CHECKING:
    from ropeway.systems.studies.load_cases.data import CasesData

_SHOWN: Mapping[str, tuple[str, Any]] = {
    "N": ("force", "near"),
    "rad": ("angle", "near"),
    "m": ("short_length", "near"),
}
"""How quantities of `governing` are shown, by their unit."""


def sections_of(study: CasesData, style: Style) -> list[Section]:
    """The sections of the report."""
    return [
        warnings_of(list(_warnings(study, style)), style),
        Section(style.text("inputs"), (values_of(_inputs(study, style), style), ropes_table(_ropes(study), style))),
        Section(style.text("load_cases"), (_weather(study, style), _tensions(study, style))),
        Section(style.text("governing"), (_governing(study, style),)),
        supports_section(study.supports, style),
        *_stringing(study, style),
    ]


def _stringing(study: CasesData, style: Style) -> list[Section]:
    """The stringing table; none of a rope that would be slack."""
    try:
        return [Section(style.text("stringing"), (report_table(study.of, style),))]
    except (EquilibriumError, SlackRopeError):
        return []


def _warnings(study: CasesData, style: Style) -> Any:
    """Cases above their allowed tension, and supports that the rope leaves."""
    for name, row in study.frame.iterrows():
        if row["utilisation"] > 1.0 + 1e-9:
            share = style.value(row["utilisation"], "percent", "up")
            yield style.text("case_above", case=name, share=share, span=row["span"])
    lifted = study.supports[study.supports["least_force"] < 0.0]
    for (support, case), _ in lifted.groupby(["support", "case"], sort=False):
        yield style.text("case_lifts", case=case, support=support)


def _inputs(study: CasesData, style: Style) -> list[tuple[str, str]]:
    what = "kind" if isinstance(study.of, SkylineRig) else "line"
    return [
        (style.text(what), _described(study)),
        (style.text("strung_at"), style.value(study.of.temperature, "temperature")),
        (style.text("gravity"), f"{study.of.gravity:g} m/s²"),
        (style.text("load_cases"), str(len(study.cases))),
    ]


def _described(study: CasesData) -> str:
    return f"{study.of.kind.name} skyline" if isinstance(study.of, SkylineRig) else study.of.name


def _ropes(study: CasesData) -> list[tuple[str, Rope, float]]:
    """Ropes by use, with their own safety factors."""
    if isinstance(study.of, SkylineRig):
        return [(use, rope, rope.safety_factor) for use, rope in rig_sections.ropes_of(study.of)]
    found: dict[Rope, str] = {}
    for run in find_runs(study.of):
        found.setdefault(run.rope, run.name)
    return [(use, rope, rope.safety_factor) for rope, use in found.items()]


def _weather(study: CasesData, style: Style) -> Table:
    """Weather and loading of each case."""
    head = (
        style.text("case"), style.text("loading"), style.head("temperature", "temperature"),
        style.head("ice_thickness", "diameter"), style.head("wind_pressure", "pressure"),
        style.head("wind_from", "degrees"), style.text("safety_factor"),
    )  # fmt: skip
    rows = [
        (
            str(name), str(row["loading"]), style.number(row["temperature"], "temperature"),
            style.number(row["ice_thickness"], "diameter"), style.number(row["wind_pressure"], "pressure"),
            style.number(row["wind_from"], "degrees"), style.number(row["safety_factor"], "number", "up"),
        )
        for name, row in study.frame.iterrows()
    ]  # fmt: skip
    return Table(head, rows, texts=2)


def _tensions(study: CasesData, style: Style) -> Table:
    """Tensions, forces and clearances of each case."""
    clear = "least_clearance" in study.frame
    head = [
        style.text("case"), style.text("span"), style.head("highest_tension", "force"),
        style.text("safety"), style.head("share_allowed", "percent"), style.head("lowest_tension", "force"),
        style.head("highest_force", "force"), style.text("support"), style.head("lowest_force", "force"),
        style.text("support"), *([style.head("clearance", "length")] if clear else []),
    ]  # fmt: skip
    rows = [
        (
            str(name), str(row["span"]), style.number(row["highest_tension"], "force", "up"),
            style.number(row["safety"], "number", "down"), style.number(row["utilisation"], "percent", "up"),
            style.number(row["lowest_tension"], "force", "down"),
            style.number(row["highest_bearing_load"], "force", "up"), str(row["highest_bearing_load_at"]),
            style.number(row.get("least_force"), "force", "down"), str(row.get("least_force_at", "-")),
            *([style.number(row["least_clearance"], "length", "down")] if clear else []),
        )
        for name, row in study.frame.iterrows()
    ]  # fmt: skip
    return Table(tuple(head), rows, texts=2)


def _governing(study: CasesData, style: Style) -> Table:
    """The governing cases."""
    head = (
        style.text("name"), style.text("quantity"), style.text("extreme"), style.text("case"), style.text("value"),
        style.text("next_case"), style.text("difference"),
    )  # fmt: skip
    rows = []
    for _, row in study.governing.iterrows():
        quantity, side = _SHOWN.get(row["unit"], ("number", "near"))
        rows.append(
            (
                str(row["name"]), str(row["quantity"]).replace("_", " "), str(row["extreme"]), str(row["case"]),
                style.value(row["value"], quantity, side), str(row["next_case"]),
                style.value(row["by"], quantity, side) if pd.notna(row["by"]) else "-",
            )
        )  # fmt: skip
    return Table(head, rows, texts=4)
