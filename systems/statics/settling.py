"""A line at rest: each load in its span, the ropes in balance over their idlers, and of several roots the one that a
taut rope leads to."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace

import numpy as np

from ropeway.components.errors import EquilibriumError
from ropeway.systems.modelling.rope_path import Run
from ropeway.systems.solvers.section_newton import solve_line
from ropeway.systems.statics.certificate.certify import certify
from ropeway.systems.statics.certificate.checks import Certificate
from ropeway.systems.statics.continuation import solve_algebraic
from ropeway.systems.statics.line_state import LineState
from ropeway.systems.statics.load_positions import assign_loads, require_pinned
from ropeway.systems.statics.stability import slack

_STEP = 1.0 / 40.0
"""Largest step, as a share of the rope that is let out."""
_FIRST_SHARE, _LEAST_SHARE = 1.0 / 16.0, 1.0 / 256.0
"""Share of the loads' masses to begin with, and the smallest step of it."""
_GROWS, _GROWS_NEARBY = 5, 1
"""How often a line may need more load slots in its spans: beyond that its rope runs away."""
_LIGHT = 0.25
"""Weight of the loads in one span, over the highest tension, below which loads are not the cause of a failure: they
turn the rope by less than this angle [rad], far less than where a rope at a set tension runs out."""


def solve(state: LineState, *, quick: bool = False) -> None:
    """Solves a state for rest, and certifies it; quick: by Newton's method alone, from nearby. Raises
    EquilibriumError."""
    settle(state, quick=quick)
    certified(state).require(state.model)


def certified(state: LineState) -> Certificate:
    """The certificate of a state."""
    return certify(state.model, state.point, state.runs, state.passed)


def settle(state: LineState, *, quick: bool = False, by_sections: bool = False) -> None:
    """Solves a state and assigns its loads until each is in its span; quick: by Newton's method alone;
    by_sections: in the compiled core by sections. Raises EquilibriumError."""
    seen: set[bytes] = set()
    models = [state.model]
    for _ in range(200):
        if quick:
            solve_line(state.model, state.point, state.passed)
        else:
            solve_algebraic(state, by_sections=by_sections)
        before = [p.copy() for p in state.passed]
        if assign_loads(state):
            require_pinned(state)
            return
        if state.model is not models[-1]:
            models.append(state.model)
            if len(models) - 1 > (_GROWS_NEARBY if quick else _GROWS):
                raise EquilibriumError(
                    f"More and more loads of system {state.model.name!r} run into one span",
                    "Take lighter or fewer loads, or more tension",
                )
        key = b"".join(p.tobytes() for p in state.passed)
        if key in seen:  # a load that can hang in neither of two spans stands on the support between them
            for r, (was, now) in enumerate(zip(before, state.passed, strict=True)):
                for k in np.flatnonzero(was != now):
                    state.hold(r, int(k), int(min(was[k], now[k])))
        seen.add(key)
    raise EquilibriumError(
        f"The loads of system {state.model.name!r} do not settle in spans",
        "Loads stand close to a support: move them a little",
    )


def share_lengths(state: LineState, names: Iterable[str]) -> None:
    """Where the length of a span over idlers is among the names: gives all spans their lengths at rest, which the user
    knows, instead of those of the initial guess."""
    spans = {name.rpartition(".length")[0] for name in names}
    runs = [run for run in state.model.runs if any(node.balance is not None for node in run.nodes)]
    if spans.isdisjoint(span.name for run in runs for span in run.spans):
        return
    rest = LineState.cold(state.model)
    solve(rest)
    rest.rezero()
    for layout in state.model.layouts:
        state.point.p[layout.length_start] = rest.point.p[layout.length_start]


def keep_taut_root(state: LineState) -> None:
    """Replaces the equilibrium of a slack line with loads by the one that a taut line leads to as rope is let out.

    Where that path cannot be followed, the equilibrium stays.
    """
    if not any(len(run.loads.place) for run in state.runs) or not slack(state) or state.standing():
        return
    try:
        trial = let_out(state, least_step=_STEP)
    except EquilibriumError:
        return
    if not trial.standing() and any(np.any(a != b) for a, b in zip(trial.passed, state.passed, strict=True)):
        state.model, state.point, state.runs, state.passed = trial.model, trial.point, trial.runs, trial.passed


