"""Instances, reset, states saved and restored, time that goes back; and that failures are never numbers."""

import math
from pathlib import Path

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException

import ropeway as rw
from ropeway.fmu import export
from support.fmus import Opened, Opener, one_span, skyline

NAMES = ["c1.tension_in", "c1.tension_out", "c1.travel", "s1.travel"]


@pytest.fixture(params=["line2", "line3"])
def line(request: pytest.FixtureRequest) -> Path:
    path: Path = request.getfixturevalue(request.param)
    return path


def started(open_fmu: Opener, line: Path) -> Opened:
    one = open_fmu(line)
    one.initialize()
    return one


def test_two_instances_are_independent(open_fmu: Opener, line: Path) -> None:
    alone = started(open_fmu, line).run(0.0, 40.0, 0.5, NAMES)
    one, two = started(open_fmu, line), started(open_fmu, line)
    two.set(c1__speed=1.05)
    rows = []
    for i in range(80):
        one.step(0.5 * i, 0.5)
        two.step(0.5 * i, 0.5)
        rows.append(one.get(*NAMES))
    assert np.array_equal(np.array(rows), alone)
    assert two.get("c1.travel")[0] == pytest.approx(42.0)


def test_reset_and_run_again_bit_for_bit(open_fmu: Opener, line: Path) -> None:
    one = started(open_fmu, line)
    first = one.run(0.0, 40.0, 0.5, NAMES)
    one.fmu.reset()
    one.setup()
    one.initialize()
    assert np.array_equal(one.run(0.0, 40.0, 0.5, NAMES), first)


def test_a_restored_state_continues_identically(open_fmu: Opener, line: Path) -> None:
    one = started(open_fmu, line)
    one.run(0.0, 25.5, 0.5, NAMES)
    state = one.save()
    first = one.run(25.5, 40.0, 0.5, NAMES)
    one.restore(state)
    assert one.get("time") == [25.5]
    assert np.array_equal(one.run(25.5, 40.0, 0.5, NAMES), first)


def test_a_state_is_restored_in_another_instance(open_fmu: Opener, line: Path) -> None:
    one, two = started(open_fmu, line), started(open_fmu, line)
    one.run(0.0, 25.6, 0.4, NAMES)
    state = one.save()
    if one.three:
        restored = two.fmu.deserializeFMUState(one.fmu.serializeFMUState(state))
    else:
        restored = two.fmu.deSerializeFMUstate(one.fmu.serializeFMUstate(state))
    two.restore(restored)
    assert np.array_equal(two.run(25.6, 40.0, 0.4, NAMES), one.run(25.6, 40.0, 0.4, NAMES))


def test_bytes_of_something_else_are_refused(open_fmu: Opener, line: Path) -> None:
    one = started(open_fmu, line)
    with pytest.raises(FMICallException):
        (one.fmu.deserializeFMUState if one.three else one.fmu.deSerializeFMUstate)(b"x" * 100)
    assert "not a state of this FMU" in one.log[-1]


