"""Arguments of rig functions: parameters in the signature, ropes by name, a terrain as a table."""

import inspect
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

import ropeway as rw
from ropeway.systems.rigs import rig_kind

RIGS = (rw.standing_skyline, rw.live_skyline, rw.gravity_skyline, rw.running_skyline)
LINES = (rw.monocable, rw.endless)
SPARS = {"headspar": rw.HeadSpar("head", at=(0.0, 30.0)), "tailspar": rw.TailSpar("tail", at=(200.0, 0.0))}
CARRIAGE = rw.Carriage("carriage", mass=400.0)
ROPE = "compacted skyline 22"
SUPPORTS = pd.DataFrame(
    [("a", 0, 0, 0, "drum"), ("c", 90, 0, 9, "control"), ("b", 180, 0, 12, "drum")],
    columns=["name", "x", "y", "z", "kind"],
)


def rig(function: Callable[..., rw.SkylineRig], **how: Any) -> rw.SkylineRig:
    carrying = {"haulback" if function is rw.running_skyline else "skyline": ROPE}
    lines = {"mainline": "6x19 EEIP 19"}
    return function(None, **{**SPARS, **carrying, **lines, "tension": 60e3, "carriage": CARRIAGE, **how})


@pytest.mark.parametrize("function", [*RIGS, *LINES])
def test_help_shows_the_real_parameters(function: Callable[..., Any]) -> None:
    parameters = inspect.signature(function).parameters
    assert not [p.name for p in parameters.values() if p.kind in (p.VAR_KEYWORD, p.VAR_POSITIONAL)]
    assert {"tension", "name", "gravity"} <= set(parameters)
    assert parameters["gravity"].default == 9.80665


@pytest.mark.parametrize("function", RIGS)
def test_the_error_of_an_unknown_argument_names_the_function(function: Callable[..., rw.SkylineRig]) -> None:
    with pytest.raises(rw.InputError, match=f"{function.__name__} has no argument 'tensoin'.*tension"):
        rig(function, tensoin=1.0)


@pytest.mark.parametrize("function", RIGS)
def test_ropes_by_name(function: Callable[..., rw.SkylineRig]) -> None:
    named = rig(function)
    assert named.skyline == rw.Rope.named(ROPE)
    assert named.mainline == rw.Rope.named("6x19 EEIP 19")
    wrong = f"{function.__name__}: mainline is '6x19 EEIP 91'.*did you mean '6x19 EEIP 19', '6x19 EEIP 25'"
    with pytest.raises(rw.InputError, match=wrong):
        rig(function, mainline="6x19 EEIP 91")
    with pytest.raises(rw.InputError, match=f"{function.__name__}: mainline is 3.*a Rope, or the name of one"):
        rig(function, mainline=3.0)


def test_every_rope_argument_takes_a_name() -> None:
    rope = rw.Rope.named(ROPE)
    line = rw.monocable(ROPE, SUPPORTS, tension=30e3)
    same = rw.monocable(rope, SUPPORTS, tension=30e3)
    assert rw.equilibrium(line)["a_c.tension_a"] == rw.equilibrium(same)["a_c.tension_a"]
    assert rw.Guyline("guy", ROPE, (0.0, 0.0), 10e3).rope == rope  # type: ignore[arg-type]
    with pytest.raises(rw.InputError, match="monocable: rope is 'compacted'"):
        rw.monocable("compacted", SUPPORTS, tension=30e3)


def test_a_terrain_is_a_profile_a_path_or_a_table(tmp_path: Path) -> None:
    table = pd.DataFrame({"station": [0.0, 90.0, 200.0], "elevation": [20.0, -15.0, -9.0]})
    path = tmp_path / "corridor.csv"
    table.to_csv(path, index=False)
    spars = {
        "headspar": rw.HeadSpar("head", station=0.0, height=12.0),
        "tailspar": rw.TailSpar("tail", station=200.0, height=8.0),
    }
    how = {**spars, "skyline": ROPE, "tension": 60e3, "carriage": CARRIAGE}
    wanted = rw.load_path(rw.standing_skyline(rw.Profile.from_csv(path), **how), 900.0, [100.0])
    for terrain in (path, str(path), table):
        pd.testing.assert_frame_equal(rw.load_path(rw.standing_skyline(terrain, **how), 900.0, [100.0]), wanted)
    with pytest.raises(rw.InputError, match=r"no_such\.csv"):
        rw.standing_skyline(tmp_path / "no_such.csv", **how)
    with pytest.raises(rw.InputError, match=r"standing_skyline: terrain is 3.*a Profile, or its table"):
        rw.standing_skyline(3.0, **how)  # type: ignore[arg-type]


def test_kinds_state_their_differences() -> None:
    kinds = {function: rig(function).kind for function in RIGS}
    assert list(kinds.values()) == [rig_kind.STANDING, rig_kind.LIVE, rig_kind.GRAVITY, rig_kind.RUNNING]
    assert [k.sets_height for k in kinds.values()] == [False, True, True, True]
    assert [k.keeps_length for k in kinds.values()] == [True, True, True, False]
    running = rig(rw.running_skyline)
    assert running.skyline_drum in running.system(station=90.0).components
    assert {"head", "carriage"} <= set(rig(rw.live_skyline).system(station=90.0).components)
