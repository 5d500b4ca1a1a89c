"""How a loaded span gives: closed forms against the differentiated equations."""

import casadi as ca
import numpy as np
import pytest

import ropeway as rw
from ropeway.components.variable import Kind, Site, Variable
from ropeway.systems.modelling.component_functions import closure_function, component_function, force_function

ROPE = {"mass_per_length": 2.4, "axial_stiffness": 24e6, "breaking_load": 450e3, "diameter": 0.0254}
PARAMETERS = {
    "length_start": 100.0, "mass_per_length": 2.4, "compliance": 1.0 / 24e6, "construction": 3e-14,
    "breaking_load": 1e5, "diameter": 0.0254, "thermal_expansion": 11.5e-6, "drag_coefficient": 1.1,
}  # fmt: skip
WEATHER = [20.0, 300.0, 90.0, 15.0, 0.01, 900.0]
"""Temperature, wind pressure and direction, temperature of stringing, thickness and density of ice."""


def derivatives(span: rw.Span, variables: tuple[Variable, ...], *, weather: bool) -> ca.Function:
    """The closure's derivatives by differentiation, and in closed form; what the moves of the tension vector leave of
    closures, and these."""
    function = component_function(span, variables, weather=weather)
    inputs = function.sx_in()
    closure, (a, b) = function.call(inputs)[1], inputs[-2:]
    unknowns = [inputs[3], a[3], b[3]]
    by_rules = ca.horzcat(*(ca.jacobian(closure, one) for one in unknowns))
    own = closure_function(span, variables, weather=weather).call(inputs)[1]
    closure, moves = force_function(span, variables, weather=weather).call(inputs)
    undone = ca.mtimes(own[:, :3], moves) + ca.horzcat(closure, own[:, 3:])
    return ca.Function("all", inputs, [by_rules, own, undone, ca.horzcat(closure, own[:, 3:])])


@pytest.mark.parametrize("weather", [False, True])
@pytest.mark.parametrize("stretch", [None, rw.ConstructionStretch(0.0414)])
@pytest.mark.parametrize("loads", [0, 3])
def test_closed_forms_are_the_derivatives(loads: int, stretch: rw.ConstructionStretch | None, weather: bool) -> None:
    rope = rw.Rope(**ROPE) if stretch is None else rw.Rope(**ROPE, stretch=stretch)
    span = rw.Span("span", rope, 100.0)
    variables = span.variables(Site(1.0, 1.0, loads, weather=weather))
    both, rng = derivatives(span, variables, weather=weather), np.random.default_rng(3)
    given = [rng.uniform(0.5, 1.5, both.size_in(i)) for i in range(both.n_in())]
    given[1] = np.array([9.81, *WEATHER, 0.0][: both.size1_in(1)])
    given[5] = np.array([PARAMETERS[v.name] for v in variables if v.kind is Kind.PARAMETER])
    given[-2], given[-1] = np.zeros(4), np.array([95.0, 3.0, 2.0, 0.0])
    for _ in range(200):
        # Taut, slack, steep upwards and downwards, folded.
        level, upwards = 10.0 ** rng.uniform(0.0, 5.0), rng.normal() * 10.0 ** rng.uniform(0.0, 4.0)
        given[3] = np.array([0.8 * level, 0.6 * level, upwards])
        drag = [rng.uniform(0.0, 1.0, loads)] if weather else []
        slots = [rng.uniform(0.0, 300.0, loads), np.sort(rng.uniform(0.0, 100.0, loads)), rng.integers(0, 2, loads)]
        given[6] = np.concatenate([*slots, *drag, np.zeros(loads)])
        expected, found, left, sides = (np.array(values) for values in both(*given))
        size = np.abs(expected).max(axis=0)
        assert (np.abs(found - expected).max(axis=0) <= 1e-10 * size).all(), (level, upwards)
        rounding = np.linalg.cond(found[:, :3]) * 1e-14
        assert (np.abs(left).max(axis=0) <= rounding * np.abs(sides).max(axis=0)).all(), (level, upwards)
