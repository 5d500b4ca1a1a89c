"""A piecewise linear line of the ground in a vertical plane: elevations, slopes, and heights above it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ropeway.components.argument_checks import checked
from ropeway.components.clearance import Clearance, least_height, under_line
from ropeway.components.errors import InputError
from ropeway.components.rope_piece import Piece


@checked
class ProfileGeometry:
    """Ground that is straight between its points: `station` and `elevation` [m], stations increasing."""

    station: np.ndarray
    elevation: np.ndarray

    def elevation_at(self, station: float) -> float:
        """Elevation at a station.

        Parameters
        ----------
        station : float
            Station [m].

        Returns
        -------
        float
            Elevation [m].

        Raises
        ------
        InputError
            The station is outside the profile.
        """
        if not self.station[0] <= station <= self.station[-1]:
            raise InputError(
                f"Station {station:g} m is outside the profile",
                f"It runs from {self.station[0]:g} m to {self.station[-1]:g} m",
            )
        return float(np.interp(station, self.station, self.elevation))

    def elevations(self, stations: float | np.ndarray) -> np.ndarray:
        """Elevations at stations.

        Parameters
        ----------
        stations : float or ndarray
            Stations [m].

        Returns
        -------
        ndarray
            Elevations [m], NaN outside the profile.
        """
        return np.asarray(np.interp(stations, self.station, self.elevation, left=np.nan, right=np.nan))

    def slope_at(self, station: float) -> float:
        """Slope of the ground at a station; at a vertex that of the segment after it.

        Parameters
        ----------
        station : float
            Station [m].

        Returns
        -------
        float
            Rise over run.

        Raises
        ------
        InputError
            The station is outside the profile.
        """
        self.elevation_at(station)
        k = min(int(np.searchsorted(self.station, station, side="right")) - 1, len(self.station) - 2)
        return float(np.diff(self.elevation[k : k + 2])[0] / np.diff(self.station[k : k + 2])[0])

    def vertex_at(self, station: float) -> tuple[float, float, float, float, float]:
        """The vertex nearest to a station.

        Parameters
        ----------
        station : float
            Station [m].

        Returns
        -------
        station, elevation, before, after, half : float
            Position of the vertex [m], slopes before and after it (rise over run; at an end that of the outermost
            segment), half the length of its shorter segment [m].
        """
        k = int(np.argmin(np.abs(self.station - station)))
        last = len(self.station) - 2
        around = [max(k - 1, 0), min(k, last)]
        runs = np.diff(self.station)[around]
        before, after = np.diff(self.elevation)[around] / runs
        return float(self.station[k]), float(self.elevation[k]), float(before), float(after), 0.5 * float(runs.min())

    def chord_slope(self, start: float, end: float) -> float:
        """Slope of the straight line between the ground at two stations.

        Parameters
        ----------
        start, end : float
            Stations [m].

        Returns
        -------
        float
            Rise over run.

        Raises
        ------
        InputError
            Equal stations, or one outside the profile.
        """
        if start == end:
            raise InputError(f"Both stations are {start:g} m", "Give two different ones")
        return (self.elevation_at(end) - self.elevation_at(start)) / (end - start)

    def clearance(self, piece: Piece) -> Clearance:
        """Smallest height of a piece of rope above the ground.

        Exact: it is at the ends, above a vertex of the ground, or where the rope is parallel to the ground.

        Parameters
        ----------
        piece : Piece
            A load-free piece of rope.

        Returns
        -------
        Clearance
            Height and station [m]; (inf, nan) if there is no ground below.
        """
        return least_height(self, piece)

    def clearance_of_line(self, points: Sequence[tuple[float, float]] | np.ndarray) -> Clearance:
        """Smallest height of a polygonal line above the ground, exact.

        Parameters
        ----------
        points : sequence of tuple of float
            Its vertices (x, z) [m], one or more.

        Returns
        -------
        Clearance
            Height and station [m]; (inf, nan) if there is no ground below.

        Raises
        ------
        InputError
            No points.
        """
        line = np.asarray(points, dtype=float).reshape(-1, 2)
        if not len(line):
            raise InputError("The line has no points", "Give one or more (x, z)")
        return under_line(self, line)
