"""The certificate: all checks hold at rest, and each fault fails its own check."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

import ropeway as rw
from ropeway.components.laws import Law, ratio, wrap
from ropeway.systems.solvers.newton import newton_of
from ropeway.systems.solvers.points import Point
from ropeway.systems.statics.certificate import checks
from ropeway.systems.statics.certificate.certify import certify
from ropeway.systems.statics.certificate.checks import Certificate
from ropeway.systems.statics.line_state import LineState
from ropeway.systems.statics.record_blocks import Records

ROPE = rw.Rope(mass_per_length=2.1, axial_stiffness=19e6, breaking_load=330e3)
GUY = rw.Rope(mass_per_length=1.5, axial_stiffness=15e6, breaking_load=300e3)


def line() -> rw.Equilibrium:
    """A drum that keeps its tension, a rough sheave, a smooth one, a control sheave, a spring."""
    s = rw.System("line")
    nodes = [
        rw.Drum("d", at=(0.0, 0.0), tension=41e3),
        rw.Sheave("rough", at=(80.0, 6.0), friction=0.03),
        rw.Sheave("s", at=(170.0, 3.0)),
        rw.ControlSheave("c", at=(250.0, 8.0), speed=0.4),
        rw.SpringAnchor("e", at=(340.0, 2.0), stiffness=3e5),
    ]
    spans = s.string(ROPE, *nodes, tension=40e3)
    s.hang(rw.Load("pinned", mass=210.0), spans[1], at=33.0)
    s.hang(rw.Load("riding", mass=180.0), spans, at=205.0)
    return rw.equilibrium(s)


def again(eq: rw.Equilibrium, **how: Any) -> Certificate:
    """The certificate of an equilibrium after a change in one of its vectors: name=value."""
    point = eq.point.copy()
    for name, value in how.items():
        full = name.replace("__", ".")
        for vector, table in (("x", eq.model.x), ("z", eq.model.z), ("p", eq.model.p), ("d", eq.model.d)):
            if full in table.index:
                getattr(point, vector)[table.index[full]] += value
                break
        else:
            raise AssertionError(full)
    return certify(eq.model, point, eq.runs, eq.passed)


def test_a_line_at_rest_has_a_certificate() -> None:
    eq = line()
    frame = eq.certificate
    assert list(frame.columns) == ["value", "limit", "holds", "component"]
    assert frame["holds"].all()
    for name in (checks.SPANS_END, checks.LEAST_ROPE, checks.ON_ROPE, checks.IN_SPAN, checks.STABLE):
        assert name in frame.index
    laws = [name for name in frame.index if ":" in name]
    assert {name.split(":")[0] for name in laws} == {"Drum", "Sheave", "SpringAnchor"}
    assert frame.loc[checks.SPANS_END, "value"] < 1e-11
    assert eq.checks.utilisation is not None
    assert eq.checks.utilisation.value == pytest.approx(
        max(eq[f"{s.name}.tension_{end}"] for s in eq.runs[0].spans for end in "ab") / 330e3
    )


@pytest.mark.parametrize(
    ("change", "check", "component"),
    [
        ({"rough_s__force_x": 1.0}, checks.SPANS_END, "rough_s"),
        ({"d_rough__length_start": 1e-6}, checks.SPANS_END, "d_rough"),
        ({"s__z": 1e-5}, checks.SPANS_END, "rough_s"),
        ({"rough_s__slot_at[1]": 1e-3}, checks.ON_ROPE, "rough_s"),
        ({"rough_s__slot_mass[1]": 1.0}, checks.ON_ROPE, "rough_s"),
        ({"d__tension": 0.1}, "Drum: the drum holds its tension", "d"),
        ({"rough__friction": 1e-4}, "Sheave: tensions on both sides", "rough"),
        ({"e__stiffness": 1.0}, "SpringAnchor: forces, x", "e"),
    ],
)
def test_each_fault_of_a_line_is_detected(change: dict[str, float], check: str, component: str) -> None:
    found = again(line(), **change)
    failed = {c.name: c for c in found.checks if not c.holds}
    assert check in failed
    if "z" not in next(iter(change)):
        assert failed[check].component == component
    with pytest.raises(rw.EquilibriumError, match="fails its check"):
        found.require(line().model)


def test_a_load_beyond_its_span_and_a_lost_load_are_detected() -> None:
    eq = line()
    (run,) = eq.runs
    place = run.loads.place.copy()
    k = run.loads.names.index("riding")
    place[k] += 60.0
    moved = certify(eq.model, eq.point, (replace(run, loads=replace(run.loads, place=place)),), eq.passed)
    assert moved.failed is not None
    assert moved.failed.name in (checks.SPANS_END, checks.ON_ROPE)
    assert {c.name for c in moved.checks if not c.holds} >= {checks.ON_ROPE, checks.IN_SPAN}


def test_given_values_rope_and_numbers_are_checked() -> None:
    eq = line()
    given = {"d_rough.tension_b": eq["d_rough.tension_b"]}
    total = [sum(eq[f"{s.name}.length"] for s in run.spans) for run in eq.runs]
    assert certify(eq.model, eq.point, eq.runs, eq.passed, given=given, rope=total).failed is None
    given["d_rough.tension_b"] *= 1.0 + 1e-6
    violated = certify(eq.model, eq.point, eq.runs, eq.passed, given=given)
    assert violated.failed is not None
    assert violated.failed.name == checks.VALUES
    short = certify(eq.model, eq.point, eq.runs, eq.passed, rope=[total[0] + 1e-5])
    assert short.failed is not None
    assert short.failed.name == checks.ROPE_SUM
    invalid = replace(eq.point, z=np.full_like(eq.point.z, np.nan))
    assert certify(eq.model, invalid, eq.runs, eq.passed).failed is not None


def test_an_unstable_root_is_detected() -> None:
    """Two equal spans of a slack rope, both on the branch where more rope increases the tension: balanced by
    symmetry."""
    s = rw.System("saddle")
    nodes = [rw.Anchor("a", at=(0.0, 0.0)), rw.Sheave("s", at=(50.0, 0.0)), rw.Anchor("b", at=(100.0, 0.0))]
    s.string(ROPE, *nodes, length=138.0)
    state = LineState.cold(rw.assemble(s))
    newton_of(state.model).solve(state.point)
    found = certify(state.model, state.point, state.runs, state.passed)
    assert [c.name for c in found.checks if not c.holds] == [checks.STABLE]
    assert found.failed is not None
    assert found.failed.component == "s"
    with pytest.raises(rw.EquilibriumError, match="unstable"):
        found.require(state.model)
    with pytest.raises(rw.EquilibriumError, match="unstable"):
        rw.equilibrium(s)


def spar_rig(payload: float = 1800.0) -> rw.Equilibrium:
    anchors = {"g1": (-18.0, -11.0, 0.5), "g2": (-18.0, 11.0, 0.0), "g3": (11.0, -18.0, -1.0), "g4": (11.0, 18.0, 0.0)}
    guys = tuple(rw.Guyline(n, rope=GUY, at=at, pretension=16e3, stiffness=4e6) for n, at in anchors.items())
    rig = rw.standing_skyline(
        None,
        headspar=rw.GuyedSpar("head", foot=(0.0, 0.0), height=13.0, guylines=guys, mass=900.0),
        tailspar=rw.TailSpar("tail", at=(210.0, -14.0)),
        skyline=ROPE,
        length=216.0,
        mainline=rw.Rope(mass_per_length=0.7, axial_stiffness=7e6, breaking_load=110e3),
        carriage=rw.Carriage("carriage", mass=380.0),
    )
    return rw.equilibrium(rig.system(0, 90.0, payload=payload), given={"carriage.x": 90.0}, solve_for="mainline.travel")


def test_a_guyed_spar_and_a_carriage_are_checked() -> None:
    eq = spar_rig()
    assert eq.certificate["holds"].all()
    kinds = {name.split(":")[0] for name in eq.certificate.index if ":" in name}
    assert kinds == {"GuyedSpar", "Carriage", "SpringAnchor"}
    for change, text in (
        ({"carriage__payload": 0.01}, "Carriage: forces on the carriage, z"),
        ({"head__axial": 1.0}, "GuyedSpar: forces at the top, z"),
        ({"head__mass": 0.1}, "GuyedSpar: forces at the top, z"),
        ({"head__height": 1e-5}, "GuyedSpar: length of the mast"),
    ):
        assert text in [c.name for c in again(eq, **change).checks if not c.holds], change


def test_an_inverted_log_has_no_certificate() -> None:
    s = rw.System("log")
    log = s.add(rw.Log("log", at=(0.0, 0.0, -6.0), mass=700.0, length=9.0, friction=0.0, moving=0.0))
    top = s.add(rw.Anchor("top", at=(0.0, 0.0)))
    span = s.add(rw.Span("drop", rope=ROPE, length=6.0))
    s.connect(span.a, top.leaving)
    s.connect(span.b, log.front)
    eq = rw.equilibrium(s)
    assert eq["log.rear_z"] < eq["log.z"]
    assert eq.certificate["holds"].all()
    turned = again(eq, log__rear_z=18.0)
    assert [c.name for c in turned.checks if not c.holds][:1] != []
    assert "Log: upright" in [c.name for c in turned.checks if not c.holds]


@dataclass(frozen=True)
class Cam(rw.Sheave):
    """A user's sheave with an outgoing tension 10 % below the incoming one, and a law for it."""

    gain: float = 0.9

    def structure(self, site: Any) -> Any:
        return Cam

    def equations(self, v: Any) -> Any:
        plain = super().equations(v)
        law = plain.outputs["tension_out"] - 0.9 * plain.outputs["tension_in"]
        return replace(plain, residuals={"tension_law": law})

    def laws(self, v: Any) -> dict[str, Law]:
        return {"tension_law": ratio(v.a.force, v.b.force, self.gain)}


