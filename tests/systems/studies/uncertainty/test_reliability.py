"""First-order probabilities against closed forms and against Monte Carlo; Sobol indices; assured payloads."""

from collections.abc import Callable

import numpy as np
import pandas as pd
import pytest
from scipy import stats
from scipy.special import ndtr

import ropeway as rw
from support.call_objects import STATIONS, payloads

ROPE = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=180e3)


def line() -> rw.System:
    """Three spans over idlers, a load in each."""
    heights = (0.0, 5.0, 2.0, 8.0)
    nodes = [(rw.Sheave if 0 < k < 3 else rw.Anchor)(f"s{k}", at=(100.0 * k, z)) for k, z in enumerate(heights)]
    system = rw.System("three spans")
    spans = system.string(ROPE, *nodes, length=301.5)
    for k, mass in enumerate((400.0, 250.0, 300.0)):
        system.hang(rw.Load(f"l{k}", mass=mass), spans, at=100.0 * k + 47.0)
    return system


def skyline() -> rw.System:
    """A skyline with a turn near midspan."""
    system = rw.System("skyline")
    (span,) = system.string(ROPE, rw.Anchor("head", at=(0.0, 0.0)), rw.Anchor("tail", at=(300.0, -30.0)), length=302.8)
    system.hang(rw.Load("turn", mass=1500.0), span, at=140.0)
    return system


MASSES = {f"l{k}.mass": stats.lognorm(0.15, scale=m) for k, m in enumerate((400.0, 250.0, 300.0))}
ALIKE = {("l0.mass", "l1.mass"): 0.5, ("l1.mass", "l2.mass"): 0.5, ("l0.mass", "l2.mass"): 0.5}
TURN = {"turn.mass": stats.gumbel_r(1400.0, 150.0), "tail.x": stats.norm(300.0, 0.1)}
STUDIES = {
    "tension of a line": (
        line,
        rw.Uncertain(MASSES | {"s1.z": stats.norm(5.0, 0.15), "s0_s1.length": stats.norm(100.5, 0.05)}, ALIKE),
        "s0_s1.tension_a",
        {"above": 29e3},
    ),
    "height of a load": (
        line,
        rw.Uncertain(MASSES | {"s2.z": stats.norm(2.0, 0.2), "s1_s2.compliance": stats.norm(1 / 34.8e6, 2e-9)}),
        "l1.z",
        {"below": -1.0},
    ),
    "safe working load of a skyline": (skyline, rw.Uncertain(TURN), "head_tail.tension_a", {"above": 100e3}),
}
SLOW = ("height of a load", "tension of a line")


@pytest.mark.parametrize("name", [pytest.param(n, marks=[pytest.mark.slow] if n in SLOW else []) for n in STUDIES])
def test_first_order_probability_against_monte_carlo(name: str) -> None:
    """100 000 random cases, 0.02 to 0.2: within 10 % and three standard errors; by the second order within 2 %."""
    make, inputs, output, limit = STUDIES[name]
    found = rw.reliability(make(), inputs, output, **limit)
    table = rw.sweep(make(), inputs.cases(100_000, method="random", seed=1), outputs=output, workers=1)
    counted = rw.exceedance(table, **{side: {output: value} for side, value in limit.items()}).loc[output]
    assert counted["failed"] == 0
    assert 0.02 < counted["probability"] < 0.2
    spread = 3.0 * counted["standard_error"]
    assert found.probability == pytest.approx(counted["probability"], rel=0.1, abs=spread)
    assert found.second_order == pytest.approx(counted["probability"], abs=0.02 * counted["probability"] + spread)
    assert found.solves < 20


def resistance(strength: float, load: float) -> float:
    return strength - load


BOTH = {"strength": stats.norm(130.0, 12.0), "load": stats.norm(100.0, 5.0)}


