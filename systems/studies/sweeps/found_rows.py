"""What the cases of a sweep came to: rows by name, or whole chunks of numbers of a line."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import pandas as pd

from ropeway.systems.results.column_labels import Labels
from ropeway.systems.studies.sweeps.journal import JournalRow

FAILURE = ("error", "message")
"""Columns that say how a case failed."""


@dataclass(frozen=True, eq=False)
class NumberRows:
    """Rows of numbers: `numbers` (rows, columns), NaN in those that failed, by row, with an error and a message."""

    columns: tuple[str, ...]
    numbers: np.ndarray
    failures: Mapping[int, tuple[str, str]] = field(default_factory=dict)

    def named(self) -> list[JournalRow]:
        """The rows by name; of one that failed only how."""
        return [
            dict(zip(FAILURE, self.failures[i], strict=True))
            if i in self.failures
            else {**dict(zip(self.columns, row, strict=True)), **dict.fromkeys(FAILURE, "")}
            for i, row in enumerate(self.numbers.tolist())
        ]


Rows = Sequence[JournalRow] | NumberRows


class FoundRows:
    """Rows of cases, by the number of the case, as they come in."""

    def __init__(self) -> None:
        self._named: dict[int, JournalRow] = {}
        self._numbers: list[tuple[Sequence[int], NumberRows]] = []
        self._cases: set[int] = set()

    def add(self, cases: Sequence[int], rows: Rows) -> None:
        """Takes the rows of some cases."""
        self._cases.update(cases)
        if isinstance(rows, NumberRows):
            self._numbers.append((cases, rows))
        else:
            self._named.update(zip(cases, rows, strict=True))

    def __len__(self) -> int:
        return len(self._cases)

    def __contains__(self, case: int) -> bool:
        return case in self._cases

    def table(self, cases: pd.DataFrame, units: Mapping[str, str]) -> pd.DataFrame:
        """The cases that have been found, with what they came to."""
        there = [i for i in cases.index if i in self._cases]
        parts = [pd.DataFrame(list(self._named.values()), index=list(self._named))] if self._named else []
        parts += [_frame(numbers, rows) for numbers, rows in self._numbers]
        found = pd.concat(parts).loc[there] if parts else pd.DataFrame(columns=list(FAILURE))
        table = pd.concat([cases.loc[there], found], axis=1)
        table = table[[c for c in table.columns if c not in FAILURE] + list(FAILURE)]
        table.attrs["units"] = Labels(units)
        return table


def _frame(cases: Sequence[int], rows: NumberRows) -> pd.DataFrame:
    # What all cases failed to find is no column.
    columns = [] if len(rows.failures) == len(rows.numbers) else list(rows.columns)
    frame = pd.DataFrame(rows.numbers[:, : len(columns)], index=list(cases), columns=columns)
    for k, name in enumerate(FAILURE):
        frame[name] = [rows.failures[i][k] if i in rows.failures else "" for i in range(len(rows.numbers))]
    return frame
