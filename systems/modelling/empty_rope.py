"""The empty rope at rest over its supports: its length in each span.

At rest the tension is equal on both sides of each support, and along each span the strain potential increases by w
times the rise. The tension at every support therefore follows in closed form from the first one, and each span is a
small independent problem; all are solved in parallel.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from ropeway.components import parabola
from ropeway.components.catenary import Strain, norm, segment
from ropeway.components.errors import InputError, SlackRopeError
from ropeway.systems.modelling.complex_newton import jacobians_of, solve_side_by_side, solved_side_by_side

_LINEAR = 1e-7
"""Relative change of a rope's tension within which the lengths of its spans are linear in it, to rounding errors."""


_CLOSE = 1e-4
"""Relative step of a guess of the tension after which Newton's method on the spans alone is as fast."""


class _Taut(NamedTuple):
    """Spans of a taut rope.

    Lengths [m], shape (n,), and their derivatives by the tension at the first support [m/N]; `spans`, shape (n, 3):
    horizontal tension, vertical component at the start, length; `jacobians` (n, 3, 3) of their equations.
    """

    length: np.ndarray
    slope: np.ndarray
    spans: np.ndarray
    jacobians: np.ndarray


def lengths_for_tension(
    points: Sequence[Sequence[float]], weight: float, strain: Strain, tension: float, names: Sequence[str]
) -> np.ndarray:
    """Unstretched span lengths [m], shape (n,), for a tension [N] at the first of n + 1 support points.

    Taut branch. Raises SlackRopeError with the first span for which the tension is too low.
    """
    return _solve(np.array(points, dtype=float), weight, strain, tension, names).length


def lengths_for_total(
    points: Sequence[Sequence[float]], weight: float, strain: Strain, total: float, names: Sequence[str]
) -> np.ndarray:
    """Unstretched span lengths [m], shape (n,), that sum to `total`.

    If the rope is too slack for a taut branch, parabolas determine the lengths. Raises InputError if an inextensible
    rope is shorter than its chords.
    """
    at = np.array(points, dtype=float)
    chords = parabola.Chords.between(at)
    if strain.none and total <= chords.length.sum():
        raise InputError(
            f"The inextensible rope {names[0]} ... is {total:.6g} m long, its chords {chords.length.sum():.6g} m",
            "Give a longer rope or a finite axial stiffness",
        )
    if len(names) == 1:
        return np.array([total])
    reference, guess = _parabolic(at, weight, strain, total)
    try:
        lengths = _taut_for_total(at, weight, strain, total, names, reference)[1].length
    except SlackRopeError:
        lengths = guess
    return lengths * (total / lengths.sum())


def lengths_between(
    starts: np.ndarray, ends: np.ndarray, weight: float, strain: Strain, tension: float, height: float
) -> np.ndarray:
    """Unstretched lengths [m], shape (n,), of spans of empty ropes from `starts` to `ends` (n, 3). Each rope has a
    `tension` [N] at a point of z = `height` [m]. NaN without a taut branch."""
    both = np.stack([starts, ends], axis=1)
    chords = parabola.Chords(*(values[::2] for values in parabola.Chords.between(both.reshape(-1, 3))))
    level = strain.potential(tension) + weight * (both[:, :, 2] - height)
    taut = level.min(axis=1) > 0.0
    first, last = _with_potential(strain, np.where(taut[:, None], level, strain.potential(tension))).T
    found, bad = _span_roots(chords, weight, strain, (first, last))
    return np.where(taut & ~bad, found.length, np.nan)


class Pretension(NamedTuple):
    """Derivatives of an empty rope, in columns: by its tension at the first support [1/N], and at that tension by the
    strain per tension c1 [N] and by the weight [per N/m].

    Of the lengths of the spans (n, 3) [m], and of the tensions at all supports (n + 1, 3) [N].
    """

    length: np.ndarray
    support: np.ndarray