def test_damaged_bytes_are_refused(open_fmu: Opener, line: Path) -> None:
    one = open_fmu(line)
    one.initialize()
    state = one.save()
    bytes_ = bytearray(one.fmu.serializeFMUState(state) if one.three else one.fmu.serializeFMUstate(state))
    for place in (len(bytes_) // 2, len(bytes_) - 1):
        bytes_[place] ^= 1
        with pytest.raises(FMICallException):
            (one.fmu.deserializeFMUState if one.three else one.fmu.deSerializeFMUstate)(bytes(bytes_))
        assert "their checksum differs" in one.log[-1]
        bytes_[place] ^= 1


def refused(one: Opened, text: str) -> None:
    assert one.log, "nothing was logged"
    assert text in one.log[-1]


def test_what_is_not_finite_is_refused(open_fmu: Opener, line: Path) -> None:
    one = started(open_fmu, line)
    for value in (math.nan, math.inf):
        with pytest.raises(FMICallException):
            one.set(c1__speed=value)
        refused(one, "not finite")
    one.step(0.0, 1.0)
    assert one.get("c1.travel") == pytest.approx([1.0])


def test_a_bad_value_reference_is_refused(open_fmu: Opener, line: Path) -> None:
    one = started(open_fmu, line)
    one.references["bad"] = 10**6
    with pytest.raises(FMICallException):
        one.get("bad")
    refused(one, "Unknown value reference")
    with pytest.raises(FMICallException):
        one.set(bad=1.0)
    one.references["hidden"] = next(r for r in range(10**4) if r not in one.references.values())
    with pytest.raises(FMICallException):
        one.get("hidden")


def test_parameters_and_outputs_cannot_be_set_while_it_runs(open_fmu: Opener, line: Path) -> None:
    one = started(open_fmu, line)
    for name in ("start_s1.length_start", "c1.tension_in"):
        with pytest.raises(FMICallException):
            one.set(**{name.replace(".", "__"): 9.0})
        refused(one, f"The variable {name} cannot be set now")


def test_the_stop_time_is_kept(open_fmu: Opener, line: Path) -> None:
    one = open_fmu(line)
    if one.three:
        one.fmu.enterInitializationMode(startTime=0.0, stopTime=1.0)
    else:
        one.fmu.setupExperiment(startTime=0.0, stopTime=1.0)
        one.fmu.enterInitializationMode()
    one.fmu.exitInitializationMode()
    for i in range(10):  # the sum of the steps is not exactly one
        one.step(0.1 * i, 0.1)
    with pytest.raises(FMICallException):
        one.step(1.0, 0.1)
    refused(one, "beyond the stop time 1 s")


def test_the_tolerance_of_the_importer_counts(open_fmu: Opener, driven: Path) -> None:
    """The FMU is exported with 1e-8; a coarse tolerance takes other steps, with a larger error."""
    found = []
    for tolerance in (None, 1e-8, 1e-3):
        one = open_fmu(driven)
        one.fmu.setupExperiment(tolerance=tolerance, startTime=0.0)
        one.initialize()
        one.set(c1__speed=1.3)
        found.append(one.run(0.0, 1.0, 1.0, ["c1.rope_speed", "c1.travel"])[0])
    assert np.array_equal(found[0], found[1])
    assert 1e-9 < np.abs(found[2] / found[0] - 1.0).max() < 1e-2


@pytest.mark.slow
def test_a_step_of_days_ends(open_fmu: Opener, line2: Path) -> None:
    one = open_fmu(line2)
    one.initialize()
    before = one.get("c1.tension_in")
    with pytest.raises(FMICallException):
        one.step(0.0, 1e7)
    refused(one, "take smaller steps")
    assert one.get("c1.tension_in") == before


def test_a_length_must_be_above_zero(open_fmu: Opener, line: Path) -> None:
    one = open_fmu(line)
    with pytest.raises(FMICallException):
        one.set(start_s1__length_start=-1.0)
    refused(one, "must be above 0")


def test_parameters_out_of_range(open_fmu: Opener, driven: Path, tmp_path: Path) -> None:
    one = open_fmu(driven)
    for name in ("c1__inertia", "c1__volume_per_metre", "c1__pump_flow", "c1__response_time"):
        for value in (0.0, -1.0):
            with pytest.raises(FMICallException):
                one.set(**{name: value})
            refused(one, "must be above 0")
    for name, value, words in (("drag", -1.0, "not be below 0"), ("mechanical_efficiency", 1.01, "be at most 1")):
        with pytest.raises(FMICallException):
            one.set(**{f"c1__{name}": value})
        refused(one, f"must {words}")
    two = open_fmu(export(skyline(), tmp_path / "skyline.fmu"))
    two.set(carriage__payload=0.0)
    with pytest.raises(FMICallException):
        two.set(carriage__payload=-1.0)
    refused(two, "must not be below 0")


def test_invalid_steps_are_rejected(open_fmu: Opener, line: Path) -> None:
    one = started(open_fmu, line)
    for time, size in ((0.0, -1.0), (0.0, math.nan), (5.0, 1.0)):
        with pytest.raises(FMICallException):
            one.step(time, size)
        refused(one, "was requested")


def test_parameters_without_an_equilibrium(open_fmu: Opener, line: Path) -> None:
    one = open_fmu(line)
    one.set(c1__travel=1e4)  # more rope than there is
    with pytest.raises(FMICallException):
        one.initialize()
    assert "No equilibrium was found" in one.log[-1]


@pytest.mark.parametrize("name", ["span2", "span3"])
def test_singular_equations(open_fmu: Opener, name: str, request: pytest.FixtureRequest) -> None:
    """A rope without weight and almost without elasticity, longer than its chord: any tension would do."""
    one = open_fmu(request.getfixturevalue(name))
    one.set(a_b__compliance=1e-30, a_b__mass_per_length=1e-200, turn__mass=0.0)
    with pytest.raises(FMICallException) as caught:
        one.initialize()
    assert caught.value.status == 3
    assert any("The equations are singular" in text for text in one.log)
    with pytest.raises(FMICallException):
        one.get("a_b.tension_a")
    one.fmu.reset()
    one.setup()
    one.initialize()
    assert one.get("a_b.tension_a") == pytest.approx([rw.equilibrium(one_span())["a_b.tension_a"]], rel=1e-9)


def test_a_step_that_fails_leaves_the_state(open_fmu: Opener, line: Path) -> None:
    one = started(open_fmu, line)
    one.step(0.0, 1.0)
    before = one.get(*NAMES)
    one.set(c1__speed=60.0, c2__speed=-60.0)  # more loads come between them than the FMU has room for
    with pytest.raises(FMICallException):
        one.step(1.0, 60.0)
    assert "which has 3 slots" in one.log[-1]
    one.set(c1__speed=1.0, c2__speed=1.0)
    assert one.get("time") == [1.0]
    assert one.get(*NAMES) == pytest.approx(before, rel=1e-12)
    one.step(1.0, 1.0)
    assert one.get("c1.travel") == pytest.approx([2.0])


def test_wrong_token(open_fmu: Opener, line: Path) -> None:
    one = open_fmu(line)
    one.fmu.guid = one.fmu.instantiationToken = "{0}"
    with pytest.raises(Exception, match=r"[Ff]ailed to instantiate"):
        one._instantiate()
