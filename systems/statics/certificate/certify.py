"""A certificate for every state that leaves a solver: an independent check, in NumPy, that it is an equilibrium.

It shares no code with the residuals that the solvers make zero. What it cannot know by itself, as the contact of a log
with the ground or a component that has no `laws`, it checks by the model's own residuals, evaluated afresh.
"""

from __future__ import annotations

import itertools
from collections.abc import Collection, Iterable, Mapping, Sequence

import numpy as np

from ropeway.components.variable import Kind
from ropeway.systems.modelling.dae_model import Model, component_of
from ropeway.systems.modelling.rope_path import Run
from ropeway.systems.solvers.newton import outputs_of, residuals_of
from ropeway.systems.solvers.points import Point
from ropeway.systems.solvers.state_rows import StateRows
from ropeway.systems.statics.certificate.checks import (
    CLOSURE,
    EQUATIONS,
    GIVEN,
    IN_SPAN,
    INSIDE,
    LAW,
    LEAST_ROPE,
    ON_ROPE,
    PLACE,
    ROPE,
    ROPE_SUM,
    SPANS_END,
    STABLE,
    UTILISATION,
    VALUES,
    Certificate,
    Check,
)
from ropeway.systems.statics.certificate.spans import (
    LoadsInSpans,
    Shape,
    Spans,
    closures,
    hung,
    pulls,
    read_spans,
    read_weather,
    shape,
    shape_in_weather,
)
from ropeway.systems.statics.certificate.stability import least_pivots
from ropeway.systems.statics.certificate_layout import CertificateLayout, layout_of
from ropeway.systems.statics.line_state import find
from ropeway.systems.statics.stability import free_balances, has_free_nodes, least_pivot

_BATCH = 200_000
"""Approximate number of values in one array of a batch of records: more take memory and save no time."""


def certify(
    model: Model,
    point: Point,
    runs: Sequence[Run],
    passed: Sequence[np.ndarray],
    *,
    given: Mapping[str, float] | None = None,
    rope: Sequence[float] = (),
    held: Collection[str] = (),
) -> Certificate:
    """The certificate of one state.

    Parameters
    ----------
    model
        The model that was solved.
    point
        The solved point.
    runs
        The runs with their loads.
    passed
        For each run the number of loads beyond each support, shape (supports,).
    given
        Values that variables or outputs must have, by name.
    rope
        For each run its unstretched length [m] as it must be; NaN, or none: it is not compared.
    held
        Names of places and travels that something else holds, as a carriage at a station ("carriage.x"): their
        balance need not be stable.

    Returns
    -------
    Certificate
        It raises nothing: `certificate.require(model)` does.
    """
    values = stacked(point)[None]
    checks = _checks(model, values, [point], runs, [beyond[None] for beyond in passed], rope, held)
    if given:
        checks.append(_given(model, point, runs, passed, given))
    return Certificate.worst(checks)


def certify_records(
    model: Model,
    runs: Sequence[Run],
    states: Iterable[tuple[Point, Sequence[np.ndarray]]],
    *,
    rope: Sequence[float] = (),
    held: Collection[str] | None = (),
) -> Certificate:
    """The worst of each check over many states of one model in order of time, each a solved point and the loads
    `passed` as in `certify`, `rope` too. A check that fails is that of the first state in which it does. held: as in
    `certify`, None for all: stability is judged elsewhere then."""
    states = iter(states)
    size = 256 if model.inertia is not None else _batch_size(layout_of(model))
    found: list[Check] = []
    first = 0
    while chunk := list(itertools.islice(states, size)):
        points = [point for point, _ in chunk]
        values = np.array([stacked(q) for q in points])
        beyond = [np.array([passed[r] for _, passed in chunk]) for r in range(len(runs))]
        checks = _checks(model, values, points, runs, beyond, rope, held)
        found += [check._replace(record=check.record + first) for check in checks]
        first += len(chunk)
    return Certificate.worst(found)


def certify_rows(model: Model, runs: Sequence[Run], batches: Iterable[StateRows]) -> Certificate:
    """As `certify_records`, of states that are rows, in batches."""
    found, first = list[Check](), 0
    for rows in batches:
        size = 256 if model.inertia is not None else _batch_size(layout_of(model))
        for a in range(0, len(rows), size):
            part = slice(a, a + size)
            values = rows.values[part]  # no frame
            passed = [beyond[part] for beyond in rows.passed]
            points = StateRows(model, values, rows.time[part], alike=rows.alike)
            checks = _checks(model, values, points, runs, passed, (), ())
            found += [check._replace(record=check.record + first + a) for check in checks]
        first += len(rows)
    return Certificate.worst(found)