def pretension(
    points: Sequence[Sequence[float]], weight: float, strain: Strain, tension: float, names: Sequence[str]
) -> Pretension:
    """Derivatives of an empty rope with a tension [N] at its first support. Raises SlackRopeError."""
    at = np.array(points, dtype=float)
    chords, taut = parabola.Chords.between(at), _solve(at, weight, strain, tension, names)
    support = support_tensions(at, weight, strain, tension)
    lengths, supports = [], []
    for i, size in enumerate((tension, max(strain.c1, 1e-12), weight)):
        step = 1e-30 * size
        moved: list[complex] = [tension, strain.c1, weight]
        moved[i] += 1j * step
        law = Strain(moved[1], strain.c2)
        level = law.potential(moved[0]) + moved[2] * (at[:, 2] - at[0, 2])
        found = support - (law.potential(support) - level) / (1.0 + law.at(support))
        off = _residual(chords, moved[2], law, found[:-1], taut.spans)
        lengths.append(np.linalg.solve(taut.jacobians, -off.imag[:, :, None] / step)[:, 2, 0])
        supports.append(found.imag / step)
    return Pretension(np.array(lengths).T, np.array(supports).T)


def tension_for_total(
    points: Sequence[Sequence[float]], weight: float, strain: Strain, total: float, names: Sequence[str]
) -> float:
    """Tension [N] at the first support of an empty rope of unstretched length `total` [m].

    Raises SlackRopeError if the rope has no taut branch.
    """
    at = np.array(points, dtype=float)
    return _taut_for_total(at, weight, strain, total, names, _parabolic(at, weight, strain, total)[0])[0]


def _parabolic(at: np.ndarray, weight: float, strain: Strain, total: float) -> tuple[float, np.ndarray]:
    """Tension at the first support [N] and span lengths of an empty rope of length `total`, as parabolas."""
    chords = parabola.Chords.between(at)
    none = np.zeros((len(at) - 1, 1))
    share = chords.length * (total / chords.length.sum())
    beam = parabola.beam(chords, weight, share, none, none)
    group = np.zeros(len(at) - 1, dtype=int)
    reference = float(parabola.common_tension(chords, weight, beam, strain, np.array([total]), group)[0])
    return reference, parabola.rope_lengths(chords, beam, strain, parabola.tensions(chords, weight, beam, reference))


def _taut_for_total(
    at: np.ndarray, weight: float, strain: Strain, total: float, names: Sequence[str], reference: float
) -> tuple[float, _Taut]:
    """Tension at the first support [N] and spans of a taut empty rope of length `total`, from a guess of the tension.

    Raises SlackRopeError.
    """
    reference, spans = _nearer(at, weight, strain, total, reference)
    for _ in range(20):
        taut = _solve(at, weight, strain, reference, names, spans)
        step = (total - taut.length.sum()) / taut.slope.sum()
        if abs(step) <= _LINEAR * reference:
            return reference + step, taut._replace(length=taut.length + taut.slope * step)
        reference, spans = reference + step, taut.spans
    raise SlackRopeError(
        f"The empty rope {names[0]} ... is too long to hang taut between its supports",
        "Shorten it or raise the tension",
    )


def _nearer(
    at: np.ndarray, weight: float, strain: Strain, total: float, reference: float
) -> tuple[float, np.ndarray | None]:
    """A better guess of the tension, and of the spans: a few steps of Newton's method on all of them at once. The given
    guess and None where they do not converge."""
    chords, tension = parabola.Chords.between(at), reference
    spans: np.ndarray | None = None
    with np.errstate(all="ignore"):
        for _ in range(6):
            try:
                support = support_tensions(at, weight, strain, tension)
                mean = (support[:-1] + support[1:]) / 2.0
                spans = _straight(chords, weight, strain, mean) if spans is None else spans
                residual = partial(_residual, chords, weight, strain, support[:-1])
                sides = np.zeros((len(spans), 3, 2))
                sides[:, :, 0] = -residual(spans)
                sides[:, 2, 1] = _gain(strain, tension, support) / support[:-1]
                moves = np.linalg.solve(jacobians_of(residual, spans), sides)
            except (SlackRopeError, np.linalg.LinAlgError):
                break
            step = (total - spans[:, 2].sum() - moves[:, 2, 0].sum()) / moves[:, 2, 1].sum()
            if not abs(step) < 0.1 * tension:
                break
            spans, tension = spans + moves[:, :, 0] + moves[:, :, 1] * step, float(tension + step)
            if abs(step) <= _CLOSE * tension:
                return tension, spans
    return reference, None


def _gain(strain: Strain, tension: float, support: np.ndarray) -> np.ndarray:
    """Derivative of the tensions at the spans' starts by that at the first support: the potential increases equally."""
    return np.asarray((1.0 + strain.at(tension)) / (1.0 + strain.at(support[:-1])))


