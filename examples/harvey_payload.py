"""Harvey's Table 2 and Figure 10 with the exact payload.

    python examples/harvey_payload.py [folder]

Harvey (2013): span 200 m, deflection 12.5 %, a 28.6 mm rope at 19,600 kgf. Draws `harvey_payload.png` and prints
the payloads as printed, as his formulas give them, corrected, and exact.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pandas as pd

import ropeway as rw
from ropeway.systems.studies.handbook.payload_comparison import compare_payload_methods

TENSION = 19600.0 * 9.80665
ROPE = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)
COLOURS = {
    "simplified moment balance": "#b5482a",
    "modified moment balance": "#5b8c2a",
    "LIRA worksheet": "#8a5a9e",
    "Harvey's rigid link": "#1b6ca8",
    "Harvey's improved rigid link": "#3fa7b5",
}


def main(folder: Path | None = None) -> Path:
    """Print the table and write the picture; returns its path."""
    table = _compare((0.0, 0.1, 0.2))
    print("Payload [kg] at chord slopes of 0, 10 and 20 %; error against the exact clamped payload")
    for name, rows in table.groupby("method", sort=False):
        print(f"\n{name}")
        for column in ("printed", "as_printed", "payload"):
            if rows[column].notna().any():
                print(f"  {column.replace('_', ' '):11s}", *(f"{v:9.1f}" for v in rows[column]))
        if rows["error"].notna().any():
            print("  error %    ", *(f"{100 * v:+9.3f}" for v in rows["error"]))
        if rows["erratum"].iloc[0]:
            print(f"  erratum     {rows['erratum'].iloc[0]}")
    return _draw(table, Path.cwd() if folder is None else folder)


def _compare(slopes: tuple[float, ...]) -> pd.DataFrame:
    return compare_payload_methods(
        span=200.0,
        deflection=25.0,
        chord_slopes=slopes,
        rope=ROPE,
        tension=TENSION,
        carriage_mass=150.0,
        as_printed=True,
    )


def _draw(table: pd.DataFrame, folder: Path) -> Path:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.5, 5.4), layout="constrained")
    left, right = figure.subplots(1, 2, sharey=True)
    fine = _compare(tuple(float(v) for v in np.linspace(0.0, 0.2, 21)))

    def column(frame: pd.DataFrame, name: str, which: str) -> tuple[np.ndarray, np.ndarray]:
        rows = frame[frame["method"] == name]
        return 100.0 * rows["chord_slope"].to_numpy(), rows[which].to_numpy()

    for panel in (left, right):
        for name, style, word in (
            ("clamped", "-", "clamped carriage"),
            ("rolling", "--", "rolling, horizontal mainline"),
        ):
            panel.plot(
                *column(fine, f"catenary, {name}", "payload"), style, color="black", lw=2.2, label=f"exact: {word}"
            )
        panel.grid(alpha=0.25)
        panel.spines[["top", "right"]].set_visible(False)
        panel.set(xlabel="chord slope [%]", xlim=(-0.4, 20.4))
        panel.set_xticks([0, 5, 10, 15, 20])
    for name, colour in COLOURS.items():
        left.plot(*column(table, name, "printed"), "o-", color=colour, lw=1.3, ms=5, label=name)
    for name in ("simplified moment balance", "modified moment balance", "LIRA worksheet"):
        right.plot(*column(fine, name, "payload"), color=COLOURS[name], lw=1.6, label=name)
    for name, colour, style in (
        ("weightless", "#999999", "-"),
        ("parabolic", "#d4a017", "-"),
        ("rigid link", "#1b6ca8", ":"),
        ("rigid link, rolling", "#3fa7b5", ":"),
    ):
        right.plot(*column(fine, name, "payload"), style, color=colour, lw=3.0 if style == ":" else 1.6, label=name)
    left.set_ylabel("payload [kg]")
    left.set_title("As printed: Harvey (2013), Figure 10", loc="left", fontsize=11)
    right.set_title("The same methods, corrected", loc="left", fontsize=11)
    left.legend(fontsize=8.5, frameon=False, loc="lower left")
    right.legend(fontsize=8.5, frameon=False, loc="lower left")
    left.set_ylim(7500, 9450)
    figure.suptitle(
        "Payload of a 200 m span, deflection 12.5 %, 28.6 mm rope at 19,600 kgf, carriage at mid-span", fontsize=12
    )
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "harvey_payload.png"
    figure.savefig(path, dpi=130)
    return path


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else None)
