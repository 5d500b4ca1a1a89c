"""The log: closed form of a rigid log in partial suspension, full suspension, and the way from one to the other."""

import numpy as np
import pytest

import ropeway as rw

G = 9.80665
LINE = rw.Rope(mass_per_length=0.5, axial_stiffness=6e6, breaking_load=100e3)


def hang(drop: float, *, slope: float = 0.2, moving: float = -1.0) -> rw.Equilibrium:
    """A log of 9 m on a line of `drop` metres under a point 10 m over sloping ground."""
    s = rw.System("log")
    at = (-0.2 * moving * drop, 10.0 - 0.98 * drop)
    log = rw.Log("log", at=at, mass=1200.0, length=9.0, friction=0.6, slope=slope, ground_z=0.0, moving=moving)
    s.string(LINE, rw.Anchor("carriage", at=(0.0, 10.0)), log, length=drop)
    return rw.equilibrium(s)


@pytest.mark.parametrize("drop", [3.0, 5.0, 7.0, 8.0])
@pytest.mark.parametrize("slope", [-0.3, 0.0, 0.4])
@pytest.mark.parametrize("moving", [-1.0, 0.0, 1.0])
def test_partial_suspension_is_the_rigid_log(drop: float, slope: float, moving: float) -> None:
    eq = hang(drop, slope=slope, moving=moving)
    front = np.array([eq["log.x"], eq["log.z"]])
    rear = np.array([eq["log.rear_x"], eq["log.rear_z"]])
    assert eq["log.normal"] > 100.0
    assert rear[1] == pytest.approx(slope * rear[0], abs=1e-9)
    assert np.linalg.norm(rear - front) == pytest.approx(9.0, rel=1e-9)
    # Moments about the front: the ground's force from the weight alone; then what the line carries.
    normal = np.array([-slope, 1.0]) / np.hypot(1.0, slope)
    tangent = np.array([1.0, slope]) / np.hypot(1.0, slope)
    reaction = normal - moving * 0.6 * tangent
    arm = rear - front
    n = 1200.0 * G * 0.5 * arm[0] / (arm[0] * reaction[1] - arm[1] * reaction[0])
    assert eq["log.normal"] == pytest.approx(n, rel=1e-9)
    pull = np.array([0.0, 1200.0 * G]) - n * reaction
    assert eq["log.line_pull"] == pytest.approx(np.linalg.norm(pull), rel=1e-9)
    assert eq["carriage_log.tension_b"] == pytest.approx(np.linalg.norm(pull), rel=1e-9)


@pytest.mark.parametrize("after", [-0.1, 0.5])
def test_over_a_vertex_of_the_ground(after: float) -> None:
    """A hollow or a ridge moved past the rear: away from it the plane's answer, between both no jump."""
    slope, drop = 0.2, 6.0

    def forces(step: float) -> np.ndarray:
        log = rw.Log("log", at=(0.2 * drop, 10.0 - 0.98 * drop), mass=1200.0, length=9.0, slope=slope, ground_z=0.0)
        s = rw.System("vertex")
        s.string(LINE, rw.Anchor("carriage", at=(0.0, 10.0)), log, length=drop)
        eq = rw.equilibrium(s)
        found = []
        for x in np.arange(12.0, 4.0, -step):
            vertex = {"log.ground_x": x, "log.ground_z": slope * x, "log.slope_after": after}
            eq = rw.equilibrium(eq.model, parameters=vertex, start=eq)
            found.append((x, eq["log.rear_x"], eq["log.rear_z"], eq["log.normal"], eq["log.line_pull"]))
        return np.array(found)

    coarse, fine = forces(0.1), forces(0.025)
    assert coarse[0, 1] < coarse[0, 0] - 1.0  # the rear lies before the vertex at first,
    assert coarse[-1, 1] > coarse[-1, 0] + 1.0  # beyond it in the end
    assert coarse[0, 3] == pytest.approx(hang(drop)["log.normal"], rel=1e-9)
    assert coarse[-1, 2] == pytest.approx(slope * coarse[-1, 0] + after * (coarse[-1, 1] - coarse[-1, 0]), abs=1e-8)
    for column in (1, 2, 3, 4):
        assert np.abs(np.diff(fine[:, column])).max() < 0.3 * np.abs(np.diff(coarse[:, column])).max()


def test_full_suspension_hangs_below_its_front() -> None:
    eq = hang(0.5)
    assert eq["log.normal"] == pytest.approx(0.0, abs=1e-6)
    assert eq["log.rear_x"] == pytest.approx(eq["log.x"], abs=1e-6)
    assert eq["log.line_pull"] == pytest.approx(1200.0 * G, rel=1e-9)
    assert eq["log.gap"] > 0.0


def test_a_dragging_log_lifts_off() -> None:
    """Followed as its line gets shorter it drags with less and less force, past the length at which it could also
    hang, down to the fold of its branch; on a shorter line it hangs, and only that."""
    eq = hang(2.0)
    normals = []
    for drop in np.linspace(2.0, 0.82, 60):
        eq = rw.equilibrium(eq.model, parameters={"carriage_log.length": float(drop)}, start=eq)
        normals.append(eq["log.normal"])
    assert (np.diff(normals) < 0.0).all()
    assert normals[-1] > 1000.0
    hanging = hang(0.9)
    assert hanging["log.normal"] == pytest.approx(0.0, abs=1e-6)
    assert hanging["log.gap"] > 0.0
    for drop in (0.66, 0.5):
        short = rw.equilibrium(hanging.model, parameters={"carriage_log.length": drop}, start=hanging)
        assert short["log.normal"] == pytest.approx(0.0, abs=1e-6)
        assert short["log.line_pull"] == pytest.approx(1200.0 * G, rel=1e-9)


def test_bad_logs_are_refused() -> None:
    for how in (
        {"mass": 0.0},
        {"length": -1.0},
        {"centre": 1.0},
        {"moving": 0.5},
        {"friction": -0.1},
        {"rounding": 0.0},
    ):
        with pytest.raises(rw.InputError):
            rw.Log("log", **{"mass": 100.0, "length": 5.0, **how})
