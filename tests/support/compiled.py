"""What a run in the compiled core has in common with the same run by IDAS."""

from __future__ import annotations

import numpy as np
import pandas as pd

import ropeway as rw

TENSION, TIME = 1e-6, 1e-6
"""Relative difference of tensions, and difference of an event's time [s]."""


def require_alike(compiled: rw.Result, integrated: rw.Result) -> None:
    """The same events, and the same tensions at all times of the grid that are no event's."""
    one, other = (_events(result) for result in (compiled, integrated))
    assert list(one.index) == list(other.index)
    assert np.abs(one.to_numpy() - other.to_numpy()).max(initial=0.0) <= TIME
    frames = [result.frame.filter(regex=r"\.tension_(in|out|a|b)$") for result in (compiled, integrated)]
    assert len(frames[0]) == len(frames[1])
    times = np.array([event.time for event in integrated.noted])
    apart = np.array([np.abs(times - t).min(initial=np.inf) > 10.0 * TIME for t in frames[1].index])
    difference = np.abs(frames[0].to_numpy() / frames[1].to_numpy() - 1.0)[apart]
    assert difference.max(initial=0.0) <= TENSION


def _events(result: rw.Result) -> pd.Series:
    """Times of all events of loads and drives, by what happened and in order of time."""
    rows = sorted((e.component, e.event, e.load, e.time) for e in result.noted)
    return pd.Series([row[3] for row in rows], index=[row[:3] for row in rows], dtype=float)
