"""LoggerPC's working assumptions (Brown et al. 1997, in Harvey 2013)."""

import numpy as np
import pytest

import ropeway as rw
from ropeway.components.errors import InputError
from ropeway.systems.studies.handbook.inextensible_catenary import catenary_for_sag
from ropeway.systems.studies.handbook.loggerpc import (
    AXIAL_STIFFNESS,
    haulback_drag,
    haulback_needed,
    log_friction,
    log_slope,
    lower_tension,
    stiffness_ratio,
)


def test_lower_tension_is_exact_for_the_catenary() -> None:
    forces = catenary_for_sag(200.0, -40.0, 10.0).forces(3.48)
    assert lower_tension(forces.tension_start, 3.48, 40.0) == pytest.approx(forces.tension_end, rel=1e-12)
    assert lower_tension(np.array([19600.0, 19600.0]), 3.48, np.array([20.0, 40.0])) == pytest.approx(
        [19530.4, 19460.8]
    )


def test_log_friction() -> None:
    assert log_friction(np.array([-0.3, 0.0, 0.9, 1.0, 1.1])) == pytest.approx([0.9, 0.9, 0.9, 1.0, 1.1])
    with pytest.raises(InputError, match="ground slope"):
        log_friction(1.2)


def test_log_slope_is_the_slope_of_the_terrain_step_before_the_carriage() -> None:
    x, z = [0.0, 10.0, 25.0, 40.0], [0.0, 4.0, 7.0, 16.0]
    assert log_slope(x, z, 25.0) == pytest.approx(0.2)
    assert log_slope(x, z, 39.0) == pytest.approx(0.2)
    assert log_slope(x, z, 40.0, log_run=14.0) == pytest.approx(0.6)
    with pytest.raises(InputError, match="more than the terrain step"):
        log_slope(x, z, 40.0, log_run=16.0)
    for place in (5.0, 41.0):
        with pytest.raises(InputError, match="no terrain point before"):
            log_slope(x, z, place)
    with pytest.raises(InputError, match="at least two"):
        log_slope([0.0], [0.0], 0.0)


def test_haulback() -> None:
    assert haulback_needed(np.array([0.1, 0.2, 0.3]), downhill=False).tolist() == [True, False, False]
    assert haulback_needed(0.5, downhill=True)
    assert haulback_drag(300.0, 10.0) == pytest.approx(1500.0)
    with pytest.raises(InputError, match="downhill=True"):
        haulback_needed(-0.3, downhill=False)


def test_one_stiffness_for_all_ropes() -> None:
    assert pytest.approx(15.569e6, rel=1e-4) == AXIAL_STIFFNESS
    thick = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)
    assert stiffness_ratio(thick) == pytest.approx(2.24, abs=5e-3)
    fitting = rw.Rope(mass_per_length=1.56, axial_stiffness=93.1e9 * 1.56 / 9300.0, breaking_load=285e3)
    assert stiffness_ratio(fitting) == pytest.approx(1.0, abs=6e-3)


def test_no_tension_at_the_lower_end() -> None:
    with pytest.raises(InputError, match="raise the upper tension"):
        lower_tension(100.0, 10.0, 20.0)
    with pytest.raises(InputError, match="height"):
        lower_tension(100.0, 10.0, -2.0)
