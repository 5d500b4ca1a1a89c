"""Invalid declarations raise a typed error with cause and remedy, and leave the system unchanged."""

from __future__ import annotations

import math
from collections.abc import Callable

import pandas as pd
import pytest

import ropeway as rw

ROPE = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)


def anchor(name: str, x: float, z: float = 0.0) -> rw.Anchor:
    return rw.Anchor(name, at=(x, z))


def line() -> tuple[rw.System, tuple[rw.Span, ...]]:
    """Two spans over an idler, with a load."""
    s = rw.System("line")
    spans = s.string(ROPE, anchor("a", 0.0), rw.Sheave("s1", at=(100.0, 5.0)), anchor("b", 200.0), length=202.0)
    s.hang(rw.Load("turn", mass=100.0), spans, at=60.0)
    return s, spans


def rejected(
    s: rw.System, declare: Callable[[], object], *words: str, error: type[rw.RopewayError] = rw.InputError
) -> rw.RopewayError:
    """`declare` raises an error with cause and remedy, and leaves the system unchanged."""
    before = (dict(s.components), dict(s.connections), list(s.hung), list(s.feeds))
    with pytest.raises(error) as info:
        declare()
    assert info.value.cause
    assert info.value.remedy
    for word in words:
        assert word in str(info.value)
    assert (s.components, s.connections, s.hung, s.feeds) == before
    return info.value


def test_two_components_with_the_same_name() -> None:
    s = rw.System("line")
    s.add(anchor("a", 0.0))
    error = rejected(s, lambda: s.add(rw.Sheave("a", at=(9.0, 0.0))), "'a'", "its own name")
    assert "test_bad_input.py:" in str(error)  # where the first one was added


def test_two_supports_with_the_same_name_in_one_string() -> None:
    s = rw.System("line")
    rejected(s, lambda: s.string(ROPE, anchor("a", 0.0), rw.Sheave("a", at=(50.0, 0.0)), length=60.0), "'a'")


def test_a_second_support_with_a_known_name_in_a_string() -> None:
    s, _ = line()
    rejected(s, lambda: s.string(ROPE, anchor("c", 0.0, 9.0), anchor("b", 50.0), length=60.0), "'b'")


def test_an_equal_support_added_twice() -> None:
    s = rw.System("line")
    s.add(anchor("b", 100.0))
    rejected(s, lambda: s.string(ROPE, anchor("a", 0.0), anchor("b", 100.0), length=101.0), "'b'")


def test_a_rope_on_an_occupied_support() -> None:
    s, _ = line()
    b = s.components["b"]
    assert isinstance(b, rw.Anchor)
    rejected(s, lambda: s.string(ROPE, b, anchor("c", 300.0), length=101.0), "b.rope", "connected twice")


def test_one_support_twice_on_a_rope() -> None:
    s, a = rw.System("line"), anchor("a", 0.0)
    rejected(s, lambda: s.string(ROPE, a, rw.Sheave("m", at=(50.0, 0.0)), a, length=120.0), "a")


@pytest.mark.parametrize("length", [0.0, -5.0, math.nan, math.inf])
def test_length_of_a_string(length: float) -> None:
    s = rw.System("line")
    rejected(s, lambda: s.string(ROPE, anchor("a", 0.0), anchor("b", 100.0), length=length), "length", repr(length))


@pytest.mark.parametrize("tension", [0.0, -5.0, math.nan, math.inf])
def test_tension_of_a_string(tension: float) -> None:
    s = rw.System("line")
    rejected(
        s,
        lambda: s.string(ROPE, anchor("a", 0.0), anchor("b", 100.0), tension=tension),
        "tension",
        repr(tension),
    )


def test_a_string_needs_length_or_tension() -> None:
    s = rw.System("line")
    rejected(s, lambda: s.string(ROPE, anchor("a", 0.0), anchor("b", 100.0)), "length", "tension")
    rejected(s, lambda: s.string(ROPE, anchor("a", 0.0), anchor("b", 100.0), length=101.0, tension=1e4), "length")


def test_a_string_needs_two_supports() -> None:
    s = rw.System("line")
    rejected(s, lambda: s.string(ROPE, anchor("a", 0.0), length=10.0), "two supports")


def test_an_anchor_inside_a_string() -> None:
    s = rw.System("line")
    rejected(
        s, lambda: s.string(ROPE, anchor("a", 0.0), anchor("m", 50.0), anchor("b", 100.0), length=101.0), "Anchor 'm'"
    )


