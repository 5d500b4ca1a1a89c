"""Continuation where Newton's method does not converge from its initial guess."""

from __future__ import annotations

import numpy as np

from ropeway.components.errors import EquilibriumError
from ropeway.systems.solvers.compiled_line import compiled_line
from ropeway.systems.solvers.newton import Newton, newton_of
from ropeway.systems.solvers.section_newton import solve_line
from ropeway.systems.statics.line_state import LineState


def solve_algebraic(state: LineState, *, by_sections: bool = False) -> None:
    """Newton's method, then continuation in the damping of the idlers and in the rope's stiffness; by_sections: the
    first in the compiled core by sections. Raises EquilibriumError."""
    try:
        if by_sections:
            compiled_line(state.model).solve_point(state.point, state.passed)
        else:
            solve_line(state.model, state.point, state.passed)
        return
    except EquilibriumError as error:
        first, start = error, state.point.copy()  # which is as it was
    newton = newton_of(state.model)
    for method in (_release_idlers, _stiffen) if state.model.layouts else ():
        for scale in (1.0, 0.3, 3.0):
            state.point.z[:] = start.z
            for layout in state.model.layouts:
                for axis in range(3):
                    state.point.z[layout.force + axis] *= scale
            try:
                method(newton, state)
                return
            except EquilibriumError:
                state.point.p[:] = start.p
    raise first


def _release_idlers(newton: Newton, state: LineState) -> None:
    """Newton's method with damped travels of the idlers, in steps down to none."""
    for power in range(3, -5, -1):
        newton.solve(state.point, damping=10.0**power)
    newton.solve(state.point)


def _stiffen(newton: Newton, state: LineState) -> None:
    """Newton's method with a soft rope, in steps up to its stiffness: a nearly inextensible rope can be hard to
    start."""
    places = np.concatenate([layout.compliance for layout in state.model.layouts])
    wanted = state.point.p[places].copy()
    for power in range(-5, -13, -1):
        state.point.p[places] = np.maximum(wanted, 10.0**power)
        newton.solve(state.point)
    state.point.p[places] = wanted
    newton.solve(state.point)
