"""The equilibrium of a system, and its values by name."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import pandas as pd

from ropeway.components import catenary, check
from ropeway.components.argument_checks import checked
from ropeway.components.clearance import Clearance
from ropeway.components.errors import (
    InputError,
    UnknownNameError,
)
from ropeway.components.table_writer import Tabular
from ropeway.components.variable import Kind
from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.modelling.rope_path import Run
from ropeway.systems.solvers.newton import outputs_of
from ropeway.systems.solvers.points import Point
from ropeway.systems.statics.certificate.certify import certify
from ropeway.systems.statics.certificate.checks import Certificate
from ropeway.systems.statics.line_state import find, load_force, load_outputs, span_rope, support_points
from ropeway.systems.statics.pending_events import Pending


@checked
@dataclass(frozen=True)
class Equilibrium(Tabular):
    """A system at rest. `eq["a_b.tension_a"]` is any variable, output or quantity of a load by its name, in SI units.

    Attributes
    ----------
    model : Model
    point : Point
        The vectors of the model.
    runs : tuple of Run
        The ropes with their loads.
    passed : tuple of ndarray
        For each run the number of loads that have passed each support, shape (supports,).
    held : tuple of str
        Supports on which a load stands that can pass neither way.
    pending : Pending
        For `result.at(t)`: clocks and an emergency stop, which a run continues.
    given : tuple of (str, float)
        Values that it was solved for.

    Examples
    --------
    >>> eq = rw.equilibrium(line)
    >>> print(f"{eq['c1.tension_in'] / 1e3:.1f} kN")
    46.6 kN
    >>> bool(eq.certificate.holds.all())
    True
    """

    model: Model
    point: Point
    runs: tuple[Run, ...]
    passed: tuple[np.ndarray, ...]
    held: tuple[str, ...]
    pending: Pending = field(default_factory=Pending)
    given: tuple[tuple[str, float], ...] = ()

    def __repr__(self) -> str:
        return f"<Equilibrium of {self.model.name!r}: {len(self.model.y)} outputs>"

    @cached_property
    def outputs(self) -> np.ndarray:
        """Values of all outputs, in the order of `model.y`, shape (ny,)."""
        return outputs_of(self.model)(*self.point.arguments)[0].copy()

    def __getitem__(self, name: str) -> float:
        kind, k = find(self.model, self.runs, self.passed, name)
        return float(self.outputs[k] if kind is Kind.OUTPUT else self.point.vector(kind)[k])

    @cached_property
    def checks(self) -> Certificate:
        """The certificate: an independent check that this is an equilibrium."""
        return certify(self.model, self.point, self.runs, self.passed, given=dict(self.given))

    @property
    def certificate(self) -> pd.DataFrame:
        """The certificate as a frame: index check; columns value, limit, holds, component where it is worst."""
        return self.checks.frame

    @cached_property
    def frame(self) -> pd.DataFrame:
        """All values: index name; columns value, unit, description."""
        m = self.model
        rows = [(m.y, self.outputs), (m.z, self.point.z), (m.x, self.point.x), (m.u, self.point.u), (m.p, self.point.p)]
        shown = [(table, vector, i) for table, vector in rows for i in table.shown]
        table = pd.DataFrame(
            {
                "name": [t.names[i] for t, _, i in shown],
                "value": [float(vector[i]) for _, vector, i in shown],
                "unit": [t.units[i] for t, _, i in shown],
                "description": [t.descriptions[i] for t, _, i in shown],
            }
        ).set_index("name")
        return pd.concat([table, self._load_rows()])

    def _load_rows(self) -> pd.DataFrame:
        words = {"x": "x of the load", "y": "y of the load", "z": "z of the load", "mass": "mass of the load"}
        words["distance"] = "unstretched distance of the load from its span's end a"
        rows = [
            (f"{row.load}.{key}", getattr(row, key), "kg" if key == "mass" else "m", text)
            for row in self.loads.itertuples()
            for key, text in words.items()
        ]
        table = pd.DataFrame(rows, columns=["name", "value", "unit", "description"])
        return table.astype({"value": float}).set_index("name")

    @cached_property
    def loads(self) -> pd.DataFrame:
        """The loads on the line: load, span, mass [kg], distance from the span's end a, x, y, z [m]; with inertia also
        their velocities [m/s] and accelerations [m/s2]."""
        rows, outputs = [], load_outputs(self.model)
        for run, beyond in zip(self.runs, self.passed, strict=True):
            for k, span in enumerate(run.spans):
                for slot, i in enumerate(range(beyond[k] - 1, beyond[k + 1] - 1, -1)):
                    read = {
                        what: self.outputs[self.model.y.index[f"{span.name}.slot_{what}[{slot + 1}]"]]
                        for what in outputs
                    }
                    if run.loads.mass[i] == 0.0:  # a missing load
                        continue
                    rows.append({"load": run.loads.names[i], "span": span.name, "mass": run.loads.mass[i], **read})
        return pd.DataFrame(
            rows, columns=["load", "span", "mass", "distance", *(o for o in outputs if o != "distance")]
        )

    def points(self, r: int) -> np.ndarray:
        """Positions of the supports of a run.

        Parameters
        ----------
        r : int
            Number of the run, from 0.

        Returns
        -------
        ndarray
            Shape (supports, 3) [m].

        Raises
        ------
        InputError
        """
        check.index(r, len(self.runs), "Equilibrium.points", "r")
        return support_points(self.model, r, self.point)

    def profile(self, span: str, stations: Sequence[float] | np.ndarray | int = 101) -> pd.DataFrame:
        """The curve of a loaded span.

        Parameters
        ----------
        span : str
            Name of the span.
        stations : sequence of float or int, default 101
            Unstretched distances from end a [m], or their number: evenly spaced, those of the loads added.

        Returns
        -------
        DataFrame
            Columns station, x, y, z [m], tension [N], slope (rise over run).

        Raises
        ------
        UnknownNameError, InputError
        """
        if isinstance(stations, int):
            check.index(stations, 1_000_000, "Equilibrium.profile", "stations")
        for r, run in enumerate(self.runs):
            for k, candidate in enumerate(run.spans):
                if candidate.name == span:
                    curve, place = self._curve(r, k, stations)
                    return pd.DataFrame(
                        {
                            "station": curve.station,
                            "x": place[:, 0],
                            "y": place[:, 1],
                            "z": place[:, 2],
                            "tension": curve.tension,
                            "slope": curve.slope,
                        }
                    )
        raise UnknownNameError(
            f"No span {span!r}", f"Spans are {', '.join(s.name for r in self.runs for s in r.spans)}"
        )

    def heights_over_ground(self, points: int = 101) -> list[Clearance]:
        """Smallest height of each span with its loads above the ground.

        Parameters
        ----------
        points : int, default 101
            Points of a span that are measured, besides its loads and the vertices of the ground.

        Returns
        -------
        list of Clearance
            Height and station of the ground there [m], span by span.

        Raises
        ------
        InputError
            The system has no ground.
        """
        ground = self.model.system.ground
        if ground is None:
            raise InputError(f"{self.model.name!r} has no ground", "Give its system a terrain")
        check.count(points, "Equilibrium.heights_over_ground", "points", 1_000_000)
        if points < 2:
            raise InputError(f"Equilibrium.heights_over_ground: points is {points}", "Give 2 or more")
        spans = [(r, k) for r, run in enumerate(self.runs) for k in range(len(run.spans))]
        return [ground.under(self._curve(r, k, points)[1]) for r, k in spans]

    @cached_property
    def clearance(self) -> pd.DataFrame:
        """Smallest height of each span above the ground.

        Index span; columns rope_clearance (of the rope with its loads), the station of the ground there, load_clearance
        (of the loads; NaN if there are none) [m]. Raises InputError if the system has no ground.
        """
        names = [span.name for run in self.runs for span in run.spans]
        rows = {name: (*found, np.nan) for name, found in zip(names, self.heights_over_ground(), strict=True)}
        frame = pd.DataFrame.from_dict(rows, "index", columns=["rope_clearance", "station", "load_clearance"])
        loads, ground = self.loads, self.model.system.ground
        if ground is not None and len(loads):
            over = loads["z"] - ground.elevations(loads["x"].to_numpy(), loads["y"].to_numpy())
            frame["load_clearance"] = over.groupby(loads["span"]).min().reindex(frame.index)
        frame.attrs["units"] = dict.fromkeys(frame.columns, "m")
        return frame.rename_axis("span")

    def _curve(
        self, r: int, k: int, stations: Sequence[float] | np.ndarray | int
    ) -> tuple[catenary.SpanCurve, np.ndarray]:
        """The curve of span k of run r, and its points (n, 3)."""
        run, beyond, force = self.runs[r], self.passed[r], int(self.model.layouts[r].force[k])
        name = run.spans[k].name
        read = self.outputs
        count = int(beyond[k] - beyond[k + 1])
        length = self[f"{name}.length"]
        at = [float(read[self.model.y.index[f"{name}.slot_distance[{j + 1}]"]]) for j in range(count)]
        at = [min(max(distance, 0.0), length) for distance in at]  # a load that crosses is there but for rounding
        loads, on = run.loads, [beyond[k] - 1 - j for j in range(count)]
        pulls = [load_force(self.model, float(loads.mass[i]), float(loads.drag[i]), self.__getitem__) for i in on]
        spread = np.linspace(0.0, length, stations) if isinstance(stations, int) else np.asarray(stations, float)
        if isinstance(stations, int):
            spread = np.union1d(spread, at)
        if spread.size and (spread.min() < 0.0 or spread.max() > length * (1.0 + 1e-12)):
            raise InputError(f"A station is outside span {name!r}", f"Its unstretched length is {length:.6g} m")
        rope = span_rope(self.model, run, k, self.__getitem__)
        tension = self.point.z[force : force + 3]
        start = run.start(k, self.__getitem__)
        if self.model.inertia is not None:
            starts, forces = [np.zeros(3)], [tension]
            for j in range(count):
                slot = [f"{name}.slot_{axis}[{j + 1}]" for axis in "xyz"]
                starts.append(read[[self.model.y.index[place] for place in slot]] - start)
                pull = [f"{name}.pull_{axis}[{j + 1}]" for axis in "xyz"]
                forces.append(self.point.z[[self.model.z.index[force] for force in pull]])
            curve = catenary.through(np.array(starts), np.array(forces), rope.weight, rope.strain, at, spread)
        else:
            curve = catenary.profile(tuple(tension), rope.weight, rope.strain, length, at, pulls, spread)
        return curve, start + curve.reach
