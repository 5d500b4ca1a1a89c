"""Variants of a line solved in a batch equal single equilibria, independent of the rest of the batch."""

import numpy as np
import pytest

import ropeway as rw
from ropeway.components.variable import Kind
from ropeway.systems.modelling.assembly import assemble
from ropeway.systems.solvers.array_outputs import outputs_of_columns
from ropeway.systems.solvers.line_sections import line_sections
from ropeway.systems.statics.line_state import LineState
from ropeway.systems.statics.settling import solve
from ropeway.systems.statics.variants import LineVariants, line_variants
from ropeway.systems.studies.sweeps.line_study import line_study

ROPE = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)


def line(rope: rw.Rope = ROPE) -> rw.System:
    """A drum, a rough idler, a control sheave, an idler, and a constant-tension drum, not in one plane, with one load
    pinned to its span."""
    system = rw.System("variants")
    nodes = (
        rw.Drum("d", at=(0.0, 0.0), speed=0.5),
        rw.Sheave("s1", at=(90.0, 4.0, 6.0), friction=0.02),
        rw.ControlSheave("c2", at=(180.0, 0.0, 3.0), speed=0.5),
        rw.Sheave("s3", at=(300.0, -3.0, 15.0)),
        rw.Drum("e", at=(380.0, 0.0, 9.0), tension=45e3),
    )
    spans = system.string(rope, *nodes, tension=45e3)
    for k in range(7):
        system.hang(rw.Load(f"l{k}", mass=200.0 + 30.0 * k), spans, at=25.0 + 50.0 * k)
    return system


NAMES = ("l0.mass", "l5.mass", "s1.z", "s3.y", "e.tension", "d_s1.length", "s1.friction", "c2.travel", "gravity")
LOW = (100.0, 100.0, 3.0, -5.0, 4.4e4, 90.0, 0.0, -0.2, 9.7)
HIGH = (500.0, 500.0, 9.0, -1.0, 4.8e4, 90.2, 0.05, 0.2, 9.9)


def prepared(system: rw.System) -> tuple[LineState, LineVariants]:
    state = LineState.cold(assemble(system))
    solve(state)
    found = line_variants(state, NAMES)
    assert found is not None
    return state, found


def values(count: int) -> np.ndarray:
    return np.random.default_rng(3).uniform(LOW, HIGH, (count, len(NAMES)))


@pytest.mark.parametrize("rope", [ROPE, rw.Rope(3.48, 34.8e6, 576.6e3, stretch=rw.ConstructionStretch())])
def test_a_variant_equals_a_single_equilibrium(rope: rw.Rope) -> None:
    state, many = prepared(line(rope))
    given = values(40)
    good, rows = many.solve(given)
    cases = rows.columns
    assert good.mean() > 0.9
    outputs = outputs_of_columns(state.model, cases)
    start = rw.Equilibrium(state.model, state.point, tuple(state.runs), tuple(state.passed), ())
    for i in np.flatnonzero(good)[:12]:
        alone = rw.equilibrium(state.model, start=start, parameters=dict(zip(NAMES, given[i], strict=True)))
        scale = np.maximum(np.abs(alone.outputs), state.model.y.nominals)
        assert np.abs(outputs[:, i] - alone.outputs).max() <= 1e-10 * scale.max()
        assert np.all(np.abs(outputs[:, i] - alone.outputs) <= 1e-9 * scale)
        for kind, vector in ((Kind.PARAMETER, cases.p), (Kind.DISCRETE, cases.d), (Kind.ALGEBRAIC, cases.z)):
            own = alone.point.vector(kind)
            np.testing.assert_allclose(vector[:, i], own, rtol=1e-9, atol=1e-8)


def test_the_bits_of_a_variant_do_not_depend_on_its_batch() -> None:
    _, many = prepared(line())
    given = values(60)
    good, rows = many.solve(given)
    cases = rows.columns
    for first, size in ((0, 1), (7, 3), (20, 33)):
        some, part_rows = many.solve(given[first : first + size])
        own = part_rows.columns
        np.testing.assert_array_equal(some, good[first : first + size])
        for whole, part in ((cases.z, own.z), (cases.p, own.p), (cases.d, own.d)):
            np.testing.assert_array_equal(whole[:, first : first + size][:, some], part[:, some])