def test_two_supports_at_the_same_point() -> None:
    s = rw.System("line")
    ends = anchor("a", 5.0, 1.0), anchor("b", 5.0, 1.0)
    rejected(s, lambda: s.string(ROPE, *ends, length=3.0), "'a'", "'b'", "position")


def test_tension_too_low_for_the_rope() -> None:
    s = rw.System("line")
    supports = (anchor("a", 0.0), rw.Sheave("m", at=(50.0, 0.0)), anchor("b", 650.0))
    rejected(s, lambda: s.string(ROPE, *supports, tension=5e3), "m_b", "tension", error=rw.SlackRopeError)
    below = (anchor("c", 0.0), anchor("d", 100.0, -400.0))
    rejected(s, lambda: s.string(ROPE, *below, tension=5e3), "tension", error=rw.SlackRopeError)


def test_an_inextensible_rope_shorter_than_its_chord() -> None:
    s = rw.System("line")
    stiff = rw.Rope(mass_per_length=1.0, axial_stiffness=math.inf, breaking_load=1e5)
    rejected(s, lambda: s.string(stiff, anchor("a", 0.0), anchor("b", 100.0), length=99.0), "a_b", "99", "100")


def test_a_rope_that_breaks_under_its_own_weight() -> None:
    s = rw.System("line")
    weak = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=1e4)
    top, bottom = anchor("top", 0.0, 500.0), anchor("bottom", 50.0, 0.0)
    rejected(s, lambda: s.string(weak, top, bottom, length=505.0), "top_bottom", "10000", "stronger")


@pytest.mark.parametrize("at", [-0.1, 202.1, math.nan])
def test_a_load_outside_its_spans(at: float) -> None:
    s, spans = line()
    error = rejected(s, lambda: s.hang(rw.Load("l2", mass=10.0), spans, at=at), "at", str(at))
    if at > 0.0:
        assert "202" in str(error)


def test_a_load_outside_its_span() -> None:
    s, (first, _) = line()
    rejected(s, lambda: s.hang(rw.Load("l2", mass=10.0), first, at=150.0), "Load 'l2'", "150", "a_s1")


def test_a_load_with_a_name_in_use() -> None:
    s, spans = line()
    rejected(s, lambda: s.hang(rw.Load("turn", mass=10.0), spans, at=5.0), "'turn'")
    rejected(s, lambda: s.hang(rw.Load("s1", mass=10.0), spans, at=5.0), "'s1'")
    rejected(s, lambda: s.add(anchor("turn", 7.0)), "'turn'")


def test_a_load_on_no_span_or_on_a_span_of_another_system() -> None:
    s, _ = line()
    rejected(s, lambda: s.hang(rw.Load("l2", mass=10.0), (), at=5.0), "'l2'", "span")
    foreign = rw.Span("x_y", rope=ROPE, length=10.0)
    rejected(s, lambda: s.hang(rw.Load("l2", mass=10.0), foreign, at=5.0), "'x_y'", "line")


def test_a_load_on_spans_that_are_not_consecutive() -> None:
    s, spans = line()
    rejected(s, lambda: s.hang(rw.Load("l2", mass=10.0), spans[::-1], at=5.0), "'l2'", "s1_b", "a_s1")
    rejected(s, lambda: s.hang(rw.Load("l2", mass=10.0), (spans[0], spans[0]), at=5.0), "'l2'", "a_s1")


@pytest.mark.parametrize(
    ("spacing", "masses", "words"),
    [
        (0.0, 100.0, ("spacing", "0.0")),
        (math.nan, 100.0, ("spacing", "nan")),
        (20.0, -1.0, ("mass", "-1.0")),
        (20.0, (), ("masses",)),
        (20.0, (100.0, math.nan), ("mass", "nan")),
    ],
)
def test_a_feed(spacing: float, masses: float | tuple[float, ...], words: tuple[str, ...]) -> None:
    s = rw.System("line")
    spans = s.string(ROPE, anchor("a", 0.0), anchor("b", 100.0), length=101.0)
    rejected(s, lambda: s.feed(spans, spacing=spacing, masses=masses), *words)


def test_feed_and_hang_on_one_rope() -> None:
    s, spans = line()
    rejected(s, lambda: s.feed(spans, spacing=20.0, masses=100.0), "loads already")
    fed = rw.System("fed")
    on = fed.string(ROPE, anchor("a", 0.0), anchor("b", 100.0), length=101.0)
    fed.feed(on, spacing=20.0, masses=100.0)
    rejected(fed, lambda: fed.hang(rw.Load("turn", mass=10.0), on, at=5.0), "feed")