@pytest.mark.parametrize("correlation", [0.0, 0.6])
def test_a_linear_limit_of_normal_inputs_is_exact(correlation: float) -> None:
    def probability(mean: float = 130.0, deviation: float = 12.0, limit: float = 4.0) -> float:
        variance = deviation**2 + 25.0 - 2.0 * correlation * deviation * 5.0
        return float(ndtr((limit - (mean - 100.0)) / np.sqrt(variance)))

    inputs = rw.Uncertain(BOTH, {("strength", "load"): correlation})
    found = rw.reliability(resistance, inputs, below=4.0)
    assert found.probability == pytest.approx(probability(), rel=1e-6)
    assert found.second_order == pytest.approx(probability(), rel=1e-6)
    assert found.per_limit == pytest.approx((probability(limit=4.01) - probability(limit=3.99)) / 0.02, rel=1e-4)
    by_mean = (probability(mean=130.01) - probability(mean=129.99)) / 0.02
    by_deviation = (probability(deviation=12.01) - probability(deviation=11.99)) / 0.02
    assert found.frame.loc["strength", "per_mean"] == pytest.approx(by_mean, rel=1e-4)
    assert found.frame.loc["strength", "per_deviation"] == pytest.approx(by_deviation, rel=1e-4)
    assert found.frame["importance"].tolist() == pytest.approx([144.0 / 169.0, 25.0 / 169.0])
    assert "85% by strength" in repr(found)
    safe = rw.reliability(resistance, inputs, above=4.0)
    assert safe.probability == pytest.approx(1.0 - probability(), rel=1e-6)
    assert safe.index == pytest.approx(-found.index, rel=1e-6)


def test_sensitivities_equal_differences_of_the_probability() -> None:
    def at(**changes: float) -> rw.Reliability:
        values = {"scale": 1500.0, "limit": 100e3, "position": 300.0} | changes
        inputs = rw.Uncertain(
            {"turn.mass": stats.norm(values["scale"], 150.0), "tail.x": stats.norm(values["position"], 0.1)}
        )
        return rw.reliability(model, inputs, "head_tail.tension_a", above=values["limit"])

    model = rw.assemble(skyline())
    found = at()
    for name, change, step in (("turn.mass", "scale", 1.0), ("tail.x", "position", 1e-3)):
        value = {"scale": 1500.0, "position": 300.0}[change]
        low, high = (at(**{change: value + s}).probability for s in (-step, step))
        assert found.frame.loc[name, "per_mean"] == pytest.approx((high - low) / (2.0 * step), rel=2e-2)
    low, high = (at(limit=100e3 + s).probability for s in (-50.0, 50.0))
    assert found.per_limit == pytest.approx((high - low) / 100.0, rel=1e-2)


def test_a_line_equals_a_function_of_it() -> None:
    model = rw.assemble(skyline())

    def pull(mass: float) -> dict[str, float]:
        return {"pull": rw.equilibrium(model, parameters={"turn.mass": mass})["head_tail.tension_a"]}

    exact = rw.reliability(
        model, rw.Uncertain({"turn.mass [t]": stats.norm(1.5, 0.15)}), "head_tail.tension_a", above=1e5
    )
    numeric = rw.reliability(pull, rw.Uncertain({"mass": stats.norm(1500.0, 150.0)}), "pull", above=1e5)
    assert exact.probability == pytest.approx(numeric.probability, rel=1e-5)
    assert exact.frame["design"].iloc[0] == pytest.approx(1e-3 * numeric.frame["design"].iloc[0], rel=1e-6)
    assert exact.plot().axes[0].get_xlabel() == "importance [%]"


def broken(a: float) -> float:
    raise ValueError("no rope")


@pytest.mark.parametrize(
    ("study", "arguments", "error", "words"),
    [
        (resistance, {}, rw.InputError, "no limit, or two"),
        (resistance, {"above": 1.0, "below": 0.0}, rw.InputError, "no limit, or two"),
        (resistance, {"above": 1.0, "output": "x"}, rw.UnknownNameError, "does not return 'x'"),
        (lambda strength, load: 3.0, {"above": 5.0}, rw.DesignPointError, "does not change with the inputs"),
        (
            lambda strength, load: broken(load),
            {"above": 5.0},
            rw.DesignPointError,
            "strength = 130, load = 100: no rope",
        ),
        (lambda strength, load: load**0.5 - np.inf, {"above": 2.0}, rw.DesignPointError, "load = 100: value is -inf"),
        (lambda strength, load: np.sin(load), {"above": 2.0}, rw.DesignPointError, "has not converged"),
    ],
)
def test_bad_limits(study: object, arguments: dict[str, float], error: type[Exception], words: str) -> None:
    with pytest.raises(error, match=words):
        rw.reliability(study, rw.Uncertain(BOTH), **arguments)