@pytest.mark.parametrize("compiled", [False, True])
def test_a_single_output_is_that_of_all(compiled: bool) -> None:
    model = assemble(line())
    every = line_study(model, NAMES, None, compiled=compiled)
    for name in ("s1_c2.tension_b", "c2.tension_in", "l3.z"):
        one = line_study(model, NAMES, (name,), compiled=compiled).rows(NAMES, values(12)).numbers[:, 0]
        alone = [every.at(dict(zip(NAMES, row, strict=True)))[name] for row in values(12).tolist()]
        np.testing.assert_allclose(one, alone, rtol=1e-9)


@pytest.mark.parametrize("compiled", [False, True])
def test_the_bits_of_a_row_do_not_depend_on_its_chunk(compiled: bool) -> None:
    study = line_study(assemble(line()), NAMES, None, compiled=compiled)
    whole = study.rows(NAMES, values(30)).numbers
    for size in (1, 3, 7, 11):
        chunks = [study.rows(NAMES, values(30)[i : i + size]).numbers for i in range(0, 30, size)]
        assert np.vstack(chunks).tobytes() == whole.tobytes()


def test_unsuitable_variants_are_omitted_from_a_batch() -> None:
    _, many = prepared(line())
    given = values(6)
    given[0, NAMES.index("l0.mass")] = -1.0
    given[1, NAMES.index("l5.mass")] = np.nan
    given[2, NAMES.index("e.tension")] = 1.0  # no equilibrium
    given[3, NAMES.index("c2.travel")] = 30.0  # loads change spans
    given[4, NAMES.index("l0.mass")] = 5e5  # the rope breaks
    good, _ = many.solve(given)
    assert good.tolist() == [False] * 5 + [True]


def test_lines_with_other_unknowns_are_solved_one_by_one() -> None:
    system = rw.System("spring")
    system.string(
        ROPE, rw.SpringAnchor("a", at=(0.0, 0.0), stiffness=1e6), rw.Anchor("b", at=(100.0, 3.0)), length=101.0
    )
    model = assemble(system)
    reason = line_sections(model)
    assert isinstance(reason, str)
    assert "'a'" in reason
    assert line_variants(LineState.cold(model), ("gravity",)) is None


def test_a_batch_in_the_compiled_core() -> None:
    state, many = prepared(line())
    compiled = line_variants(state, NAMES, compiled=True)
    assert compiled is not None
    good, rows = many.solve(values(30))
    own, found = compiled.solve(values(30))
    np.testing.assert_array_equal(own, good)
    np.testing.assert_allclose(found.z[good], rows.z[good], rtol=1e-10, atol=1e-9)


def test_an_equilibrium_in_the_compiled_core() -> None:
    model = assemble(line())
    one, other = (rw.equilibrium(model, compiled=compiled) for compiled in (True, False))
    np.testing.assert_allclose(one.outputs, other.outputs, rtol=1e-10, atol=1e-7)
    heavier = {"l3.mass": 340.0, "s1.z": 6.5}
    one, other = (rw.equilibrium(model, start=one, parameters=heavier, compiled=c) for c in (True, False))
    np.testing.assert_allclose(one.outputs, other.outputs, rtol=1e-10, atol=1e-7)
    assert one.certificate["holds"].all()


def test_an_equilibrium_with_a_given_value_in_the_compiled_core() -> None:
    model, wanted = assemble(line()), {"given": {"e.rope_tension": 46e3}, "solve_for": "e.tension"}
    one, other = (rw.equilibrium(model, **wanted, compiled=compiled) for compiled in (True, False))
    np.testing.assert_allclose(one.outputs, other.outputs, rtol=1e-10, atol=1e-7)
    assert one.model is other.model


def test_a_sweep_that_the_compiled_core_does_not_solve() -> None:
    with pytest.raises(rw.CompiledError, match="function"):
        rw.sweep(lambda x: x, {"x": [1.0]}, compiled=True)


def test_a_compiled_sweep_has_the_same_rows() -> None:
    table = {"l0.mass": [150.0, 250.0], "s3.z": [14.0, 15.5], "e.tension": [44e3, 1.0]}
    one, other = (rw.sweep(line(), table, workers=1, compiled=compiled) for compiled in (True, False))
    assert one["error"].tolist() == other["error"].tolist()
    assert (one["error"] != "").sum() == 4
    numbers = [name for name in one if one[name].dtype == float]
    np.testing.assert_allclose(one[numbers], other[numbers], rtol=1e-9, atol=1e-6)
