"""Place, velocity and acceleration of a node that its ropes accelerate."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ropeway.components.variable import Kind, Variable

AXES = "xyz"


def motion_variables(places: Mapping[str, Variable]) -> tuple[Variable, ...]:
    """States and accelerations of a node, from the variables of its coordinates without inertia."""
    state, alg = Kind.STATE, Kind.ALGEBRAIC
    return (
        *(Variable(axis, state, "m", place.description, place.value) for axis, place in places.items()),
        *(Variable(f"velocity_{axis}", state, "m/s", f"velocity, {axis}", rate_of=axis) for axis in places),
        *(Variable(f"acceleration_{axis}", alg, "m/s2", f"acceleration, {axis}") for axis in places),
    )


def motion_rates(v: Any, axes: Sequence[str]) -> dict[str, Any]:
    """Rates of the states of `motion_variables`."""
    return {
        **{axis: getattr(v, f"velocity_{axis}") for axis in axes},
        **{f"velocity_{axis}": getattr(v, f"acceleration_{axis}") for axis in axes},
    }


def inertial_force(v: Any, axis: str, mass: Any, seats: Sequence[str]) -> Any:
    """What the forces on a node must overcome along an axis [N]: its own inertia and that of its ropes."""
    rope = sum(getattr(v, seat).inertia["xyz".index(axis)] for seat in seats)
    return rope + mass * getattr(v, f"acceleration_{axis}", 0.0)


def energy_outputs(*, hangs: bool = True) -> tuple[Variable, ...]:
    """Outputs of the energies of a node; hangs: it also has potential energy."""
    kinetic = Variable("kinetic_energy", Kind.OUTPUT, "J", "kinetic energy", nominal=1e3)
    gravity = Variable("gravity_energy", Kind.OUTPUT, "J", "potential energy relative to z = 0", nominal=1e6)
    return (kinetic, gravity) if hangs else (kinetic,)


def energies(v: Any, mass: Any, axes: Sequence[str]) -> dict[str, Any]:
    """Values of `energy_outputs`."""
    speed = sum(getattr(v, f"velocity_{axis}") ** 2 for axis in axes)
    return {"kinetic_energy": mass / 2 * speed, "gravity_energy": mass * v.gravity * v.z}


def across_variables(rope: str) -> tuple[Variable, ...]:
    """Motion of the ends of a rope on which a node rolls: that of the node across the rope's direction."""
    alg, res = Kind.ALGEBRAIC, Kind.RESIDUAL
    units = {"velocity": "m/s", "acceleration": "m/s2"}
    return (
        *(
            Variable(f"along_{axis}", Kind.PARAMETER, "1", f"direction of the {rope}, {axis}", value)
            for axis, value in zip(AXES, (1.0, 0.0, 0.0), strict=True)
        ),
        *(
            Variable(f"{rope}_{what}_{axis}", alg, unit, f"{what} of the {rope} at the node, {axis}")
            for what, unit in units.items()
            for axis in AXES
        ),
        *(
            Variable(f"{rope}_{what}_across_{axis}", res, unit, f"the node rolls on the {rope}, {axis}")
            for what, unit in units.items()
            for axis in AXES
        ),
    )


def across_residuals(v: Any, rope: str, axes: Sequence[str]) -> dict[str, Any]:
    """Residuals of `across_variables` for a node that is free to move along some axes."""
    found = {}
    for what in ("velocity", "acceleration"):
        own = [getattr(v, f"{what}_{axis}") if axis in axes else 0.0 for axis in AXES]
        for axis, part in zip(AXES, _across(v, own), strict=True):
            found[f"{rope}_{what}_across_{axis}"] = getattr(v, f"{rope}_{what}_{axis}") - part
    return found


def across_force(v: Any, axis: str, seats: Sequence[str]) -> Any:
    """Inertia of the ropes on which a node rolls [N], along an axis."""
    total = [sum(getattr(v, seat).inertia[i] for seat in seats) for i in range(3)]
    return _across(v, total)[AXES.index(axis)]


def _across(v: Any, vector: Sequence[Any]) -> list[Any]:
    """The part of a vector across the direction `along`."""
    along = [getattr(v, f"along_{axis}", 0.0) for axis in AXES]
    lengthwise = sum(a * b for a, b in zip(along, vector, strict=True))
    return [b - lengthwise * a for a, b in zip(along, vector, strict=True)]
