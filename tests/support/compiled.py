"""What a run or a study in compiled code has in common with the same one without."""

from __future__ import annotations

import numpy as np
import pandas as pd

import ropeway as rw

TENSION, TIME, SAME = 1e-6, 1e-6, 1e-9
"""Relative difference of tensions, difference of an event's time [s], and relative difference in a table."""


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


def require_same_table(compiled: pd.DataFrame, plain: pd.DataFrame, tolerance: float = SAME) -> None:
    """The same words, and the same numbers relative to the largest of each column and one unit."""
    assert list(compiled.columns) == list(plain.columns)
    numbers = plain.select_dtypes(float).columns
    pd.testing.assert_frame_equal(
        compiled.drop(columns=numbers).reset_index(drop=True), plain.drop(columns=numbers).reset_index(drop=True)
    )
    one, other = compiled[numbers].to_numpy(), plain[numbers].to_numpy()
    np.testing.assert_array_equal(np.isfinite(one), np.isfinite(other))
    size = np.nanmax(np.where(np.isfinite(other), np.abs(other), 1.0), axis=0, initial=1.0)
    assert np.nanmax(np.where(np.isfinite(other), np.abs(one - other) / size, 0.0), initial=0.0) <= tolerance


def _events(result: rw.Result) -> pd.Series:
    """Times of all events of loads and drives, by what happened and in order of time."""
    rows = sorted((e.component, e.event, e.load, e.time) for e in result.noted)
    return pd.Series([row[3] for row in rows], index=[row[:3] for row in rows], dtype=float)
