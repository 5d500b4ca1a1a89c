"""A guyed spar: a rigid mast with a hinged foot, held by guylines."""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np

from ropeway.components import check, laws
from ropeway.components.annotation_checks import Unbounded
from ropeway.components.argument_checks import checked
from ropeway.components.catenary import norm
from ropeway.components.check import NOT_NEGATIVE, POSITIVE
from ropeway.components.component import Seat
from ropeway.components.errors import InputError
from ropeway.components.rope import Rope
from ropeway.components.smooth import size
from ropeway.components.spar import HeadSpar, Tailhold
from ropeway.components.terrain import Profile
from ropeway.components.variable import Equations, Kind, Limit, MovingMass, Site, Variable


@checked
@dataclass(frozen=True)
class Guyline:
    """A guyline of a guyed spar.

    Parameters
    ----------
    name : str
        Identifier.
    rope : Rope
        Its rope.
    at : tuple of float
        Position of the anchor, (x, y, z) or (x, z) [m].
    pretension : float
        Tension at the anchor when it is set up, with the spar upright [N].
    stiffness : float, default inf
        Stiffness of the anchor [N/m]; inf: rigid.

    Raises
    ------
    InputError
        An invalid value, or a pretension above the minimum breaking load.

    Examples
    --------
    >>> rw.Guyline("g1", rope=rope, at=(-15.0, 10.0, 0.0), pretension=20e3, stiffness=5e6).stiffness
    5000000.0
    """

    name: str
    rope: Rope
    at: tuple[float, ...]
    pretension: float
    stiffness: Unbounded = math.inf

    def __post_init__(self) -> None:
        label = f"Guyline {self.name!r}"
        check.name(self.name, "Guyline")
        object.__setattr__(self, "at", check.point(self.at, label))
        check.positive(self.pretension, label, "pretension", "N")
        check.positive(self.stiffness, label, "stiffness", "N/m", infinite=True)
        if self.pretension >= self.rope.breaking_load:
            raise InputError(
                f"{label}: pretension {self.pretension:g} N is above its minimum breaking load "
                f"{self.rope.breaking_load:g} N",
                "Reduce the pretension or use a stronger rope",
            )


