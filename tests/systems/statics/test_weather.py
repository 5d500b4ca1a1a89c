"""Temperature, ice and wind: exact spans against direct integration, published changes of state, and refusals."""

from __future__ import annotations

import numpy as np
import pytest

import ropeway as rw
from support.weather import misses

pytestmark = pytest.mark.filterwarnings("ignore::ropeway.components.errors.RopewayWarning")  # drawn without regard


def rope(**values: float) -> rw.Rope:
    given = {"mass_per_length": 3.48, "axial_stiffness": 34.8e6, "breaking_load": 576.6e3, "diameter": 0.0286}
    return rw.Rope(**{**given, **values})


def random_weather(rng: np.random.Generator) -> rw.Environment:
    """Wind to 1.5 kPa from anywhere, ice to 40 mm, 60 K colder or warmer than strung."""
    return rw.Environment(
        "drawn",
        temperature=15.0 + rng.uniform(-60.0, 60.0),
        ice_thickness=float(rng.choice([0.0, rng.uniform(0.0, 0.04)])),
        wind_pressure=float(rng.choice([0.0, rng.uniform(0.0, 1500.0)])),
        wind_from=rng.uniform(0.0, 360.0),
    )


def random_rope(rng: np.random.Generator) -> rw.Rope:
    d = rng.uniform(0.012, 0.05)
    return rw.Rope(
        mass_per_length=4200.0 * d**2,
        axial_stiffness=4.2e10 * d**2 * rng.uniform(0.7, 1.2),
        breaking_load=7e8 * d**2,
        diameter=d,
        drag_coefficient=rng.uniform(0.8, 1.3),
        thermal_expansion=rng.uniform(8e-6, 2.3e-5),
        stretch=rw.ConstructionStretch() if rng.random() < 0.2 else rw.Elastic(),
    )


def random_span(rng: np.random.Generator) -> rw.System:
    """One span in space with 0 to 5 loads, from nearly straight to 10 % longer than its chord."""
    heading, rise, across = rng.uniform(-np.pi, np.pi), rng.uniform(-0.8, 0.8), rng.uniform(50.0, 600.0)
    b = across * np.array([np.cos(heading), np.sin(heading), rise])
    s, own = rw.System("drawn"), random_rope(rng)
    length = float(np.linalg.norm(b)) * (1.0 + float(np.exp(rng.uniform(np.log(1e-3), np.log(0.1)))))
    (span,) = s.string(own, rw.Anchor("a", at=(0, 0, 0)), rw.Anchor("b", at=tuple(b)), length=length)
    for i in range(int(rng.integers(0, 6))):
        mass = own.mass_per_length * length * rng.uniform(0.01, 0.5)
        s.hang(rw.Load(f"l{i}", mass=mass, drag_area=rng.uniform(0.0, 3.0)), span, at=rng.uniform(0.0, 1.0) * length)
    return s


def random_line(rng: np.random.Generator) -> rw.System:
    """A rope over two to four idlers that do not stand in one line."""
    count = int(rng.integers(2, 5))
    x = np.cumsum(rng.uniform(60.0, 180.0, count + 2)) - 60.0
    at = np.column_stack([x, rng.uniform(-4.0, 4.0, count + 2), rng.uniform(-8.0, 8.0, count + 2)])
    nodes = [rw.Sheave(f"s{i}", at=tuple(p)) for i, p in enumerate(at[1:-1])]
    s, own = rw.System("drawn"), random_rope(rng)
    ends = (rw.Anchor("a", at=tuple(at[0])), rw.Anchor("b", at=tuple(at[-1])))
    spans = s.string(own, ends[0], *nodes, ends[1], tension=own.breaking_load * rng.uniform(0.08, 0.2))
    length = sum(span.length for span in spans)
    for i, share in enumerate(np.sort(rng.uniform(0.05, 0.95, int(rng.integers(0, 4))))):
        load = rw.Load(f"l{i}", mass=own.mass_per_length * rng.uniform(5.0, 60.0), drag_area=rng.uniform(0.0, 2.0))
        s.hang(load, spans, at=float(share) * length)
    return s


def require_exact(system: rw.System, environment: rw.Environment, note: object) -> None:
    eq = rw.equilibrium(system, environment=environment)
    found = misses(eq, environment)
    assert found.ends < 1e-9, (note, found)
    assert found.tensions < 1e-9, (note, found)
    assert found.sum < 1e-9, (note, found)
    assert eq.certificate["holds"].all(), note


@pytest.mark.parametrize("seed", range(20))
def test_random_spans_and_lines_in_weather(seed: int) -> None:
    rng = np.random.default_rng([18, seed])
    require_exact(random_span(rng), random_weather(rng), seed)
    require_exact(random_line(rng), random_weather(rng), seed)


@pytest.mark.slow
@pytest.mark.parametrize("first", range(20, 200, 20))
def test_more_random_spans_and_lines_in_weather(first: int) -> None:
    for seed in range(first, first + 20):
        test_random_spans_and_lines_in_weather(seed)
