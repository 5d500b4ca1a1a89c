"""Loads that cross supports: the time of the next crossing, and its effect on the state of the line.

A load at place c on the rope stands on support k exactly when the support's travel is X_k - c, with X_k the rope at the
support at zero travel: a threshold known in advance. At a crossing the load changes spans; tensions and the travel of
idlers jump. Where a sheave holds the rope down, the load can be pushed back from both sides; then it stands on the
sheave, which carries it, until the pull of one side prevails.

A drum that sets a tension can draw back a load that is put on there. Such a load rests on the drum until the rope takes
it away.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np

from ropeway.systems.dynamics.chattering import FinalError
from ropeway.systems.modelling.dae_model import Model, kept_with_model
from ropeway.systems.solvers.newton import residuals_of
from ropeway.systems.statics.line_state import LineState, end_force, load_force, read_value
from ropeway.systems.statics.load_positions import take_more
from ropeway.systems.statics.stability import unstable

PUT_ON, TAKEN_OFF = "load put on", "load taken off"
NEAR = 1e-9
"""A load is on a support within this part of the neighbouring span."""


class Crossing(NamedTuple):
    """The load of number `load` at support `k` of run `r`; forward: from a to b. `time` [s] from now, at present
    speed, and `gap` [m] of travel until then; both negative when overdue. Where an endless rope begins and ends, at
    k = 0, one crossing is that of both ends."""

    time: float
    gap: float
    r: int
    k: int
    load: int
    forward: bool

    def opposite(self, other: Crossing) -> bool:
        """Whether one is the way back of the other."""
        return (self.r, self.k, self.load) == (other.r, other.k, other.load) and self.forward != other.forward


@dataclass(frozen=True)
class Gaps:
    """How far each support's travel is from the next load that crosses it, shapes (supports,) [m]: `ahead`
    forward and `behind` backward, negative where the threshold has been passed; inf where there is none."""

    ahead: np.ndarray
    behind: np.ndarray


def gaps(state: LineState, r: int) -> Gaps:
    """The gaps of a run; takes more loads from its feed when the last one is near."""
    take_more(state, r)
    run = state.runs[r]
    beyond, rope = state.passed[r], state.rope(r)
    padded = np.concatenate([[np.inf], state.runs[r].loads.place, [-np.inf]])
    # rope falls as travel grows: the next load forward is the first that has not passed.
    ahead, behind = rope - padded[beyond + 1], padded[beyond] - rope
    if run.around:  # the wheel where the rope begins and ends counts once
        ahead[-1] = behind[-1] = np.inf
    # No load crosses a sheave on which another one stands.
    busy = state.busy(r)
    ahead[busy] = behind[busy] = np.inf
    for (own, k), (load, further) in state.resting.items():
        if own == r and load == _number(state, r, k, forward=k == 0):
            (ahead if k == 0 else behind)[k] += further
    return Gaps(ahead, behind)


def _number(state: LineState, r: int, k: int, *, forward: bool) -> int:
    """Number of the load that crosses support k next."""
    return int(state.passed[r][k]) + state.runs[r].loads.first - (0 if forward else 1)


def next_crossing(state: LineState, rates: list[np.ndarray]) -> Crossing | None:
    """The first crossing at the present `rates` of travel of each run [m/s]; overdue ones have a negative time. None if
    no load moves towards a support."""
    best: Crossing | None = None
    for r, rate in enumerate(rates):
        gap = gaps(state, r)
        with np.errstate(divide="ignore", invalid="ignore"):
            times = np.where(rate > 1e-12, gap.ahead / rate, np.where(rate < -1e-12, gap.behind / -rate, np.inf))
        k = int(np.argmin(times))
        if np.isfinite(times[k]) and (best is None or times[k] < best.time):
            forward = bool(rate[k] > 0.0)
            load = _number(state, r, k, forward=forward)
            best = Crossing(float(times[k]), float(gap.ahead[k] if forward else gap.behind[k]), r, k, load, forward)
    return best


def gap_of(state: LineState, crossing: Crossing, rates: list[np.ndarray]) -> Crossing:
    """The same crossing with its time and gap from the present state."""
    gap, rate = gaps(state, crossing.r), float(rates[crossing.r][crossing.k])
    value = float((gap.ahead if crossing.forward else gap.behind)[crossing.k])
    way = rate if crossing.forward else -rate
    return crossing._replace(gap=value, time=value / way if way > 1e-12 else np.inf)


def _at(state: LineState, r: int, k: int, *, forward: bool) -> Crossing:
    """The next crossing of support k, here."""
    return Crossing(0.0, 0.0, r, k, _number(state, r, k, forward=forward), forward)


def due(state: LineState, first: Crossing, rates: list[np.ndarray]) -> list[Crossing]:
    """All crossings that happen at the time of the first one, itself among them."""
    found = [first]
    for r, rate in enumerate(rates):
        gap, near = gaps(state, r), NEAR * state.span_scale[r]
        ahead = np.flatnonzero((np.abs(gap.ahead) <= near) & (rate > 0.0))
        behind = np.flatnonzero((np.abs(gap.behind) <= near) & (rate < 0.0))
        found += [_at(state, r, int(k), forward=True) for k in ahead]
        found += [_at(state, r, int(k), forward=False) for k in behind]
    return [first, *(c for c in found[1:] if (c.r, c.k) != (first.r, first.k))]


def overrun(state: LineState, just: set[tuple[int, int]]) -> list[Crossing]:
    """Loads that a jump of the line has moved past a support; at the ends of a run, not those of `just` (run, support),
    which have been put on or taken off there."""
    found = []
    for r in range(len(state.passed)):
        gap, near = gaps(state, r), NEAR * state.span_scale[r]
        ends = (0, len(gap.ahead) - 1)
        skip = {k for k in ends if (r, k) in just}
        found += [
            _at(state, r, int(k), forward=forward)
            for forward, left in ((True, gap.ahead), (False, gap.behind))
            for k in np.flatnonzero(left < -near)
            if k not in skip
        ]
    return found


def passes(state: LineState, crossing: Crossing) -> bool:
    """Whether the load passes its support, rather than being pushed back onto it: after the support it hangs on the
    other side, and the rope must continue to move."""
    run, layout = state.runs[crossing.r], state.model.layouts[crossing.r]
    k = crossing.k
    if layout.held[k] < 0 or not 0 < k < len(run.nodes) - 1:
        return True
    force = prevailing(state, crossing.r, k, crossing.load - run.loads.first)
    return (force.forward if crossing.forward else force.backward) >= -1e-9 * force.size  # a load without mass passes


@dataclass(frozen=True)
class Prevailing:
    """Forces by which each side of an idler draws a load on it away [N]: `forward` with the load on the rope out,
    `backward` with it on the rope in; `size` is the tension they are compared with."""

    forward: float
    backward: float
    size: float


def prevailing(state: LineState, r: int, k: int, load: int) -> Prevailing:
    """The forces on the load at support k: `load` is its place in the list of loads.

    With f the tension vectors of the rope beside the load and P z its weight (with wind on it a vector P), forward it
    is |f_out - P z| - |f_in|, and backward |f_in + P z| - |f_out|, without friction; else the idler's own tension law.
    """
    layout, run, z, p = state.model.layouts[r], state.runs[r], state.point.z, state.point.p
    beyond, mass, gravity = state.passed[r], run.loads.mass, p[0]
    going = z[layout.force[k] : layout.force[k] + 3]
    if state.model.weather:
        read = partial(read_value, state.model, state.point, state.outputs())
        coming = end_force(state.model, run, k - 1, read)
        pull = -np.array(load_force(state.model, mass[load], run.loads.drag[load], read))
    else:
        pull = np.array([0.0, 0.0, mass[load] * gravity])
        coming = z[layout.force[k - 1] : layout.force[k - 1] + 3].copy()
        rope = layout.start(p)[k - 1 : k + 1] - layout.travel.read(state.point.x, z)[k - 1 : k + 1]
        carried = p[layout.mass_per_length[k - 1]] * (rope[1] - rope[0]) + mass[beyond[k] : beyond[k - 1]].sum()
        coming[2] += carried * gravity
    before = load >= beyond[k]  # it hangs at the end of the span before
    # What the load's side changes in both ropes' forces.
    ahead, behind = (-pull, 0.0 * pull) if before else (0.0 * pull, pull)
    t_in, t_out = _length(coming), _length(going)
    if state.point.d[layout.held[k]] > 0.0 or abs(t_out - t_in) > 1e-9 * t_in:
        return Prevailing(_law(state, r, k, ahead), -_law(state, r, k, behind), t_in)
    return Prevailing(
        _length(going + ahead) - _length(coming + ahead), _length(coming + behind) - _length(going + behind), t_in
    )


def _length(force: np.ndarray) -> float:
    """Magnitude of a force."""
    return float(np.sqrt(force[0] ** 2 + force[1] ** 2 + force[2] ** 2))


def _law(state: LineState, r: int, k: int, more: np.ndarray) -> float:
    """Residual of an idler's tension law [N], tension out less what the tension in balances, with the forces of both
    ropes larger by a vector; no load holds the idler."""
    layout, point = state.model.layouts[r], state.point
    z, d = point.z.copy(), point.d.copy()
    for span in (k - 1, k):
        z[layout.force[span] : layout.force[span] + 3] += more  # the force at the end follows that at the start
    d[layout.held[k]] = 0.0
    row = balances_of(state.model)[int(layout.travel.algebraic[k])]
    return float(residuals_of(state.model)(*replace(point, z=z, d=d).arguments)[0][row])


@kept_with_model
def balances_of(model: Model) -> dict[int, int]:
    """The residual that balances each algebraic travel."""
    return {balance.travel: balance.residual for balance in model.balances}


def apply(state: LineState, crossing: Crossing, *, passing: bool | None = None) -> str:
    """Moves the load to the next span, or leaves it on the support; returns the event. `passing`: whether it moves, by
    default as `passes` decides. The line is not solved. Raises EquilibriumError where no load can stand.
    """
    run, k = state.runs[crossing.r], crossing.k
    if not (passes(state, crossing) if passing is None else passing):
        state.hold(crossing.r, k, crossing.load - run.loads.first)
        return "load held"
    last = len(run.nodes) - 1
    for end in (0, last) if run.closed and k == 0 else (k,):
        state.passed[crossing.r][end] += 1 if crossing.forward else -1
        state.write_beside(crossing.r, end)
    return passing_event(state, crossing)


def passing_event(state: LineState, crossing: Crossing) -> str:
    """What happens when a load passes its support."""
    run, k = state.runs[crossing.r], crossing.k
    last = len(run.nodes) - 1
    entering = (k == 0 and crossing.forward) or (k == last and not crossing.forward)
    if k in (0, last) and not run.closed:
        return PUT_ON if entering else TAKEN_OFF
    return "crossing forward" if crossing.forward else "crossing backward"


def drawn_back(state: LineState, crossing: Crossing) -> float:
    """How far a load that has been put on hangs outside the rope's end [m], negative where it hangs in its span."""
    loads = state.runs[crossing.r].loads
    beyond = float(state.rope(crossing.r)[crossing.k] - loads.place[crossing.load - loads.first])
    return beyond if crossing.forward else -beyond


