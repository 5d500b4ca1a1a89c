"""Values of inputs at intermediate times of a step."""

from typing import Any

from fmpy.fmi1 import FMICallException

from ropeway.fmu.importing.input_ramps import InputRamp


class _Fmu:
    component = None

    def __init__(self) -> None:
        self.seen: list[tuple[list[int], list[float]]] = []

    def fmi3SetFloat64(self, component: Any, references: Any, count: int, values: Any, size: int) -> None:  # noqa: N802
        self.seen.append((list(references), list(values)))
        if values[0] > 3.0:
            raise FMICallException("fmi3SetFloat64", 3)


def test_values_follow_the_ramp() -> None:
    fmu, ramp = _Fmu(), InputRamp()
    ramp.update(None, 1.0, True)
    ramp.begin(fmu, 1.0, {5: (2.0, 0.5), 7: (0.0, -1.0)})
    for time, wanted in ((1.0, True), (1.5, True), (1.7, False), (1.25, True)):
        ramp.update(None, time, wanted, False, False, False, None, None)
    assert fmu.seen == [([5, 7], values) for values in ([2.0, 0.0], [2.25, -0.5], [2.125, -0.25])]
    assert ramp.end() is None
    ramp.update(None, 2.0, True)
    assert len(fmu.seen) == 3


def test_a_rejected_value_is_known_at_the_end() -> None:
    fmu, ramp = _Fmu(), InputRamp()
    ramp.begin(fmu, 0.0, {5: (2.0, 1.0)})
    ramp.update(None, 2.0, True)
    ramp.update(None, 0.5, True)
    refusal = ramp.end()
    assert refusal is not None
    assert refusal.status == 3
    assert ramp.end() is None
