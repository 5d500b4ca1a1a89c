"""User-defined components: correct numbers for each class and its constants, equilibria by closed forms, typed
errors."""

from dataclasses import dataclass, field, replace
from typing import Any

import casadi as ca
import numpy as np
import pytest

import ropeway as rw

ROPE = rw.Rope(mass_per_length=1.9, axial_stiffness=18e6, breaking_load=320e3)
GRAVITY = 9.80665


@dataclass(frozen=True)
class Rough(rw.Sheave):
    """Multiplies the incoming tension by `gain`, a constant of the instance."""

    gain: float = 1.0

    def equations(self, v: Any) -> rw.Equations:
        plain = super().equations(v)
        tensions = plain.outputs["tension_out"], plain.outputs["tension_in"]
        return replace(plain, residuals={"tension_law": tensions[0] - self.gain * tensions[1]})


@pytest.mark.parametrize("order", [(0, 1, 2), (1, 0, 2), (2, 1, 0)])
def test_each_class_and_each_constant_has_its_own_equations(order: tuple[int, ...]) -> None:
    gains = {"plain": 1.0, "more": 1.03, "less": 0.96}
    made = [rw.Sheave("plain", at=(0, 0)), Rough("more", at=(0, 0), gain=1.03), Rough("less", at=(0, 0), gain=0.96)]
    over = [replace(made[k], at=(60.0 * (i + 1), 2.0 * i)) for i, k in enumerate(order)]
    s = rw.System("rough")
    s.string(ROPE, rw.Anchor("a", at=(0.0, 0.0)), *over, rw.Drum("d", at=(240.0, 0.0), tension=35e3), length=241.0)
    eq = rw.equilibrium(s)
    for name, gain in gains.items():
        assert eq[f"{name}.tension_out"] / eq[f"{name}.tension_in"] == pytest.approx(gain, rel=1e-9)
    assert eq.certificate["holds"].all()


@dataclass(frozen=True)
class Spring(rw.Node):
    """An anchor held in x by a spring and a damper."""

    stiffness: float = 2e5
    damping: float = 1e4

    @property
    def seats(self) -> tuple[rw.Seat, ...]:
        return (rw.Seat(self, "rope"),)

    def variables(self, site: rw.Site) -> tuple[rw.Variable, ...]:
        return (
            *self.place()[1:],
            rw.Variable("stiffness", rw.Kind.PARAMETER, "N/m", "stiffness", self.stiffness, 1e5),
            rw.Variable("x", rw.Kind.STATE, "m", "x of the anchor", self.at[0]),
        )

    def equations(self, v: Any) -> rw.Equations:
        return rw.Equations(rates={"x": (v.rope.force[0] - v.stiffness * (v.x - self.at[0])) / self.damping})


def test_displacement_of_a_spring() -> None:
    """15.0 kN at 2e5 N/m: 75.0 mm."""
    s = rw.System("spring")
    s.string(ROPE, Spring("spring", at=(0.0, 0.0)), rw.Anchor("b", at=(120.0, 0.0)), length=120.2)
    eq = rw.equilibrium(s, given={"spring_b.horizontal": 15e3}, solve_for="spring_b.length")
    assert eq["spring.x"] == pytest.approx(0.075, rel=1e-10)
    run = rw.simulate(s, until=1.0, every=0.5, progress=False)
    rest = rw.equilibrium(s)
    assert run.frame["spring.x"].to_numpy() == pytest.approx(rest["spring.x"], rel=1e-9)
    softer = rw.equilibrium(s, parameters={"spring.stiffness": 1e5}, start=rest)
    assert softer["spring.x"] == pytest.approx(softer["spring_b.horizontal"] / 1e5, rel=1e-10)


