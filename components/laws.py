"""What must hold at a component at rest, in NumPy: the certificate of a state checks these.

They share no code with the residuals of the solvers, so that an error in one does not hide an error in the other. A
force is an array of shape (3, ...): the pull of the rope at a seat.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np


class Law(NamedTuple):
    """A difference that is zero at rest, and the magnitude that it is relative to; arrays of one shape."""

    miss: np.ndarray
    size: np.ndarray


def tension(force: np.ndarray) -> np.ndarray:
    """Magnitude of a force [N]."""
    return np.asarray(np.sqrt((force * force).sum(axis=0)))


def wrap(coming: np.ndarray, going: np.ndarray) -> np.ndarray:
    """Wrap angle of a rope [rad], from its pulls on both sides."""
    turned = np.cross(coming, going, axis=0)
    return np.asarray(np.arctan2(tension(turned), -np.sum(coming * going, axis=0)))


def ratio(coming: np.ndarray, going: np.ndarray, by: np.ndarray | float = 1.0) -> Law:
    """The outgoing tension is `by` times the incoming tension."""
    t_in, t_out = tension(coming), tension(going)
    return Law(t_out - by * t_in, np.maximum(t_in, t_out))


def balance(*forces: np.ndarray) -> dict[str, Law]:
    """All forces on a body sum to zero along each axis."""
    total, size = sum(forces, np.zeros(1)), sum((tension(f) for f in forces), np.zeros(1))
    return {axis: Law(total[i], size) for i, axis in enumerate("xyz")}


def weight(newtons: np.ndarray) -> np.ndarray:
    """Force vector of a weight."""
    none = np.zeros_like(newtons)
    return np.stack([none, none, -newtons])


def wind(v: Any) -> np.ndarray | float:
    """Force of the wind on a body with a drag area; zero without weather."""
    if v.weather is None:
        return 0.0
    angle = np.radians(v.weather.wind_from - v.weather.north)
    force = v.weather.wind_pressure * v.drag_area
    return np.stack([-force * np.sin(angle), -force * np.cos(angle), 0.0 * force])


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
    """Laws of a rope that leaves a circular shoe tangentially.

    The point of departure is on the arc, the rope is tangent there, and the length of rope on the shoe equals that of
    the arc.

    Parameters
    ----------
    turned : tuple of ndarray
        Vector (x, z) from the centre to the point from which rope is counted [m].
    place : tuple of ndarray
        Vector (x, z) from the centre to the point of departure [m].
    force : ndarray, shape (3, ...)
        Pull of the rope on the shoe [N].
    rope : tuple of ndarray
        Unstretched length between both points, positive away from the middle [m]; stretched over unstretched length.
    radius : ndarray
        Radius of the shoe [m].
    side : float
        1 for a rope towards greater x, -1 towards smaller x.
    free : bool, default False
        Whether the rope may also leave above the shoe without lying on it.

    Returns
    -------
    tuple of Law
        Point on the arc, tangency, length on the arc.
    """
    (x0, z0), (x, z) = turned, place
    arc = side * np.arctan2(z0 * x - x0 * z, x0 * x + z0 * z)
    size = tension(force)
    out = (force[0] * x + force[2] * z) / radius
    along = side * (force[0] * z - force[2] * x) / radius
    # A rope that leaves in the opposite direction is tangent as well.
    lifted = np.where(along > 0.0, out, size)
    if free:
        lifted = np.where(arc > 1e-9, lifted, np.where(along > 0.0, np.minimum(out, 0.0), lifted))
    laid, stretched = rope
    return (
        Law(np.hypot(x, z) - radius, radius),
        Law(lifted, size),
        Law(laid * stretched - radius * arc, radius),
    )
