"""The grip of a rope on a control sheave."""

import numpy as np
import pytest

from ropeway.components.control_sheave import grip_margin


@pytest.mark.parametrize(("friction", "turns"), [(0.2, 1000.0), (1e6, 1.0)])
def test_it_is_finite_however_often_a_rope_is_wound(friction: float, turns: float) -> None:
    assert np.isfinite(grip_margin(friction, 0.1, turns, 4e4, 3e4))


def test_it_is_that_of_a_capstan() -> None:
    assert grip_margin(0.2, 0.5, 1.0, 4e4, 2e4) == pytest.approx(np.exp(0.2 * (0.5 + 2.0 * np.pi)) - 2.0, rel=1e-12)
