"""Whether the ropes of a line hold their places over its idlers: the condensed stiffness of all free travels.

Each span answers for itself: as a rope of compliance C (2, 2) in its vertical plane, its end tensions change with the
rope that runs over its two supports by -(1 + eps) u C^-1 u'. Their sum over a line is tridiagonal, and stable where
it is positive definite. Loads count as clamped to the rope, as they are once the line moves.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg.lapack import dpttrf

from ropeway.systems.certificate_layout import CertificateLayout
from ropeway.systems.certificate_spans import Shape, Spans


def _stiffness(spans: Spans, found: Shape) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """How the rope that runs over an end changes a span's balance there, (records, spans) [N/m]: at end a, at end b,
    and the square of how one end feels the other, all in terms of the strain potential."""
    h2, w = spans.horizontal2, spans.weight
    h = np.sqrt(h2)
    u0, u1 = found.v0 / found.t0, found.v1 / found.t1
    # Compliance of the whole span: sums over the pieces between its loads.
    turned = ((u1 - u0).sum(axis=2)) / w
    shared = h * ((1.0 / found.t1 - 1.0 / found.t0).sum(axis=2)) / w
    elastic = spans.c1 * spans.length
    flat = elastic + np.maximum(found.angle.sum(axis=2) - turned, 0.0)
    upright = elastic + np.maximum(turned, 0.0)
    if spans.c2.any():
        h2_, piece = h2[:, :, None], found.piece
        # Integrals of c2 T (1 + u u) along the pieces, by Simpson's rule: a small part of the whole.
        mid_v = 0.5 * (found.v0 + found.v1)
        mid = np.sqrt(h2_ + mid_v * mid_v)
        share = spans.c2[:, :, None] * piece / 6.0
        weights = ((found.v0, found.t0, 1.0), (mid_v, mid, 4.0), (found.v1, found.t1, 1.0))
        flat = flat + sum((share * k * (t + h2_ / t)).sum(axis=2) for _, t, k in weights)
        upright = upright + sum((share * k * (t + v * v / t)).sum(axis=2) for v, t, k in weights)
        shared = shared + h * sum((share * k * v / t).sum(axis=2) for v, t, k in weights)
    det = flat * upright - shared * shared
    t_a, t_b = found.t0[:, :, 0], found.t1[:, :, -1]
    ha, va, hb, vb = h / t_a, u0[:, :, 0], h / t_b, u1[:, :, -1]
    own_a = (upright * ha * ha - 2.0 * shared * ha * va + flat * va * va) / det
    own_b = (upright * hb * hb - 2.0 * shared * hb * vb + flat * vb * vb) / det
    cross = (upright * ha * hb - shared * (ha * vb + va * hb) + flat * va * vb) / det
    stretch_a = 1.0 + t_a * (spans.c1 + spans.c2 * t_a)
    stretch_b = 1.0 + t_b * (spans.c1 + spans.c2 * t_b)
    return stretch_a * own_a + w * va, stretch_b * own_b - w * vb, stretch_a * stretch_b * cross * cross


def least_pivots(layout: CertificateLayout, values: np.ndarray, spans: Spans, found: Shape) -> tuple[float, int, int]:
    """The least pivot of the stiffness of all free travels, over its own diagonal: above 0 where it is positive
    definite. With it the first record where it is not, or that of the least one, and the support. inf without a free
    travel."""
    free = (layout.travels >= 0)[None] & ~(values[:, layout.held] > 0.0)
    if not free.any():
        return np.inf, 0, 0
    at_a, at_b, shared = _stiffness(spans, found)
    records, supports = free.shape
    diagonal, beside = np.zeros((records, supports)), np.zeros((records, supports))
    for r, first in enumerate(layout.spans.runs[:-1]):
        last = layout.spans.runs[r + 1]
        diagonal[:, first + r : last + r] += at_a[:, first:last]
        diagonal[:, first + r + 1 : last + r + 1] += at_b[:, first:last]
        beside[:, first + r : last + r] = shared[:, first:last]
    beside[:, :-1] *= free[:, :-1] & free[:, 1:]
    diagonal = np.where(free, diagonal, 1.0)
    # Over its diagonal the matrix has ones there: its pivots lie between 0 and 1. Records follow each other in one
    # matrix that does not couple them.
    beside[:, :-1] /= diagonal[:, :-1] * diagonal[:, 1:]
    bad = (free & ~(diagonal > 0.0)).ravel()
    off = np.sqrt(np.abs(beside)).ravel()[:-1]
    pivots, _, info = dpttrf(np.ones(records * supports), off)
    worst = int(np.argmax(bad)) if bad.any() else supports * records
    if info > 0:
        worst = min(worst, int(info) - 1)
    if worst < supports * records:
        return -1.0, *divmod(worst, supports)
    worst = int(np.argmin(pivots))
    return float(pivots[worst]), *divmod(worst, supports)