@dataclass(frozen=True)
class Weight(rw.Node):
    """A counterweight with inertia at the end of a rope."""

    mass: float = 1500.0
    travels: bool = True

    @property
    def seats(self) -> tuple[rw.Seat, ...]:
        return (rw.Seat(self, "rope", travel="travel"),)

    @property
    def drive_speed(self) -> str:
        return "speed"

    def variables(self, site: rw.Site) -> tuple[rw.Variable, ...]:
        return (
            *self.place(),
            rw.Variable("mass", rw.Kind.PARAMETER, "kg", "mass", self.mass, 1000.0),
            rw.Variable("travel", rw.Kind.STATE, "m", "rope let out", 0.0, site.length),
            rw.Variable("speed", rw.Kind.STATE, "m/s", "speed"),
        )

    def equations(self, v: Any) -> rw.Equations:
        pull = ca.norm_2(ca.vertcat(*v.rope.force))
        return rw.Equations(rates={"travel": v.speed, "speed": pull / v.mass - v.gravity if self.travels else -v.speed})

    def energies(self, read: Any) -> rw.Energies:
        mass = self.mass
        return rw.Energies(kinetic=0.5 * mass * read("speed") ** 2, supplied=-mass * GRAVITY * read("travel"))


def weighted(**how: Any) -> rw.System:
    s = rw.System("weighted")
    nodes = (Weight("w", at=(0.0, 0.0), **how), rw.Sheave("s", at=(70.0, 4.0)), rw.Drum("d", at=(150.0, 0.0)))
    s.string(ROPE, *nodes, length=151.0)
    return s


def test_equilibrium_of_a_counterweight() -> None:
    s = weighted()
    table = rw.sweep(
        s, {"w.mass": [1200.0, 1500.0, 2100.0]}, outputs=["w_s.tension_a", "s.tension_out"], progress=False
    )
    assert table["w_s.tension_a"].to_numpy() == pytest.approx(GRAVITY * table["w.mass"].to_numpy(), rel=1e-9)
    found = rw.sensitivities(rw.equilibrium(s), of=["w_s.tension_a"], to=["w.mass"])
    assert float(found.loc["w_s.tension_a", "w.mass"]) == pytest.approx(GRAVITY, rel=1e-6)


def test_energy_balance_of_a_counterweight() -> None:
    s = weighted()
    turn = rw.Schedule((0.0, 1.0, 4.0), (0.0, 0.3, 0.3))
    run = rw.simulate(s, until=4.0, every=0.002, inputs={"d.speed": turn}, progress=False)
    energy = run.energy()
    assert energy["take_up"] < -1e3
    assert abs(energy["residual"]) < 1e-4 * abs(energy["take_up"])
    assert energy["kinetic"] == pytest.approx(0.5 * 1500.0 * run.frame["w.speed"].iloc[-1] ** 2, rel=1e-9)
    assert run.summary().supports.loc["w", "kind"] == "Weight"


def test_the_error_names_an_undetermined_travel() -> None:
    with pytest.raises(rw.UnbalancedSystemError, match=r"Nothing determines w\.travel at rest.*kept_at_rest"):
        rw.equilibrium(weighted(travels=False))


@dataclass(frozen=True)
class Faulty(rw.Node):
    """A component with one fault."""

    variables_: tuple[rw.Variable, ...] = ()
    given: dict[str, Any] = field(default_factory=dict, hash=False)
    made: Any = None
    limited: str = ""

    @property
    def seats(self) -> tuple[rw.Seat, ...]:
        return (rw.Seat(self, "rope"),)

    def variables(self, site: rw.Site) -> tuple[rw.Variable, ...]:
        return (*self.place(), *self.variables_)

    def limits(self) -> tuple[rw.Limit, ...]:
        return (rw.Limit(self.limited, "too much", high=1.0),) if self.limited else ()

    def equations(self, v: Any) -> rw.Equations:
        return rw.Equations(**(self.made(v) if self.made else self.given))


def var(name: str, kind: rw.Kind = rw.Kind.OUTPUT, unit: str = "N", **how: Any) -> rw.Variable:
    return rw.Variable(name, kind, unit, "a quantity", **how)


