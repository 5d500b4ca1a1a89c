"""A system at rest: solved, checked to be physical, and ready to ask."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import pandas as pd

from ropeway.components import catenary, check
from ropeway.components.checked import checked
from ropeway.components.component import Kind
from ropeway.components.errors import (
    EquilibriumError,
    InputError,
    RopewayWarning,
    UnbalancedSystemError,
    UnknownNameError,
)
from ropeway.systems.assembly import assemble
from ropeway.systems.at_rest import TooHeavyError, keep_taut_root, let_out, loaded, settle, share_lengths
from ropeway.systems.carrying import carried_over, declared_alike, undriven
from ropeway.systems.certificate import Certificate, certify
from ropeway.systems.given_values import solve_swapped
from ropeway.systems.interrupts import interruptible
from ropeway.systems.model import Model
from ropeway.systems.newton import Point, outputs_of
from ropeway.systems.pending import Pending
from ropeway.systems.run import Run
from ropeway.systems.state import LOAD_OUTPUTS, LineState, find, support_points
from ropeway.systems.system import System, caller


@checked
@dataclass(frozen=True)
class Equilibrium:
    """A system at rest. `eq["a_b.tension_a"]` reads any variable, output or load by name (SI units).

    `point` holds the vectors of `model`, `loads` and `passed` where the loads of each run are, `held` the
    supports on which a load stands that could pass neither way. `pending`: what a run goes on with that starts
    here, where this is the line in the course of another run. `given`: values that it was solved for.
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
        """Values of all outputs, in the order of `model.y`."""
        return outputs_of(self.model)(*self.point.arguments)[0].copy()

    def __getitem__(self, name: str) -> float:
        kind, k = find(self.model, self.runs, self.passed, name)
        return float(self.outputs[k] if kind is Kind.OUTPUT else self.point.vector(kind)[k])

    @cached_property
    def checks(self) -> Certificate:
        """The certificate: an independent check, made afresh, that this is an equilibrium."""
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
        table = pd.DataFrame(
            {
                "name": [n for t, _ in rows for n in t.names],
                "value": np.concatenate([v for _, v in rows]),
                "unit": [n for t, _ in rows for n in t.units],
                "description": [n for t, _ in rows for n in t.descriptions],
            }
        ).set_index("name")
        return pd.concat([table[~table.index.str.contains(r"\.slot_")], self._load_rows()])

    def _load_rows(self) -> pd.DataFrame:
        words = {"x": "x of the load", "y": "y of the load", "z": "z of the load", "mass": "mass of the load"}
        words["distance"] = "unstretched distance of the load from its span's end a"
        rows = [
            (f"{row.load}.{key}", getattr(row, key), "kg" if key == "mass" else "m", text)
            for row in self.loads.itertuples()
            for key, text in words.items()
        ]
        return pd.DataFrame(rows, columns=["name", "value", "unit", "description"]).set_index("name")

    @cached_property
    def loads(self) -> pd.DataFrame:
        """The loads on the line: load, span, mass [kg], distance from the span's end a, x, y, z [m]."""
        rows = []
        for run, beyond in zip(self.runs, self.passed, strict=True):
            for k, span in enumerate(run.spans):
                for slot, i in enumerate(range(beyond[k] - 1, beyond[k + 1] - 1, -1)):
                    read = {
                        what: self.outputs[self.model.y.index[f"{span.name}.slot_{what}[{slot + 1}]"]]
                        for what in LOAD_OUTPUTS
                    }
                    if run.loads.mass[i] == 0.0:  # a missing load
                        continue
                    rows.append({"load": run.loads.names[i], "span": span.name, "mass": run.loads.mass[i], **read})
        return pd.DataFrame(rows, columns=["load", "span", "mass", "distance", "x", "y", "z"])

    def points(self, r: int) -> np.ndarray:
        """Places of the supports of a run, shape (supports, 3) [m]."""
        check.index(r, len(self.runs), "Equilibrium.points", "r")
        return support_points(self.model, r, self.point)

    def profile(self, span: str, stations: Sequence[float] | np.ndarray | int = 101) -> pd.DataFrame:
        """A loaded span along its unstretched `stations` [m] from end a, or that many evenly spread, its
        loads included. Columns: station, x, y, z [m], tension [N], slope (rise over run)."""
        if isinstance(stations, int):
            check.index(stations, 1_000_000, "Equilibrium.profile", "stations")
        for run, layout, beyond in zip(self.runs, self.model.layouts, self.passed, strict=True):
            for k, candidate in enumerate(run.spans):
                if candidate.name == span:
                    return self._profile(run, k, int(layout.force[k]), beyond, stations)
        raise UnknownNameError(
            f"No span {span!r}", f"Spans are {', '.join(s.name for r in self.runs for s in r.spans)}"
        )

    def _profile(
        self, run: Run, k: int, force: int, beyond: np.ndarray, stations: Sequence[float] | np.ndarray | int
    ) -> pd.DataFrame:
        name = run.spans[k].name
        read, p = self.outputs, self.model.p.index
        count = int(beyond[k] - beyond[k + 1])
        gravity, length = float(self.point.p[0]), self[f"{name}.length"]
        at = [float(read[self.model.y.index[f"{name}.slot_distance[{j + 1}]"]]) for j in range(count)]
        at = [min(max(distance, 0.0), length) for distance in at]  # a load that crosses is there but for rounding
        mass = [float(run.loads.mass[beyond[k] - 1 - j]) for j in range(count)]
        spread = np.linspace(0.0, length, stations) if isinstance(stations, int) else np.asarray(stations, float)
        if isinstance(stations, int):
            spread = np.union1d(spread, at)
        if spread.size and (spread.min() < 0.0 or spread.max() > length * (1.0 + 1e-12)):
            raise InputError(f"A station is outside span {name!r}", f"Its unstretched length is {length:.6g} m")
        strain = catenary.Strain(self.point.p[p[f"{name}.compliance"]], run.rope.strain.c2)
        tension = self.point.z[force : force + 3]
        weight = self.point.p[p[f"{name}.mass_per_length"]] * gravity
        curve = catenary.profile(tuple(tension), weight, strain, length, at, [m * gravity for m in mass], spread)
        place = run.start(k, self.__getitem__) + curve.reach
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