def can_rest(state: LineState, crossing: Crossing) -> bool:
    """Whether a load is put on at an end that lets rope in and out."""
    k, last = crossing.k, len(state.passed[crossing.r]) - 1
    free = state.model.layouts[crossing.r].travel.algebraic[k] >= 0
    return bool(free) and not state.runs[crossing.r].closed and k == (0 if crossing.forward else last)


def rest(state: LineState, crossing: Crossing, back: float) -> None:
    """Leaves a load on the drum that would draw it back by `back` [m]: a thousandth more than that."""
    load, further = state.resting.get((crossing.r, crossing.k), (crossing.load, 0.0))
    more = 1.001 * back + NEAR * state.span_scale[crossing.r]
    state.resting[crossing.r, crossing.k] = (crossing.load, more + (further if load == crossing.load else 0.0))


def require_order(state: LineState) -> None:
    """Raises EquilibriumError where loads have crossed a support without having reached the one before: the jump of the
    line does not converge."""
    for run, beyond in zip(state.runs, state.passed, strict=True):
        if np.any(np.diff(beyond) > 0):
            raise unstable(run.nodes[int(np.argmax(np.diff(beyond) > 0)) + 1].name)


def on_line(state: LineState) -> np.ndarray:
    """Number of loads in the slots of each run's spans, shape (runs,)."""
    return np.array([layout.slots.filled(state.point.d) for layout in state.model.layouts])


