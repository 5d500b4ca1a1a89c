"""Which load is in which span: loads assigned to the spans where the rope takes them, and loads that follow."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ropeway.components.errors import EquilibriumError
from ropeway.systems.modelling.rope_path import Loads, extended, loads_passed, rounds
from ropeway.systems.statics.line_state import LineState


def assign_loads(state: LineState) -> bool:
    """Assigns each load to the span where the rope has taken it. False where one had to change its span."""
    moved = False
    for r, run in enumerate(state.runs):
        rope = state.rope(r)
        if run.loads.pins:
            before, run = run.loads.names, replace(run, loads=run.loads.sorted(rope))
            state.runs[r], moved = run, moved or run.loads.names != before
        if run.around:
            _wind(state, r, rope)
        elif run.feed is not None and run.loads.place[-1] > rope[0]:
            extend(state, r)
        run = state.runs[r]
        # A load that stands on a support to rounding stays where it is.
        near = 1e-10 * (1.0 + np.abs(rope))
        least, most = loads_passed(run, np.array([rope + near, rope - near]))
        beyond = np.minimum(np.maximum(state.passed[r], least), most)
        if run.around:
            beyond[-1] = beyond[0] - run.around
        if (beyond != state.passed[r]).any():
            moved = True
            state.passed[r] = beyond
    if moved:
        state.write_slots()
    return not moved


def take_more(state: LineState, r: int) -> None:
    """Lists more loads of a run from its feed where the last one, or on an endless rope the first one, is near."""
    run = state.runs[r]
    if run.feed is not None and state.passed[r][0] >= len(run.loads.place) - 1:
        extend(state, r)
    if run.around and state.passed[r][-1] < 1:
        extend(state, r, ahead=True)


def extend(state: LineState, r: int, *, ahead: bool = False) -> None:
    """Doubles the listed loads of a run with a feed: behind the last, or `ahead` of the first where the rope is
    endless."""
    run = state.runs[r]
    if run.feed is None:
        return
    if not run.around:
        loads = extended(run.loads, run.feed, len(run.loads.place))
    else:
        there = len(run.loads.place) // run.around
        before, behind = (there, there - 1) if ahead else (0, 2 * there - 1)
        loads = rounds(run.loads, 0, run.around, state.length(r), before, behind)
    state.passed[r] += run.loads.first - loads.first
    state.runs[r] = replace(run, loads=loads)


def loads_once(state: LineState, r: int) -> Loads:
    """The loads of an endless rope once, in the order of their numbers from 0 on."""
    run, length = state.runs[r], state.length(r)
    turn, before = divmod(-run.loads.first, run.around)
    loads = rounds(run.loads, before, run.around, length, 0, 0)
    return replace(loads, place=loads.place - turn * length, first=0)


def _wind(state: LineState, r: int, rope: np.ndarray) -> None:
    """Lists the loads of an endless rope for its present length, in as many rounds as the places on `rope` need."""
    run, length = state.runs[r], state.length(r)
    begin = int(np.clip(state.passed[r][-1], 0, len(run.loads.place) - run.around))
    on = run.loads.place[begin : begin + run.around]
    ahead = max(1, int(np.ceil((rope[-1] - on[0]) / length)) + 1)
    behind = max(1, int(np.ceil((on[-1] - rope[0]) / length)) + 1)
    loads = rounds(run.loads, begin, run.around, length, ahead, behind)
    state.passed[r] += run.loads.first - loads.first
    state.runs[r] = replace(run, loads=loads)


def require_pinned(state: LineState) -> None:
    """Raises EquilibriumError where a span does not have enough rope for a load that hangs at a distance on it."""
    for r, run in enumerate(state.runs):
        loads = run.loads
        if not loads.pins:
            continue
        pinned = np.flatnonzero((loads.pinned >= 0) & (loads.at > 0.0))
        room = np.diff(state.rope(r)) + state.model.layouts[r].free(state.point.z)
        for i in pinned:
            span = run.spans[loads.pinned[i]].name
            if loads.at[i] > room[loads.pinned[i]] * (1.0 + 1e-9):
                raise EquilibriumError(
                    f"Load {loads.names[i]!r} hangs {loads.at[i]:.6g} m along span {span!r}, which has "
                    f"{room[loads.pinned[i]]:.6g} m of rope at rest",
                    "Hang it nearer to the span's end a, or on all spans of the rope at its distance along them",
                    span,
                )


def unpin(state: LineState) -> None:
    """Clamps pinned loads to the rope where they hang, so that they travel with it."""
    for r, run in enumerate(state.runs):
        loads = run.loads
        state.runs[r] = replace(run, loads=replace(loads, pinned=np.full(len(loads.pinned), -1)))
    state.write_slots()
