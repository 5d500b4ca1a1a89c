"""Standing skylines: scripts of the design, three dimensions, haulback, components in a plain System."""

from pathlib import Path

import numpy as np
import pytest

import ropeway as rw
from ropeway.systems.studies.skyline.payload.command import CorridorRequest, payload_command

CORRIDOR = Path(rw.__file__).parent / "examples" / "corridor.csv"
ROPE = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)
MAIN = rw.Rope(mass_per_length=0.73, axial_stiffness=8e6, breaking_load=120e3)


def test_the_script_of_the_design() -> None:
    rig = rw.standing_skyline(
        rw.Profile.from_csv(CORRIDOR),
        headspar=rw.HeadSpar("head", station=0.0, height=15.0),
        supports=[rw.IntermediateSupport("jack", station=260.0, height=9.0)],
        tailspar=rw.TailSpar("tail", station=480.0, height=8.0),
        skyline=ROPE,
        tension=70e3,
        mainline=MAIN,
        carriage=rw.Carriage("carriage", mass=450.0),
    )
    path = rw.load_path(rig, payload=2500.0, stations=[50, 100, 150])
    columns = "carriage_x carriage_z skyline_tension headspar_tension tailspar_tension mainline_pull sag deflection"
    assert {*columns.split(), "clearance"} <= set(path.columns)
    np.testing.assert_allclose(path.carriage_x, [50.0, 100.0, 150.0], atol=1e-9)
    assert (path.clearance > 5.0).all()
    assert path.attrs["units"]["skyline_tension"] == "N"
    study = rw.payload(rig, safety_factor=3.0, clearance=1.0)
    assert {"station", "payload", "limited_by"} <= set(study.frame.columns)
    assert study.limiting.payload == study.frame.payload.min() > 3000.0
    assert len(study.plot().axes) == 3
    # The bare rope has its tension at the headspar.
    bare = rw.System("bare")
    bare.string(ROPE, rig.headspar, *rig.supports, rig.tailspar, length=rig.length)
    assert rw.equilibrium(bare)["head.tension"] == pytest.approx(70e3, rel=1e-9)


def test_a_tailhold_off_the_line_pulls_the_carriage_aside() -> None:
    """Three dimensions: the whole skyline between tailspar and tailhold leaves the corridor's plane."""

    def rig(aside: float) -> rw.SkylineRig:
        hold = rw.Tailhold("stump", at=(260.0, aside, -45.0))
        return rw.standing_skyline(
            None,
            headspar=rw.HeadSpar("head", at=(0.0, 0.0, 0.0)),
            tailspar=rw.TailSpar("tail", at=(230.0, 0.5 * aside, -30.0), tailhold=hold),
            skyline=ROPE,
            tension=60e3,
            carriage=rw.Carriage("carriage", mass=450.0),
        )

    straight = rw.load_path(rig(0.0), 2000.0, [115.0]).iloc[0]
    turned = rw.load_path(rig(20.0), 2000.0, [115.0]).iloc[0]
    assert straight.carriage_y == pytest.approx(0.0, abs=1e-9)
    # The carriage hangs in the vertical plane through headspar and tailspar.
    assert turned.carriage_y == pytest.approx(0.5 * 10.0, rel=1e-6)
    assert turned.anchor_tension < turned.tailspar_tension
    assert rw.payload(rig(20.0), stations=[115.0]).limiting.limited_by == "skyline tension"


def test_a_haulback_pulls_against_the_mainline() -> None:
    def pull(**how: object) -> float:
        rig = rw.standing_skyline(
            None,
            headspar=rw.HeadSpar("head", at=(0.0, 60.0)),
            tailspar=rw.TailSpar("tail", at=(240.0, 0.0)),
            skyline=ROPE,
            tension=60e3,
            mainline=MAIN,
            carriage=rw.Carriage("carriage", mass=450.0),
            **how,  # type: ignore[arg-type]
        )
        row = rw.load_path(rig, 1500.0, [120.0]).iloc[0]
        assert row.held_by == "mainline"
        return float(row.mainline_pull)

    alone, both = pull(), pull(haulback=MAIN, haulback_tension=8e3)
    assert both - alone == pytest.approx(8e3, rel=0.1)


def test_components_in_a_plain_system_with_a_dropline() -> None:
    """A carriage on a rope in two parts; a second rope holds a block on its dropline."""
    s = rw.System("dropline")
    carriage = rw.Carriage("carriage", at=(50.0, -8.0), mass=300.0, holding="bisector")
    s.string(ROPE, rw.HeadSpar("head", at=(0.0, 0.0)), carriage, rw.TailSpar("tail", at=(100.0, 0.0)), length=101.0)
    s.string(MAIN, carriage.dropline, rw.Tailhold("log", at=(50.0, -30.0)), length=22.5)
    eq = rw.equilibrium(s)
    assert eq["carriage.holding"] == pytest.approx(0.0, abs=1e-6)
    assert eq["carriage.dropline_pull"] > 0.0
    lift = eq["head_carriage.vertical_a"] + eq["carriage_tail.vertical_b"]
    weight = (300.0 + 3.48 * 101.0) * 9.80665 + eq["carriage_log.vertical_a"]
    assert lift == pytest.approx(weight, rel=1e-10)


def test_the_command_writes_table_and_figure(tmp_path: Path) -> None:
    request = CorridorRequest(
        corridor=CORRIDOR,
        skyline=ROPE,
        tension=70e3,
        mainline=MAIN,
        head=0.0,
        tail=480.0,
        supports=("260:9",),
        spacing=20.0,
    )
    study, (table, picture) = payload_command(request, tmp_path / "out")
    assert study.payload > 3000.0
    assert table.read_text().startswith("station [m],payload [kg],limited_by")
    assert picture.stat().st_size > 20_000
    with pytest.raises(rw.InputError, match="STATION:HEIGHT"):
        payload_command(CorridorRequest(corridor=CORRIDOR, skyline=ROPE, tension=70e3, supports=("260",)), tmp_path)