def test_laws_of_a_users_component() -> None:
    s = rw.System("own")
    s.string(
        ROPE, rw.Anchor("a", at=(0.0, 0.0)), Cam("cam", at=(60.0, 4.0)), rw.Anchor("b", at=(130.0, 0.0)), length=131.0
    )
    eq = rw.equilibrium(s)
    assert eq["cam.tension_out"] == pytest.approx(0.9 * eq["cam.tension_in"], rel=1e-12)
    assert "Cam: tensions on both sides" in eq.certificate.index
    assert again(eq, cam_b__force_x=1.0).failed is not None


def test_wrap_is_the_change_of_direction() -> None:
    coming, going = np.array([[-3.0], [0.0], [0.0]]), np.array([[0.0], [0.0], [-5.0]])
    np.testing.assert_allclose(wrap(coming, going), math.pi / 2.0)
    np.testing.assert_allclose(wrap(coming, -coming), 0.0, atol=1e-15)


def test_a_run_has_the_worst_of_its_records() -> None:
    rope = rw.Rope(mass_per_length=1.9, axial_stiffness=18e6, breaking_load=310e3)
    s = rw.System("moving")
    nodes = [rw.Drum("d", at=(0.0, 0.0), speed=1.3), *(rw.Sheave(f"s{k}", at=(60.0 * k, 2.0 * k)) for k in (1, 2, 3))]
    spans = s.string(rope, *nodes, rw.Drum("e", at=(240.0, 5.0), tension=35e3), tension=35e3)
    s.feed(spans, spacing=33.0, masses=[90.0, 120.0])
    result = rw.simulate(s, 60.0, every=2.0)
    frame = result.certificate
    assert frame["holds"].all()
    assert frame["time"].between(0.0, 60.0).all()
    solved = np.flatnonzero(result.exact).tolist()  # the others are solved when they are read, one by one or together
    single = [result.record(i).certificate for i in solved[::3]]
    for name in (checks.SPANS_END, checks.STABLE):
        values = [c.loc[name, "value"] for c in single]
        worst = frame.loc[name, "value"]
        # A record alone and one of a batch differ by rounding.
        assert worst <= min(values) * (1.0 + 1e-9) if name == checks.STABLE else worst >= max(values) - 1e-15


