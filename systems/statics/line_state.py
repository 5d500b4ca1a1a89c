"""The state of a line: a point of its model, and which load is in which span."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from ropeway.components.catenary import Strain, Uniform, Weight
from ropeway.components.check import Range
from ropeway.components.errors import EquilibriumError, InputError, UnknownNameError
from ropeway.components.schedule import Schedule
from ropeway.components.variable import Kind
from ropeway.components.weather import SHARED, Weather
from ropeway.systems.modelling.assembly import assembled
from ropeway.systems.modelling.dae_model import Model, in_code, kept_with_model, nearest
from ropeway.systems.modelling.initial_guess import run_start
from ropeway.systems.modelling.rope_path import Run, rounded_up
from ropeway.systems.solvers.newton import outputs_of
from ropeway.systems.solvers.points import VECTORS, Point, Slot

LOAD_OUTPUTS = ("x", "y", "z", "distance")
"""What a slot says of the load in it, as outputs `slot_x`, ... of its span."""
LOAD_MOTION = tuple(f"{what}_{axis}" for what in ("velocity", "acceleration") for axis in "xyz")
"""As `LOAD_OUTPUTS`, with inertia."""


def load_outputs(model: Model) -> tuple[str, ...]:
    """What the slots of a model say of their loads."""
    return LOAD_OUTPUTS if model.inertia is None else (*LOAD_OUTPUTS, *LOAD_MOTION)


class LineState:
    """A point of a model, its runs with their loads, and the loads that have passed each support."""

    def __init__(self, model: Model, point: Point, runs: Sequence[Run], passed: Sequence[np.ndarray]) -> None:
        self.model = model
        self.point = point
        self.runs = list(runs)
        self.passed = [p.copy() for p in passed]
        self.span_scale = [
            float(point.p[layout.length_start].sum()) / len(layout.length_start) for layout in model.layouts
        ]
        """Mean span length of each run [m]."""
        self.resting: dict[tuple[int, int], tuple[int, float]] = {}
        """For the end (run, support) of a run the number of a load that rests on its drum, and the travel [m] that the
        rope still makes without it. Determined anew where it is missing."""

    @classmethod
    def declared(cls, model: Model) -> LineState:
        """As declared, without loads: ropes have the start values of the assembly."""
        state = cls(model, declared_point(model), model.runs, [np.zeros(len(run.nodes), int) for run in model.runs])
        state.write_slots()
        return state

    @classmethod
    def cold(cls, model: Model) -> LineState:
        """From geometry, without any solution."""
        state = cls(model, declared_point(model), model.runs, [np.zeros(0, int) for _ in model.runs])
        state.restart()
        return state

    def copy(self) -> LineState:
        """With arrays of its own."""
        copied = LineState(self.model, self.point.copy(), self.runs, self.passed)
        copied.resting = dict(self.resting)
        return copied

    def restart(self) -> None:
        """Starting values from geometry for the present lengths and loads."""
        for r, (run, layout) in enumerate(zip(self.runs, self.model.layouts, strict=True)):
            travel = layout.travel.read(self.point.x, np.zeros_like(self.point.z))
            start = run_start(run, float(self.point.p[0]), self.point.p[layout.length_start], travel, self.points(r))
            for axis in range(3):
                self.point.z[layout.force + axis] = start.force[:, axis]
            layout.travel.write(start.travel, self.point.x, self.point.z)
            self.passed[r] = start.passed
        self.write_slots()

    def rope(self, r: int) -> np.ndarray:
        """The rope at each support of a run [m, unstretched, from the run's start], shape (supports,)."""
        layout = self.model.layouts[r]
        return np.asarray(layout.start(self.point.p) - layout.travel.read(self.point.x, self.point.z))

    def points(self, r: int) -> np.ndarray:
        """Positions of the supports of a run, shape (supports, 3) [m]."""
        return support_points(self.model, r, self.point)

    def write_slots(self) -> None:
        """Writes the loads into the slots of their spans; assembles the model anew where a span has too few."""
        counts = [p[:-1] - p[1:] for p in self.passed]
        if any(np.any(c > layout.slots.count) for c, layout in zip(counts, self.model.layouts, strict=True)):
            self._grow(
                [
                    np.where(c > layout.slots.count, [rounded_up(int(n) + 1) for n in c], layout.slots.count)
                    for c, layout in zip(counts, self.model.layouts, strict=True)
                ]
            )
        for run, layout, beyond in zip(self.runs, self.model.layouts, self.passed, strict=True):
            layout.slots.write(self.point.d, run, beyond, layout.start(self.point.p))

    def write_beside(self, r: int, k: int) -> None:
        """`write_slots` for the spans on both sides of a support."""
        layout, beyond = self.model.layouts[r], self.passed[r]
        spans = np.arange(max(k - 1, 0), min(k + 1, len(beyond) - 1))
        if np.any(beyond[spans] - beyond[spans + 1] > layout.slots.count[spans]):
            self.write_slots()
        else:
            layout.slots.write(self.point.d, self.runs[r], beyond, layout.start(self.point.p), spans)

    def _grow(self, counts: Sequence[np.ndarray]) -> None:
        old = self.model
        grown = assembled(old.system, [[int(n) for n in c] for c in counts], old.inertia)
        self.model = in_code(grown, compiled=old.compiled)
        if old.inertia is None:
            d = self.model.d.values.copy()
            d[self.model.kept] = self.point.d[old.kept]
            self.point = replace(self.point, d=d)
        else:
            self.point = with_more_slots(old, self.point, self.model)

    def length(self, r: int) -> float:
        """Unstretched length of a run's rope between its ends at zero travel [m]."""
        return float(self.point.p[self.model.layouts[r].length_start].sum())

    def outputs(self) -> np.ndarray:
        """Values of all outputs, shape (ny,)."""
        return outputs_of(self.model)(*self.point.arguments)[0].copy()

    def hold(self, r: int, k: int, load: int) -> None:
        """Sets a load down on support k: the idler's travel is held there, its tensions are free. Raises
        EquilibriumError."""
        layout = self.model.layouts[r]
        if layout.held[k] < 0:
            raise EquilibriumError(
                f"Load {self.runs[r].loads.names[load]!r} can stand on neither side of {self.runs[r].nodes[k].name!r}",
                "Move the load",
                self.runs[r].nodes[k].name,
            )
        self.point.d[layout.held[k]] = 1.0
        self.point.d[layout.held_travel[k]] = layout.start(self.point.p)[k] - self.runs[r].loads.place[load]

    def release(self, r: int, k: int) -> None:
        """Lets an idler turn again."""
        self.point.d[self.model.layouts[r].held[k]] = 0.0

    def busy(self, r: int) -> np.ndarray:
        """The supports of a run on which a load stands."""
        layout = self.model.layouts[r]
        return layout.holding[self.point.d[layout.held[layout.holding]] > 0.0]

    def standing(self) -> tuple[tuple[int, int, float], ...]:
        """Run, support and travel of each idler on which a load stands."""
        found = []
        for r, layout in enumerate(self.model.layouts):
            for k in self.busy(r):
                found.append((r, int(k), float(self.point.d[layout.held_travel[k]])))
        return tuple(found)

    @property
    def held(self) -> tuple[str, ...]:
        """Names of the supports on which a load stands."""
        return tuple(self.runs[r].nodes[k].name for r, k, _ in self.standing())

    def rezero(self) -> None:
        """Sets the travel of all supports to zero: span lengths and places of loads follow."""
        for r, (run, layout) in enumerate(zip(self.runs, self.model.layouts, strict=True)):
            rope, loads, d = self.rope(r), run.loads, self.point.d
            place = loads.place
            if loads.pins:
                place = np.where(loads.pinned >= 0, rope[np.maximum(loads.pinned, 0)] + loads.at, place)
            self.runs[r] = run.carrying(place=place - rope[0])
            self.point.p[layout.length_start] = rope[1:] - rope[:-1]
            gripped, grip = layout.grips
            if len(grip):
                self.point.p[grip] -= layout.travel.read(self.point.x, self.point.z)[gripped]
            layout.travel.clear(self.point.x, self.point.z)
            held, held_travel = layout.holds
            d[held_travel] *= 1.0 - d.take(held)
            layout.slots.write_places(d, self.runs[r], self.passed[r], layout.start(self.point.p))

    def require_rope(self, remedy: str) -> None:
        """Raises EquilibriumError where no rope is left in a span."""
        for r, run in enumerate(self.runs):
            length = np.diff(self.rope(r)) + self.model.layouts[r].free(self.point.z)
            if np.any(length <= 0.0):
                name = run.spans[int(np.argmin(length))].name
                raise EquilibriumError(f"No rope is left in span {name!r}", remedy, name)

    def find(self, name: str) -> Slot:
        """The vector entry of a variable, an output or a load's quantity. Raises UnknownNameError."""
        return find(self.model, self.runs, self.passed, name)

    def set(self, values: Mapping[str, float]) -> None:
        """Sets parameters, inputs, drives' states and masses of loads, and writes the slots that change. Raises
        InputError."""
        names, numbers = tuple(values), np.fromiter(values.values(), float, len(values))
        settings = _settings_of(self.model)(names, tuple(run.loads.names for run in self.runs))
        if (wrong := settings.refused(numbers)) is not None:
            self._refuse(names[wrong], values[names[wrong]])
        for kind, places, which in settings.entries:
            self.point.vector(kind)[places] = numbers[which]
        for r, places, which in settings.masses:
            mass = self.runs[r].loads.mass.copy()
            mass[places] = numbers[which]
            self.runs[r] = self.runs[r].carrying(mass=mass)
        if settings.entries:
            self.write_slots()
            return
        for r, _, _ in settings.masses:
            self.model.layouts[r].slots.write_masses(self.point.d, self.runs[r], self.passed[r])

    def _refuse(self, name: str, value: float) -> None:
        """Raises InputError for a value that cannot be set."""
        if not math.isfinite(value):
            raise InputError(f"{name} is {value!r}", "Give a finite number")
        if name in _owners(tuple(run.loads.names for run in self.runs)):
            raise InputError(f"{name} is {value!r} kg", "A load has a mass above zero")
        kind, k = self.find(self.model.swaps.get(name, name))
        if kind in (Kind.OUTPUT, Kind.ALGEBRAIC):
            raise InputError(f"{name} is a result", "Use given= and solve_for=")
        raise InputError(f"{name} is {value!r}", f"Give {self.model.tables[kind].ranges[k].words}")


class _Settings:
    """Where values by `names` go, in runs with loads of the names `loads`: `entries` of vectors (kind, places, numbers
    of the values), and `masses` (run, places, numbers)."""

    def __init__(self, model: Model, names: tuple[str, ...], loads: tuple[tuple[str, ...], ...]) -> None:
        owners, ranges = _owners(loads), list[Range]()
        entries = dict[Kind, list[tuple[int, int]]]()
        masses = dict[int, list[tuple[int, int]]]()
        for i, name in enumerate(names):
            if (owned := owners.get(name)) is not None:
                ranges.append(Range(0.0, above=model.runs[owned[0][0]].feed is None))
                for r, load in owned:
                    masses.setdefault(r, []).append((load, i))
                continue
            entry = model.swaps.get(name, name)
            kind = next((kind for kind in _SET if entry in model.tables[kind].index), None)
            if kind is None:
                ranges.append(_NONE)
                continue
            place = model.tables[kind].index[entry]
            ranges.append(model.tables[kind].ranges[place])
            entries.setdefault(kind, []).append((place, i))
        self.entries = [(kind, *np.array(found, dtype=int).T.copy()) for kind, found in entries.items()]
        self.masses = [(r, *np.array(found, dtype=int).T.copy()) for r, found in masses.items()]
        self._least = np.array([np.nextafter(own.least, np.inf) if own.above else own.least for own in ranges])
        self._most = np.minimum([own.most for own in ranges], np.finfo(float).max)

    def refused(self, numbers: np.ndarray) -> int | None:
        """The first of the values that is not finite, outside its range, or without a place."""
        good = (numbers >= self._least) & (numbers <= self._most)
        return None if good.all() else int(good.argmin())


_SET = (Kind.STATE, Kind.INPUT, Kind.PARAMETER, Kind.DISCRETE)
"""The vectors whose entries can be set."""
_NONE = Range(np.inf, -np.inf)
"""Of entries that are results: it has no numbers."""


@kept_with_model
def _settings_of(model: Model) -> Callable[[tuple[str, ...], tuple[tuple[str, ...], ...]], _Settings]:
    """Finds where values by name go, and remembers the last few names."""
    return lru_cache(maxsize=8)(lambda names, loads: _Settings(model, names, loads))


@lru_cache(maxsize=16)
def _owners(names: tuple[tuple[str, ...], ...]) -> dict[str, list[tuple[int, int]]]:
    """For the name of each load's mass its run and its number there, from the names in each run; a load comes round an
    endless rope more than once."""
    owners: dict[str, list[tuple[int, int]]] = {}
    for r, run in enumerate(names):
        for i, name in enumerate(run):
            owners.setdefault(f"{name}.mass", []).append((r, i))
    return owners


def with_more_slots(old: Model, point: Point, new: Model) -> Point:
    """A point of a model with inertia as that of the same model with more load slots. With inertia slots have states:
    those of the new slots, which are empty, have the declared values."""
    x, z, d = (new.tables[kind].values.copy() for kind in (Kind.STATE, Kind.ALGEBRAIC, Kind.DISCRETE))
    found = Point(x, z, point.u, point.p, d, point.t)
    for kind in (Kind.STATE, Kind.ALGEBRAIC, Kind.DISCRETE):
        there = new.tables[kind].index
        found.vector(kind)[[there[name] for name in old.tables[kind].names]] = point.vector(kind)
    return found


def declared_point(model: Model) -> Point:
    """All values as they are declared, inputs at time 0."""
    u = [
        s.at(0.0) if isinstance(s, Schedule) else open_start if s is None else s
        for s, open_start in zip(model.signals, model.u.values, strict=True)
    ]
    x, z, p, d = (table.values.copy() for table in (model.x, model.z, model.p, model.d))
    return Point(x, z, np.array(u), p, d)


def support_points(model: Model, r: int, point: Point) -> np.ndarray:
    """Positions of the supports of a run, shape (supports, 3) [m]: parameters, or variables where ropes hold them."""
    return np.concatenate(point.vectors)[_coordinates(model, r)]


@kept_with_model
def _coordinates(model: Model, r: int) -> np.ndarray:
    """Where the coordinates of a run's supports stand in all vectors, one after the other; shape (supports, 3)."""
    names = [name for kind in VECTORS for name in model.tables[kind].names]
    index = {name: i for i, name in enumerate(names)}
    return np.array([[index[f"{node.name}.{axis}"] for axis in "xyz"] for node in model.runs[r].nodes])


def read_value(model: Model, point: Point, outputs: np.ndarray, name: str) -> float:
    """A variable or output by its name. Raises UnknownNameError."""
    kind, k = find(model, (), (), name)
    return float(outputs[k] if kind is Kind.OUTPUT else point.vector(kind)[k])


def find(model: Model, runs: Sequence[Run], passed: Sequence[np.ndarray], name: str) -> Slot:
    """The vector entry of a variable, an output or a quantity of a load (x, y, z, distance, mass).

    Raises UnknownNameError.
    """
    for kind in (Kind.OUTPUT, *VECTORS):
        if name in model.tables[kind].index:
            return kind, model.tables[kind].index[name]
    owner, _, quantity = name.rpartition(".")
    for run, beyond in zip(runs, passed, strict=True):
        if owner in run.loads.names and quantity in (*load_outputs(model), "mass"):
            # Loads of an endless rope are listed once for each round.
            load = run.loads.names.index(owner, int(beyond[-1]) if run.around else 0)
            k = int(np.searchsorted(-beyond, -load, side="left")) - 1
            if not 0 <= k < len(run.spans):
                raise UnknownNameError(f"Load {owner!r} is not on the line", "Ask for one that is")
            slot = f"{run.spans[k].name}.slot_{quantity}[{beyond[k] - load}]"
            kind = Kind.DISCRETE if quantity == "mass" else Kind.OUTPUT
            return kind, model.tables[kind].index[slot]
    tables = [model.tables[kind] for kind in (Kind.OUTPUT, *VECTORS)]
    known = [table.names[i] for table in tables for i in table.shown]
    known += [f"{load}.{of}" for run in runs for load in run.loads.names for of in (*load_outputs(model), "mass")]
    raise UnknownNameError(f"{name!r} is not in system {model.name!r}", nearest(name, known))


Read = Callable[[str], Any]
"""The value of a variable or output, by its name."""


class SpanRope(NamedTuple):
    """Weight of a rope [N/m], with wind a `Uniform` force, and its strain."""

    weight: Weight
    strain: Strain


def span_rope(model: Model, run: Run, k: int, read: Read) -> SpanRope:
    """The rope in span k of a run."""
    name = run.spans[k].name
    strain = Strain(read(f"{name}.compliance"), run.rope.strain.c2)
    if not model.weather:
        return SpanRope(read(f"{name}.mass_per_length") * read("gravity"), strain)
    pull = (read(f"{name}.load_x"), read(f"{name}.load_y"), read(f"{name}.load_z"))
    return SpanRope(Uniform.of(pull), strain._replace(expansion=read(f"{name}.expansion")))


def end_force(model: Model, run: Run, k: int, read: Read) -> np.ndarray:
    """Tension vector at end b of span k of a run, (3,) [N]."""
    name = run.spans[k].name
    ends = ("pull_b_x[1]", "pull_b_y[1]") if model.weather else ("force_x", "force_y")
    return np.array([read(f"{name}.{variable}") for variable in (*ends, "vertical_b")])


def load_force(model: Model, mass: float, drag_area: float, read: Read) -> Any:
    """A load on a rope as `loaded` takes it [N]: its weight; in weather a vector, with wind on it."""
    down = mass * read("gravity")
    if not model.weather:
        return down
    x, y, _ = Weather.of([read(name) for name in SHARED]).drag(drag_area)
    return (x, y, -down)
