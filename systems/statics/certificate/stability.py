"""Whether the ropes of a line hold their places over its idlers: the condensed stiffness of all free travels.

Each span answers for itself: as a rope of compliance C (2, 2) in its vertical plane, its end tensions change with the
rope that runs over its two supports by -(1 + eps) u C^-1 u'. Their sum over a line is tridiagonal, and stable where
it is positive definite. Loads count as clamped to the rope, as they are once the line moves.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg.lapack import dpttrf

from ropeway.systems.statics.certificate.spans import Shape, Spans
from ropeway.systems.statics.certificate_layout import CertificateLayout


def _stiffness(spans: Spans, found: Shape) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """How the rope that runs over an end changes a span's balance there, (records, spans) [N/m]: at end a, at end b,
    and the square of how one end feels the other, all in terms of the strain potential."""
    h, w = np.sqrt(spans.horizontal2), spans.weight
    upwards, inverse = found.vertical / found.tension, 1.0 / found.tension
    # Compliance of the whole span: sums over the pieces between its loads.
    turned = -(upwards[0] + upwards[1]).sum(axis=1) / w
    shared = h * (inverse[1] - inverse[0]).sum(axis=1) / w
    elastic = spans.c1 * spans.length
    flat = elastic + np.maximum(found.angle.sum(axis=1) - turned, 0.0)
    upright = elastic + np.maximum(turned, 0.0)
    if spans.curved:
        more = _constructional(spans, found)
        flat, upright, shared = flat + more[0], upright + more[1], shared + more[2]
    # Directions of the rope at both ends, (2, records, spans).
    level, rise = np.empty((2, *h.shape)), np.empty((2, *h.shape))
    level[0], level[1] = inverse[0, :, 0], inverse[1, :, -1]
    level *= h
    rise[0] = upwards[0, :, 0]
    np.negative(upwards[1, :, -1], out=rise[1])
    tension = np.empty_like(level)
    tension[0], tension[1] = found.tension[0, :, 0], found.tension[1, :, -1]
    ahead, across = upright * level - shared * rise, flat * rise - shared * level
    det = flat * upright - shared * shared
    own = (ahead * level + across * rise) / det
    cross = (ahead[0] * level[1] + across[0] * rise[1]) / det
    stretch = 1.0 + tension * (spans.c1 + spans.c2 * tension if spans.curved else spans.c1)
    own *= stretch
    rise *= w
    return own[0] + rise[0], own[1] - rise[1], stretch[0] * stretch[1] * cross * cross


def _constructional(spans: Spans, found: Shape) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Integrals of c2 T (1 + u u) along the pieces, by Simpson's rule: a small part of the compliance."""
    h2 = spans.horizontal2[:, None]
    mid = 0.5 * (found.vertical[0] - found.vertical[1])
    v = np.stack((found.vertical[0], mid, -found.vertical[1]))
    t = np.sqrt(h2 + v * v)
    share = spans.c2[:, None] * found.piece / 6.0 * np.array([1.0, 4.0, 1.0])[:, None, None, None]
    flat, upright, shared = share * (t + h2 / t), share * (t + v * v / t), share * v / t
    return flat.sum(axis=(0, 2)), upright.sum(axis=(0, 2)), np.sqrt(spans.horizontal2) * shared.sum(axis=(0, 2))


def least_pivots(layout: CertificateLayout, values: np.ndarray, spans: Spans, found: Shape) -> tuple[float, int, int]:
    """The least pivot of the stiffness of all free travels, over its own diagonal: above 0 where it is positive
    definite. With it the first record where it is not, or that of the least one, and the support. inf without a free
    travel."""
    if not layout.free.any():
        return np.inf, 0, 0
    free = layout.free & ~(values.take(layout.held, axis=1) > 0.0)
    at_a, at_b, shared = _stiffness(spans, found)
    records, supports = free.shape
    diagonal, beside = np.zeros((records, supports)), np.zeros((records, supports))
    for r, first in enumerate(layout.spans.runs[:-1]):
        last = layout.spans.runs[r + 1]
        diagonal[:, first + r : last + r] += at_a[:, first:last]
        diagonal[:, first + r + 1 : last + r + 1] += at_b[:, first:last]
        beside[:, first + r : last + r] = shared[:, first:last]
    if not free.all():
        beside[:, :-1] *= free[:, :-1] & free[:, 1:]
        diagonal = np.where(free, diagonal, 1.0)
    # Over its diagonal the matrix has ones there: its pivots lie between 0 and 1. Records follow each other in one
    # matrix that does not couple them.
    beside[:, :-1] /= diagonal[:, :-1] * diagonal[:, 1:]
    off = np.sqrt(np.abs(beside)).ravel()[:-1]
    pivots, _, info = dpttrf(np.ones(records * supports), off)
    good = diagonal > 0.0
    worst = records * supports if good.all() else int(good.argmin())
    if info > 0:
        worst = min(worst, int(info) - 1)
    if worst < supports * records:
        return -1.0, *divmod(worst, supports)
    worst = int(pivots.argmin())
    return float(pivots[worst]), *divmod(worst, supports)
