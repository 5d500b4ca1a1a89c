"""The time in which a transverse wave returns along a span: how a rigger measures tension with a stopwatch."""

from __future__ import annotations

import numpy as np
import pandas as pd

from ropeway.components.catenary import Strain
from ropeway.systems.studies.inertia.material_points import CutSpan, MaterialPoints

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(12)


def wave_return(cut: MaterialPoints) -> pd.DataFrame:
    """Times [s] in which a blow beside end a or b of each span returns from the nearest load, or the other end."""
    rows = {}
    for span in cut.spans:
        times = np.concatenate([[0.0], np.cumsum(_times(cut, span))])
        index = cut.model.p.index
        loaded = [i for i, piece in enumerate(span.pieces[1:], 1) if cut.point.p[index[f"{piece}.point.mass"]] > 0.0]
        first, last = (loaded[0], loaded[-1]) if loaded else (len(times) - 1, 0)
        rows[span.name] = (2.0 * times[first], 2.0 * (times[-1] - times[last]))
    frame = pd.DataFrame.from_dict(rows, "index", columns=["from_a", "from_b"]).rename_axis("span")
    frame.attrs["units"] = dict.fromkeys(frame.columns, "s")
    return frame


def _times(cut: MaterialPoints, span: CutSpan) -> np.ndarray:
    """Time of a transverse wave through each piece [s]: its unstretched speed is sqrt(T / (mu (1 + eps)))."""
    p, index, lengths = cut.point.p, cut.model.p.index, np.diff(span.station)
    mass, compliance = (p[index[f"{span.pieces[0]}.{name}"]] for name in ("mass_per_length", "compliance"))
    construction = p[index[f"{span.pieces[0]}.construction"]] if f"{span.pieces[0]}.construction" in index else 0.0
    level = np.hypot(span.force[:, 0, 0], span.force[:, 0, 1])
    share = 0.5 * (1.0 + _NODES)
    upright = span.force[:, 0, 2, None] + (span.force[:, 1, 2] - span.force[:, 0, 2])[:, None] * share
    tension = np.hypot(level[:, None], upright)
    stretched = 1.0 + Strain(compliance, construction).at(tension)
    return np.asarray(0.5 * lengths * (np.sqrt(mass * stretched / tension) @ _WEIGHTS))
