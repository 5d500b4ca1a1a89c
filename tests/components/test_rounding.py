"""Limits as text never promise more than there is."""

import math
from decimal import Decimal

from hypothesis import given, strategies as st

from ropeway.components.rounding import NOISE, at_least, at_most

VALUES = st.floats(-1e7, 1e7, allow_nan=False)


@given(VALUES, st.integers(0, 3))
def test_texts_enclose_the_value_within_one_digit(value: float, places: int) -> None:
    low, high = Decimal(at_most(value, places)), Decimal(at_least(value, places))
    noise = Decimal(2.0 * NOISE * max(abs(value), 1.0))
    assert low <= Decimal(value) + noise
    assert high >= Decimal(value) - noise
    assert high - low <= Decimal(1).scaleb(-places)


def test_payloads_go_down_and_tensions_up() -> None:
    assert at_most(3894.97) == "3894"
    assert at_most(4.1259, 2) == "4.12"
    assert at_least(85.401, 1) == "85.5"
    assert at_least(-0.26, 1) == "-0.2"


def test_rounding_errors_change_no_digit() -> None:
    assert at_least(0.1 + 0.2, 1) == "0.3"
    assert at_most(3.0 - 1e-12) == "3"
    assert at_least(192.2 * (1.0 + 1e-13), 1) == "192.2"


def test_infinite_limits_are_printed() -> None:
    assert at_most(math.inf, 1) == "inf"