def _straight(chords: parabola.Chords, weight: float, strain: Strain, mean: np.ndarray) -> np.ndarray:
    """Initial guess of the spans' unknowns from their mean tensions [N]."""
    cosine, sine = chords.horizontal / chords.length, chords.rise / chords.length
    length = chords.length / (1.0 + strain.at(mean))
    return np.column_stack([mean * cosine, mean * sine - weight * chords.length / 2.0, length])


def support_tensions(at: np.ndarray, weight: float, strain: Strain, tension: float) -> np.ndarray:
    """Tension of the empty rope at each of the support points (n, 3) for a tension [N] at the first.

    Raises SlackRopeError if one is not positive.
    """
    level = strain.potential(tension) + weight * (at[:, 2] - at[0, 2])
    if level.min() <= 0.0:
        raise SlackRopeError(
            f"With {tension:.6g} N at the first support the tension is zero at support {int(np.argmin(level)) + 1}, "
            f"{at[0, 2] - at[int(np.argmin(level)), 2]:.6g} m below it",
            "Raise the tension",
        )
    return _with_potential(strain, level)


def _with_potential(strain: Strain, level: np.ndarray) -> np.ndarray:
    """Tensions of given strain potentials above zero [N]."""
    support = level.copy()
    for _ in range(30):
        before = support
        support = before - (strain.potential(before) - level) / (1.0 + strain.at(before))
        if (support == before).all():
            break
    return np.asarray(support)


def _solve(
    at: np.ndarray,
    weight: float,
    strain: Strain,
    tension: float,
    names: Sequence[str],
    spans: np.ndarray | None = None,
) -> _Taut:
    """All spans between points `at` (n + 1, 3), from a guess of their unknowns. Raises SlackRopeError."""
    chords, support = parabola.Chords.between(at), support_tensions(at, weight, strain, tension)
    found, bad = _span_roots(chords, weight, strain, (support[:-1], support[1:]), spans)
    if bad.any():
        k = int(np.argmax(bad))
        raise SlackRopeError(
            f"{support[k]:.6g} N at {names[k]!r} is too low for the weight of the rope in that span",
            "Raise the tension or add a support",
        )
    return found._replace(slope=found.slope * _gain(strain, tension, support))


def _span_roots(
    chords: parabola.Chords,
    weight: float,
    strain: Strain,
    support: tuple[np.ndarray, np.ndarray],
    spans: np.ndarray | None = None,
) -> tuple[_Taut, np.ndarray]:
    """Independent spans by Newton's method on (horizontal tension, vertical component at the start, length), and which
    have no taut root, (n,). `support`: tensions at their starts and ends, (n,) each; the slopes are by those at the
    starts; `spans`: a guess of the unknowns."""
    first, last = support
    mean = (first + last) / 2.0
    start = _straight(chords, weight, strain, mean) if spans is None else spans
    residual = partial(_residual, chords, weight, strain, first)

    def relative_step(u: np.ndarray, move: np.ndarray) -> np.ndarray:
        return np.maximum(np.abs(move[:, 2]) / u[:, 2], np.abs(move[:, :2]).max(axis=1) / mean)

    roots = solve_side_by_side(residual, start, relative_step, longest=0.3)
    unknown, error = roots.unknowns, np.abs(residual(roots.unknowns)).max(axis=1)
    with np.errstate(all="ignore"):
        by_tension = np.zeros((len(first), 3))
        by_tension[:, 2] = 1.0 / first
        slope = solved_side_by_side(roots.jacobians, by_tension)[:, 2]
    bad = ~(error < 1e-10) | ~(unknown[:, 2] > 0.0) | ~(slope < 0.0)
    return _Taut(unknown[:, 2], slope, unknown, roots.jacobians), bad


def _residual(
    chords: parabola.Chords, weight: complex, strain: Strain, support: np.ndarray, u: np.ndarray
) -> np.ndarray:
    """Residuals (..., n, 3) of the spans' unknowns, from the tensions (n,) at their starts."""
    force = (u[..., 0], np.zeros_like(u[..., 0]), u[..., 1])
    piece = segment(force, weight, u[..., 2], strain)
    return np.stack(
        [
            (piece.reach[0] - chords.horizontal) / chords.length,
            (piece.reach[2] - chords.rise) / chords.length,
            norm(force) / support - 1.0,
        ],
        axis=-1,
    )
