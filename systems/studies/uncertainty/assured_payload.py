"""The payload that is possible with a stated confidence, where the corridor is uncertain."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.errors import InputError
from ropeway.systems.interrupts import interruptible, users_code
from ropeway.systems.studies.skyline.payload.study import PayloadStudy
from ropeway.systems.studies.sweeps.sweep import sweep
from ropeway.systems.studies.sweeps.workers import Workers
from ropeway.systems.studies.uncertainty.uncertain import Uncertain

EVERYWHERE = "everywhere"
"""Row of the payload that is possible at every station."""


@checked
@interruptible
def assured_payload(
    study: Callable[..., PayloadStudy],
    inputs: Uncertain,
    *,
    confidence: float = 0.95,
    samples: int = 200,
    seed: int = 0,
    workers: Workers = None,
    progress: bool | None = None,
) -> pd.DataFrame:
    """The payload that an uncertain corridor can carry with a stated confidence.

    Parameters
    ----------
    study : callable
        A function of the inputs by name, which returns `rw.payload` at the same stations in each case.
    inputs : Uncertain
        Pretension, rope, carriage, heights of supports, ...
    confidence : float, default 0.95
        Share of the cases that can carry at least this payload.
    samples : int, default 200
        Cases, in a Latin hypercube.
    seed : int, default 0
        Of the random numbers.
    workers : int or dask.distributed.Client, optional
        As in `rw.sweep`.
    progress : bool, optional
        As in `rw.sweep`.

    Returns
    -------
    DataFrame
        A row a station, and "everywhere" for a turn that can hang at each of them. Columns: `payload` [kg], possible
        with the confidence; `at_least` [kg], its lower bound in view of the number of cases (of 95 %; 0 if there are
        too few); `median`;
        `limited_by`, the most frequent limit of the cases below the median; `failed` cases, which count as no payload.

    Raises
    ------
    InputError
        Too few cases for the confidence, other stations in another case, or no case that is solved.

    Examples
    --------
    >>> from dataclasses import replace
    >>> from scipy.stats import norm
    >>> def study(mass):
    ...     return rw.payload(replace(rig, carriage=rw.Carriage("carriage", mass=mass)), stations=[150.0])
    >>> inputs = rw.Uncertain({"mass": norm(450.0, 30.0)})
    >>> found = rw.assured_payload(study, inputs, confidence=0.8, samples=5, workers=1)
    >>> float(found.loc["everywhere", "median"] - found.loc["everywhere", "payload"]) > 0.0
    True
    """
    if not 0.5 <= confidence < 1.0:
        raise InputError(f"confidence is {confidence:g}", "Give a number from 0.5 to below 1")
    check.positive(samples, "assured_payload", "samples")
    if samples * (1.0 - confidence) < 1.0 - 1e-9:
        raise InputError(
            f"{samples} cases cannot show a confidence of {confidence:g}",
            f"Take at least {int(np.ceil(1.0 / (1.0 - confidence) - 1e-9))}",
        )
    table = sweep(_Payloads(study), inputs.cases(samples, seed=seed), workers=workers, progress=progress)
    failed = table["error"] != ""
    if failed.all():
        raise InputError(
            f"No case is solved: {table['message'].iloc[0]}", "Call the study with the means of its inputs"
        )
    stations = [c.removeprefix(_PAYLOAD) for c in table.columns if str(c).startswith(_PAYLOAD)]
    payloads = table[[_PAYLOAD + s for s in stations]].mask(failed, 0.0)
    limits = table[[_LIMIT + s for s in stations]]
    if payloads.isna().to_numpy().any():
        raise InputError("The study has other stations in another case", "Give rw.payload the same stations")
    least = payloads.to_numpy().argmin(axis=1)
    payloads[_PAYLOAD + EVERYWHERE] = payloads.min(axis=1)
    limits = limits.assign(**{_LIMIT + EVERYWHERE: limits.to_numpy()[np.arange(len(limits)), least]})
    rows = {
        key: {
            **_assured(payloads[_PAYLOAD + str(key)], limits[_LIMIT + str(key)], confidence),
            "failed": int(failed.sum()),
        }
        for key in (*stations, EVERYWHERE)
    }
    found = pd.DataFrame.from_dict(rows, orient="index")
    found.index = pd.Index([*map(float, stations), EVERYWHERE], name="station")
    found.attrs["units"] = {"payload": "kg", "at_least": "kg", "median": "kg"}
    return found


_PAYLOAD, _LIMIT = "payload at ", "limit at "


@dataclass(frozen=True)
class _Payloads:
    """The payloads of a study of the user's, by station."""

    study: Callable[..., PayloadStudy]

    def __call__(self, **case: Any) -> Mapping[str, float | str]:
        with users_code():
            frame = self.study(**case).frame
        rows = list(zip(frame["station"], frame["payload"], frame["limited_by"], strict=True))
        return {f"{_PAYLOAD}{s:.12g}": float(p) for s, p, _ in rows} | {f"{_LIMIT}{s:.12g}": by for s, _, by in rows}


def _assured(payload: pd.Series, limited_by: pd.Series, confidence: float) -> dict[str, float | str]:
    """What a share `confidence` of the cases can carry, without interpolation between cases."""
    from scipy.stats import binom

    ordered, count = np.sort(payload.to_numpy()), len(payload)
    # Of `count` cases fewer than `below` are under the true quantile with a probability of 5 %.
    below = int(binom.ppf(0.05, count, 1.0 - confidence))
    low = limited_by[payload <= payload.median()].dropna()
    return {
        "payload": float(ordered[int(count * (1.0 - confidence) + 1e-9) - 1]),
        "at_least": float(ordered[below - 1]) if below else 0.0,
        "median": float(np.median(ordered)),
        "limited_by": str(low.mode().iloc[0]) if len(low) else "",
    }
