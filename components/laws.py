"""What must hold at a component at rest, in NumPy alone: the certificate of a state is checked by these.

They share no code with the residuals that the solvers take, so that an error in one does not hide in the other.
A force is an array of shape (3, ...): the pull of the rope at a seat.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class Law(NamedTuple):
    """A difference that vanishes at rest, and the size that it is measured by; arrays of one shape."""

    miss: np.ndarray
    size: np.ndarray


def tension(force: np.ndarray) -> np.ndarray:
    """Size of a force [N]."""
    return np.asarray(np.sqrt((force * force).sum(axis=0)))


def wrap(coming: np.ndarray, going: np.ndarray) -> np.ndarray:
    """Angle by which a rope is turned [rad], from its pulls on both sides."""
    turned = np.cross(coming, going, axis=0)
    return np.asarray(np.arctan2(tension(turned), -np.sum(coming * going, axis=0)))


def ratio(coming: np.ndarray, going: np.ndarray, by: np.ndarray | float = 1.0) -> Law:
    """The tension going out is `by` times the tension coming in."""
    t_in, t_out = tension(coming), tension(going)
    return Law(t_out - by * t_in, np.maximum(t_in, t_out))


def balance(*forces: np.ndarray) -> dict[str, Law]:
    """All forces on a body sum to zero, along each axis."""
    total, size = sum(forces, np.zeros(1)), sum((tension(f) for f in forces), np.zeros(1))
    return {axis: Law(total[i], size) for i, axis in enumerate("xyz")}


def weight(newtons: np.ndarray) -> np.ndarray:
    """The force of a weight."""
    none = np.zeros_like(newtons)
    return np.stack([none, none, -newtons])


def on_arc(
    turned: tuple[np.ndarray, np.ndarray],
    place: tuple[np.ndarray, np.ndarray],
    force: np.ndarray,
    rope: tuple[np.ndarray, np.ndarray],
    radius: np.ndarray,
    *,
    side: float,
    free: bool = False,
) -> tuple[Law, Law, Law]:
    """A rope that leaves a circular shoe along it: the place is on the arc, the rope is tangent there, and as much rope
    lies on the shoe as the arc is long.

    Parameters
    ----------
    turned
        From the shoe's centre to where the rope is counted from, (x, z) [m].
    place
        From the shoe's centre to where the rope leaves, (x, z) [m].
    force
        Pull of the rope on the shoe (3, ...) [N].
    rope
        Unstretched rope between both places, positive away from the middle [m]; and stretched over unstretched length.
    radius
        Of the shoe [m].
    side
        1 for a rope that goes towards greater x, -1 towards smaller x.
    free
        Whether the rope may also go off above the shoe, nowhere on it.
    """
    (x0, z0), (x, z) = turned, place
    arc = side * np.arctan2(z0 * x - x0 * z, x0 * x + z0 * z)
    size = tension(force)
    out = (force[0] * x + force[2] * z) / radius
    along = side * (force[0] * z - force[2] * x) / radius
    # A rope that goes the other way round is tangent too.
    lifted = np.where(along > 0.0, out, size)
    if free:
        lifted = np.where(arc > 1e-9, lifted, np.where(along > 0.0, np.minimum(out, 0.0), lifted))
    laid, stretched = rope
    return (
        Law(np.hypot(x, z) - radius, radius),
        Law(lifted, size),
        Law(laid * stretched - radius * arc, radius),
    )
