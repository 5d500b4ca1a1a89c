"""Tables of a line in all load cases."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import pandas as pd

from ropeway.systems.modelling.dae_model import Model, kept_with_model
from ropeway.systems.results.end_forces import EndForces, end_forces
from ropeway.systems.results.support_rows import UNITS, support_rows
from ropeway.systems.statics.equilibrium import Equilibrium
from ropeway.systems.studies.load_cases.case_tables import CaseTables, RopeTension, rope_rows, with_units
from ropeway.systems.studies.load_cases.load_case import LoadCase


def line_tables(cases: Sequence[LoadCase], states: Sequence[Equilibrium]) -> CaseTables:
    """The tables of a line at rest in each case."""
    ropes = [row for case, line in zip(cases, states, strict=True) for row in rope_rows(case, list(_tensions(line)))]
    supports = supports_at_rest(states)
    names = [case.name for case in cases]
    supports.insert(0, "case", [names[i] for i in supports.pop("state")])
    clearances = None
    if states[0].model.system.ground is not None:
        parts = [line.clearance.reset_index().assign(case=name) for name, line in zip(names, states, strict=True)]
        clearances = pd.concat(parts, ignore_index=True)
        clearances = with_units(clearances[["case", *(c for c in clearances.columns if c != "case")]])
    return CaseTables(with_units(pd.DataFrame(ropes)), with_units(supports, dict(UNITS)), clearances)


def supports_at_rest(states: Sequence[Equilibrium]) -> pd.DataFrame:
    """Rows of `support_rows` for equilibria of lines; state is the number of the equilibrium."""
    groups: dict[int, list[int]] = {}
    for i, line in enumerate(states):
        groups.setdefault(id(line.model), []).append(i)
    found = []
    for members in groups.values():
        lines = [states[i] for i in members]
        forces = [end_forces(line.model, [line.point], line.runs, line.passed) for line in lines]
        pulls, chords = (
            np.concatenate(parts, axis=a) for a, parts in zip((1, 0), zip(*forces, strict=True), strict=True)
        )
        rows = support_rows(lines[0].model, EndForces(pulls, chords), np.array([line.outputs for line in lines]))
        rows["state"] = np.array(members)[rows["state"]]
        found.append(rows)
    frame = pd.concat(found, ignore_index=True).sort_values("state", kind="stable", ignore_index=True)
    frame.attrs["units"] = dict(UNITS)
    return frame


def _tensions(line: Equilibrium) -> Iterator[RopeTension]:
    """Of each rope."""
    for run, (used, ends) in zip(line.runs, _places(line.model), strict=True):
        highest = line.outputs[used] * np.array([span.rope.breaking_load for span in run.spans])
        k = int(np.argmax(highest))
        yield RopeTension(run.name, run.rope, float(highest[k]), float(line.outputs[ends].min()), run.spans[k].name)


@kept_with_model
def _places(model: Model) -> list[tuple[np.ndarray, np.ndarray]]:
    """For each run the places of utilisation (spans,) and of tensions at both ends (2 spans,) in the outputs."""
    y = model.y.index
    return [
        (
            np.array([y[f"{span.name}.utilisation"] for span in run.spans]),
            np.array([y[f"{span.name}.tension_{end}"] for span in run.spans for end in "ab"]),
        )
        for run in model.runs
    ]
