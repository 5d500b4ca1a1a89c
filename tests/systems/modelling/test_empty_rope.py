"""The empty rope: spans side by side against one by one, and tensions for lengths against lengths for tensions."""

import numpy as np
import pytest

from ropeway.components.catenary import Strain
from ropeway.components.errors import SlackRopeError
from ropeway.systems.modelling.complex_newton import solve_side_by_side
from ropeway.systems.modelling.empty_rope import (
    lengths_between,
    lengths_for_tension,
    lengths_for_total,
    support_tensions,
    tension_for_total,
)

WEIGHT, STRAIN = 34.0, Strain(1.0 / 34.8e6, 2e-15)
POINTS = np.array([[0.0, 0.0, 15.0], [90.0, 4.0, 3.0], [210.0, 0.0, 30.0], [300.0, 1.0, -8.0]])
NAMES = ["a_b", "b_c", "c_d"]


def test_a_length_and_its_tension_belong_together() -> None:
    lengths = lengths_for_tension(POINTS, WEIGHT, STRAIN, 60e3, NAMES)
    total = float(lengths.sum())
    assert tension_for_total(POINTS, WEIGHT, STRAIN, total, NAMES) == pytest.approx(60e3, rel=1e-9)
    np.testing.assert_allclose(lengths_for_total(POINTS, WEIGHT, STRAIN, total, NAMES), lengths, rtol=1e-12)


def test_spans_side_by_side_are_those_of_the_rope() -> None:
    lengths = lengths_for_tension(POINTS, WEIGHT, STRAIN, 60e3, NAMES)
    found = lengths_between(POINTS[2::-1], POINTS[:0:-1], WEIGHT, STRAIN, 60e3, 15.0)
    np.testing.assert_allclose(found, lengths[::-1], rtol=1e-13)


def test_a_span_without_a_taut_root_leaves_the_others_alone() -> None:
    """4 kN are too low for the long span, and there is no tension left 150 m below; the first span is solved."""
    starts = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, -150.0]])
    ends = np.array([[50.0, 0.0, 1.0], [900.0, 0.0, 0.0], [50.0, 0.0, -150.0]])
    found = lengths_between(starts, ends, WEIGHT, STRAIN, 4e3, 0.0)
    alone = lengths_for_tension([starts[0], ends[0]], WEIGHT, STRAIN, 4e3, ["a_b"])
    assert found[0] == pytest.approx(float(alone[0]), rel=1e-13)
    assert np.isnan(found[1:]).all()
    with pytest.raises(SlackRopeError, match="too low"):
        lengths_for_tension([starts[1], ends[1]], WEIGHT, STRAIN, 4e3, ["a_b"])
    with pytest.raises(SlackRopeError, match="zero at support"):
        support_tensions(np.array([starts[0], starts[2]]), WEIGHT, STRAIN, 4e3)


def test_a_singular_problem_has_no_root_and_the_others_have_theirs() -> None:
    roots = solve_side_by_side(
        lambda u: np.stack([u[..., 0] * np.array([1.0, 0.0]) - 2.0], axis=-1),
        np.ones((2, 1)),
        lambda u, move: np.abs(move[:, 0] / u[:, 0]),
        longest=10.0,
    )
    assert roots.unknowns[0, 0] == pytest.approx(2.0)
    assert roots.converged.tolist() == [True, False]
