"""An elastic rope piece between two points, for a tension at its start, a horizontal tension or a length."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ropeway.components import catenary
from ropeway.components.catenary import Strain
from ropeway.systems.modelling.complex_newton import solve_side_by_side
from ropeway.systems.studies.handbook.array_roots import Array, Numbers, complex_step, newton
from ropeway.systems.studies.handbook.inextensible_catenary import vertical_at


class ElasticPiece(NamedTuple):
    """A rope piece over (run, rise) [m]: weight per unstretched metre, strain, tension vector at its start (vertical >
    0 where it rises), unstretched length [m]. Arrays in any consistent unit of force."""

    run: Array
    rise: Array
    weight: Array
    strain: Strain
    horizontal: Array
    vertical: Array
    length: Array

    @classmethod
    def between(
        cls, run: Array, rise: Array, weight: Array, strain: Strain, horizontal: Array, length: Array
    ) -> ElasticPiece:
        """Initial guess of `solve`: the inextensible rope of a horizontal tension, with its length reduced by the
        strain."""
        vertical = -vertical_at(weight * run / (2.0 * horizontal), run, -rise, weight)
        stretched = length / (1.0 + strain.at(horizontal * np.hypot(1.0, rise / run)))
        return cls(run, rise, weight, strain, horizontal, vertical, stretched)

    @property
    def end_tension(self) -> Array:
        """Tension at the end."""
        return np.asarray(np.hypot(self.horizontal, self.vertical + self.weight * self.length))

    def solve(
        self,
        *,
        tension: Numbers | None = None,
        horizontal: Numbers | None = None,
        length: Numbers | None = None,
    ) -> ElasticPiece:
        """Newton's method for a given tension at the start, horizontal tension, or unstretched length. NaN where it
        does not converge."""
        (given,) = (v for v in (tension, horizontal, length) if v is not None)
        *known, wanted = np.broadcast_arrays(*self[:3], *self[4:], np.asarray(given, dtype=float))
        shape = wanted.shape
        run, rise, weight, *unknown = (v.ravel() for v in known)
        wanted = wanted.ravel()

        def residual(u: Any) -> Any:
            piece = catenary.segment((u[..., 0], 0.0, u[..., 1]), weight, u[..., 2], self.strain)
            if tension is not None:
                condition = np.sqrt(u[..., 0] ** 2 + u[..., 1] ** 2)
            else:
                condition = u[..., 0] if horizontal is not None else u[..., 2]
            return np.stack(
                [piece.reach[0] / run - 1.0, (piece.reach[2] - rise) / run, condition / wanted - 1.0], axis=-1
            )

        def relative_step(u: Array, step: Array) -> Array:
            return np.max(np.abs(step[:, [0, 2]] / u[:, [0, 2]]), axis=1)

        roots = solve_side_by_side(residual, np.column_stack(unknown), relative_step, longest=0.5)
        x = roots.unknowns
        x[~(roots.converged & (x[:, 0] > 0.0) & (x[:, 2] > 0.0))] = np.nan
        solved = (column.reshape(shape) for column in x.T)
        return self._replace(**dict(zip(("horizontal", "vertical", "length"), solved, strict=True)))

    def sag(self, share: float) -> Array:
        """Vertical distance [m] from the chord down to the rope, at a share of the run."""
        force = (self.horizontal, 0.0, self.vertical)

        def sag_condition(station: Any) -> Any:
            return catenary.segment(force, self.weight, station, self.strain).reach[0] / self.run - share

        station = newton(complex_step(sag_condition), share * self.length)
        reach = catenary.segment(force, self.weight, station, self.strain).reach
        return np.asarray(share * self.rise - reach[2])
