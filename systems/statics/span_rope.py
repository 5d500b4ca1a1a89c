"""Weight and strain of the rope in a span, as its closed form takes them, for curves and heights."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ropeway.components.catenary import Strain, Uniform, Weight
from ropeway.components.weather import SHARED, Weather
from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.modelling.rope_path import Run

Read = Callable[[str], Any]
"""The value of a variable or output, by its name."""


class SpanRope(NamedTuple):
    """Weight of a rope [N/m], with wind a `Uniform` force, and its strain."""

    weight: Weight
    strain: Strain


def span_rope(model: Model, run: Run, k: int, read: Read) -> SpanRope:
    """The rope in span k of a run."""
    name = run.spans[k].name
    strain = Strain(read(f"{name}.compliance"), run.rope.strain.c2)
    if not model.weather:
        return SpanRope(read(f"{name}.mass_per_length") * read("gravity"), strain)
    pull = (read(f"{name}.load_x"), read(f"{name}.load_y"), read(f"{name}.load_z"))
    return SpanRope(Uniform.of(pull), strain._replace(expansion=read(f"{name}.expansion")))


def end_force(model: Model, run: Run, k: int, read: Read) -> np.ndarray:
    """Tension vector at end b of span k of a run, (3,) [N]."""
    name = run.spans[k].name
    ends = ("pull_b_x[1]", "pull_b_y[1]") if model.weather else ("force_x", "force_y")
    return np.array([read(f"{name}.{variable}") for variable in (*ends, "vertical_b")])


def load_force(model: Model, mass: float, drag_area: float, read: Read) -> Any:
    """A load on a rope as `loaded` takes it [N]: its weight; in weather a vector, with wind on it."""
    down = mass * read("gravity")
    if not model.weather:
        return down
    x, y, _ = Weather.of([read(name) for name in SHARED]).drag(drag_area)
    return (x, y, -down)