def test_a_port_connected_twice() -> None:
    s = rw.System("line")
    a, b, c = (s.add(anchor(n, x)) for n, x in (("a", 0.0), ("b", 50.0), ("c", 90.0)))
    span, other = (s.add(rw.Span(n, rope=ROPE, length=51.0)) for n in ("one", "two"))
    s.connect(span.a, a.rope)
    rejected(s, lambda: s.connect(span.a, c.rope), "one.a", "twice")
    rejected(s, lambda: s.connect(a.rope, other.b), "a.rope", "twice")
    rejected(s, lambda: s.connect(span.b, other.a), "one.b", "two.a")
    rejected(s, lambda: s.connect(a.rope, b.rope), "a.rope", "b.rope")
    rejected(s, lambda: s.connect(span.b, anchor("d", 5.0).rope), "'d'", "Add it")


def test_an_open_port() -> None:
    s = rw.System("line")
    a = s.add(anchor("a", 0.0))
    span = s.add(rw.Span("one", rope=ROPE, length=51.0))
    s.connect(span.a, a.rope)
    error = rejected(s, lambda: rw.equilibrium(s), "one.b", "Connect", error=rw.UnbalancedSystemError)
    assert "test_bad_input.py:" in str(error)
    rejected(s, lambda: rw.assemble(s), "one.b", error=rw.UnbalancedSystemError)


def test_an_empty_system() -> None:
    s = rw.System("line")
    rejected(s, lambda: rw.equilibrium(s), "'line'", "empty", error=rw.UnbalancedSystemError)


def test_spans_of_opposite_direction() -> None:
    s = rw.System("line")
    a, b, m = s.add(anchor("a", 0.0)), s.add(anchor("b", 100.0)), s.add(rw.Sheave("m", at=(50.0, 0.0)))
    one, two = (s.add(rw.Span(n, rope=ROPE, length=51.0)) for n in ("one", "two"))
    s.connect(one.a, a.rope)
    s.connect(one.b, m.a)
    s.connect(two.a, b.rope)
    s.connect(two.b, m.b)
    rejected(s, lambda: rw.equilibrium(s), "'one'", "'two'", "'m'", error=rw.UnbalancedSystemError)


def test_a_line_with_different_ropes() -> None:
    s = rw.System("line")
    a, b, m = s.add(anchor("a", 0.0)), s.add(anchor("b", 100.0)), s.add(rw.Sheave("m", at=(50.0, 0.0)))
    thin = rw.Rope(mass_per_length=1.0, axial_stiffness=1e7, breaking_load=1e5)
    one, two = s.add(rw.Span("one", rope=ROPE, length=51.0)), s.add(rw.Span("two", rope=thin, length=51.0))
    for end, seat in ((one.a, a.rope), (one.b, m.a), (two.a, m.b), (two.b, b.rope)):
        s.connect(end, seat)
    rejected(s, lambda: rw.equilibrium(s), "one", "two", "one rope")


def test_arguments_that_are_not_a_system() -> None:
    for study in (rw.equilibrium, lambda line: rw.simulate(line, until=1.0)):
        with pytest.raises(rw.InputError, match=r"system is 'line\.csv'. Give a System or a Model"):
            study("line.csv")


def test_a_rope_without_a_hold() -> None:
    s = rw.System("line")
    ends = (rw.Drum("a", at=(0.0, 0.0), tension=2e4), rw.Drum("b", at=(100.0, 0.0), tension=2e4))
    s.string(ROPE, *ends, length=101.0)
    rejected(s, lambda: rw.equilibrium(s), "a_b", "run freely", error=rw.UnbalancedSystemError)


@pytest.mark.parametrize(
    ("arguments", "words", "error"),
    [
        ({"given": {"a_s1.tension_a": 1e4}}, ("given has 1 values", "0 names"), rw.UnbalancedSystemError),
        ({"solve_for": "turn.mass"}, ("given has 0 values", "1 names"), rw.UnbalancedSystemError),
        ({"given": {"a_s1.tensoin_a": 1e4}, "solve_for": "turn.mass"}, ("a_s1.tension_a",), rw.UnknownNameError),
        ({"given": {"a_s1.tension_a": 1e4}, "solve_for": "trun.mass"}, ("trun.mass",), rw.UnknownNameError),
        ({"given": {"a_s1.tension_a": 1e4}, "solve_for": "a_s1.tension_b"}, ("a_s1.tension_b",), rw.InputError),
        ({"given": {"a_s1.tension_a": math.nan}, "solve_for": "turn.mass"}, ("a_s1.tension_a", "nan"), rw.InputError),
        ({"parameters": {"turn.mass": math.nan}}, ("turn.mass", "nan"), rw.InputError),
        ({"parameters": {"turn.mass": -5.0}}, ("turn.mass", "-5"), rw.InputError),
        ({"parameters": {"a_s1.length_start": -5.0}}, ("a_s1.length_start", "-5"), rw.InputError),
        ({"parameters": {"a_s1.mass_per_length": 0.0}}, ("a_s1.mass_per_length", "0.0"), rw.InputError),
        ({"parameters": {"a_s1.tension_a": 1e4}}, ("a_s1.tension_a", "given="), rw.InputError),
        ({"parameters": {"nowhere.mass": 1e4}}, ("nowhere.mass",), rw.UnknownNameError),
    ],
)
def test_invalid_requests_to_equilibrium(
    arguments: dict[str, object], words: tuple[str, ...], error: type[rw.RopewayError]
) -> None:
    s, _ = line()
    rejected(s, lambda: rw.equilibrium(s, **arguments), *words, error=error)  # type: ignore[arg-type]


