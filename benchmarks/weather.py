"""Changes of state by temperature, ice and wind: ropeway and mechaphlowers (RTE, for overhead lines) side by side.

    python benchmarks/weather.py

Horizontal tension of a span strung at 15 degrees C. mechaphlowers gives each metre of the rope as it hangs its weight,
ropeway each metre as it was strung: `hanging` is ropeway with the weight raised by the strain. What is left there is
wind on inclined spans, which mechaphlowers turns with the whole plane of the rope. Needs the extra `benchmark`.
"""

from __future__ import annotations

import logging
import time

import numpy as np
import pandas as pd
from mechaphlowers.api.section_study import SectionStudy
from mechaphlowers.data.catalog import sample_cable_catalog
from mechaphlowers.entities.arrays import SectionArray
from rich.console import Console
from rich.table import Table

import ropeway as rw

GRAVITY = 9.81
MASS, STIFFNESS, DIAMETER, EXPANSION = 1.8, 3.6e7, 31.86e-3, 2.3e-5  # ASTER600 of its catalogue
ICE = 6000.0 / GRAVITY
SPANS = ((500.0, 0.0, 2000.0), (300.0, 40.0, 1500.0), (400.0, -25.0, 1800.0))
"""Span, rise, parameter of the catenary at 15 degrees C [m]."""
STATES = ((-20.0, 0.0, 0.0), (90.0, 0.0, 0.0), (15.0, 0.01, 0.0), (15.0, 0.0, 300.0), (30.0, 0.01, 500.0))
"""Temperature [degrees C], ice [m], wind pressure [Pa]."""


def theirs(span: float, rise: float, parameter: float) -> list[float]:
    """Horizontal tension in each state by mechaphlowers [N]."""
    rows = {"name": ["1", "2"], "suspension": [False, False], "conductor_attachment_altitude": [30.0, 30.0 + rise]}
    rows |= {name: [0.0, 0.0] for name in ("crossarm_length", "line_angle", "insulator_mass", "ground_altitude")}
    rows |= {name: [0.0, np.nan] for name in ("load_mass", "load_position")}
    rows |= {"insulator_length": [0.01, 0.01], "span_length": [span, np.nan]}
    section = SectionArray(pd.DataFrame(rows), sagging_parameter=parameter, sagging_temperature=15.0)
    study = SectionStudy(sample_cable_catalog.get_as_object(["ASTER600"]), section)
    study.solve_adjustment()
    found = []
    for temperature, ice, wind in STATES:
        study.solve_change_state(new_temperature=temperature, ice_thickness=ice, wind_pressure=wind)
        found.append(float(study.balance_engine.balance_model.span_model.T_h()[0]))
    return found


def ours(span: float, rise: float, parameter: float, *, hanging: bool) -> list[float]:
    """Horizontal tension along the span in each state [N]; hanging: a metre as it hangs has its weight."""
    rope = rw.Rope(MASS, STIFFNESS, 2e5, DIAMETER, thermal_expansion=EXPANSION, drag_coefficient=1.0)
    s, at = rw.System("span", gravity=GRAVITY), parameter * MASS * GRAVITY
    s.string(rope, rw.Anchor("a", at=(0.0, 0.0)), rw.Anchor("b", at=(span, rise)), tension=at)
    model = rw.assemble(s.in_weather(rw.Environment("calm")))

    def heavier(strain: float) -> dict[str, float]:
        more = 1.0 + strain if hanging else 1.0
        return {"a_b.mass_per_length": more * MASS, "ice_density": more * ICE, "a_b.drag_coefficient": more}

    strung = rw.equilibrium(
        model, given={"a_b.horizontal": at}, solve_for="a_b.length", parameters=heavier(at / STIFFNESS)
    )
    found = []
    for temperature, ice, wind in STATES:
        state = {"temperature": temperature, "ice_thickness": ice, "wind_pressure": wind}
        state["a_b.length"], tension = strung["a_b.length"], at
        for _ in range(4 if hanging else 1):
            strain = tension / STIFFNESS + EXPANSION * (temperature - 15.0)
            tension = rw.equilibrium(model, parameters=state | heavier(strain))["a_b.force_x"]
        found.append(tension)
    return found


def main() -> None:
    """Prints the table."""
    logging.disable(logging.CRITICAL)
    table = Table(
        "span [m]", "rise [m]", "state", "mechaphlowers [N]", "ropeway", "hanging", title="horizontal tension"
    )
    for span in SPANS:
        before = time.perf_counter()
        known = theirs(*span)
        between = time.perf_counter()
        own, hanging = ours(*span, hanging=False), ours(*span, hanging=True)
        ratio = (between - before) / (time.perf_counter() - between)
        for state, h, a, b in zip(STATES, known, own, hanging, strict=True):
            words = "{:g} C, {:g} m, {:g} Pa".format(*state)
            table.add_row(
                f"{span[0]:g}", f"{span[1]:g}", words, f"{h:.1f}", f"{a / h - 1.0:+.2%}", f"{b / h - 1.0:+.3%}"
            )
        table.add_row("", "", f"time: {ratio:.1f} times that of ropeway", end_section=True)
    Console().print(table)


if __name__ == "__main__":
    main()
