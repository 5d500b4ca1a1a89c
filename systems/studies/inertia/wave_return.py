"""The time in which a transverse wave returns along a span: how a rigger measures tension with a stopwatch."""

from __future__ import annotations

import numpy as np
import pandas as pd

from ropeway.components.catenary import Strain
from ropeway.systems.studies.inertia.mass_matrix import rope_mass
from ropeway.systems.studies.inertia.material_points import CutSpan, MaterialPoints

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(12)


def wave_return(cut: MaterialPoints) -> pd.DataFrame:
    """Times [s] in which a blow beside end a or b of each span returns from the nearest load, or the other end."""
    rows = {}
    for span in cut.spans:
        times = np.concatenate([[0.0], np.cumsum(_times(cut, span))])
        loaded = [i for i, piece in enumerate(span.pieces[1:], 1) if cut.read(f"{piece}.point.mass") > 0.0]
        first, last = (loaded[0], loaded[-1]) if loaded else (len(times) - 1, 0)
        rows[span.name] = (2.0 * times[first], 2.0 * (times[-1] - times[last]))
    frame = pd.DataFrame.from_dict(rows, "index", columns=["from_a", "from_b"]).rename_axis("span")
    frame.attrs["units"] = dict.fromkeys(frame.columns, "s")
    return frame


def _times(cut: MaterialPoints, span: CutSpan) -> np.ndarray:
    """Time of a transverse wave through each piece [s]: its unstretched speed is sqrt(T / (mu (1 + eps)))."""
    lengths, mass = np.diff(span.station), rope_mass(cut, span.pieces[0])
    compliance, construction = (cut.read(f"{span.pieces[0]}.{name}", 0.0) for name in ("compliance", "construction"))
    share = 0.5 * (1.0 + _NODES)[:, None]
    tension = np.linalg.norm((1.0 - share) * span.force[:, None, 0] + share * span.force[:, None, 1], axis=2)
    stretched = 1.0 + Strain(compliance, construction).at(tension)
    return np.asarray(0.5 * lengths * (np.sqrt(mass * stretched / tension) @ _WEIGHTS))
