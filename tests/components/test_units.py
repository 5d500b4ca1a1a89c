"""Units: what a symbol measures, and what becomes of one in another."""

import math

import pytest
from hypothesis import given, strategies as st

import ropeway as rw
from ropeway.components import units

G = 9.80665
SYMBOLS = {  # factor to SI and the exponents of kg, m, s, K, rad
    "m/s2": (1.0, (0, 1, -2, 0, 0)),
    "N.m": (1.0, (1, 2, -2, 0, 0)),
    "kNm": (1e3, (1, 2, -2, 0, 0)),
    "daN": (10.0, (1, 1, -2, 0, 0)),
    "MN": (1e6, (1, 1, -2, 0, 0)),
    "kgf": (G, (1, 1, -2, 0, 0)),
    "lbf": (4.4482216152605, (1, 1, -2, 0, 0)),
    "kgf/cm2": (98066.5, (1, -1, -2, 0, 0)),
    "psi": (6894.757293168, (1, -1, -2, 0, 0)),
    "mbar": (100.0, (1, -1, -2, 0, 0)),
    "N/mm²": (1e6, (1, -1, -2, 0, 0)),
    "ft": (0.3048, (0, 1, 0, 0, 0)),
    "US survey foot": (1200 / 3937, (0, 1, 0, 0, 0)),
    "Metre": (1.0, (0, 1, 0, 0, 0)),
    "rpm": (math.pi / 30, (0, 0, -1, 0, 1)),
    "U/min": (math.pi / 30, (0, 0, -1, 0, 1)),
    "deg/s": (math.pi / 180, (0, 0, -1, 0, 1)),
    "1/min": (1 / 60, (0, 0, -1, 0, 0)),
    "L/min": (1e-3 / 60, (0, 3, -1, 0, 0)),
    "cm3/rev": (1e-6 / (2 * math.pi), (0, 3, 0, 0, -1)),
    "km/h": (1 / 3.6, (0, 1, -1, 0, 0)),
    "hp": (745.69987158227, (1, 2, -3, 0, 0)),
    "kWh": (3.6e6, (1, 2, -2, 0, 0)),
    "kg.m2.s^-2": (1.0, (1, 2, -2, 0, 0)),
    "N.m/(rad/s)": (1.0, (1, 2, -1, 0, -1)),
    "kg/(m.s)": (1.0, (1, -1, -1, 0, 0)),
    "(kg.m)2/s": (1.0, (2, 2, -1, 0, 0)),
    "W/(m2.K)": (1.0, (1, 0, -3, -1, 0)),
    "%": (0.01, (0, 0, 0, 0, 0)),
    "t": (1e3, (1, 0, 0, 0, 0)),
}


@pytest.mark.parametrize("symbol", SYMBOLS)
def test_symbols_are_read(symbol: str) -> None:
    unit = units.parse(symbol)
    assert unit is not None
    factor, (kg, m, s, kelvin, rad) = SYMBOLS[symbol]
    assert unit.factor == pytest.approx(factor, rel=1e-12)
    assert unit.exponents == (kg, m, s, 0, kelvin, 0, 0, rad)


@pytest.mark.parametrize(
    "symbol",
    ["", " ", "furlong", "KN", "Kg", "kgg", "10", "12 m", "m/", "/s", "(m", "m)", "()", "N^", "m_s", "e6", "m//s"],
)
def test_invalid_symbols_are_unknown(symbol: str) -> None:
    assert units.parse(symbol) is None


@given(st.text(alphabet="kNmsrad/.()^-²*123 %°", max_size=12))
def test_any_text_is_read_or_not_known(text: str) -> None:
    unit = units.parse(text)
    assert unit is None or (math.isfinite(unit.factor) and unit.factor >= 0.0)


KNOWN = st.sampled_from([s for s in SYMBOLS if "/" not in s and s not in ("US survey foot", "Metre")])


@given(KNOWN, KNOWN)
def test_products_and_quotients_are_those_of_their_parts(one: str, other: str) -> None:
    a, b = units.parse(one), units.parse(other)
    product, quotient = units.parse(f"{one}.{other}"), units.parse(f"{one}/({other})")
    if a is None or b is None or product is None or quotient is None:
        pytest.fail("not read")
    assert product.factor == pytest.approx(a.factor * b.factor)
    assert quotient.factor == pytest.approx(a.factor / b.factor)
    assert product.exponents == tuple(x + y for x, y in zip(a.exponents, b.exponents, strict=True))
    assert quotient.exponents == tuple(x - y for x, y in zip(a.exponents, b.exponents, strict=True))


