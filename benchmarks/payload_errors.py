"""The tables of docs/methods.md: errors of each payload method over slopes, deflections and carriage stations.

python benchmarks/payload_errors.py
"""

from __future__ import annotations

import numpy as np

from ropeway.components.rope import Rope
from ropeway.systems.studies.handbook.payload_comparison import method_errors

ROPE = Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)
TENSION = 19600.0 * 9.80665
SPANS = (200.0, 600.0)


def table(span: float, points: tuple[int, int, int] = (13, 18, 17)) -> str:
    """A Markdown table for a span [m]; points: number of slopes, deflections and carriage stations."""
    slopes, deflections, places = (
        np.linspace(low, high, n) for (low, high), n in zip(((0.0, 0.6), (0.03, 0.2), (0.1, 0.9)), points, strict=True)
    )
    errors = method_errors(ROPE, span=span, tension=TENSION, slopes=slopes, deflections=deflections, carriages=places)
    lines = [
        "| method | against | lowest % | highest % | mean of size % | worst at slope, deflection, carriage % |",
        "|-|-|-|-|-|-|",
    ]
    for row in errors.itertuples():
        exact = row.mean < 1e-12
        numbers = ("0", "0", "0") if exact else tuple(f"{100 * v:+.4f}" for v in (row.lowest, row.highest))
        mean = "0" if exact else f"{100 * row.mean:.4f}"
        worst = (
            ""
            if exact
            else f"{100 * row.worst_slope:.0f}, {100 * row.worst_deflection:.0f}, {100 * row.worst_carriage:.0f}"
        )
        lines.append(f"| {row.Index} | {row.reference} | {numbers[0]} | {numbers[1]} | {mean} | {worst} |")
    return "\n".join(lines)


def main() -> None:
    for span in SPANS:
        print(f"Span {span:.0f} m\n\n{table(span)}\n")


if __name__ == "__main__":
    main()