OUT, ALG, RES, PAR = rw.Kind.OUTPUT, rw.Kind.ALGEBRAIC, rw.Kind.RESIDUAL, rw.Kind.PARAMETER
FAULTS: list[tuple[dict[str, Any], str]] = [
    ({"variables_": (var("pull"),)}, "no output 'pull'"),
    ({"given": {"outputs": {"pull": 1.0}}}, "'pull', which is not declared"),
    ({"given": {"residuals": {"law": 1.0}}}, "'law', which is not declared"),
    ({"variables_": (var("a", ALG),)}, "1 algebraic variables and 0 residuals"),
    ({"variables_": (var("time", PAR),)}, "'time' has the name of"),
    ({"variables_": (var("rope", PAR),)}, "'rope' has the name of a port"),
    ({"variables_": (var("pull", PAR), var("pull", PAR))}, "two variables are named 'pull'"),
    ({"variables_": (var("my pull", PAR),)}, "not a valid name of a variable"),
    ({"variables_": (var("pull", PAR, "furlong"),)}, "unit 'furlong'"),
    ({"variables_": (var("pull", PAR, nominal=0.0),)}, "nominal"),
    ({"variables_": (var("pull", PAR, value=float("nan")),)}, "value nan"),
    ({"variables_": (rw.Variable("pull", "output", "N", "pull"),)}, "a Kind"),  # type: ignore[arg-type]
    ({"variables_": (rw.Variable(7, PAR, "N", "pull"),)}, "a name"),  # type: ignore[arg-type]
    ({"variables_": (var("pull", PAR, value="12 kN"),)}, "Give numbers"),
    ({"limited": "pull"}, "limit 'too much' names 'pull'"),
    ({"variables_": (var("p"),), "made": lambda v: {"outputs": {"p": 1.0 if v.rope.force[0] > 0 else 2.0}}}, "if_else"),
    ({"variables_": (var("p"),), "made": lambda v: {"outputs": {"p": max(v.rope.force[0], 1.0)}}}, "fmax"),
    ({"variables_": (var("p"),), "made": lambda v: {"outputs": {"p": v.pull}}}, r"v\.pull"),
    ({"variables_": (var("p"),), "made": lambda v: {"outputs": {"p": float(v.rope.force[0])}}}, "NaN for all values"),
    ({"variables_": (var("p"),), "made": lambda v: {"outputs": {"p": ca.vertcat(*v.rope.force)}}}, "3 values"),
]


@pytest.mark.parametrize(("how", "words"), FAULTS)
def test_each_fault_is_a_typed_error_with_a_remedy(how: dict[str, Any], words: str) -> None:
    faulty = Faulty("mine", at=(0.0, 0.0), **how)
    with pytest.raises(rw.InputError, match=words) as info:
        rw.check_component(faulty)
    assert info.value.remedy
    s = rw.System("faulty")
    s.string(ROPE, faulty, rw.Anchor("b", at=(50.0, 0.0)), length=50.5)
    with pytest.raises(rw.InputError, match=words):
        rw.equilibrium(s)


def test_components_of_the_library_pass() -> None:
    made = [
        rw.Anchor("a", at=(0, 0)),
        rw.Sheave("s", at=(0, 0), friction=0.02),
        rw.ControlSheave("c", at=(0, 0), response=rw.ThresholdResponse(low=1e4, high=2e4, increment=0.1)),
        rw.Drum("d", at=(0, 0), tension=1e4),
        rw.Joint("j", at=(0, 0)),
        rw.Log("l", mass=500.0, length=8.0),
        rw.Carriage("k", mass=300.0, at=(0, 0)),
        rw.Span("sp", rope=ROPE, length=20.0),
        rw.IntermediateSupport("i", at=(0, 0), radius=1.5),
        rw.HydraulicPowerUnit("h", pump_flow=1e-3, engine_power=1e4),
        rw.SpringAnchor("sa", at=(0, 0), stiffness=1e6),
    ]
    for component in made:
        rw.check_component(component)


@dataclass(frozen=True)
class SlipDrive(rw.Drive):
    """Runs a share slower than it is commanded."""

    slip: float = 0.1

    def motion(self, v: Any) -> rw.DriveMotion:
        return rw.DriveMotion((1.0 - self.slip) * (v.speed + v.correction), v.tension_in - v.tension_out)


