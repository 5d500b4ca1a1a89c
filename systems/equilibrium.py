"""A system at rest: solved, checked to be physical, and ready to ask."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
import pandas as pd

from ropeway.components import catenary
from ropeway.components.checked import checked
from ropeway.components.component import Kind
from ropeway.components.errors import EquilibriumError, InputError, UnbalancedSystemError, UnknownNameError
from ropeway.systems.assembly import assemble
from ropeway.systems.carrying import carried_over, declared_alike, undriven
from ropeway.systems.continuation import solve_algebraic
from ropeway.systems.interrupts import interruptible
from ropeway.systems.model import Model, component_of
from ropeway.systems.newton import Newton, Point, Slot, newton_of, outputs_of
from ropeway.systems.pending import Pending
from ropeway.systems.run import Run
from ropeway.systems.stability import require_stable, slack
from ropeway.systems.state import LOAD_OUTPUTS, LineState, find, support_points
from ropeway.systems.system import System


@checked
@dataclass(frozen=True)
class Equilibrium:
    """A system at rest. `eq["a_b.tension_a"]` reads any variable, output or load by name (SI units).

    `point` holds the vectors of `model`, `loads` and `passed` where the loads of each run are, `held` the
    supports on which a load stands that could pass neither way. `pending`: what a run goes on with that starts
    here, where this is the line in the course of another run.
    """

    model: Model
    point: Point
    runs: tuple[Run, ...]
    passed: tuple[np.ndarray, ...]
    held: tuple[str, ...]
    pending: Pending = field(default_factory=Pending)

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
        return support_points(self.model, r, self.point)

    def profile(self, span: str, stations: Sequence[float] | np.ndarray | int = 101) -> pd.DataFrame:
        """A loaded span along its unstretched `stations` [m] from end a, or that many evenly spread, its
        loads included. Columns: station, x, y, z [m], tension [N], slope (rise over run)."""
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

    After the solve the travel of all idlers is zero: the equilibrium is where a line starts from. Raises
    InputError, UnknownNameError, UnbalancedSystemError before, EquilibriumError after a failed solve.
    """
    freed_names = [solve_for] if isinstance(solve_for, str) else list(solve_for)
    wanted = dict(given or {})
    if len(wanted) != len(freed_names):
        raise UnbalancedSystemError(
            f"{len(wanted)} values are given and {len(freed_names)} are solved for", "Free one for each one given"
        )
    for name, value in wanted.items():
        if not np.isfinite(value):
            raise InputError(f"given {name} is {value!r}", "Give a finite number")
    model = system if isinstance(system, Model) else assemble(system)
    if start is None:
        state = LineState.cold(model)
    else:
        rest = start if declared_alike(start, model.system) else carried_over(start, model)
        state = LineState(rest.model, rest.point.copy(), rest.runs, rest.passed)
        for r, k, _ in state.standing():
            state.release(r, k)
        undriven(state)
    if parameters:
        if start is None:
            _share_lengths(state, parameters)
        state.set(parameters)
        state.restart() if start is None else state.write_slots()
    if wanted:
        _solve_swapped(state, wanted, [model.swaps.get(n, n) for n in freed_names])
    else:
        solve(state)
        if start is None:
            _let_out(state)
    state.rezero()
    return Equilibrium(state.model, state.point, tuple(state.runs), tuple(state.passed), state.held)


def _share_lengths(state: LineState, names: Iterable[str]) -> None:
    """Where the length of a span over idlers is among the names: gives all spans those they have at rest, as the
    user knows them, instead of those of the first guess."""
    spans = {name.rpartition(".length")[0] for name in names}
    runs = [run for run in state.model.runs if any(node.balance is not None for node in run.nodes)]
    if spans.isdisjoint(span.name for run in runs for span in run.spans):
        return
    rest = LineState.cold(state.model)
    solve(rest)
    rest.rezero()
    for layout in state.model.layouts:
        state.point.p[layout.length_start] = rest.point.p[layout.length_start]


def solve(state: LineState) -> None:
    """Brings a state to rest: every load in its span, the idlers balanced, the balance stable.

    Raises EquilibriumError.
    """
    seen: set[bytes] = set()
    for _ in range(200):
        solve_algebraic(state)
        before = [p.copy() for p in state.passed]
        if state.settle():
            _check(state)
            return
        key = b"".join(p.tobytes() for p in state.passed)
        if key in seen:  # a load that neither of two spans keeps stands on the support between them
            for r, (was, now) in enumerate(zip(before, state.passed, strict=True)):
                for k in np.flatnonzero(was != now):
                    state.hold(r, int(k), int(min(was[k], now[k])))
        seen.add(key)
    raise EquilibriumError(
        f"The loads of system {state.model.name!r} find no place on the rope",
        "Loads stand close to a support: move them a little",
    )