def test_sobol_indices_of_ishigami() -> None:
    """A. Saltelli and others, Global Sensitivity Analysis (2008), with a = 7, b = 0.1."""

    def ishigami(x: float, y: float, z: float) -> dict[str, float]:
        return {"value": np.sin(x) + 7.0 * np.sin(y) ** 2 + 0.1 * z**4 * np.sin(x), "twice": 2.0 * y}

    inputs = rw.Uncertain(dict.fromkeys("xyz", stats.uniform(-np.pi, 2.0 * np.pi)))
    found = rw.sobol_indices(ishigami, inputs, ["value", "twice"], samples=1024, workers=1)
    np.testing.assert_allclose(found.loc["value", "first"], [0.3139, 0.4424, 0.0], atol=0.02)
    np.testing.assert_allclose(found.loc["value", "total"], [0.5576, 0.4424, 0.2437], atol=0.02)
    np.testing.assert_allclose(found.loc["twice", "first"], [0.0, 1.0, 0.0], atol=0.01)
    assert (found["total_low"] <= found["total"]).all()
    assert (found["total"] <= found["total_high"]).all()


def test_sobol_indices_of_a_line_agree_with_its_importance() -> None:
    _, inputs, output, limit = STUDIES["height of a load"]
    shares = rw.sobol_indices(line(), inputs, output, samples=256, workers=1).loc[output]
    assert shares["total"].idxmax() == rw.reliability(line(), inputs, output, **limit).frame["importance"].idxmax()
    assert shares["first"].sum() == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize(
    ("study", "inputs", "error", "words"),
    [
        (resistance, rw.Uncertain(BOTH, {("strength", "load"): 0.1}), rw.InputError, "correlated inputs"),
        (broken, rw.Uncertain({"a": stats.norm()}), rw.EquilibriumError, "fail, the first by ValueError: no rope"),
        (lambda a: 1.0, rw.Uncertain({"a": stats.norm()}), rw.InputError, "the same in all cases"),
    ],
)
def test_bad_sobol_indices(study: object, inputs: rw.Uncertain, error: type[Exception], words: str) -> None:
    with pytest.raises(error, match=words):
        rw.sobol_indices(study, inputs, samples=8, workers=1)


def test_assured_payload_is_carried_by_its_share_of_cases() -> None:
    cases = list[pd.Series]()

    def study(tension: float) -> rw.PayloadStudy:
        found = payloads(tension)
        cases.append(found.frame.set_index("station")["payload"])
        return found

    inputs = rw.Uncertain({"tension": stats.norm(60e3, 3e3)})
    found = rw.assured_payload(study, inputs, confidence=0.6, samples=5, workers=1)
    assert found.index.tolist() == [*STATIONS, "everywhere"]
    table = pd.DataFrame(cases)
    for station in STATIONS:
        assert np.mean(table[station] >= found.loc[station, "payload"]) >= 0.6
        assert found.loc[station, "payload"] in table[station].to_list()
    assert found.loc["everywhere", "payload"] == pytest.approx(np.sort(table.min(axis=1))[1])
    assert (found["at_least"] <= found["payload"]).all()
    assert (found["payload"] < found["median"]).all()
    assert found["limited_by"].str.len().gt(3).all()


def failing(tension: float) -> rw.PayloadStudy:
    if tension > 60e3:
        raise rw.InputError("too tight", "slacken")
    return payloads(tension)


@pytest.mark.parametrize(
    ("study", "samples", "words"),
    [(broken, 2, "No case is solved"), (payloads, 5, "Take at least 20"), (failing, 20, "")],
)
def test_bad_assured_payloads(study: Callable[..., rw.PayloadStudy], samples: int, words: str) -> None:
    name = "a" if study is broken else "tension"
    inputs = rw.Uncertain({name: stats.norm(60e3, 1e3)})
    if words:
        confidence = 0.5 if study is broken else 0.95
        with pytest.raises(rw.InputError, match=words):
            rw.assured_payload(study, inputs, confidence=confidence, samples=samples, workers=1)
        return
    found = rw.assured_payload(study, inputs, confidence=0.6, samples=4, workers=1)
    assert found["failed"].tolist() == [2, 2, 2]
    assert found["payload"].tolist() == [0.0, 0.0, 0.0]