@checked
@interruptible
def equilibrium(
    system: System | Model,
    *,
    given: Mapping[str, float] | None = None,
    solve_for: str | Sequence[str] = (),
    parameters: Mapping[str, float] | None = None,
    start: Equilibrium | None = None,
) -> Equilibrium:
    """The stable, taut equilibrium of a system at rest.

    given: values that variables, outputs or loads must take (`{"a_b.tension_a": 150e3}`), and solve_for: as
    many parameters, span lengths or load masses freed in exchange. parameters: other values for parameters,
    inputs, states (a drive's travel) and load masses of this solve; the length of one span over idlers counts from
    those that all spans have at rest. start: a nearby equilibrium of the same
    declarations, for a warm start; of a line in the course of a run too, without its brakes and responses.

    After the solve the travel of all idlers is zero: the equilibrium is where a line starts from. Every result carries
    a `certificate`; a solution that fails its check is solved again from another start. Warns by RopewayWarning where
    a tension is above the rope's minimum breaking load. Raises InputError, UnknownNameError, UnbalancedSystemError
    before, EquilibriumError after a failed solve.
    """
    freed = [solve_for] if isinstance(solve_for, str) else list(solve_for)
    wanted = dict(given or {})
    if len(wanted) != len(freed):
        raise UnbalancedSystemError(
            f"{len(wanted)} values are given and {len(freed)} are solved for", "Free one for each one given"
        )
    for name, value in wanted.items():
        if not np.isfinite(value):
            raise InputError(f"given {name} is {value!r}", "Give a finite number")
    model = system if isinstance(system, Model) else assemble(system)
    freed = [model.swaps.get(name, name) for name in freed]
    first: EquilibriumError | None = None
    for way in ("near", "from geometry", "let out", "loaded"):
        if (way == "near" and start is None) or (way == "loaded" and wanted):
            continue
        state = _near(model, start, parameters) if way == "near" and start else _cold(model, parameters)
        try:
            found, certificate = _at_rest(state, wanted, freed, way)
        except TooHeavyError as error:
            raise error from first
        except EquilibriumError as error:
            first = first or error
            continue
        _warn(certificate)
        return found
    raise first or EquilibriumError(f"{model.name!r} has no equilibrium")


def _cold(model: Model, parameters: Mapping[str, float] | None) -> LineState:
    """A state from geometry."""
    state = LineState.cold(model)
    if parameters:
        share_lengths(state, parameters)
        state.set(parameters)
        state.restart()
    return state


def _near(model: Model, start: Equilibrium, parameters: Mapping[str, float] | None) -> LineState:
    """A state from a nearby equilibrium."""
    rest = start if declared_alike(start, model.system) else carried_over(start, model)
    state = LineState(rest.model, rest.point.copy(), rest.runs, rest.passed)
    for r, k, _ in state.standing():
        state.release(r, k)
    undriven(state)
    if parameters:
        state.set(parameters)
        state.write_slots()
    return state


def _at_rest(
    state: LineState, wanted: Mapping[str, float], freed: Sequence[str], way: str
) -> tuple[Equilibrium, Certificate]:
    """The equilibrium of a state with values `wanted` and others `freed` in exchange, and its certificate. The way
    "let out" comes from a taut rope, the way "loaded" from light loads. Raises EquilibriumError."""
    declared = state.point.p.copy()
    if way == "let out":
        state = let_out(state)
    elif way == "loaded":
        state = loaded(state)
    if wanted:
        solve_swapped(state, wanted, freed, from_chord=way != "let out")
    elif way in ("near", "from geometry"):
        settle(state)
        if way == "from geometry":
            keep_taut_root(state)
    for name in freed:
        kind, k = state.find(name)
        if kind is Kind.PARAMETER:
            declared[k] = state.point.p[k]
    rope = [_rope(state, r, declared) for r in range(len(state.runs))]
    state.rezero()
    certificate = certify(state.model, state.point, state.runs, state.passed, given=wanted, rope=rope)
    certificate.require(state.model)
    runs, passed = tuple(state.runs), tuple(state.passed)
    return Equilibrium(state.model, state.point, runs, passed, state.held, given=tuple(wanted.items())), certificate


def _rope(state: LineState, r: int, declared: np.ndarray) -> float:
    """Unstretched rope of a run [m]: what was declared, and what its ends have let in."""
    layout = state.model.layouts[r]
    travel = layout.travel.read(state.point.x, state.point.z)
    return float(declared[layout.length_start].sum() + travel[0] - travel[-1])


def _warn(certificate: Certificate) -> None:
    """Warns of a rope that cannot bear its tension, in the name of the user's line of code."""
    used = certificate.utilisation
    if used is not None and not used.holds:
        path, _, line = caller().rpartition(":")
        warnings.warn_explicit(
            f"The highest tension in span {used.component!r} at rest is {used.value:.3g} times the rope's minimum "
            "breaking load. Take lighter loads, more sag or a stronger rope",
            RopewayWarning,
            path or "?",
            int(line) if line.isdigit() else 1,
        )