@pytest.mark.parametrize(
    ("source", "target", "value", "expected"),
    [
        ("kgf", "daN", 12.0, 1.2 * G),
        ("km", "ft", 3.0, 3000 / 0.3048),
        ("rpm", "rad/s", 45.0, 1.5 * math.pi),
        ("degC", "K", 21.0, 294.15),
        ("degF", "degC", 50.0, 10.0),
        ("J", "N.m/rad", 7.0, 7.0),
        ("%", "1", 35.0, 0.35),
        ("gallons", "gallons", 2.0, 2.0),
        ("", "kN", 2.0, 2.0),
    ],
)
def test_values_are_converted(source: str, target: str, value: float, expected: float) -> None:
    found = units.conversion(source, target)
    assert found.factor * value + found.offset == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(
    ("source", "target", "words"),
    [
        ("kPa", "daN", "different quantities"),
        ("lb", "N", "different quantities"),
        ("stone", "kg", "'stone' is unknown"),
        ("kg", "stone", "'stone' is unknown"),
        ("stone", "ell", "'stone' is unknown"),
        ("Hz", "rad/s", "turns or radians"),
        ("rpm", "1/min", "turns or radians"),
        ("mol/s", "Hz", "different quantities"),
    ],
)
def test_what_cannot_be_converted_is_refused(source: str, target: str, words: str) -> None:
    with pytest.raises(rw.InputError, match=words) as error:
        units.conversion(source, target)
    assert error.value.remedy


@pytest.mark.parametrize(
    ("source", "target", "factor"),
    [("degC", "K", 1.0), ("degF", "degC", 5 / 9), ("K", "degF", 9 / 5), ("kN", "N", 1e3)],
)
def test_a_difference_has_no_zero(source: str, target: str, factor: float) -> None:
    assert units.conversion(source, target, differences=(True, True)) == (pytest.approx(factor), 0.0)
    shifted = {"own": units.from_base({"K": 1}, 2.0, 100.0)}
    assert units.conversion("own", "K", shifted, differences=(True, True)) == (2.0, 0.0)
    assert units.to_si("own", shifted, difference=True) == ("K", 2.0, 0.0)


def test_a_difference_is_no_temperature_on_a_scale_with_a_zero_of_its_own() -> None:
    assert units.conversion("degC", "K", differences=(True, False)) == (1.0, 0.0)
    assert units.conversion("K", "degF", differences=(False, True)) == (pytest.approx(1.8), 0.0)
    for source, target, differences in (("degC", "degF", (True, False)), ("degF", "K", (False, True))):
        with pytest.raises(rw.InputError, match="become a value on the scale of 'degF'"):
            units.conversion(source, target, differences=differences)


def test_definitions_precede_symbols() -> None:
    stone = {"stone": units.from_base({"kg": 1}, 6.35029318)}
    assert units.conversion("stone", "kg", stone).factor == pytest.approx(6.35029318)
    assert units.conversion("stone", "stone", stone, {"stone": units.from_base({"kg": 1}, 5.0)}).factor > 1.2
    without_angle = {"rpm": units.from_base({"s": -1}, math.pi / 30)}
    assert units.conversion("rpm", "rad/s", without_angle).factor == pytest.approx(math.pi / 30)


def test_a_factor_alone_has_no_zero() -> None:
    assert units.factor("m/s", "km/h") == pytest.approx(3.6)
    with pytest.raises(rw.InputError, match="zeros"):
        units.factor("degC", "K")


@pytest.mark.parametrize(
    ("symbol", "si", "factor"),
    [("kNm", "J", 1e3), ("L/min", "m3/s", 1e-3 / 60), ("kN.s", "kg.m/s", 1e3), ("ell", "ell", 1)],
)
def test_symbols_in_si(symbol: str, si: str, factor: float) -> None:
    assert units.to_si(symbol) == (si, pytest.approx(factor), 0.0)
    known = units.parse(si)
    assert known is None or known.factor == 1.0


@pytest.mark.parametrize(("one", "other", "equal"), [("N.m", "J", True), ("kN", "N", False), ("ell", "ell", True)])
def test_equal_units(one: str, other: str, equal: bool) -> None:
    assert units.same(one, other) is equal