def test_a_run_ends_before_a_record_that_fails() -> None:
    s = rw.System("moving")
    nodes = [rw.Drum("d", at=(0.0, 0.0), speed=0.9), rw.Sheave("s", at=(70.0, 3.0))]
    s.string(ROPE, *nodes, rw.Drum("e", at=(150.0, 1.0), tension=30e3), tension=30e3)
    result = rw.simulate(s, 10.0)
    records = list(result.records)
    spoilt = records[6].z.copy()
    spoilt[result.model.z.index["d_s.force_x"]] *= 1.01
    records[6] = records[6]._replace(z=spoilt)
    broken = replace(result, records=Records([records]), exact=np.ones(len(records), dtype=bool))
    with pytest.raises(rw.SimulationError, match="fails its check") as info:
        broken.require_certified()
    assert info.value.time == records[6].time
    assert len(info.value.result.records) == 6
    for request in (lambda: broken.at(records[6].time), lambda: broken.record(6)):
        with pytest.raises(rw.SimulationError, match="fails its check") as info:
            request()
        assert info.value.time == records[6].time
    assert broken.at(records[5].time).certificate["holds"].all()


def test_the_point_of_a_certificate_is_not_changed() -> None:
    eq = line()
    before = [v.copy() for v in eq.point.arguments]
    certify(eq.model, eq.point, eq.runs, eq.passed)
    for was, now in zip(before, eq.point.arguments, strict=True):
        np.testing.assert_array_equal(was, now)
    assert isinstance(eq.point, Point)
