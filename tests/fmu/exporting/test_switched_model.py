"""The models of all places of a carriage as one: each part's own equations at its place."""

import casadi as ca
import numpy as np
import pytest

from ropeway.fmu.exporting.carriage_corridor import Corridor
from ropeway.fmu.exporting.equations import ModelEquations
from ropeway.systems.solvers.kernels.kernel_network import Network
from ropeway.systems.solvers.newton import outputs_of
from support.fmus import corridor


@pytest.fixture(scope="module")
def way() -> Corridor:
    return Corridor(corridor(haulback_tension=3e3), 345.0, 0.0)


def test_each_place_has_its_own_equations(way: Corridor) -> None:
    whole = way.united
    rng = np.random.default_rng(1)
    assert len(way.order) == 6
    assert np.abs(np.array(whole.model.dae(*way.state.point.arguments)[1])).max() < 1e-9
    for i, part in enumerate(whole.parts):
        at = whole.point(i)
        # Off the solution: the same residuals, in another order, and zeros where a part has no unknown.
        own = part.point.copy()
        own.z[:] += 1e-3 * part.model.z.nominals * rng.standard_normal(len(own.z))
        at.z[:] = whole.unknowns(part, own.z)
        residuals = np.array(whole.model.dae(*at.arguments)[1]).ravel()
        wanted = np.array(part.model.dae(*own.arguments)[1]).ravel() / part.model.r.nominals
        np.testing.assert_allclose(np.sort(residuals[residuals != 0.0]), np.sort(wanted[wanted != 0.0]), rtol=1e-9)
        shown = dict(zip(whole.model.y.names, outputs_of(whole.model)(*at.arguments)[0].copy(), strict=True))
        known = dict(zip(part.model.y.names, outputs_of(part.model)(*own.arguments)[0].copy(), strict=True))
        for name in ("carriage.tension_a", "head.tension", "mainline.rope_tension"):
            assert shown[name] == pytest.approx(known[name], rel=1e-12)
        assert shown["skyline.utilisation"] == pytest.approx(
            max(v for n, v in known.items() if n.endswith(".utilisation") and n.split(".")[0] in skyline_of(way, i)),
            rel=1e-12,
        )


def skyline_of(way: Corridor, i: int) -> set[str]:
    """Names of the skyline's spans at a place."""
    return {span.name for run in way.united.parts[i].model.runs if run.nodes[0].name == "head" for span in run.spans}


def jacobian(net: Network, vectors: np.ndarray, columns: range) -> np.ndarray:
    """Derivatives of the rows of a network by some entries of its vectors: changes that go from call to call."""
    values, changes = np.zeros(net.size), np.zeros((net.size, len(columns)))
    values[: len(vectors)] = vectors
    changes[list(columns), range(len(columns))] = 1.0
    for kernel, first, inputs, entries in zip(net.kernels, net.results, net.inputs, net.entries, strict=True):
        found = np.array(kernel.function(values[inputs])).ravel()
        values[first : first + len(found)] = found
        for (row, by), entry in zip(entries, found[kernel.results :], strict=True):
            changes[row] += entry * changes[by]
    return changes[net.rows]


def test_its_jacobian_is_that_of_its_equations(way: Corridor) -> None:
    whole, equations = way.united, ModelEquations(way.state, way)
    f = whole.model.dae
    by_casadi = ca.Function(
        "jacobian",
        f.mx_in(),
        [ca.horzcat(*(ca.jacobian(ca.vertcat(*f(*f.mx_in())), f.mx_in()[i]) for i in (1, 2)))],
    )
    for i in range(len(whole.parts)):
        at = whole.point(i)
        vectors = np.concatenate([np.atleast_1d(np.array(v, float)).ravel() for v in at.arguments])
        ours = jacobian(equations.networks.lists["matrix"][i], vectors, range(1, 1 + len(at.x) + len(at.z)))
        wanted = np.array(ca.densify(by_casadi(*at.arguments)))
        pattern = np.array(ca.DM(equations.pattern, 1.0))
        assert np.all(pattern[wanted != 0.0] == 1.0)
        np.testing.assert_allclose(ours, wanted, rtol=1e-9, atol=1e-12 * np.abs(wanted).max())


def test_both_places_hold_at_a_transition(way: Corridor) -> None:
    """What both know is continuous there; each border is passed both ways."""
    known = {name: k for k, name in enumerate(way.united.model.z.names)}
    same = [known[name] for name in ("carriage.x", "carriage.z", "carriage.travel", "haulback.travel")]
    over = [(i, p.to, p.jump) for i, passages in enumerate(way.passages) for p in passages if p.to >= 0]
    assert {(i, to) for i, to, _ in over} == {(to, i) for i, to, _ in over}
    assert len(over) == 12
    for _, _, jump in over:
        np.testing.assert_allclose(jump[same], 0.0, atol=2e-6)