def test_an_unknown_name() -> None:
    s, _ = line()
    eq = rw.equilibrium(s)
    with pytest.raises(rw.UnknownNameError, match=r"a_s1\.tension_a") as info:
        eq["a_s1.tension"]
    assert "slot" not in info.value.remedy
    with pytest.raises(rw.UnknownNameError, match=r"turn\.mas") as info:
        eq["turn.mas"]
    assert info.value.remedy == "Did you mean turn.x, turn.y, turn.z, turn.distance, turn.mass?"
    with pytest.raises(rw.UnknownNameError, match="'c_d'") as info:
        eq.profile("c_d")
    assert "a_s1" in info.value.remedy
    with pytest.raises(rw.InputError, match="a_s1"):
        eq.profile("a_s1", [500.0])


def test_a_start_from_another_system() -> None:
    s, _ = line()
    other = rw.System("other")
    other.string(ROPE, anchor("a", 0.0), anchor("b", 100.0), length=101.0)
    start = rw.equilibrium(other)
    rejected(s, lambda: rw.equilibrium(s, start=start), "another system")
    rejected(s, lambda: rw.simulate(s, 1.0, start=start), "another system")


@pytest.mark.parametrize(
    ("other", "words"),
    [({"load_mass": 310.0}, "other loads"), ({"speed": 0.5}, ""), ({"tension": 41e3}, "another"),
     ({"gravity": 9.81}, "another")],
)  # fmt: skip
def test_a_start_from_a_line_with_the_same_names(other: dict[str, float], words: str) -> None:
    """Its solution would be that of the other line."""
    table = pd.DataFrame(
        [("d0", 0.0, "drum"), ("c1", 100.0, "control"), ("s1", 200.0, "idler"), ("d1", 300.0, "drum")],
        columns=["name", "x", "kind"],
    ).assign(y=0.0, z=0.0)
    mine = {"tension": 40e3, "load_mass": 300.0, "load_spacing": 60.0}
    line, start = rw.monocable(ROPE, table, **mine), rw.equilibrium(rw.monocable(ROPE, table, **{**mine, **other}))
    if not words:
        assert rw.simulate(line, 2.0, start=start).frame["c1.travel"].iloc[-1] == pytest.approx(2.0)
        warm, cold = rw.equilibrium(line, start=start), rw.equilibrium(line)
        assert warm["c1.speed"] == 1.0
        assert warm["c1.power"] == pytest.approx(cold["c1.power"])
        return
    rejected(line, lambda: rw.equilibrium(line, start=start), words)
    rejected(line, lambda: rw.simulate(line, 1.0, start=start), words)


def test_a_payload_below_zero() -> None:
    """A tension below that of the empty rope would need a load that pushes up."""
    s = rw.System("line")
    (span,) = s.string(ROPE, anchor("a", 0.0), anchor("b", 200.0), length=201.0)
    s.hang(rw.Load("turn", mass=100.0), span, at=90.0)
    error = rejected(
        s,
        lambda: rw.equilibrium(s, given={"a_b.tension_a": 19e3}, solve_for="turn.mass"),
        "turn.mass",
        error=rw.EquilibriumError,
    )
    assert isinstance(error, rw.EquilibriumError)
    assert error.component == "turn"


def test_a_load_on_spans_that_are_not_connected() -> None:
    s = rw.System("line")
    spans = [s.add(rw.Span(name, rope=ROPE, length=50.0)) for name in ("one", "two")]
    rejected(s, lambda: s.hang(rw.Load("turn", mass=100.0), spans, at=60.0), "'one' and 'two' are not consecutive")