def let_out(
    state: LineState, least_step: float = _STEP / 16.0, advance: Callable[[float], None] = lambda share: None
) -> LineState:
    """The state that a taut rope leads to as it is let out to its length, loads at the same share of it; in steps of at
    least `least_step` of the rope let out. `advance` takes the share that is done. Raises EquilibriumError.
    """
    trial = _afresh(state)
    lengths = [state.point.p[layout.length_start].copy() for layout in state.model.layouts]
    runs, chords = tuple(state.runs), [np.diff(trial.points(r), axis=0) for r in range(len(state.runs))]
    taut = [
        min(float(np.linalg.norm(chord, axis=1).sum()) * (1.0 + 1e-4) / float(length.sum()), 1.0)
        for chord, length in zip(chords, lengths, strict=True)
    ]

    def longer(share: float) -> None:
        for r, (run, layout) in enumerate(zip(runs, trial.model.layouts, strict=True)):
            part = taut[r] + share * (1.0 - taut[r])
            trial.point.p[layout.length_start] = part * lengths[r]
            loads = run.loads
            trial.runs[r] = replace(run, loads=replace(loads, place=part * loads.place, at=part * loads.at))

    if any(node.set_tension is not None for run in runs for node in run.nodes):
        raise EquilibriumError(
            f"A drum of system {state.model.name!r} sets the tension at any length of rope", "Check its tension"
        )
    longer(0.0)
    trial.restart()
    solve(trial)
    done, step = 0.0, _STEP
    while done < 1.0:
        saved = trial.copy()
        share = min(1.0, done + step)
        try:
            longer(share)
            trial.write_slots()
            solve(trial, quick=True)
        except EquilibriumError:
            step /= 2.0
            if step < least_step:
                raise
            trial = saved
            continue
        done, step = share, min(2.0 * step, _STEP)
        advance(done)
    return trial


def _afresh(state: LineState) -> LineState:
    """A state from geometry with the parameters, inputs, drives and loads of another; no load stands on an idler."""
    trial = LineState.cold(state.model)
    for vector in ("x", "u", "p"):
        getattr(trial.point, vector)[:] = getattr(state.point, vector)
    kept = state.model.kept
    trial.point.d[kept] = state.point.d[kept]
    trial.runs = list(state.runs)
    for r, k, _ in trial.standing():
        trial.release(r, k)
    return trial


def _bends(state: LineState, r: int) -> float:
    """Weight of the loads in the heaviest loaded span of a run, over the highest tension of the run."""
    run, passed, y, index = state.runs[r], state.passed[r], state.outputs(), state.model.y.index
    total = np.concatenate([[0.0], np.cumsum(run.loads.mass)])
    counts = np.clip(passed, 0, len(run.loads.mass))
    heaviest = float((total[counts[:-1]] - total[counts[1:]]).max()) * state.model.system.gravity
    return heaviest / max(float(y[index[f"{span.name}.tension_{end}"]]) for span in run.spans for end in "ab")


class TooHeavyError(EquilibriumError):
    """A line has no equilibrium because of its loads."""


def loaded(state: LineState, advance: Callable[[float], None] = lambda share: None) -> LineState:
    """The state that a line leads to as its loads grow from a small share of their masses to all. `advance` takes the
    share that is reached. Raises TooHeavyError; EquilibriumError where loads are not the cause.
    """
    share = _FIRST_SHARE
    try:
        near = _lightly_loaded(state, share)
    except EquilibriumError:
        share *= _FIRST_SHARE
        near = _lightly_loaded(state, share)
    step = share
    while share < 1.0 and step >= _LEAST_SHARE:
        more, trial = min(1.0, share + step), near.copy()
        trial.runs = [_scaled(run, more / share) for run in trial.runs]
        try:
            trial.write_slots()
            solve(trial, quick=True)
        except EquilibriumError:
            step /= 2.0
        else:
            near, share, step = trial, more, 2.0 * step
            advance(share)
    if share < 1.0:
        raise _not_loaded(near, share)
    return near


def _lightly_loaded(state: LineState, share: float) -> LineState:
    """The state with a small share of its loads, from geometry. Raises EquilibriumError."""
    near = _afresh(state)
    near.runs = [_scaled(run, share) for run in near.runs]
    near.restart()
    solve(near)
    return near


def _scaled(run: Run, factor: float) -> Run:
    """A run with the masses of all its loads multiplied, also of those of its feed."""
    loads, feed = replace(run.loads, mass=factor * run.loads.mass), run.feed
    if feed is not None:
        feed = replace(feed, masses=tuple(factor * mass for mass in feed.masses))
    return replace(run, loads=loads, feed=feed)


def _not_loaded(near: LineState, share: float) -> EquilibriumError:
    """The error for a line that holds a `share` of its loads, in the state `near`, and hardly more. A rope of fixed
    length holds any load until it breaks: there loads are not the cause."""
    cause = f"The loads of system {near.model.name!r} are too heavy for its rope"
    part, strongest = f"{100.0 * share:.2g} %", certified(near).utilisation
    if strongest is not None and not strongest.holds:
        return TooHeavyError(
            f"{cause}: with {part} of them the tension in span {strongest.component!r} is {strongest.value:.3g} times "
            "its minimum breaking load",
            "Take lighter or fewer loads, more sag or a stronger rope",
            strongest.component,
        )
    if any(_gives_way(run) and _bends(near, r) >= _LIGHT for r, run in enumerate(near.runs)):
        return TooHeavyError(
            f"{cause}: as it is strung it holds {part} of them, and hardly more",
            "Take lighter or fewer loads, or more tension",
        )
    return EquilibriumError(f"No equilibrium of system {near.model.name!r} is found", "Start from a nearby one")


def _gives_way(run: Run) -> bool:
    """Whether a drum or a wheel on a slide lets rope out at a set force, so that too heavy loads pull it out."""
    return any(
        node.set_tension is not None or any(place not in {"x", "y", "z"} for place, _ in node.free)
        for node in run.nodes
    )
