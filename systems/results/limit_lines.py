"""Safe working load and breaking load in a figure of tensions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from ropeway.components.rope import Rope
from ropeway.components.rounding import at_least, at_most

if TYPE_CHECKING:
    from matplotlib.axes import Axes

NEAR = 0.5
"""Share of a limit above which a figure shows its line. Below it the line would compress the curves."""

NOISE = 1e-6
"""Relative tolerance above a limit: the tension of a largest payload is at its limit."""

ABOVE: dict[str, Any] = {"loc": "lower right", "bbox_to_anchor": (1.0, 1.0), "borderaxespad": 0.1, "frameon": False}
"""Position of a legend above its panel, clear of the curves."""


class LimitLine(NamedTuple):
    """A limit of a tension [N] with its name, and the colour and style of its line."""

    value: float
    name: str
    colour: str = "tab:red"
    style: str = "--"

    @property
    def text(self) -> str:
        """Name and value, rounded down."""
        return f"{self.name} {at_most(self.value / 1e3, 1)} kN"


def limits_of(rope: Rope, of: str = "", colour: str = "tab:red") -> list[LimitLine]:
    """SWL and MBL of a rope. `of` names the rope if there are several."""
    owner = f" {of}" if of else ""
    return [
        LimitLine(rope.safe_working_load, f"SWL{owner} (MBL / {rope.safety_factor:g})", colour, "--"),
        LimitLine(rope.breaking_load, f"MBL{owner}", colour, "-"),
    ]


def draw_limits(axis: Axes, ropes: Sequence[tuple[float, Sequence[LimitLine]]]) -> None:
    """Draws the limits near the tensions and names the others in the legend. `ropes` has the highest tension [N] of
    each rope and its limits. A text in the figure reports a tension above a limit.

    The axis [kN] begins at zero and includes all tensions and limits drawn.
    """
    drawn = [highest for highest, _ in ropes]
    highest_of_all = max(drawn, default=0.0)
    not_drawn, exceeded = [], []
    for highest, limits in ropes:
        for limit in limits:
            if highest_of_all >= NEAR * limit.value:
                axis.axhline(limit.value / 1e3, color=limit.colour, ls=limit.style, lw=1.2, label=limit.text)
                drawn.append(limit.value)
            else:
                not_drawn.append(limit.text)
        if over := [limit for limit in limits if highest > (1.0 + NOISE) * limit.value]:
            exceeded.append(f"{at_least(highest / 1e3, 1)} kN: above {max(over).text}")
    if not_drawn:
        axis.plot([], [], ls="", label=f"not drawn: {', '.join(not_drawn)}")
    top = max(drawn, default=0.0) / 1e3
    axis.set_ylim(0.0, 1.08 * top if top > 0.0 else 1.0)
    if exceeded:
        axis.text(
            0.01, 0.97, "\n".join(exceeded), transform=axis.transAxes, va="top", color="tab:red", fontsize="small",
            zorder=6, bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.5},
        )  # fmt: skip