@checked
@dataclass(frozen=True, kw_only=True)
class GuyedSpar(HeadSpar):
    """A rigid mast with a hinged foot, held upright by guylines.

    The mast is a two-force member: its axial force alone balances the ropes at its top. The balance is taken at the
    displaced top, so P-delta is included. Give its position by its foot, or by station and height on a terrain. The
    skyline is fixed at the top, or runs through a block, or stays open.

    Parameters
    ----------
    name : str
        Identifier; dotted names of results begin with it.
    at : tuple of float, optional
        Not to be given: the position of the top follows from foot and height.
    label : str, optional
        Text in pictures and messages; by default the name.
    station : float, optional
        Station of the foot on a terrain [m].
    height : float
        Length of the mast [m].
    capacity : float, optional
        Largest compression that it can carry [N].
    foot : tuple of float, optional
        Position of the foot, (x, z) or (x, y, z) [m].
    mass : float, default 0
        Mass of the mast [kg]; half of it acts at the top.
    guylines : sequence of Guyline
        Two or more.
    blocks : sequence of str, default ()
        Names of the ropes that run through a block at the top, each with a seat `block(name)`.
    tailhold : Tailhold, optional
        Where the skyline ends behind a tailspar.

    Raises
    ------
    InputError
        No height, no position, fewer than two guylines, or an invalid value.

    Examples
    --------
    >>> guys = [
    ...     rw.Guyline(f"g{k}", rope=rope, at=(-15.0, y, 0.0), pretension=20e3) for k, y in enumerate((-15.0, 15.0))
    ... ]
    >>> rw.GuyedSpar("mast", height=12.0, foot=(0.0, 0.0), mass=800.0, guylines=guys).guylines[1].pretension
    20000.0
    """

    foot: tuple[float, ...] = ()
    mass: float = 0.0
    guylines: tuple[Guyline, ...] = ()
    blocks: tuple[str, ...] = ()
    tailhold: Tailhold | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "guylines", tuple(self.guylines))
        object.__setattr__(self, "blocks", tuple(self.blocks))
        for block in self.blocks:
            check.name(block, "Block")
        check.not_negative(self.mass, self.described, "mass", "kg")
        if self.height is None:
            raise InputError(f"{self.described} has no height", "Give height=, and foot= or station=")
        check.positive(self.height, self.described, "height", "m")
        if self.foot:
            foot = check.point(self.foot, self.described)
            object.__setattr__(self, "foot", foot)
            object.__setattr__(self, "at", (foot[0], foot[1], foot[2] + self.height))
            if self.station is None:
                object.__setattr__(self, "station", foot[0])
        elif self.at:
            raise InputError(f"{self.described} is placed by its top", "Give foot=, or station and height")
        super().__post_init__()
        if len(self.guylines) < 2:
            raise InputError(
                f"{self.described} has {len(self.guylines)} guylines", "A mast with a hinged foot needs two or more"
            )
        if len({g.name for g in self.guylines}) < len(self.guylines):
            raise InputError(f"{self.described} has two guylines of one name", "Give each its own name")

    def placed(self, ground: Profile | None) -> Self:
        if self.foot:
            self.require_above(ground)
            return self
        if ground is None or self.station is None:
            raise InputError(
                f"{self.described} is placed by station and height", "Give a terrain, or place it with foot="
            )
        return replace(self, foot=(self.station, 0.0, ground.elevation_at(self.station)))

    @property
    def skyline(self) -> Seat:
        """Where the skyline is fixed."""
        return Seat(self, "skyline", optional=True)

    def block(self, rope: str) -> Seat:
        """The seat where a rope arrives at its block.

        Parameters
        ----------
        rope : str
            Name of the rope, one of `blocks`.

        Returns
        -------
        Seat
            Its port.
        """
        return Seat(self, f"{rope}_in", travel=f"{rope}_travel")

    def block_out(self, rope: str) -> Seat:
        """Where a rope leaves its block."""
        return Seat(self, f"{rope}_out", travel=f"{rope}_travel")

    def guy(self, name: str) -> Seat:
        """The seat where a guyline is fixed.

        Parameters
        ----------
        name : str
            Name of the guyline.

        Returns
        -------
        Seat
            Its port.
        """
        return Seat(self, f"guy_{name}")

    @property
    def arriving(self) -> Seat:
        return self.skyline

    @property
    def leaving(self) -> Seat:
        return self.skyline

    @property
    def seats(self) -> tuple[Seat, ...]:
        blocks = [seat for rope in self.blocks for seat in (self.block(rope), self.block_out(rope))]
        return (self.skyline, *blocks, *(self.guy(g.name) for g in self.guylines))

    def through(self, seat: Seat) -> Seat | None:
        return next((self.block_out(rope) for rope in self.blocks if seat == self.block(rope)), None)

    def balance_at(self, seat: Seat) -> str | None:
        return next((f"{rope}_law" for rope in self.blocks if seat == self.block(rope)), None)

    @property
    def free(self) -> tuple[tuple[str, str], ...]:
        # The length of the mast determines z, the vertical balance its axial force.
        return (("x", "balance_x"), ("y", "balance_y"))

    def limits(self) -> tuple[Limit, ...]:
        return () if self.capacity is None else (Limit("compression", "above capacity", high=self.capacity),)

    def masses(self, read: Callable[[str], Any]) -> tuple[MovingMass, ...]:
        # A uniform mast that turns about its foot.
        return tuple(MovingMass(axis, read("mass") / 3.0, {f"balance_{axis}": 1.0}) for axis in "xyz")

    def structure(self, site: Site) -> Hashable:
        return (self.blocks, tuple(g.name for g in self.guylines))

    def variables(self, site: Site) -> tuple[Variable, ...]:
        par, alg, res, out, force = Kind.PARAMETER, Kind.ALGEBRAIC, Kind.RESIDUAL, Kind.OUTPUT, site.force
        foot = check.point(self.foot, self.described)
        upright = sum(g.pretension for g in self.guylines)
        return (
            *(
                Variable(f"foot_{a}", par, "m", f"{a} of the foot", at, 100.0)
                for a, at in zip("xyz", foot, strict=True)
            ),
            Variable("height", par, "m", "length of the mast", self.height or 0.0, 10.0, range=POSITIVE),
            Variable("mass", par, "kg", "mass of the mast", self.mass, 1000.0, range=NOT_NEGATIVE),
            *(Variable(a, alg, "m", f"{a} of the top", at, 100.0) for a, at in zip("xyz", self.position, strict=True)),
            Variable("axial", alg, "N", "compression of the mast", upright, force),
            *(
                Variable(f"{r}_travel", alg, "m", f"unstretched length of {r} run through its block", 0.0, site.length)
                for r in self.blocks
            ),
            *(Variable(f"{r}_law", res, "N", f"{r} on both sides of its block", 0.0, force) for r in self.blocks),
            *(Variable(f"balance_{a}", res, "N", f"forces at the top, {a}", 0.0, 0.01 * force) for a in "xyz"),
            Variable("rigid", res, "m", "length of the mast", 0.0, 10.0),
            Variable("compression", out, "N", "compression of the mast", nominal=force),
            Variable("lean", out, "m", "horizontal displacement of the top"),
            Variable("tension", out, "N", "tension of the skyline at the top", nominal=force),
        )

    def equations(self, v: Any) -> Equations:
        along = (v.x - v.foot_x, v.y - v.foot_y, v.z - v.foot_z)
        forces = [v.skyline.force, *(getattr(v, f"guy_{g.name}").force for g in self.guylines)]
        at_blocks = [(getattr(v, f"{r}_in").force, getattr(v, f"{r}_out").force) for r in self.blocks]
        forces += [force for both in at_blocks for force in both]
        total = [sum(f[i] for f in forces) + v.axial * along[i] / v.height for i in range(3)]
        total[2] = total[2] - v.mass / 2.0 * v.gravity
        residuals = {f"balance_{a}": total[i] for i, a in enumerate("xyz")}
        # (|p|^2 - h^2) / 2h equals the error of the length to first order, and is smooth.
        residuals["rigid"] = (along[0] ** 2 + along[1] ** 2 + along[2] ** 2 - v.height**2) / (2.0 * v.height)
        for rope, (coming, going) in zip(self.blocks, at_blocks, strict=True):
            residuals[f"{rope}_law"] = norm(going) - norm(coming)
        lean = (along[0] ** 2 + along[1] ** 2 + 1e-30) ** 0.5
        return Equations(
            residuals=residuals,
            outputs={
                "compression": v.axial,
                "lean": lean,
                "tension": size(v.skyline.force),
            },
        )

    def laws(self, v: Any) -> dict[str, laws.Law]:
        mast = np.stack([v.x - v.foot_x, v.y - v.foot_y, v.z - v.foot_z])
        ropes = [getattr(v, seat.name).force for seat in self.seats]
        length = laws.tension(mast)
        forces = [*ropes, v.axial * mast / v.height, laws.weight(v.mass / 2.0 * v.gravity)]
        found = {f"balance_{axis}": law for axis, law in laws.balance(*forces).items()}
        found["rigid"] = laws.Law(length - v.height, v.height)
        for rope in self.blocks:
            found[f"{rope}_law"] = laws.ratio(getattr(v, f"{rope}_in").force, getattr(v, f"{rope}_out").force)
        return found