def _batch_size(layout: CertificateLayout) -> int:
    """How many states are checked together."""
    return max(1, _BATCH // max(1, layout.spans.read.size + layout.spans.slots.size))


def certified_variants(
    model: Model,
    runs: Sequence[Run],
    states: StateRows,
    passed: Sequence[np.ndarray],
    masses: Sequence[np.ndarray],
) -> np.ndarray:
    """Which of many states of a line, each with loads of other `masses` (states, loads) in each run, hold every check,
    also that of the ropes' breaking load, (states,). `passed` as in `certify`, the same in all states."""
    good, size = np.zeros(len(states), dtype=bool), _batch_size(layout_of(model))
    left = [slice(a, min(a + size, len(good))) for a in range(0, len(good), size)]
    beyond = [p[None] for p in passed]
    while left:
        part = left.pop()
        rows = StateRows(model, states.values[part])
        checks = _checks(model, rows.values, rows, runs, beyond, (), (), [mass[part] for mass in masses])
        if all(check.holds for check in checks):
            good[part] = True
        elif len(rows) > 1:
            middle = (part.start + part.stop) // 2
            left += [slice(part.start, middle), slice(middle, part.stop)]
    return good


def stacked(point: Point) -> np.ndarray:
    """All vectors of a point, and the zero behind them that a layout counts on."""
    return np.concatenate((*point.vectors, (0.0,)))


def _checks(
    model: Model,
    values: np.ndarray,
    points: Sequence[Point],
    runs: Sequence[Run],
    passed: Sequence[np.ndarray],
    rope: Sequence[float],
    held: Collection[str] | None,
    masses: Sequence[np.ndarray] | None = None,
) -> list[Check]:
    if model.inertia is not None:
        return [_other_equations(model, np.arange(len(model.r)), points)]
    layout, checks = layout_of(model), []
    places = layout.spans
    gravity = values[:, places.gravity, None]
    with np.errstate(all="ignore"):  # what is not a number fails its check
        if places.names:
            alike = layout.weather is None and isinstance(points, StateRows) and points.alike
            spans = read_spans(places, values, gravity, alike=alike)
            loads = hung(places, values, spans, runs, passed, masses, weather=layout.weather is not None)
            found, ends = shape_of(layout, values, spans, loads, gravity)
            checks += _span_checks(layout, values, spans, loads, found, rope)
            pull = pulls(spans, found, ends)
        else:
            pull = np.zeros((3, len(values), 1))
        checks += _law_checks(layout, values, pull)
        if len(layout.others):
            checks.append(_other_equations(model, layout.others, points))
        if held is None:
            return checks
        quick = None
        # Where ropes move a node, as a wheel on its slide, this is a part of what a state needs: it serves for runs.
        serves = layout.plain or (len(points) > 1 and not has_free_nodes(model))
        if places.names and not held and serves and layout.weather is None:
            quick = least_pivots(layout, values, spans, found)
    return checks + _stability(model, layout, points, quick, held)


def shape_of(
    layout: CertificateLayout, values: np.ndarray, spans: Spans, loads: LoadsInSpans | None, gravity: np.ndarray
) -> tuple[Shape, np.ndarray | None]:
    """The catenaries, and in weather the tension vectors at their ends (records, 3, spans)."""
    if layout.weather is None:
        return shape(spans, loads, gravity), None
    weather = read_weather(layout.weather, values, spans, gravity)
    return shape_in_weather(spans, loads, weather, gravity)


def _stability(
    model: Model,
    layout: CertificateLayout,
    points: Sequence[Point],
    quick: tuple[float, int, int] | None,
    held: Collection[str],
) -> list[Check]:
    """By the condensed stiffness of plain lines; that of the whole model counts where ropes hold nodes, and where
    the first refuses a line that friction may hold."""
    if quick is not None and quick[0] > 0.0:
        return [Check(STABLE, quick[0], 0.0, layout.supports[quick[2]], quick[1], lower=True)]
    found = []
    for i, point in enumerate(points if quick is None else points[quick[1] : quick[1] + 1]):
        free = free_balances(model, point, held)
        if free:
            pivot, balance = least_pivot(model, point, free)
            name = component_of(model.z.names[balance.travel])
            found.append(Check(STABLE, pivot, 0.0, name, i if quick is None else quick[1], lower=True))
    return list(Certificate.worst(found).checks)


def _worst(name: str, misses: np.ndarray, limit: float, components: Sequence[str], *, lower: bool = False) -> Check:
    """The worst of misses (records, components): the largest in the first record that fails, else in all."""
    flat = int(misses.argmin() if lower else misses.argmax())  # both stop at the first that is not a number
    record, place = divmod(flat, misses.shape[1])
    check = Check(name, misses.item(flat), limit, components[place], record, lower)
    if len(misses) == 1 or check.holds:
        return check
    good = misses > limit if lower else misses <= limit
    record = int(np.argmax(~good.all(axis=1)))
    place = int(misses[record].argmin() if lower else misses[record].argmax())
    return Check(name, float(misses[record, place]), limit, components[place], record, lower)


def _span_checks(
    layout: CertificateLayout,
    values: np.ndarray,
    spans: Spans,
    loads: LoadsInSpans | None,
    found: Shape,
    rope: Sequence[float],
) -> list[Check]:
    places = layout.spans
    miss = closures(spans, found)
    size = spans.chord + 1e-5 * (np.abs(spans.length) + spans.coordinates)
    checks = [
        _worst(SPANS_END, miss / size, CLOSURE, places.names),
        _worst(LEAST_ROPE, spans.length / spans.chord, 0.0, places.names, lower=True),
        _worst(
            UTILISATION,
            found.tension.max(axis=(0, 2)) / spans.breaking_load,
            1.0,
            places.names,
        ),
    ]
    if loads is not None:
        checks += _load_checks(layout, values, spans, loads)
    if rope:
        wanted = np.asarray(rope)
        missing = np.abs(np.add.reduceat(spans.whole, places.runs[:-1], axis=1) - wanted) / wanted
        missing[:, np.isnan(wanted)] = 0.0
        checks.append(_worst(ROPE_SUM, missing, ROPE, [places.names[a] for a in places.runs[:-1]]))
    return checks


def _load_checks(layout: CertificateLayout, values: np.ndarray, spans: Spans, loads: LoadsInSpans) -> list[Check]:
    """The slots of the model hold the loads of the runs, and these hang within their spans."""
    places, used = layout.spans, loads.distance.shape[1]
    slots = values.take(places.slots[:, :used], axis=1)
    read = slots[:, 2] * spans.travel_a[:, None] + slots[:, 3] * spans.length[:, None]
    read += slots[:, 1]
    away = np.abs(read - loads.distance) * loads.there
    away[slots[:, 0] != loads.mass] = np.inf
    if layout.weather is not None and loads.drag is not None:
        away[values.take(layout.weather.drag[:used], axis=1) != loads.drag] = np.inf
    away, mean = away.max(axis=1), spans.chord.sum(axis=1)[:, None] / len(places.names)
    away /= mean
    lost = loads.lost
    if used < places.slots.shape[1]:
        lost = lost | (values.take(places.slots[0, used:], axis=1) != 0.0).any(axis=1)
    away[lost] = np.inf
    beyond = np.maximum(-loads.distance, loads.distance - spans.length[:, None])
    return [
        _worst(ON_ROPE, away, PLACE, places.names),
        _worst(IN_SPAN, beyond.max(axis=1) / mean, INSIDE, places.names),
    ]


def _law_checks(layout: CertificateLayout, values: np.ndarray, pull: np.ndarray) -> list[Check]:
    checks = []
    for kind in layout.kinds:
        for name, law in kind.laws(values, pull).items():
            miss, shape = np.abs(law.miss / law.size), (len(values), len(kind.names))
            if miss.shape != shape:
                miss = np.broadcast_to(miss, shape)
            checks.append(_worst(kind.titles[name], miss, LAW, kind.names))
    return checks


def _other_equations(model: Model, others: np.ndarray, points: Sequence[Point]) -> Check:
    """Residuals of numbers `others`, by their own values."""
    residuals = residuals_of(model)
    nominal = model.r.nominals[others]
    found = np.array([residuals(*point.arguments)[0][others] for point in points])
    names = [component_of(model.r.names[i]) for i in others]
    return _worst(EQUATIONS, np.abs(found) / nominal, LAW, names)


def _given(
    model: Model, point: Point, runs: Sequence[Run], passed: Sequence[np.ndarray], given: Mapping[str, float]
) -> Check:
    outputs, misses = outputs_of(model)(*point.arguments)[0], []
    for name, target in given.items():
        kind, k = find(model, runs, passed, name)
        value = outputs[k] if kind is Kind.OUTPUT else point.vector(kind)[k]
        misses.append(abs(value - target) / max(abs(target), model.tables[kind].nominals[k]))
    return _worst(VALUES, np.array([misses]), GIVEN, [component_of(name) for name in given])
