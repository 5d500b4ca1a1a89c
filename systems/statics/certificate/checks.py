"""The checks of a certificate, and what they say together."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import pandas as pd

from ropeway.components.errors import EquilibriumError
from ropeway.systems.modelling.dae_model import Model

CLOSURE = 1e-9
"""Largest distance of a span's end from its support, over its chord. A hundred-thousandth of its rope and of its
coordinates counts as chord too, for rounding."""
PLACE = 1e-9
"""Largest distance of a load from its place on the rope, over the mean span."""
INSIDE = 1e-8
"""Largest distance of a load that stands on a support beyond it, over the mean span."""
ROPE = 1e-9
"""Largest error of a rope's length, relative."""
LAW = 1e-8
"""Largest residual of a balance of forces, over their sizes, and of a component's law."""
GIVEN = 1e-8
"""Largest error of a given value, over its size or its nominal."""

SPANS_END = "distance of a span's end from its support over its chord"
LEAST_ROPE = "least rope in a span over its chord"
ON_ROPE = "distance of a load from its place on the rope over the mean span"
IN_SPAN = "distance of a load beyond its span over the mean span"
ROPE_SUM = "rope missing from a run over its length"
STABLE = "least pivot of the stiffness of free travels"
EQUATIONS = "other equations over their nominals"
UTILISATION = "highest tension over minimum breaking load"
VALUES = "distance from a given value over its size"


class Check(NamedTuple):
    """One check: its worst `value`, its `limit`, and the `component` and `record` where it is worst. The value is at
    most the limit; of `lower` limits it is above it."""

    name: str
    value: float
    limit: float
    component: str
    record: int = 0
    lower: bool = False

    @property
    def holds(self) -> bool:
        """Whether it is met; a value that is not a number is not."""
        return self.value > self.limit if self.lower else self.value <= self.limit

    def worse_than(self, other: Check) -> bool:
        """Whether this one is to be reported of two of a name: the first that fails, else the worst."""
        if not (self.holds and other.holds):
            return other.holds or (not self.holds and self.record < other.record)
        return self.value < other.value if self.lower else self.value > other.value


@dataclass(frozen=True)
class Certificate:
    """The checks of a state, or the worst of each over many records. `utilisation`: the highest tension over its
    minimum breaking load, which is no check: such a state is an equilibrium, if a rope bears it."""

    checks: tuple[Check, ...]
    utilisation: Check | None = None

    @property
    def failed(self) -> Check | None:
        """The failed check of the first record in which one failed, None where all hold."""
        return min((c for c in self.checks if not c.holds), key=lambda c: c.record, default=None)

    @property
    def frame(self) -> pd.DataFrame:
        """The checks: index check; columns value, limit, holds, component where it is worst. A value is at most its
        limit; of the checks that begin with "least" it is above it."""
        table = pd.DataFrame(
            {
                "check": [c.name for c in self.checks],
                "value": [c.value for c in self.checks],
                "limit": [c.limit for c in self.checks],
                "holds": [c.holds for c in self.checks],
                "component": [c.component for c in self.checks],
            }
        )
        return table.set_index("check")

    def require(self, model: Model) -> None:
        """Raises EquilibriumError that names the check which failed."""
        check = self.failed
        if check is None:
            return
        if check.name == STABLE:
            raise EquilibriumError(
                f"The balance of the rope over {check.component!r} is unstable: it would run into one of the spans",
                "The rope is too slack: shorten it or raise the tension",
                check.component,
            )
        if check.name == LEAST_ROPE:
            raise EquilibriumError(
                f"No rope is left in span {check.component!r}", "Give the run more rope", check.component
            )
        raise EquilibriumError(
            f"The solution found for {model.name!r} fails its check: {check.name} is {check.value:.3g} at "
            f"{check.component!r}, the limit is {check.limit:g}",
            "Start from a nearby equilibrium with start=, or change lengths, tensions or loads a little",
            check.component,
        )

    def numbered(self, records: Sequence[int]) -> Certificate:
        """The same, with other numbers for the records."""
        checks = tuple(check._replace(record=records[check.record]) for check in self.checks)
        used = self.utilisation
        return Certificate(checks, None if used is None else used._replace(record=records[used.record]))

    def and_also(self, other: Certificate) -> Certificate:
        """The worst of each check of two certificates."""
        every = (*self.checks, *other.checks, *(c for c in (self.utilisation, other.utilisation) if c is not None))
        return Certificate.worst(every)

    @classmethod
    def worst(cls, checks: Iterable[Check]) -> Certificate:
        """Of the checks of each name the worst, or the first that failed."""
        found: dict[str, Check] = {}
        for check in checks:
            known = found.get(check.name)
            if known is None or check.worse_than(known):
                found[check.name] = check
        used = found.pop(UTILISATION, None)
        return cls(tuple(found.values()), used)
