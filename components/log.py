"""A log below a carriage: its front is lifted, its rear drags on the ground or hangs free."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ropeway.components import check, laws
from ropeway.components.argument_checks import checked
from ropeway.components.catenary import namespace
from ropeway.components.check import NOT_NEGATIVE, POSITIVE
from ropeway.components.component import Seat
from ropeway.components.errors import InputError
from ropeway.components.node import Node
from ropeway.components.variable import Equations, Kind, MovingMass, Site, Variable
from ropeway.components.weather import drag_variables

_FORCE = 1e4
"""Unit of the normal force in the contact law [N]; that of the gap is 1 m."""


@checked
@dataclass(frozen=True, kw_only=True)
class Log(Node):
    """A rigid log, held at its front by a tagline or dropline.

    Partial suspension: its rear drags on the ground, two straight segments that a parabola joins at a vertex, so that
    the normal is continuous. Full suspension: it hangs free. The contact law decides: normal force times gap is zero
    and neither is negative, written as the Fischer-Burmeister function, with its corner rounded by `smoothing`: normal
    force / 1e4 N * gap = smoothing^2 / 2. With friction, a log that is about to leave the ground can have two states of
    rest: dragging on an inclined line, or hanging on a vertical one. The initial guess determines which one is found;
    it starts behind its front. After the rigid-log statics of Kendrick and Sessions, derived anew.

    Parameters
    ----------
    name : str
        Identifier; dotted names of results begin with it.
    at : tuple of float, default (0, 0, 0)
        Initial guess of the position of its front, (x, z) or (x, y, z) [m].
    label : str, optional
        Text in pictures and messages; by default the name.
    mass : float
        Mass [kg].
    length : float
        Length [m].
    friction : float, default 0.6
        Coulomb friction coefficient on the ground.
    centre : float, default 0.5
        Distance of the centre of gravity from the front, over the length.
    slope : float, default 0
        Slope of the ground up to the vertex, rise over run.
    slope_after : float, optional
        Slope of the ground beyond the vertex; by default the same.
    ground_x, ground_z : float, default 0, -1000
        Position of the vertex [m].
    rounding : float, default 1
        Half the width of the parabola at the vertex [m].
    moving : {-1, 0, 1}, default -1
        Sign of its motion in x, against which friction acts; 0: at rest without friction.
    smoothing : float, default 1e-8
        Rounding of the contact law [m].
    drag_area : float, default 0
        Drag coefficient times area in the wind [m2]; the force acts at the centre of gravity, and across the line at
        the front.

    Raises
    ------
    InputError
        A value out of its range.

    Examples
    --------
    >>> rw.Log("log", mass=900.0, length=7.0, friction=0.5).length
    7.0
    """

    hangs: ClassVar[bool] = True

    at: tuple[float, ...] = (0.0, 0.0, 0.0)
    mass: float
    length: float
    friction: float = 0.6
    centre: float = 0.5
    slope: float = 0.0
    slope_after: float | None = None
    ground_x: float = 0.0
    ground_z: float = -1e3
    rounding: float = 1.0
    moving: float = -1.0
    smoothing: float = 1e-8
    drag_area: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        check.positive(self.mass, self.described, "mass", "kg")
        check.positive(self.length, self.described, "length", "m")
        check.not_negative(self.friction, self.described, "friction")
        check.positive(self.smoothing, self.described, "smoothing", "m")
        check.positive(self.rounding, self.described, "rounding", "m")
        check.not_negative(self.drag_area, self.described, "drag_area", "m2")
        for field in ("slope", "ground_x", "ground_z"):
            check.number(getattr(self, field), self.described, field)
        check.number(self.after, self.described, "slope_after")
        if not 0.0 < self.centre < 1.0:
            raise InputError(
                f"{self.described}: centre is {self.centre!r}",
                "Give a fraction of the length from the front, between 0 and 1",
            )
        if self.moving not in (-1.0, 0.0, 1.0):
            raise InputError(f"{self.described}: moving is {self.moving!r}", "Give -1, 0 or 1")

    @property
    def after(self) -> float:
        """Slope of the ground beyond the vertex."""
        return self.slope if self.slope_after is None else self.slope_after

    @property
    def front(self) -> Seat:
        """Where the tagline or dropline holds it."""
        return Seat(self, "front")

    @property
    def seats(self) -> tuple[Seat, ...]:
        return (self.front,)

    def masses(self, read: Callable[[str], Any]) -> tuple[MovingMass, ...]:
        # As a point at its front; the rear follows at rest.
        return tuple(MovingMass(axis, read("mass"), {f"balance_{axis}": 1.0}) for axis in "xyz")

    def structure(self, site: Site) -> Hashable:
        return ()

    def variables(self, site: Site) -> tuple[Variable, ...]:
        par, alg, res, out = Kind.PARAMETER, Kind.ALGEBRAIC, Kind.RESIDUAL, Kind.OUTPUT
        x, y, z = self.at
        weight = 10.0 * self.mass
        rear_x, rear_z, normal = self.rear_start()
        return (
            Variable("mass", par, "kg", "mass of the log", self.mass, 1000.0, range=POSITIVE),
            Variable("length", par, "m", "length of the log", self.length, 10.0, range=POSITIVE),
            Variable("centre", par, "1", "centre of gravity from the front over length", self.centre),
            Variable("friction", par, "1", "friction of the log on the ground", self.friction, range=NOT_NEGATIVE),
            Variable("slope", par, "1", "slope of the ground up to its vertex", self.slope),
            Variable("slope_after", par, "1", "slope of the ground beyond its vertex", self.after),
            Variable("rounding", par, "m", "half the width of the rounded vertex", self.rounding, range=POSITIVE),
            Variable("ground_x", par, "m", "x of the ground's vertex", self.ground_x, 100.0),
            Variable("ground_z", par, "m", "z of the ground's vertex", self.ground_z, 100.0),
            Variable("moving", par, "1", "sign of the log's motion in x", self.moving),
            Variable("smoothing", par, "m", "rounding of the contact law", self.smoothing, 1e-3, range=POSITIVE),
            *drag_variables(site, self.drag_area),
            Variable("x", alg, "m", "x of the front", x, 100.0),
            Variable("y", alg, "m", "y of the front", y, 100.0),
            Variable("z", alg, "m", "z of the front", z, 100.0),
            Variable("rear_x", alg, "m", "x of the rear", rear_x, 100.0),
            Variable("rear_z", alg, "m", "z of the rear", rear_z, 100.0),
            Variable("normal", alg, "N", "force of the ground, normal to it", normal, weight),
            *(Variable(f"balance_{a}", res, "N", f"forces on the log, {a}", 0.0, weight) for a in "xyz"),
            Variable("moment", res, "N.m", "moments about the front", 0.0, weight * self.length),
            Variable("rigid", res, "m", "length of the log", 0.0, 10.0),
            Variable("contact", res, "m", "normal force or gap is zero"),
            Variable("gap", out, "m", "height of the rear over the ground, normal to it"),
            Variable("ground_slope", out, "1", "slope of the ground under the rear"),
            Variable("ground_force", out, "N", "force of the ground on the log, normal to it", nominal=weight),
            Variable("line_pull", out, "N", "tension of the line at the front", nominal=weight),
            Variable("inclination", out, "rad", "angle of the log from its rear up to its front"),
        )

    def rear_start(self) -> tuple[float, float, float]:
        """Initial guess of the rear: on the ground behind the front, or below the front.

        Returns
        -------
        x, z, normal : float
            Position of the rear [m] and normal force [N].
        """
        x, _, z = self.at
        behind = -self.moving or (-1.0 if self.slope + self.after > 0.0 else 1.0)  # at rest the rear is downhill
        slope = self.slope if x < self.ground_x else self.after
        over = z - self.ground_z - slope * (x - self.ground_x)
        if over >= self.length:
            return x + 1e-3 * behind * self.length, z - self.length, 0.0
        over = max(over, 0.0)
        # On the plane: (x + d, ground + slope d) at the log's length from the front.
        a, b, c = 1.0 + slope**2, -2.0 * over * slope, over**2 - self.length**2
        d = (-b + behind * (b * b - 4.0 * a * c) ** 0.5) / (2.0 * a)
        return x + d, z - over + slope * d, 4.0 * self.mass

    def equations(self, v: Any) -> Equations:
        pull = v.front.force
        ground, slope = _rounded(v)
        unit = (1.0 + slope**2) ** 0.5
        across, up = -slope / unit, 1.0 / unit  # normal of the ground; its tangent is (up, -across)
        drag = -v.moving * v.friction
        ground_x = v.normal * (across + drag * up)
        ground_z = v.normal * (up - drag * across)
        dx, dz = v.rear_x - v.x, v.rear_z - v.z
        weight = v.mass * v.gravity
        gap = (v.rear_z - ground) * up
        pressed = v.normal / _FORCE
        balance = [pull[0] + ground_x, pull[1], pull[2] + ground_z - weight]
        moment = dx * ground_z - dz * ground_x - v.centre * dx * weight
        if v.weather is not None:
            wind = v.weather.drag(v.drag_area)
            balance = [force + blown for force, blown in zip(balance, wind, strict=True)]
            moment = moment - v.centre * dz * wind[0]
        return Equations(
            residuals={
                **{f"balance_{axis}": balance[i] for i, axis in enumerate("xyz")},
                "moment": moment,
                "rigid": (dx * dx + dz * dz - v.length**2) / (2.0 * v.length),
                "contact": pressed + gap - (pressed**2 + gap**2 + v.smoothing**2) ** 0.5,
            },
            outputs={
                "gap": gap,
                "ground_slope": slope,
                "ground_force": v.normal,
                "line_pull": (pull[0] ** 2 + pull[1] ** 2 + pull[2] ** 2) ** 0.5,
                "inclination": _angle(-dz, (dx * dx + 1e-30) ** 0.5),
            },
        )

    def laws(self, v: Any) -> dict[str, laws.Law]:
        beyond = np.clip((v.rear_x - v.ground_x) / v.rounding, -1.0, 1.0)
        steep = np.arctan(v.slope + (v.slope_after - v.slope) * (1.0 + beyond) / 2.0)
        drag = -v.moving * v.friction
        ground = v.normal * np.stack(
            [drag * np.cos(steep) - np.sin(steep), 0.0 * steep, np.cos(steep) + drag * np.sin(steep)]
        )
        own = laws.weight(v.mass * v.gravity) + laws.wind(v)
        found = {f"balance_{axis}": law for axis, law in laws.balance(v.front.force, ground, own).items()}
        back, up = v.rear_x - v.x, v.z - v.rear_z
        moment = back * (ground[2] + v.centre * own[2]) + up * (ground[0] + v.centre * own[0])
        found["moment"] = laws.Law(moment, v.length * v.mass * v.gravity)
        found["rigid"] = laws.Law(np.hypot(back, up) - v.length, v.length)
        # The slope varies linearly within the rounding; outside it the ground is straight.
        x, r = v.rear_x - v.ground_x, v.rounding
        bend = np.clip(x + r, 0.0, 2.0 * r) ** 2 / (4.0 * r) + np.maximum(x - r, 0.0)
        ground_z = v.ground_z + v.slope * x + (v.slope_after - v.slope) * bend
        gap = (v.rear_z - ground_z) * np.cos(steep)
        # Smoothing rounds the corner, where both are of that magnitude.
        found["contact"] = laws.Law(np.minimum(v.normal / _FORCE, gap), np.maximum(1.0, 1e8 * v.smoothing))
        # Free of the ground it hangs below its front; upside down it is unstable.
        free = v.normal < 1e-4 * v.mass * v.gravity
        found["upright"] = laws.Law(np.where(free, np.minimum(up, 0.0), 0.0), v.length)
        return found


def _rounded(v: Any) -> tuple[Any, Any]:
    """Height and slope of the ground under the rear."""
    xp = namespace(v.rear_x)
    x, r = v.rear_x - v.ground_x, v.rounding
    near = xp.fmin(xp.fmax(x / r, -1.0), 1.0)
    size = r * (near * near + 1.0) / 2.0 + xp.fmax(x - r, 0.0) + xp.fmax(-x - r, 0.0)  # |x|, rounded
    mean, half = (v.slope + v.slope_after) / 2.0, (v.slope_after - v.slope) / 2.0
    return v.ground_z + mean * x + half * size, mean + half * near


def _angle(rise: Any, run: Any) -> Any:
    return namespace(rise, run).atan2(rise, run)
