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
        parts += [_frame(self._numbers)] if self._numbers else []
        found = pd.concat(parts) if len(parts) > 1 else parts[0] if parts else pd.DataFrame(columns=list(FAILURE))
        table = pd.concat([_rows(cases, there), _rows(found, there)], axis=1)
        order = [c for c in table.columns if c not in FAILURE] + list(FAILURE)
        if list(table.columns) != order:
            table = table[order]
        table.attrs["units"] = Labels(units)
        return table


def _rows(frame: pd.DataFrame, wanted: list[int]) -> pd.DataFrame:
    """Rows of a frame by their numbers; the frame itself where these are all, in order."""
    return frame if frame.index.tolist() == wanted else frame.loc[wanted]


def _frame(parts: Sequence[tuple[Sequence[int], NumberRows]]) -> pd.DataFrame:
    """Rows of numbers with their failures."""
    numbers = np.concatenate([rows.numbers for _, rows in parts])
    failures = [rows.failures.get(i) for _, rows in parts for i in range(len(rows.numbers))]
    # What all cases failed to find is no column.
    columns = list(parts[0][1].columns) if None in failures else []
    index = [case for cases, _ in parts for case in cases]
    frame = pd.DataFrame(numbers[:, : len(columns)], index=index, columns=columns)
    for k, name in enumerate(FAILURE):
        frame[name] = ["" if failure is None else failure[k] for failure in failures]
    return frame
