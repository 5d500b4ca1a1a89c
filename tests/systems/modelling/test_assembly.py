"""Assembly of the flat model: determinism, names, structure check."""

from __future__ import annotations

import re

import numpy as np
import pytest

import ropeway as rw
from ropeway.components.variable import Kind

ROPE = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)


def line() -> rw.System:
    s = rw.System("line")
    spans = s.string(
        ROPE,
        rw.Drum("d", at=(0.0, 0.0, 0.0)),
        rw.Sheave("s1", at=(100.0, 4.0, 5.0), friction=0.02),
        rw.ControlSheave("c1", at=(210.0, -3.0, 2.0), speed=None),
        rw.Sheave("s2", at=(300.0, 0.0, 12.0)),
        rw.Drum("e", at=(380.0, 0.0, 10.0), tension=2e4),
        tension=2e4,
    )
    for k in range(4):
        s.hang(rw.Load(f"l{k}", mass=200.0 + k), spans, at=30.0 + 85.0 * k)
    return s


def test_the_same_declarations_give_the_same_model() -> None:
    one, two = rw.assemble(line()), rw.assemble(line())
    for kind in Kind:
        assert one.tables[kind].names == two.tables[kind].names
        assert one.tables[kind].units == two.tables[kind].units
        assert one.tables[kind].descriptions == two.tables[kind].descriptions
        np.testing.assert_array_equal(one.tables[kind].values, two.tables[kind].values)
        np.testing.assert_array_equal(one.tables[kind].nominals, two.tables[kind].nominals)
    assert one.dae.serialize() == two.dae.serialize()
    assert one.outputs.serialize() == two.outputs.serialize()
    a, b = rw.equilibrium(one), rw.equilibrium(two)
    np.testing.assert_array_equal(a.point.z, b.point.z)
    np.testing.assert_array_equal(a.outputs, b.outputs)


def test_assembly_does_not_change_the_system() -> None:
    s = line()
    before = (dict(s.components), dict(s.connections), list(s.hung))
    rw.assemble(s)
    assert (s.components, s.connections, s.hung) == before


def test_tables_are_complete() -> None:
    model = rw.assemble(line())
    seen: set[str] = set()
    for kind in Kind:
        table = model.tables[kind]
        n = len(table)
        assert len(table.units) == len(table.descriptions) == len(table.values) == len(table.nominals) == n
        assert all(table.units)
        assert all(len(text) > 3 for text in table.descriptions)
        assert np.all(np.isfinite(table.values))
        assert np.all(table.nominals > 0.0)
        assert [table.index[name] for name in table.names] == list(range(n))
        assert not seen.intersection(table.names)
        seen.update(table.names)
    legal = re.compile(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*(\[[1-9]\d*\])?)?")
    assert all(legal.fullmatch(name) for name in seen)


def test_functions_match_the_tables() -> None:
    model = rw.assemble(line())
    sizes = [1, len(model.x), len(model.z), len(model.u), len(model.p), len(model.d)]
    for function in (model.dae, model.outputs):
        assert [function.numel_in(i) for i in range(6)] == sizes
        assert function.name_in() == ["t", "x", "z", "u", "p", "d"]
    assert model.dae.numel_out("ode") == len(model.x)
    assert model.dae.numel_out("alg") == len(model.z) == len(model.r)
    assert model.outputs.numel_out("y") == len(model.y)


def test_kinds_of_variables() -> None:
    model = rw.assemble(line())
    assert model.x.names == ("d.travel", "c1.travel")
    assert model.u.names == ("d.speed", "c1.speed")
    assert model.signals == (0.0, None)
    assert {"s1.travel", "s2.travel", "e.travel"} <= set(model.z.names)
    assert "gravity" in model.p.names
    assert model.p.values[model.p.index["gravity"]] == 9.80665


def test_residuals_vanish_at_rest() -> None:
    eq = rw.equilibrium(line())
    _, alg = eq.model.dae(*eq.point.arguments)
    scaled = np.array(alg).ravel() / eq.model.r.nominals
    assert np.abs(scaled).max() < 1e-11


def test_the_order_of_declaration_does_not_matter() -> None:
    """The same line from components, with spans declared in reverse order."""
    known = rw.equilibrium(line())
    s, other = rw.System("parts"), line()
    nodes = [c for c in other.components.values() if not isinstance(c, rw.Span)]
    spans = [c for c in other.components.values() if isinstance(c, rw.Span)]
    for component in (*nodes[::-1], *spans[::-1]):
        s.add(component)
    for span, a, b in list(zip(spans, nodes[:-1], nodes[1:], strict=True))[::-1]:
        s.connect(b.arriving, span.b)
        s.connect(span.a, a.leaving)
    for hung in other.hung[::-1]:
        s.hang(hung.load, spans, at=hung.at)
    eq = rw.equilibrium(s)
    for span in spans:
        assert eq[f"{span.name}.tension_a"] == pytest.approx(known[f"{span.name}.tension_a"], rel=1e-10)


def test_two_ropes_in_one_system_are_independent() -> None:
    both, alone = line(), rw.System("other")
    other = rw.Rope(mass_per_length=1.4, axial_stiffness=14e6, breaking_load=256.3e3)
    for s in (both, alone):
        s.string(other, rw.Anchor("x", at=(0.0, 50.0, 0.0)), rw.Anchor("y", at=(90.0, 50.0, 8.0)), length=92.0)
    eq = rw.equilibrium(both)
    assert eq["x_y.tension_a"] == pytest.approx(rw.equilibrium(alone)["x_y.tension_a"], rel=1e-12)
    assert eq["d_s1.tension_a"] == pytest.approx(rw.equilibrium(line())["d_s1.tension_a"], rel=1e-10)


def test_more_slots_change_nothing() -> None:
    known, roomy = rw.equilibrium(line()), rw.equilibrium(rw.assemble(line(), slots=[[7, 5, 6, 4]]))
    for name in ("d_s1.tension_a", "s2_e.tension_b", "l2.z"):
        assert roomy[name] == pytest.approx(known[name], rel=1e-10)
