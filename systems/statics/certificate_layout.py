"""Places of a certificate's variables in the stacked vectors of a model, which end with a zero for variables that a
model does not have."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from ropeway.components.component import Component, Seat
from ropeway.components.laws import tension
from ropeway.components.node import Node
from ropeway.components.variable import Site
from ropeway.systems.modelling.dae_model import Model, component_of, kept_with_model
from ropeway.systems.modelling.rope_path import Run, drive_speeds
from ropeway.systems.solvers.points import VECTORS

SPAN = (
    "force_x",
    "force_y",
    "force_z",
    "length_start",
    "mass_per_length",
    "compliance",
    "construction",
    "breaking_load",
)
"""Variables of a span, in the order of the rows of `SpanPlaces.read`; behind them, for ends a and b, `ENDS`."""
ENDS = ("travel", "x", "y", "z", "rope", "aside_x", "aside_z")


class FilledSlots(NamedTuple):
    """Which loads are in which slots, as many as the fullest span needs: of each run its spans and the numbers of their
    loads (records, slots, spans), 0 in empty slots; of all spans `there`, the slots with a load, and `lost`: whether a
    span has more loads than slots (records, spans)."""

    runs: tuple[tuple[slice, np.ndarray], ...]
    there: np.ndarray
    lost: np.ndarray


@dataclass(frozen=True, eq=False)
class SpanPlaces:
    """Places of all spans, run after run. `read` (22, spans): of `SPAN`, and of `ENDS` at both ends; `slots`
    (4, slots, spans): mass, at, ride, empty of each load slot; `runs`: the first span of each run, and their number
    behind; `gravity`: its place; `shoes`: whether a rope leaves a node beside its place anywhere."""

    names: tuple[str, ...]
    read: np.ndarray
    slots: np.ndarray
    slot_counts: np.ndarray
    runs: tuple[int, ...]
    gravity: int
    shoes: bool

    def slots_of(self, passed: Sequence[np.ndarray]) -> FilledSlots:
        """The slots for the loads beyond each support (records, supports) of each run; those of one state are
        remembered, as the loads stay in their spans in most solves."""
        if passed and len(passed[0]) == 1:
            return self._slots_of_one(tuple(beyond.astype(int).tobytes() for beyond in passed))
        return self._slots(passed)

    @cached_property
    def _slots_of_one(self) -> Callable[[tuple[bytes, ...]], FilledSlots]:
        return lru_cache(maxsize=8)(
            lambda passed: self._slots([np.frombuffer(beyond, dtype=int)[None] for beyond in passed])
        )

    def _slots(self, passed: Sequence[np.ndarray]) -> FilledSlots:
        counts = [beyond[:, :-1] - beyond[:, 1:] for beyond in passed]
        every = np.concatenate(counts, axis=1) if counts else np.zeros((1, 0), dtype=int)
        slot = np.arange(int(every.max(initial=0)))[:, None]
        there, runs = np.less(slot, every[:, None]), list[tuple[slice, np.ndarray]]()
        for r, beyond in enumerate(passed):
            own = slice(self.runs[r], self.runs[r + 1])
            runs.append((own, (beyond[:, None, :-1] - 1 - slot) * there[:, :, own]))
        return FilledSlots(tuple(runs), there, every > self.slot_counts)


@dataclass(frozen=True, eq=False)
class WeatherPlaces:
    """Places of the weather: `shared` (7,) of what all components have in common, without gravity; `of_rope` (3, spans)
    of each rope's diameter, thermal expansion and drag coefficient; `drag` (slots, spans): of the loads' drag areas."""

    shared: np.ndarray
    of_rope: np.ndarray
    drag: np.ndarray


@dataclass(frozen=True, eq=False)
class Kindred:
    """Components of one kind: `first` stands for all `names`. `variables`: places of each (components,); `seats`:
    for each seat the rope end that sits there, a number of `pulls`, and the places of the rope's speed, of its two
    strain coefficients and of its thermal expansion; `weather`: places of what all components share, without gravity;
    `titles`: what each law says, by the name of its residual."""

    first: Component
    names: tuple[str, ...]
    variables: dict[str, np.ndarray]
    seats: dict[str, tuple[np.ndarray, ...]]
    titles: dict[str, str]
    weather: dict[str, np.ndarray] | None

    def laws(self, values: np.ndarray, pulls: np.ndarray) -> Any:
        """Laws of the components for values (records, all) and pulls (3, records, ends)."""
        return self.first.laws(_Reading(self, values, pulls))


class _Reading:
    """What `Component.laws` reads: variables as arrays (records, components), seats with force and speed."""

    def __init__(self, kind: Kindred, values: np.ndarray, pulls: np.ndarray) -> None:
        self._kind, self._values, self._pulls = kind, values, pulls
        self.weather: SimpleNamespace | None = None
        if kind.weather is not None:
            self.weather = SimpleNamespace(**{n: values.take(place, axis=1) for n, place in kind.weather.items()})

    def __getattr__(self, name: str) -> Any:
        seat = self._kind.seats.get(name)
        if seat is not None:
            return _Seat(self._values, self._pulls, self.weather, *seat)
        place = self._kind.variables.get(name)
        if place is None:
            raise AttributeError(name)
        return self._values.take(place, axis=1)


class _Seat:
    """What `Component.laws` reads of a seat, when it is asked for."""

    def __init__(
        self, values: np.ndarray, pulls: np.ndarray, weather: Any, end: np.ndarray, speed: np.ndarray, *rope: np.ndarray
    ) -> None:
        self._values, self._pulls, self._weather = values, pulls, weather
        self._end, self._speed, self._rope = end, speed, rope

    @property
    def force(self) -> np.ndarray:
        return self._pulls.take(self._end, axis=2)

    @property
    def speed(self) -> np.ndarray:
        return self._values.take(self._speed, axis=1)

    @property
    def stretched(self) -> np.ndarray:
        """Stretched over unstretched length of the rope where it lies on a shoe."""
        size = tension(self.force)
        c1, c2, expansion = (self._values.take(c, axis=1) for c in self._rope)
        stretched = np.asarray(1.0 + size * (c1 + 2.0 / 3.0 * c2 * size))
        if self._weather is None:
            return stretched
        return stretched + expansion * (self._weather.temperature - self._weather.strung_temperature)


@dataclass(frozen=True, eq=False)
class CertificateLayout:
    """All places of a model. `kinds`: components with laws of their own; `others`: residuals that no law stands
    for; `free`: whether a support, run after run, is an idler or a drum that keeps its tension; `held`: place of what
    says that a load stands on it; `plain`: whether ropes hold no node; `weather`: None without."""

    spans: SpanPlaces
    kinds: tuple[Kindred, ...]
    others: np.ndarray
    free: np.ndarray
    held: np.ndarray
    supports: tuple[str, ...]
    plain: bool
    weather: WeatherPlaces | None


@kept_with_model
def layout_of(model: Model) -> CertificateLayout:
    """The places of a model. They follow from its structure and its names: the next model of both shares them."""
    names = (*model.system.components, *(name for table in model.tables.values() for name in table.names))
    known: tuple[tuple[str, ...], CertificateLayout] | None = model.structure.derived.get(_layout)
    if known is not None and known[0] == names:
        return known[1]
    layout = _layout(model)
    model.structure.derived[_layout] = (names, layout)
    return layout


def _layout(model: Model) -> CertificateLayout:
    places = _Places(model)
    kinds = _kinds(model, places)
    known = {f"{s.name}.closure_{axis}" for run in model.runs for s in run.spans for axis in "xyz"}
    with np.errstate(all="ignore"):  # only the names count
        for kind in kinds:
            found = kind.laws(places.declared, np.ones((3, 1, 2 * len(places.spans) + 1)))
            for residual in found:
                k = model.r.index.get(f"{kind.names[0]}.{residual}")
                text = residual if k is None else model.r.descriptions[k]
                kind.titles[residual] = f"{type(kind.first).__name__}: {text}"
            known.update(f"{name}.{residual}" for name in kind.names for residual in found)
    supports = [(run, k) for run in model.runs for k in range(len(run.nodes))]
    return CertificateLayout(
        spans=_span_places(model, places),
        kinds=kinds,
        others=np.array([i for i, name in enumerate(model.r.names) if name not in known], dtype=int),
        free=np.array([_is_free(model, run, k) for run, k in supports], dtype=bool),
        held=np.array([places(f"{run.nodes[k].name}.held") for run, k in supports], dtype=int),
        supports=tuple(run.nodes[k].name for run, k in supports),
        plain=all(f"{node.name}.{axis}" in model.p.index for run in model.runs for node in run.nodes for axis in "xyz"),
        weather=_weather_places(model, places) if model.weather else None,
    )


_WEATHER = ("temperature", "wind_pressure", "wind_from", "strung_temperature", "ice_thickness", "ice_density", "north")


def _weather_places(model: Model, places: _Places) -> WeatherPlaces:
    counts = [n for layout in model.layouts for n in layout.slots.count]
    rope = ("diameter", "thermal_expansion", "drag_coefficient")
    return WeatherPlaces(
        np.array([places(name) for name in _WEATHER]),
        np.array([[places(f"{span}.{name}") for span in places.spans] for name in rope], dtype=int),
        np.array(
            [
                [places(f"{name}.slot_drag[{j + 1}]") for name in places.spans]
                for j in range(int(np.max(counts, initial=0)))
            ],
            dtype=int,
        ).reshape(-1, len(places.spans)),
    )


class _Places:
    """Places of variables by their names; the last place holds a zero."""

    def __init__(self, model: Model) -> None:
        names = [name for kind in VECTORS for name in model.tables[kind].names]
        self.index = {name: i for i, name in enumerate(names)}
        self.none = len(names)
        self.declared = np.append(np.concatenate([model.tables[kind].values for kind in VECTORS]), 0.0)[None]
        self.spans = [span.name for run in model.runs for span in run.spans]

    def __call__(self, name: str) -> int:
        return self.index.get(name, self.none)


def _span_places(model: Model, places: _Places) -> SpanPlaces:
    def end(node: Node, seat: Seat) -> list[int]:
        """Places of `ENDS`."""
        beside = "" if seat.offset is None else f"{node.name}.{seat.offset}_"
        aside = [places(f"{beside}{name}") if beside else places.none for name in ("rope", "x", "z")]
        return [places(f"{node.name}.{seat.travel}"), *(places(f"{node.name}.{a}") for a in "xyz"), *aside]

    read, firsts = [], [0]
    for run in model.runs:
        for k, span in enumerate(run.spans):
            leaves = run.seats[0] if k == 0 else run.nodes[k].through(run.seats[k]) or run.seats[k]
            own = [places(f"{span.name}.{name}") for name in SPAN]
            read.append([*own, *end(run.nodes[k], leaves), *end(run.nodes[k + 1], run.seats[k + 1])])
        firsts.append(len(read))
    counts = np.array([n for layout in model.layouts for n in layout.slots.count], dtype=int)
    most = int(counts.max(initial=0))
    slots = [
        [[places(f"{name}.slot_{what}[{j + 1}]") for name in places.spans] for j in range(most)]
        for what in ("mass", "at", "ride", "empty")
    ]
    return SpanPlaces(
        names=tuple(places.spans),
        read=np.array(read, dtype=int).reshape(-1, len(SPAN) + 2 * len(ENDS)).T.copy(),
        slots=np.array(slots, dtype=int).reshape(4, most, len(places.spans)),
        slot_counts=counts,
        runs=tuple(firsts),
        gravity=places("gravity"),
        shoes=any(seat.offset for run in model.runs for node in run.nodes for seat in node.seats),
    )


def _kinds(model: Model, places: _Places) -> tuple[Kindred, ...]:
    """Components with laws, by their kind."""
    groups: dict[Any, list[Component]] = {}
    for c in model.system.components.values():
        if c.has_laws:
            groups.setdefault(c.form(Site(1.0, 1.0, weather=model.weather)), []).append(c)
    numbers = {name: k for k, name in enumerate(places.spans)}
    sits = {
        seat: numbers[span] + (len(numbers) if end == "b" else 0)
        for (span, end), seat in model.system.connections.items()
    }
    spans = {seat: span for (span, _), seat in model.system.connections.items()}
    speeds = drive_speeds(model.runs)
    owned: dict[str, set[str]] = {}
    for name in places.index:
        owned.setdefault(component_of(name), set()).add(name.rpartition(".")[2])
    found = []
    for group in groups.values():
        names = [c.name for c in group]
        first = group[0]
        seats = first.seats if isinstance(first, Node) else ()
        variables = {v: np.array([places(f"{name}.{v}") for name in names]) for v in owned.get(first.name, ())}
        variables["gravity"] = np.full(len(names), places.index["gravity"])
        found.append(
            Kindred(
                first,
                tuple(names),
                variables,
                {
                    seat.name: (
                        np.array([sits.get((name, seat.name), 2 * len(numbers)) for name in names]),
                        np.array([places(".".join(speeds.get((name, seat.name), ("", "")))) for name in names]),
                        *(
                            np.array([places(f"{spans.get((name, seat.name))}.{c}") for name in names])
                            for c in ("compliance", "construction", "thermal_expansion")
                        ),
                    )
                    for seat in seats
                },
                {},
                {n: np.full(len(names), places(n)) for n in _WEATHER} if model.weather else None,
            )
        )
    return tuple(found)


def _is_free(model: Model, run: Run, k: int) -> bool:
    """Whether tensions balance a support's travel."""
    node, seat = run.nodes[k], run.seats[k]
    if seat.travel is None or node.balance_at(seat) is None:
        return False
    return f"{node.name}.{seat.travel}" in model.z.index
