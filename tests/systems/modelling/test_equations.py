"""Derivatives of a model's equations: closed forms of spans against differentiation of all of them."""

from collections.abc import Callable
from typing import Any

import casadi as ca
import numpy as np
import pytest

import ropeway as rw
from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.modelling.equations import equations
from ropeway.systems.solvers.points import Point
from support import lines, nets


def _at_rest(declared: Callable[[], rw.System]) -> tuple[Model, Point]:
    model = rw.assemble(declared())
    assert model.structure.closures is not None
    return model, rw.equilibrium(model).point


def _moving() -> tuple[Model, Point]:
    """A line with inertia, whose loads have just started to swing."""
    moved = rw.simulate(lines.random_line(4).system(), 0.2, inertia=rw.Inertia(), progress=False).at(0.2)
    assert moved.model.structure.nested is not None
    return moved.model, moved.point


@pytest.mark.parametrize(
    "made",
    [lambda: _at_rest(lambda: lines.random_line(4).system()), lambda: _at_rest(nets.published_net), _moving],
    ids=["line", "net", "inertia"],
)
def test_closed_forms_are_the_derivatives(made: Callable[[], tuple[Model, Point]]) -> None:
    model, point = made()
    symbols = [model.sym(str(i), len(v)) for i, v in enumerate(point.arguments)]
    rate = model.sym("rate", len(model.x))
    rows = list(range(len(model.r)))

    def derivatives(*, closed: bool) -> Any:
        residuals = equations(model, symbols, closed=closed)[1].scaled(ca.DM(1.0 / model.r.nominals)).only(rows)
        moved = ca.densify(residuals.along([(symbols[1], rate)])) if len(model.x) else ca.SX(0, 1)
        found = ca.Function("found", [*symbols, rate], [residuals.value, residuals.jacobian(symbols[2]), moved])
        values = found(*point.arguments, np.linspace(1.0, 2.0, len(model.x)))
        return [np.array(value) for value in values]

    for own, rules in zip(derivatives(closed=True), derivatives(closed=False), strict=True):
        np.testing.assert_allclose(own, rules, rtol=1e-9, atol=1e-12 * np.abs(rules).max(initial=1.0))
