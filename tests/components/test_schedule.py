"""A schedule read from another time on."""

import pytest

import ropeway as rw

OWN = rw.Schedule((0.0, 20.0, 60.0), (1.0, 1.1, 0.9))


@pytest.mark.parametrize("by", [0.0, 5.0, 20.0, 45.0, 70.0])
def test_a_later_schedule_is_the_same_at_the_same_time(by: float) -> None:
    rest = OWN.later(by, 30.0)
    assert (rest.times[0], rest.times[-1]) == (0.0, 30.0)
    for t in (0.0, 1.0, 14.9, 20.0, 30.0):
        assert rest.at(t) == pytest.approx(OWN.at(by + t), abs=1e-12)


def test_a_later_schedule_keeps_its_last_speed() -> None:
    rest = OWN.later(50.0, 30.0)
    assert rest.times == (0.0, 10.0, 30.0)
    assert rest.speeds == pytest.approx((0.95, 0.9, 0.9))
