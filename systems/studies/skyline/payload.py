"""The largest payload along a corridor, and which limit governs where."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Unpack, cast

import numpy as np
import pandas as pd

from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.component import Node
from ropeway.components.errors import InputError
from ropeway.components.guyed_spar import GuyedSpar
from ropeway.components.intermediate_support import IntermediateSupport
from ropeway.components.rope import Rope
from ropeway.components.rounding import at_most
from ropeway.components.terrain import Profile
from ropeway.systems.interrupts import interruptible, keeping
from ropeway.systems.reporting.document import ReportOptions, style_of, write_report
from ropeway.systems.rigs.skyline_rig import RigKind, SkylineRig
from ropeway.systems.studies.skyline.carriage_model import Solved
from ropeway.systems.studies.skyline.load_path import rope_clearance, stations_of, units_of
from ropeway.systems.studies.skyline.payload_data import PayloadData, is_lowered
from ropeway.systems.studies.skyline.payload_search import LimitMargin, PayloadSearch

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@checked
@dataclass(frozen=True, eq=False)
class PayloadStudy(PayloadData):
    """The largest payload by station. `frame` has one row a station: station [m], payload [kg], limited_by,
    and the columns of `load_path` under that payload. A payload of 0 with limited_by is an answer: not even
    the empty carriage keeps that limit. "rest point": a running skyline's carriage would run back from there; "haulback
    tension": it carries no more however deep it hangs."""

    def __repr__(self) -> str:
        worst = self.limiting
        return (
            f"<PayloadStudy of {self.rig.name!r}: {at_most(self.payload)} kg, limited at {worst['station']:g} m by "
            f"{worst['limited_by']}{self._unhauled}>"
        )

    @property
    def _unhauled(self) -> str:
        count = len(self.not_hauled)
        return f", but not hauled at {count} of {len(self.frame)} stations" if count else ""

    def report(self, path: str | Path, **options: Unpack[ReportOptions]) -> Path:
        """Write the report of the study: payloads by station, supports, anchors, set-up.

        Parameters
        ----------
        path : str or Path
            HTML, or PDF by a browser's print; needs the extra `report`.
        **options
            `project`, `units`, `labels`, `more`, see `docs/reports.md`.

        Returns
        -------
        Path

        Raises
        ------
        InputError, WriteError
        """
        from ropeway.systems.studies.skyline.reporting.payload_report import sections_of

        style = style_of(options)
        return write_report(path, self.rig.name, sections_of(self, style), options)

    def plot(self) -> Figure:
        """The corridor to scale with the load path, the payload by station in the colour of the limit that
        governs, and the tensions against their safe working loads."""
        from ropeway.systems.studies.skyline.payload_plot import payload_figure

        return payload_figure(self)


@checked
@interruptible
def payload(
    rig: SkylineRig,
    *,
    safety_factor: float = 3.0,
    clearance: float | None = None,
    rope_clearance: float = 0.0,
    stations: Sequence[float] | np.ndarray | None = None,
    mainline_safety_factor: float | None = None,
    lift_off: bool = True,
) -> PayloadStudy:
    """The largest payload at `stations` [m] (by default about every 5 m) within all limits.

    safety_factor: minimum breaking load over highest tension, of the skyline, and of mainline, haulback, dropline
    and guylines unless mainline_safety_factor is given; clearance: of the load over the ground [m], of a log's
    front, as its rear may drag, and with it rope_clearance: of the loaded skyline itself, between headspar and
    tailspar [m]; lift_off: the skyline must stay in its saddles, a guyed spar on its foot; capacities of spars,
    supports and tailhold where they are known. A live, gravity or running skyline with a clearance is lowered at
    each station to just that clearance, or as low as its empty carriage goes, as far up as the rope itself needs; not
    with a log, which hangs as its dropline lets it. Raises InputError.
    """
    check.positive(safety_factor, rig.name, "safety_factor")
    others = safety_factor if mainline_safety_factor is None else mainline_safety_factor
    check.positive(others, rig.name, "mainline_safety_factor")
    if clearance is not None:
        check.number(clearance, rig.name, "clearance", "m")
        if rig.terrain is None:
            raise InputError(f"{rig.name} has no terrain to clear", "Give the rig a Profile, or leave clearance out")
    check.number(rope_clearance, rig.name, "rope_clearance", "m")
    where = stations_of(rig, stations)
    margins = margins_of(rig, safety_factor, others, (clearance, rope_clearance), lift_off)
    search = PayloadSearch(rig, margins, clearance if is_lowered(rig) else None, rope_clearance)
    rows: list[dict[str, Any]] = []

    def study() -> PayloadStudy:
        frame = pd.DataFrame(rows)
        frame.attrs["units"] = units_of(frame)
        return PayloadStudy(rig, frame, safety_factor, others, clearance)

    with keeping(lambda: study().frame):
        for x in where:
            rows.append(search.at(float(x)))
    return study()