def require_all(state: LineState, before: np.ndarray, events: Sequence[tuple[Crossing, str]]) -> None:
    """Raises FinalError unless the loads on the line are those `before`, with those put on by the events and
    without those taken off."""
    expected = before.copy()
    for crossing, what in events:
        expected[crossing.r] += {PUT_ON: 1, TAKEN_OFF: -1}.get(what, 0)
    for r, (found, run, beyond) in enumerate(zip(on_line(state), state.runs, state.passed, strict=True)):
        if found != expected[r] or found != beyond[0] - beyond[-1] or np.any(np.diff(beyond) > 0):
            raise FinalError(
                f"Internal error: {found} loads are on {run.name} after a crossing, {expected[r]} should be",
                "Please report it, with the script",
                state.point.t,
            )


def pulls(state: LineState) -> list[tuple[Crossing, float]]:
    """For each load that stands on a sheave, forward and backward, the force by which that side prevails [N]: the load
    is released when it is positive."""
    found = []
    for r, k, travel in state.standing():
        place = state.model.layouts[r].start(state.point.p)[k] - travel
        load = int(np.argmin(np.abs(state.runs[r].loads.place - place)))
        force, number = prevailing(state, r, k, load), load + state.runs[r].loads.first
        found.append((Crossing(0.0, 0.0, r, k, number, True), force.forward))
        found.append((Crossing(0.0, 0.0, r, k, number, False), force.backward))
    return found


def let_go(state: LineState, crossing: Crossing) -> None:
    """Releases a load that stands on a sheave, to the side of the crossing."""
    state.release(crossing.r, crossing.k)
    first = state.runs[crossing.r].loads.first
    state.passed[crossing.r][crossing.k] = crossing.load - first + (1 if crossing.forward else 0)
    state.write_beside(crossing.r, crossing.k)
