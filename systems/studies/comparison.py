"""Variants side by side: a table of what matters, and a picture."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from ropeway.components.argument_checks import checked
from ropeway.components.errors import InputError
from ropeway.components.notebook_figure import new_figure
from ropeway.components.table_writer import Tabular
from ropeway.systems.dynamics.result import Result
from ropeway.systems.results.energy_balance import power
from ropeway.systems.rigs.skyline_rig import SkylineRig
from ropeway.systems.studies.skyline.payload.study import PayloadStudy, payload

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_COLOURS = ("tab:blue", "tab:orange", "tab:green", "tab:red", "tab:purple", "tab:brown", "tab:pink", "tab:olive")
_MOST = len(_COLOURS)
"""Most variants with a curve of their own."""
_UNITS = {
    "payload": "kg", "at_station": "m", "highest_tension": "N", "mainline_highest": "N", "lowest_clearance": "m",
    "support_heights": "m", "skyline_length": "m", "pretension": "N", "duration": "s", "lowest_tension": "N",
    "share_of_SWL": "1", "energy": "J", "highest_power": "W",
}  # fmt: skip


@checked
@dataclass(frozen=True, eq=False)
class Comparison(Tabular):
    """Variants side by side, as `rw.compare` returns them.

    Parameters
    ----------
    variants : tuple of PayloadStudy or Result
        All of one kind.
    frame : DataFrame
        A row for each variant, index variant.

    Examples
    --------
    >>> studies = [rw.payload(rig, stations=[150.0], clearance=c) for c in (1.0, 4.0)]
    >>> rw.compare(*studies, names=["low", "high"]).frame[["payload", "limited_by"]].shape
    (2, 2)
    """

    variants: tuple[PayloadStudy | Result, ...]
    frame: pd.DataFrame

    def __repr__(self) -> str:
        return f"<Comparison of {len(self.variants)} variants: {', '.join(map(str, self.frame.index[:6]))}>"

    def plot(self) -> Figure:
        """The variants in one picture: payloads by station, or highest tensions over time.

        Returns
        -------
        matplotlib.figure.Figure
            With the first eight variants.
        """
        from ropeway.systems.studies.skyline.payload.plot import shown_up_to

        figure = new_figure(figsize=(10.0, 4.6), layout="constrained")
        axis = figure.subplots()
        for name, one, colour in zip(self.frame.index, self.variants, _COLOURS, strict=False):
            if isinstance(one, PayloadStudy):
                axis.plot(one.frame["station"], one.frame["payload"] / 1e3, color=colour, label=str(name))
                axis.axhline(one.payload / 1e3, color=colour, lw=0.8, ls="--")
            else:
                highest = one.frame.filter(regex=r"\.tension_[ab]$").max(axis=1) / 1e3
                axis.plot(highest.index, highest, color=colour, label=str(name))
        payloads = isinstance(self.variants[0], PayloadStudy)
        axis.set(
            xlabel="station [m]" if payloads else "time [s]",
            ylabel="largest payload [t]" if payloads else "highest tension [kN]",
        )
        if payloads:
            axis.set_ylim(0.0, max(shown_up_to(one) for one in self.variants if isinstance(one, PayloadStudy)))
        axis.grid(alpha=0.3)
        axis.legend(fontsize="small")
        return figure


@checked
def compare(
    *variants: SkylineRig | PayloadStudy | Result, names: Sequence[str] | None = None, safety_factor: float = 3.0,
    clearance: float | None = None,
) -> Comparison:  # fmt: skip
    """Compare variants side by side.

    Parameters
    ----------
    *variants : SkylineRig, PayloadStudy or Result
        Two or more of one kind; rigs are studied by `rw.payload` first.
    names : sequence of str, optional
        Of the variants; by default those of their rigs or lines, numbered where they are equal.
    safety_factor : float, default 3.0
        Of `rw.payload`, for rigs.
    clearance : float, optional
        Of `rw.payload`, for rigs, in metres.

    Returns
    -------
    Comparison

    Raises
    ------
    InputError
        Fewer than two variants, variants of different kinds, or names that do not fit.

    Examples
    --------
    >>> def study(tension):
    ...     rig = rw.standing_skyline(
    ...         None, headspar=rw.HeadSpar("head", at=(0.0, 15.0)), tailspar=rw.TailSpar("tail", at=(300.0, -20.0)),
    ...         skyline="RHOL-IWRC 29", tension=tension, carriage=rw.Carriage("carriage", mass=450.0),
    ...     )
    ...     return rw.payload(rig, stations=[150.0])
    >>> rw.compare(study(60e3), study(70e3), names=["60 kN", "70 kN"]).frame["at_station"].tolist()
    [150.0, 150.0]
    """
    if len(variants) < 2:
        raise InputError(f"compare has {len(variants)} variants", "Give two or more")
    found: tuple[Any, ...] = tuple(
        payload(v, safety_factor=safety_factor, clearance=clearance) if isinstance(v, SkylineRig) else v
        for v in variants
    )
    row: Callable[[Any], dict[str, Any]]
    if all(isinstance(v, PayloadStudy) for v in found):
        row = _payload_row
    elif all(isinstance(v, Result) for v in found):
        row = _result_row
    else:
        raise InputError("The variants are of different kinds", "Compare rigs with payload studies, or runs with runs")
    chosen = _names(found) if names is None else list(names)
    if len(chosen) != len(found) or len(set(chosen)) != len(chosen):
        raise InputError(f"compare has {len(found)} variants and names {chosen}", "Give each a name of its own")
    frame = pd.DataFrame([row(one) for one in found], index=pd.Index(chosen, name="variant"))
    frame.attrs["units"] = {column: _UNITS.get(column, "") for column in frame.columns}
    return Comparison(found, frame)


def _names(found: Sequence[Any]) -> list[str]:
    own = [one.rig.name if isinstance(one, PayloadStudy) else one.model.name for one in found]
    return [name if own.count(name) == 1 else f"{name} {k}" for k, name in enumerate(own, 1)]


def _payload_row(study: PayloadStudy) -> dict[str, Any]:
    rig, worst = study.rig, study.limiting
    columns = {c: study.frame[c] for c in ("mainline_highest", "clearance") if c in study.frame}
    return {
        "payload": study.payload,
        "at_station": float(worst["station"]),
        "limited_by": str(worst["limited_by"]),
        "hauled": study.hauled,
        "highest_tension": float(study.frame["highest_tension"].max()),
        "mainline_highest": float(columns["mainline_highest"].max()) if "mainline_highest" in columns else np.nan,
        "lowest_clearance": float(columns["clearance"].min()) if "clearance" in columns else np.nan,
        "supports": len(rig.supports),
        "support_heights": float(sum(s.height or 0.0 for s in rig.supports)),
        "skyline_length": np.nan if rig.length is None else rig.length,
        "pretension": np.nan if rig.tension is None else rig.tension,
    }


def _result_row(result: Result) -> dict[str, Any]:
    spans, drives = result.summary().spans, power(result)
    return {
        "duration": float(result.times[-1]),
        "highest_tension": float(spans["highest_tension"].max()),
        "in_span": str(spans["highest_tension"].idxmax()),
        "share_of_SWL": float(spans["over_SWL"].max()),
        "lowest_tension": float(spans["lowest_tension"].min()),
        "energy": float(drives.loc["line", "pulled"]) if len(drives) else np.nan,
        "highest_power": float(drives["highest"].max()) if len(drives) else np.nan,
        "events": len(result.events),
    }