def test_a_users_drive() -> None:
    s = rw.System("own drive")
    nodes = [
        rw.Drum("a", at=(0.0, 0.0), tension=40e3),
        rw.ControlSheave("c", at=(90.0, 3.0), speed=0.5, drive=SlipDrive(0.1)),
        rw.ControlSheave("e", at=(180.0, 3.0), speed=0.45),
        rw.ControlSheave("f", at=(270.0, 3.0), speed=0.6, drive=SlipDrive(0.25)),
        rw.Drum("b", at=(350.0, 0.0), tension=40e3),
    ]
    s.string(ROPE, *nodes, tension=40e3)
    run = rw.simulate(s, until=10.0, every=1.0, progress=False)
    for name in "cef":
        assert run.frame[f"{name}.travel"].iloc[-1] == pytest.approx(4.5, rel=1e-9)
    assert np.ptp(run.frame["c.tension_in"]) < 100.0


@dataclass(frozen=True)
class Battery(rw.Component):
    """A source with a largest power."""

    limit: float

    @property
    def ports(self) -> tuple[()]:
        return ()

    @property
    def sums(self) -> tuple[str, ...]:
        return ("power",)

    def variables(self, site: rw.Site) -> tuple[rw.Variable, ...]:
        return (
            rw.Variable("limit", rw.Kind.PARAMETER, "W", "largest power", self.limit, 1e3),
            rw.Variable("demanded", rw.Kind.OUTPUT, "W", "sum of the demands", nominal=1e3),
            rw.Variable("part", rw.Kind.OUTPUT, "1", "part of the demand that is met"),
        )

    def equations(self, v: Any) -> rw.Equations:
        return rw.Equations(outputs={"demanded": v.power, "part": ca.fmin(1.0, v.limit / ca.fmax(v.power, 1.0))})


@dataclass(frozen=True, slots=True)
class ElectricDrive(rw.Drive):
    """Its demand is proportional to its speed; its speed is reduced by its share of the supply."""

    shares = ("part",)
    rating: float

    def demand(self, v: Any) -> dict[str, Any]:
        return {"power": self.rating * v.speed}

    def motion(self, v: Any) -> rw.DriveMotion:
        return rw.DriveMotion(v.speed * v.part, v.tension_in - v.tension_out)


def test_own_source_shares_its_power_among_own_drives() -> None:
    """Demands of 2 kW and 6 kW at 5 kW: each sheave gets 5/8 of its speed; without the source its full speed."""

    def frame(*, fed: bool) -> Any:
        s = rw.System("fed")
        battery = s.add(Battery("battery", limit=5e3))
        for k, (name, speed) in enumerate((("p", 0.5), ("q", 1.5))):
            sheave = rw.ControlSheave(name, at=(50.0, 5.0, 30.0 * k), speed=speed, drive=ElectricDrive(4e3))
            ends = [rw.Drum(f"{name}{i}", at=(x, 0.0, 30.0 * k), tension=3e4) for i, x in enumerate((0.0, 100.0))]
            s.string(ROPE, ends[0], sheave, ends[1], tension=3e4)
            if fed:
                s.connect(sheave.supply, battery.outlet)
        return rw.simulate(s, until=4.0, every=2.0, progress=False).frame.iloc[-1]

    fed, alone = frame(fed=True), frame(fed=False)
    assert fed[["battery.demanded", "battery.part"]].tolist() == pytest.approx([8e3, 0.625], rel=1e-12)
    assert fed[["p.travel", "q.travel"]].tolist() == pytest.approx([1.25, 3.75], rel=1e-9)
    assert alone[["battery.demanded", "p.travel", "q.travel"]].tolist() == pytest.approx([0.0, 2.0, 6.0], rel=1e-9)


def test_a_source_and_a_consumer_that_do_not_match_are_rejected() -> None:
    s = rw.System("unfit")
    battery = s.add(Battery("battery", limit=5e3))
    hydraulic = rw.HydraulicDrive(
        displacement=1e-4, gear_ratio=20.0, sheave_radius=0.5, relief_pressure=2e7, pump_flow=0.01, engine_power=4e4,
        inertia=500.0,
    )  # fmt: skip
    with pytest.raises(rw.InputError, match="no output flow_share, power_share"):
        s.connect(s.add(rw.ControlSheave("h", at=(0.0, 0.0), drive=hydraulic)).supply, battery.outlet)
    with pytest.raises(rw.InputError, match="takes no power from a unit"):
        s.connect(s.add(rw.ControlSheave("i", at=(0.0, 0.0))).supply, battery.outlet)