def _let_out(state: LineState) -> None:
    """Makes sure that a slack line with loads is the one that a taut line becomes as rope is let out.

    Where that cannot be followed, the equilibrium found stays.
    """
    if not any(len(run.loads.place) for run in state.runs) or not slack(state) or state.standing():
        return
    trial = LineState.cold(state.model)
    trial.point.p[:] = state.point.p
    lengths = [state.point.p[layout.length_start].copy() for layout in state.model.layouts]
    places = [run.loads.place for run in state.runs]
    try:
        for share in np.linspace(0.0, 1.0, 41):
            for r, (run, layout) in enumerate(zip(state.runs, state.model.layouts, strict=True)):
                chord = np.linalg.norm(np.diff(state.points(r), axis=0), axis=1)
                taut = np.minimum(chord.sum() * (1.0 + 1e-4) / lengths[r].sum(), 1.0)
                part = taut + share * (1.0 - taut)
                trial.point.p[layout.length_start] = part * lengths[r]
                trial.runs[r] = replace(run, loads=replace(run.loads, place=part * places[r]))
            if share == 0.0:
                trial.restart()
            trial.write_slots()
            solve(trial)
    except EquilibriumError:
        return
    if not trial.standing() and any(np.any(a != b) for a, b in zip(trial.passed, state.passed, strict=True)):
        state.model, state.point, state.runs, state.passed = trial.model, trial.point, trial.runs, trial.passed


def _check(state: LineState) -> None:
    """Raises EquilibriumError for a root that no rope can have: a piece of no length, or an unstable balance."""
    state.require_rope("Give the run more rope")
    require_stable(state)


def _solve_swapped(state: LineState, given: Mapping[str, float], solve_for: Sequence[str]) -> None:
    """Brings a state to rest with values given and as many quantities freed."""
    lengths = {int(k) for layout in state.model.layouts for k in layout.length_start}
    freed = [state.find(name) for name in solve_for]
    for name, (kind, _) in zip(solve_for, freed, strict=True):
        if kind not in (Kind.PARAMETER, Kind.STATE, Kind.INPUT, Kind.DISCRETE):
            raise InputError(f"{name} is a result and cannot be freed", "Free a parameter, a length or a mass")
    stretched = [k for kind, k in freed if kind is Kind.PARAMETER and k in lengths]
    if stretched:
        _pull_straight(state, stretched, given)
    else:
        solve(state)
    for _ in range(20):
        wanted = [state.find(name) for name in given]
        freed = [state.find(name) for name in solve_for]
        _approach(state, Newton(state.model, freed, wanted), wanted, np.array(list(given.values()), float))
        _read_masses(state)
        if state.settle():
            break
    else:
        raise EquilibriumError(
            f"The loads of system {state.model.name!r} find no place on the rope with the values given",
            "Ask for values nearer to an equilibrium that you know",
        )
    for name, (kind, k) in zip(solve_for, freed, strict=True):
        value = state.point.vector(kind)[k]
        if value < 0.0 and (name.endswith(".mass") or k in stretched):
            raise EquilibriumError(f"The values given need {name} = {value:.6g}", "Ask for less", component_of(name))
    _check(state)


def _pull_straight(state: LineState, lengths: Sequence[int], given: Mapping[str, float]) -> None:
    """Starts from a taut rope at its chord: for a given tension a very slack one may exist too."""
    for run, layout in zip(state.runs, state.model.layouts, strict=True):
        for k, span in enumerate(run.spans):
            if int(layout.length_start[k]) in lengths:
                a, b = run.nodes[k], run.nodes[k + 1]
                near = [
                    v
                    for name, v in given.items()
                    if "tension" in name and component_of(name) in (span.name, a.name, b.name)
                ]
                tension = max(near, default=0.1 * run.rope.breaking_load)
                chord = float(np.linalg.norm(np.subtract(a.at, b.at)))
                state.point.p[layout.length_start[k]] = chord / (1.0 + run.rope.strain.at(tension))
                if run.rope.strain == (0.0, 0.0):
                    sag = run.rope.mass_per_length * state.point.p[0] * chord / tension
                    state.point.p[layout.length_start[k]] *= 1.0 + sag**2 / 24.0
    state.restart()


def _approach(state: LineState, newton: Newton, wanted: Sequence[Slot], target: np.ndarray) -> None:
    """Newton's method towards the target, by smaller steps where the whole way is too far."""
    try:
        newton.solve(state.point, target=target)
        return
    except EquilibriumError:
        plain = newton_of(state.model)
        plain.solve(state.point)
    outputs = state.outputs()
    origin = np.array([outputs[k] if kind is Kind.OUTPUT else state.point.vector(kind)[k] for kind, k in wanted])
    done, share = 0.0, 0.25
    while done < 1.0:
        share = min(share, 1.0 - done)
        try:
            newton.solve(state.point, target=origin + (done + share) * (target - origin))
            done, share = done + share, 2.0 * share
        except EquilibriumError as error:
            share /= 2.0
            if share < 1e-3:
                raise EquilibriumError(
                    f"No equilibrium of {state.model.name!r} has the values given",
                    "Ask for values nearer to an equilibrium that you know",
                    error.component,
                ) from error


def _read_masses(state: LineState) -> None:
    """Takes masses that were solved for out of the slots."""
    for r, (run, layout) in enumerate(zip(state.runs, state.model.layouts, strict=True)):
        beyond, mass = state.passed[r], run.loads.mass.copy()
        for k in range(len(run.spans)):
            for slot, i in enumerate(range(beyond[k] - 1, beyond[k + 1] - 1, -1)):
                mass[i] = state.point.d[layout.slots.mass[k] + slot]
        state.runs[r] = replace(run, loads=replace(run.loads, mass=mass))
