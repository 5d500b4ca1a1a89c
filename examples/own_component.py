"""Components of your own: a counterweight with inertia, an anchor with spring and damper; run, swept, exported."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import casadi as ca

import ropeway as rw

STATE, PARAMETER, OUTPUT = rw.Kind.STATE, rw.Kind.PARAMETER, rw.Kind.OUTPUT


@dataclass(frozen=True)
class Counterweight(rw.Node):
    """A weight on the end of a rope that runs over its wheel.

    travel' = speed, mass speed' = tension - weight - extra - drag speed.

    extra: an additional pull [N], a number or a schedule.
    """

    mass: float = 1000.0
    drag: float = 300.0
    extra: float | rw.Schedule = 0.0

    @property
    def rope(self) -> rw.Seat:
        return rw.Seat(self, "rope", travel="travel")

    @property
    def seats(self) -> tuple[rw.Seat, ...]:
        return (self.rope,)

    @property
    def drive_speed(self) -> str:
        return "speed"

    def variables(self, site: rw.Site) -> tuple[rw.Variable, ...]:
        return (
            *self.place(),
            rw.Variable("mass", PARAMETER, "kg", "mass of the weight", self.mass, 1000.0),
            rw.Variable("drag", PARAMETER, "N.s/m", "drag of its guide", self.drag, 100.0),
            rw.Variable("extra", rw.Kind.INPUT, "N", "additional pull", nominal=site.force),
            rw.Variable("travel", STATE, "m", "length of rope from the weight", 0.0, site.length),
            rw.Variable("speed", STATE, "m/s", "speed of the weight, upward"),
            rw.Variable("tension", OUTPUT, "N", "tension of its rope", nominal=site.force),
        )

    def equations(self, v: Any) -> rw.Equations:
        tension = ca.norm_2(ca.vertcat(*v.rope.force))
        pull = tension - v.mass * v.gravity - v.extra - v.drag * v.speed
        return rw.Equations(rates={"travel": v.speed, "speed": pull / v.mass}, outputs={"tension": tension})


@dataclass(frozen=True)
class DampedAnchor(rw.Node):
    """An anchor with a spring and a damper in x: damping x' = pull - stiffness (x - home)."""

    stiffness: float = 2e5
    damping: float = 1e5

    @property
    def rope(self) -> rw.Seat:
        return rw.Seat(self, "rope")

    @property
    def seats(self) -> tuple[rw.Seat, ...]:
        return (self.rope,)

    def variables(self, site: rw.Site) -> tuple[rw.Variable, ...]:
        _, y, z = self.place()
        return (
            y,
            z,
            rw.Variable("home", PARAMETER, "m", "x without a pull", self.at[0], 100.0),
            rw.Variable("stiffness", PARAMETER, "N/m", "stiffness of the spring", self.stiffness, 1e5),
            rw.Variable("damping", PARAMETER, "N.s/m", "damping", self.damping, 1e5),
            rw.Variable("x", STATE, "m", "x of the anchor", self.at[0], 1.0),
        )

    def equations(self, v: Any) -> rw.Equations:
        return rw.Equations(rates={"x": (v.rope.force[0] - v.stiffness * (v.x - v.home)) / v.damping})


def line() -> rw.System:
    """A rope from a counterweight, with an extra pull of 2 kN from 1 s on, over a sheave to a damped anchor."""
    pull = rw.Schedule((0.0, 1.0, 1.5, 60.0), (0.0, 0.0, 2e3, 2e3))
    rope = rw.Rope(mass_per_length=2.1, axial_stiffness=19e6, breaking_load=330e3)
    s = rw.System("own components")
    spans = s.string(
        rope,
        Counterweight("weight", at=(0.0, 0.0), mass=2500.0, extra=pull),
        rw.Sheave("sheave", at=(90.0, 6.0)),
        DampedAnchor("anchor", at=(170.0, 0.0)),
        length=171.5,
    )
    s.hang(rw.Load("load", mass=300.0), spans, at=60.0)
    return s


def main(folder: Path = Path("ropeway-own-component")) -> None:
    """Checks both components, solves the equilibrium, simulates the line, sweeps the mass and exports an FMU."""
    folder.mkdir(parents=True, exist_ok=True)
    for component in (Counterweight("weight", at=(0.0, 0.0)), DampedAnchor("anchor", at=(0.0, 0.0))):
        rw.check_component(component)
    s = line()
    rest = rw.equilibrium(s)
    print(f"at rest the tension at the weight is {rest['weight.tension'] / 1e3:.3f} kN; the anchor moves by "
          f"{1e3 * (rest['anchor.x'] - 170.0):.1f} mm")  # fmt: skip
    run = rw.simulate(s, until=10.0, every=0.1)
    print(run.frame[["weight.travel", "weight.tension", "anchor.x"]].iloc[::20].round(4))
    table = rw.sweep(s, rw.latin_hypercube({"weight.mass": (2000.0, 3000.0)}, 4), outputs=["anchor.x"], progress=False)
    print(table.sort_values("weight.mass"))
    columns = {"weight.travel": "travel of the weight [m]", "weight.tension": "tension [N]", "anchor.x": "anchor [m]"}
    axes = run.frame[list(columns)].plot(subplots=True, legend=False, figsize=(8, 6), grid=True)
    for axis, label in zip(axes, columns.values(), strict=True):
        axis.set_ylabel(label)
        axis.ticklabel_format(axis="y", useOffset=False)
    axes[-1].set_xlabel("time [s]")
    axes[0].figure.savefig(folder / "own_component.png", dpi=150, bbox_inches="tight")
    rw.fmu.export(s, folder / "own.fmu")
    print(f"{folder}: own_component.png, own.fmu")


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:2]))