def margins_of(
    rig: SkylineRig, safety_factor: float, others: float | None, clearances: tuple[float | None, float], lift_off: bool
) -> dict[str, LimitMargin]:
    """For each limit how far a loaded rig stays from it, in parts of the limit (of 10 m for clearances). others: safety
    factor of the ropes but the skyline, None: each its own."""

    def working_load(rope: Rope) -> float:
        return rope.breaking_load / (rope.safety_factor if others is None else others)

    def tension(column: str, limit: float) -> LimitMargin:
        return lambda r, s: 1.0 - r[column] / limit

    def capacity(stand: Node, limit: float) -> LimitMargin:
        return lambda r, s: 1.0 - carried(s, stand) / limit

    def pulled(span: str, limit: float) -> LimitMargin:
        return lambda r, s: 1.0 - max(s[f"{span}.tension_a"], s[f"{span}.tension_b"]) / limit

    def pressed(column: str) -> LimitMargin:
        return lambda r, s: r[column] / skyline

    def clear(limit: float) -> LimitMargin:
        ground = cast(Profile, rig.terrain)
        return lambda r, s: (rope_clearance(s, ground) - limit) / 10.0

    def standing(spar: GuyedSpar) -> LimitMargin:
        return lambda r, s: s[f"{spar.name}.compression"] / skyline

    skyline = rig.skyline.breaking_load / safety_factor
    sky = "haulback" if rig.kind is RigKind.RUNNING else "skyline"
    found: dict[str, LimitMargin] = {f"{sky} tension": tension("highest_tension", skyline)}
    if rig.mainline is not None:
        found["mainline tension"] = tension("mainline_highest", working_load(rig.mainline))
    if rig.haulback is not None and rig.kind is not RigKind.RUNNING:
        found["haulback tension"] = tension("haulback_highest", working_load(rig.haulback))
    if rig.turn is not None:
        found["dropline tension"] = tension("dropline_tension", working_load(rig.turn.dropline))
    block = rig.haulback_block
    if block is not None and block.capacity is not None:
        load, most = f"{block.name}.bearing_load", block.capacity
        found[f"capacity of {block.name}"] = lambda r, s: 1.0 - s[load] / most
    of_load, of_rope = clearances
    if of_load is not None and not is_lowered(rig):
        over = "clearance" if rig.turn is None else "front_clearance"
        found["clearance"] = lambda r, s: (r[over] - of_load) / 10.0
        found["rope clearance"] = clear(of_rope)
    for support in rig.supports:
        if lift_off:
            found[f"lift-off at {support.name}"] = pressed(f"{support.name}_force")
        if support.capacity is not None:
            found[f"capacity of {support.name}"] = capacity(support, support.capacity)
    for spar in (rig.headspar, rig.tailspar):
        if spar.capacity is not None:
            found[f"capacity of {spar.name}"] = capacity(spar, spar.capacity)
        if isinstance(spar, GuyedSpar):
            if lift_off:
                found[f"lift-off of {spar.name}"] = standing(spar)
            for guy in spar.guylines:
                found[f"guyline {guy.name}"] = pulled(f"{guy.name}_{spar.name}", working_load(guy.rope))
    hold = rig.tailspar.tailhold
    if hold is not None and hold.capacity is not None:
        found[f"capacity of {hold.name}"] = tension("anchor_tension", hold.capacity)
    return found


def carried(solved: Solved, stand: Node) -> float:
    """What a spar or support carries [N]: the resultant of all ropes at its top; the compression of a guyed spar; on
    a shoe the load on it and that of the mainline on its roller."""
    if isinstance(stand, GuyedSpar):
        return solved[f"{stand.name}.compression"]
    model = solved.at.model
    if isinstance(stand, IntermediateSupport) and stand.radius > 0.0:
        roller = f"{stand.name}_mainline.bearing_load"
        return solved[f"{stand.name}.bearing_load"] + (solved[roller] if roller in model.y.index else 0.0)
    total = np.zeros(3)
    for r, run in enumerate(model.runs):
        for k, node in enumerate(run.nodes):
            if node.at != stand.at:
                continue
            if k < len(run.spans):
                total += solved.at.curve(solved.point, k, r)
            if k > 0:
                total -= solved.at.curve(solved.point, k - 1, r)
                weight = run.rope.mass_per_length * solved.at.rig.gravity
                total[2] -= weight * solved[f"{run.spans[k - 1].name}.length"]
    return float(np.linalg.norm(total))
