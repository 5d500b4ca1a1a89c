"""Long lines at rest are solved by sections: the roots of Newton's method on the whole equations."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import ropeway as rw
from ropeway.systems.solvers.line_sections import line_sections
from ropeway.systems.solvers.newton import newton_of
from ropeway.systems.solvers.section_newton import SectionNewton, solve_line
from ropeway.systems.statics.line_state import LineState
from support import schedule_lines

STORM = rw.Environment("storm", temperature=-5.0, wind_pressure=300.0, wind_from=40.0, ice_thickness=0.004)
STRETCHING = rw.Rope(3.48, 34.8e6, 576.6e3, stretch=rw.ConstructionStretch(), diameter=0.0286)


def rough() -> rw.System:
    """A stretching rope over rough idlers, with loads pinned to their spans, some spans without."""
    system = rw.System("rough", temperature=10.0)
    nodes = [
        rw.Drum("d", at=(0.0, 0.0), speed=0.5),
        *(
            rw.Sheave(f"s{k}", at=(90.0 * k, 3.0 * (k % 2), 2.0 * (k % 3)), friction=0.01 * (k % 2))
            for k in range(1, 6)
        ),
        rw.Drum("e", at=(540.0, 0.0, 3.0), tension=50e3),
    ]
    spans = system.string(STRETCHING, *nodes, tension=50e3)
    for k in (0, 2, 3):
        for j in range(k):
            system.hang(rw.Load(f"l{k}{j}", mass=200.0 + 50.0 * j), spans[k], at=20.0 + 20.0 * j)
    return system


@pytest.mark.parametrize(
    ("system", "environment"), [(rough, None), (rough, STORM), (lambda: schedule_lines.line(17, 5), None)]
)
def test_roots_are_those_of_the_whole_equations(
    system: Callable[[], rw.System], environment: rw.Environment | None
) -> None:
    line = system()
    model = rw.equilibrium(line, environment=environment).model
    state = LineState.cold(model)
    sections = line_sections(model)
    assert not isinstance(sections, str)
    one, other = state.point.copy(), state.point.copy()
    SectionNewton(sections, sections.used(state.passed)).solve(one)
    newton_of(model).solve(other)
    np.testing.assert_allclose(one.z / model.z.nominals, other.z / model.z.nominals, rtol=0.0, atol=1e-11)


def test_a_failure_leaves_the_point() -> None:
    state = LineState.cold(rw.assemble(schedule_lines.line(17, 5)))
    state.point.p[state.model.p.index["s3.z"]] = np.nan
    before = state.point.z.copy()
    with pytest.raises(rw.EquilibriumError, match="singular"):
        solve_line(state.model, state.point, state.passed)
    assert np.array_equal(state.point.z, before)


def test_threads_solve_one_model_to_the_same_bits() -> None:
    model = rw.assemble(schedule_lines.line(17, 5))
    rest = rw.equilibrium(model)

    def solved(k: int) -> bytes:
        return rw.equilibrium(model, start=rest, parameters={"l3.mass": 300.0 + 10.0 * (k % 4)}).point.z.tobytes()

    alone = [solved(k) for k in range(4)]
    with ThreadPoolExecutor(8) as pool:
        together = list(pool.map(solved, range(32)))
    assert together == alone * 8
