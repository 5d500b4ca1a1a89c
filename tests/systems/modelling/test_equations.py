"""Derivatives of a model's equations: closed forms of spans against differentiation of all of them."""

from collections.abc import Callable
from typing import Any

import casadi as ca
import numpy as np
import pytest

import ropeway as rw
from ropeway.systems.modelling.equations import equations
from support import lines, nets


@pytest.mark.parametrize("declared", [lambda: lines.random_line(4).system(), nets.published_net])
def test_closed_forms_are_the_derivatives(declared: Callable[[], rw.System]) -> None:
    model = rw.assemble(declared())
    point = rw.equilibrium(model).point
    symbols = [model.sym(str(i), len(v)) for i, v in enumerate(point.arguments)]
    rate = model.sym("rate", len(model.x))
    rows = list(range(len(model.r)))

    def derivatives(*, closed: bool) -> Any:
        residuals = equations(model, symbols, closed=closed)[1].scaled(ca.DM(1.0 / model.r.nominals)).only(rows)
        moved = ca.densify(residuals.along([(symbols[1], rate)])) if len(model.x) else ca.SX(0, 1)
        found = ca.Function("found", [*symbols, rate], [residuals.value, residuals.jacobian(symbols[2]), moved])
        values = found(*point.arguments, np.linspace(1.0, 2.0, len(model.x)))
        return [np.array(value) for value in values]

    assert model.structure.closures is not None
    for own, rules in zip(derivatives(closed=True), derivatives(closed=False), strict=True):
        np.testing.assert_allclose(own, rules, rtol=1e-9, atol=1e-12 * np.abs(rules).max(initial=1.0))
