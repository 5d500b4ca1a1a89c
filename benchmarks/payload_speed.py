"""Speed of exact payloads: 100,000 in one sweep over slope, deflection and station.

    python benchmarks/payload_speed.py

Harvey (2013) reports 32 us for one catenary parameter (the improved rigid link, MATLAB) and about 0.5 s for the longest
catenary over a profile; he concluded that catenary methods cost 16,000 times more. Times are the best of five.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

from ropeway.systems.studies.handbook.kendrick import kendrick_iteration
from ropeway.systems.studies.handbook.loaded_span import LoadedSpan
from ropeway.systems.studies.handbook.longest_rope import longest_rope
from ropeway.systems.studies.handbook.payload_exact import catenary_clamped
from ropeway.systems.studies.handbook.payload_methods import METHODS

HARVEY_PARAMETER = 32e-6
HARVEY_LONGEST = 0.5
WEIGHT, TENSION = 3.48, 19600.0


def sweep(count: int = 100_000) -> LoadedSpan:
    """Slopes 0-60 %, deflections 3-20 %, carriage at 10-90 %: at least `count` spans of 200 m."""
    n = int(np.ceil(count ** (1.0 / 3.0)))
    slopes, shares, places = np.meshgrid(
        np.linspace(0.0, 0.6, n), np.linspace(0.03, 0.2, n), np.linspace(0.1, 0.9, n), indexing="ij"
    )
    return LoadedSpan(200.0, 200.0 * shares.ravel(), slopes.ravel(), places.ravel())


def best(function: Callable[[], object], repeat: int = 5) -> float:
    """Shortest time of several runs [s]."""
    times = []
    for _ in range(repeat):
        start = time.perf_counter()
        function()
        times.append(time.perf_counter() - start)
    return min(times)


def terrain(points: int) -> tuple[np.ndarray, np.ndarray]:
    """A valley of 300 m."""
    x = np.linspace(0.0, 300.0, points)
    return x, -45.0 - 0.15 * x + 6.0 * np.sin(x / 17.0) + 25.0 * np.abs(x / 150.0 - 1.0)


def main() -> None:
    line = sweep()
    count = np.asarray(line.deflection).size
    print(f"{count} spans at once{'':25s} {'total s':>9} {'us each':>9} {'Harvey 32 us over it':>21}")
    for name, method in METHODS.items():
        seconds = best(lambda method=method: method(line, WEIGHT, TENSION))  # type: ignore[misc]
        print(f"  {name:40s} {seconds:9.4f} {1e6 * seconds / count:9.3f} {HARVEY_PARAMETER * count / seconds:21.0f}")
    one = LoadedSpan(200.0, 25.0, 0.1)
    print("\nOne at a time")
    seconds = best(lambda: catenary_clamped(one, WEIGHT, TENSION), 200)
    print(f"  {'exact loaded catenary':40s} {1e6 * seconds:9.1f} us")
    seconds = best(lambda: kendrick_iteration(100.0, 35.0, WEIGHT, TENSION), 200)
    print(f"  {'Kendrick iteration of one piece':40s} {1e6 * seconds:9.1f} us")
    x, z = terrain(83)
    seconds = best(lambda: longest_rope(x, z, (0.0, 0.0), (300.0, -45.0)), 20)
    times = f"Harvey 0.5 s: {HARVEY_LONGEST / seconds:.0f} times"
    print(f"  {'longest catenary over 83 terrain points':40s} {1e6 * seconds:9.1f} us   {times}")


if __name__ == "__main__":
    main()
