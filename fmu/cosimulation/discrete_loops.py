"""Algebraic loops of Booleans, integers and enumerations: solved by trial of their values."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from itertools import product
from math import prod

from ropeway.fmu.cosimulation.algebraic_loops import ambiguous, named
from ropeway.fmu.cosimulation.connections import Connection
from ropeway.fmu.errors import FmuRunError, FmuVariableError
from ropeway.fmu.importing.variable_types import Entry, Value

_TRIALS = 1024
"""Largest number of combinations that are tried; larger loops are iterated only."""


def solution(
    loop: Sequence[Connection],
    entries: Mapping[str, Entry],
    answer: Callable[[Mapping[str, Value]], Mapping[str, Value]],
    present: Mapping[str, Value],
    time: float,
) -> dict[str, Value]:
    """Values of the inputs of a loop that its outputs confirm; the `present` ones if trials decide nothing.

    `answer`: what the outputs would set instead of trial values. Raises FmuRunError if no values satisfy the loop, or
    more than one combination does.
    """
    targets = [c.target for c in loop]
    now = {target: present[target] for target in targets}
    numbers = [v for v in now.values() if not isinstance(v, bool | str | bytes)]
    choices = [_choices(entries[target], now[target], numbers) for target in targets]
    if prod(map(len, choices)) > _TRIALS:
        return now
    found = [
        trial for values in product(*choices) if _confirmed(trial := dict(zip(targets, values, strict=True)), answer)
    ]
    if len(found) > 1:
        raise ambiguous(loop, time)
    if not found and all(entries[target].kind in ("Boolean", "Enumeration") for target in targets):
        raise FmuRunError(
            f"No values satisfy the algebraic loop {named(loop)} at t = {time:.9g} s",
            "Open the loop, for example by an FMU that keeps the value of its last step",
            time=time,
        )
    return found[0] if found else now


def _choices(entry: Entry, now: Value, numbers: Sequence[float | int]) -> list[Value]:
    """All values of a Boolean or an enumeration; the present `numbers` of the loop, and another, of a number."""
    if entry.kind == "Boolean":
        return [False, True]
    if entry.kind == "Enumeration" and entry.items:
        return [*entry.items.values()]
    return [now] if isinstance(now, str | bytes) else [*dict.fromkeys([*numbers, max(numbers) + 1])]


def _confirmed(trial: Mapping[str, Value], answer: Callable[[Mapping[str, Value]], Mapping[str, Value]]) -> bool:
    try:
        return answer(trial) == trial
    except FmuVariableError:
        return False
    except FmuRunError as error:  # a slave rejects the values
        if error.fatal:
            raise
        return False
