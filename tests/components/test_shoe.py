"""A rope that passes over a shoe, by its points."""

import numpy as np
import pytest

from ropeway.components import catenary, shoe


@pytest.mark.parametrize(("height", "before"), [(0.02, 0.3), (-0.004, 0.3), (0.02, -0.3)])
def test_clearance_of_a_rope_over_a_shoe(height: float, before: float) -> None:
    """Against the least distance of points along the rope; where its end is before the shoe, that."""
    radius, weight, strain = 3.0, 7.0, catenary.Strain(1e-7, 0.0)
    end = (before, np.sqrt(radius**2 - before**2) + height)
    force = (4000.0, 0.0, -4000.0 * np.sin(before / radius) + 300.0)
    back = np.linspace(0.0, 2.0, 200001)
    reach = catenary.segment((force[0], 0.0, force[2] - weight * back), weight, back, strain).reach
    away = np.hypot(end[0] - reach[0], end[1] - reach[2])
    least = int(np.argmin(away))
    found = float(shoe.clearance(end, force, weight, strain, radius))
    if 0 < least < len(back) - 1:
        assert found == pytest.approx(away[least] - radius, abs=1e-9)
    else:
        assert found > 0.1
