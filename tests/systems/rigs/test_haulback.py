"""A haulback from the headspar to a block near the tailspar and back to the carriage."""

import numpy as np
import pytest

import ropeway as rw

G = 9.80665
ROPE = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)
MAIN = rw.Rope(mass_per_length=0.73, axial_stiffness=8e6, breaking_load=120e3)
TOP, TAIL = 100.0, -70.0


def rig(make: object = rw.standing_skyline, block: rw.Block | None = None, **how: object) -> rw.SkylineRig:
    parts: dict[str, object] = {"haulback": MAIN, "haulback_tension": 8e3, "haulback_block": block, **how}
    return make(  # type: ignore[operator, no-any-return]
        None,
        headspar=rw.HeadSpar("head", at=(0.0, TOP)),
        supports=[rw.IntermediateSupport("s1", at=(160.0, 40.0)), rw.IntermediateSupport("s2", at=(330.0, -20.0))],
        tailspar=rw.TailSpar("tail", at=(480.0, TAIL)),
        skyline=ROPE,
        tension=70e3,
        mainline=MAIN,
        carriage=rw.Carriage("carriage", mass=450.0),
        **parts,
    )


BLOCK = rw.Block("tail_block", at=(495.0, -78.0))


def lowered(tension: float, drop: float) -> float:
    """Tension of the haulback `drop` metres below a point with `tension`: T + T^2/2EA changes by the weight."""
    stiffness = 8e6
    potential = tension + tension**2 / (2.0 * stiffness) - 0.73 * G * drop
    return float(stiffness * (np.sqrt(1.0 + 2.0 * potential / stiffness) - 1.0))


@pytest.mark.parametrize("make", [rw.standing_skyline, rw.live_skyline])
def test_a_block_at_the_tailspars_top_equals_a_drum_there_with_the_tension_at_the_block(make: object) -> None:
    stations = [60.0, 200.0, 420.0]
    real = rw.load_path(rig(make, rw.Block("tail_block", at=(480.0, TAIL))), 2500.0, stations)
    at_tail = lowered(8e3, TOP - TAIL)
    ideal = rw.load_path(rig(make, haulback_tension=at_tail), 2500.0, stations)
    for column in ("carriage_z", "skyline_tension", "mainline_pull", "mainline_tension", "haulback_pull"):
        np.testing.assert_allclose(real[column], ideal[column], rtol=1e-9)
    np.testing.assert_allclose(real.haulback_tension, 8e3, rtol=1e-12)
    for x, row in zip(stations, real.itertuples(), strict=True):
        assert row.haulback_pull == pytest.approx(lowered(8e3, TOP - row.carriage_z), rel=1e-9), x


def test_forces_of_a_rig_with_a_real_haulback_sum_to_zero() -> None:
    held = rig(block=BLOCK)
    eq = rw.equilibrium(held.system(1, 250.0, payload=2500.0), given={"carriage.x": 250.0}, solve_for="mainline.travel")
    spans = [n.removesuffix(".vertical_a") for n in eq.model.y.names if n.endswith(".vertical_a")]
    ends = {"head_s1": "a", "mainline_s1_mainline": "a", "haulback_tail_block": "a", "s2_tail": "b"}
    up = sum(eq[f"{span}.vertical_{end}"] for span, end in ends.items())
    up += eq["s1.support_force"] + eq["s2.support_force"] + eq["s1_mainline.support_force"]
    up += eq["tail_block.support_force"]
    mass = sum(
        eq[f"{s}.length"] * (3.48 if s in ("head_s1", "s1_carriage", "carriage_s2", "s2_tail") else 0.73) for s in spans
    )
    assert up == pytest.approx((mass + 2950.0) * G, rel=1e-10)
    assert eq["tail_block.tension_in"] == pytest.approx(eq["tail_block.tension_out"], rel=1e-12)
    assert eq["haulback.rope_tension"] == pytest.approx(8e3, rel=1e-12)


def test_a_run_with_a_real_haulback_is_the_load_path_and_its_drum_brakes() -> None:
    run = rw.inhaul(rig(block=BLOCK), payload=2500.0, start=300.0, end=190.0, speed=3.0, every=4.0)
    path = rw.load_path(rig(block=BLOCK), 2500.0, run.frame.carriage_x.to_numpy())
    for column in ("carriage_z", "skyline_tension", "mainline_pull", "haulback_pull"):
        np.testing.assert_allclose(run.frame[column], path[column], rtol=1e-6)
    assert (run.frame.haulback_power < 0.0).all()
    # It leaves the drum at about the speed of the carriage.
    paid = run.frame.haulback_power / -8e3
    assert paid.to_numpy() == pytest.approx(-run.frame.carriage_speed.to_numpy(), rel=0.15)


def test_the_blocks_capacity_limits_the_payload_and_a_block_needs_a_haulback() -> None:
    weak = rw.Block("tail_block", at=(495.0, -78.0), capacity=5e3)
    study = rw.payload(rig(block=weak), stations=[250.0])
    assert (study.payload, study.limiting.limited_by) == (0.0, "capacity of tail_block")
    with pytest.raises(rw.InputError, match="no haulback"):
        rig(block=BLOCK, haulback=None, haulback_tension=None)


def test_over_a_guyed_spar() -> None:
    anchors = [(-20.0, -12.0, 83.0), (-20.0, 12.0, 83.0), (12.0, -20.0, 82.0), (12.0, 20.0, 82.0)]
    guy = rw.Rope(mass_per_length=2.0, axial_stiffness=20e6, breaking_load=380e3)
    guys = tuple(rw.Guyline(f"g{i}", rope=guy, at=at, pretension=20e3) for i, at in enumerate(anchors))
    head = rw.GuyedSpar("head", foot=(0.0, TOP - 15.0), height=15.0, guylines=guys)
    free, held = (
        rw.load_path(
            rw.live_skyline(
                None,
                headspar=head,
                tailspar=rw.TailSpar("tail", at=(480.0, TAIL)),
                skyline=ROPE,
                tension=70e3,
                mainline=MAIN,
                carriage=rw.Carriage("carriage", mass=450.0),
                **haulback,
            ),
            2500.0,
            [250.0],
        ).iloc[0]
        for haulback in ({}, {"haulback": MAIN, "haulback_tension": 8e3, "haulback_block": BLOCK})
    )
    # Its two parts at the block: one towards the drum, one towards the tail.
    assert held.spar_compression > free.spar_compression + 8e3
    assert held.haulback_pull == pytest.approx(lowered(8e3, TOP - 15.0 - held.carriage_z), rel=1e-9)
