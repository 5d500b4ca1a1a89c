"""Load cases of a line in a batch, against one equilibrium after the other: 12 environments and 4 loadings."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from functools import partial

from lines import driven

import ropeway as rw
from ropeway.systems.studies.load_cases.loadings import STANDARD, loaded

WEATHER = [
    rw.Environment(
        f"weather {k}", temperature=-25.0 + 5.0 * k, ice_thickness=0.001 * k, wind_pressure=30.0 * k, wind_from=30.0 * k
    )
    for k in range(12)
]


def main(spans: tuple[int, ...] = (24, 100), repeats: int = 5) -> None:
    """Prints the least times and their ratio."""
    for count in spans:
        line = driven(count)
        batch = min(_time(partial(rw.load_cases, line, WEATHER)) for _ in range(repeats))
        some = [(loading, weather) for loading in STANDARD for weather in WEATHER[::6]]
        single = _time(partial(_one_by_one, line, some)) * 48 / len(some)
        print(f"{count} spans: 48 cases {batch:.2f} s; one after the other {single:.1f} s, {single / batch:.0f} times")


def _one_by_one(line: rw.System, cases: Sequence[tuple[str, rw.Environment]]) -> None:
    for loading, weather in cases:
        rw.equilibrium(loaded(line, loading, {}), environment=weather)


def _time(call: Callable[[], object]) -> float:
    start = time.perf_counter()
    call()
    return time.perf_counter() - start


if __name__ == "__main__":
    main()
