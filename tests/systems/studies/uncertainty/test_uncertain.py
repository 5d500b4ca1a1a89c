"""Samples of uncertain inputs have their distributions and their correlation; limits are counted."""

import re

import numpy as np
import pandas as pd
import pytest
from scipy import stats

import ropeway as rw

MIXED = {
    "force": stats.gumbel_r(40.0, 5.0),
    "mass": stats.lognorm(0.2, scale=300.0),
    "height": stats.uniform(-1.0, 3.0),
}


@pytest.mark.parametrize("method", ["latin hypercube", "sobol", "random"])
def test_samples_follow_their_distributions(method: str) -> None:
    inputs = rw.Uncertain(MIXED, {("force", "mass"): 0.7, ("mass", "height"): -0.4})
    cases = inputs.cases(2**13, method=method, seed=5)
    for name, distribution in MIXED.items():
        assert stats.kstest(cases[name], distribution.cdf).statistic < 0.02
    scores = stats.norm.ppf(np.column_stack([MIXED[n].cdf(cases[n]) for n in MIXED]))
    expected = [[1.0, 0.7, 0.0], [0.7, 1.0, -0.4], [0.0, -0.4, 1.0]]
    np.testing.assert_allclose(np.corrcoef(scores, rowvar=False), expected, atol=0.03)
    pd.testing.assert_frame_equal(cases, inputs.cases(2**13, method=method, seed=5))
    rank = stats.spearmanr(cases["force"], cases["mass"]).statistic
    assert 2.0 * np.sin(np.pi * rank / 6.0) == pytest.approx(0.7, abs=0.03)


def test_every_part_of_a_latin_hypercube_has_one_case() -> None:
    cases = rw.Uncertain({"a": stats.norm(3.0, 2.0)}).cases(50)["a"]
    assert sorted(np.floor(50 * stats.norm(3.0, 2.0).cdf(cases))) == list(range(50))


def test_normal_inputs_have_their_covariance() -> None:
    covariance = pd.DataFrame([[4.0, 1.5], [1.5, 9.0]], index=["a", "b"], columns=["a", "b"])
    swapped = rw.Uncertain.normal(pd.Series({"b": -1.0, "a": 2.0}), covariance)
    assert swapped.names == ("b", "a")
    cases = swapped.cases(2**14, method="sobol")
    np.testing.assert_allclose(cases.mean(), [-1.0, 2.0], atol=0.01)
    np.testing.assert_allclose(cases.cov(), [[9.0, 1.5], [1.5, 4.0]], atol=0.1)


def test_far_tails_keep_their_digits() -> None:
    values = rw.Uncertain({"a": stats.norm(), "b": stats.expon()}).values(np.array([[-9.0, 9.0], [9.0, 9.0]]))
    np.testing.assert_allclose(values[:, 0], [-9.0, 9.0], rtol=1e-10)
    np.testing.assert_allclose(values[:, 1], -stats.norm.logsf(9.0), rtol=1e-10)


NORMAL = stats.norm(3.0, 1.0)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: rw.Uncertain({}), "no inputs"),
        (lambda: rw.Uncertain.normal(pd.Series(["a"], index=["b"]), [[1.0]]), r"means\['b'\] is 'a'"),
        (lambda: rw.Uncertain.normal(pd.Series([1.0, 2.0]), [[1.0, 0.0], [0.0, 1.0]]), "text as each key"),
        (lambda: rw.Uncertain.normal({"a": 1.0}, pd.DataFrame([["x"]], ["a"], ["a"])), "not of numbers"),
        (lambda: rw.Uncertain({"a": NORMAL, "b": NORMAL}, [[1.0], [0.5, 1.0]]), "rows of one length"),
        (lambda: rw.Uncertain.normal({"a": 1.0, "b": 2.0}, [[1.0], [0.5, 1.0]]), "rows of one length"),
        (lambda: rw.Uncertain({"a": 3.0}), "The distribution of 'a' is 3.0"),
        (lambda: rw.Uncertain({"a": stats.norm(3.0, -1.0)}), "quartiles"),
        (lambda: rw.Uncertain({"a": stats.poisson(3.0)}), "continuous frozen distribution"),
        (lambda: rw.Uncertain({"a": NORMAL}, {("a", "x"): 0.1}), "names 'x'"),
        (lambda: rw.Uncertain({"a": NORMAL}, {("a", "a"): 0.1}), "with itself"),
        (lambda: rw.Uncertain({"a": NORMAL, "b": NORMAL}, {("a", "b"): 1.0}), "not positive definite"),
        (lambda: rw.Uncertain({"a": NORMAL, "b": NORMAL}, {("a", "b"): 0.1, ("b", "a"): 0.2}), "given twice"),
        (lambda: rw.Uncertain({"a": NORMAL, "b": NORMAL}, [[1.0, 0.5], [0.4, 1.0]]), "not positive definite"),
        (lambda: rw.Uncertain({"a": NORMAL, "b": NORMAL}, [[1.0]]), r"shape \(1, 1\)"),
        (lambda: rw.Uncertain.normal({"a": 3.0}, [[0.0]]), "variance of zero"),
        (lambda: rw.Uncertain.normal({"a": 3.0}, pd.DataFrame([[1.0]])), "no 'a'"),
        (lambda: rw.Uncertain({"a": NORMAL}).cases(100, method="sobol"), "power of two, such as 128"),
        (lambda: rw.Uncertain({"a": NORMAL}).cases(0), "samples is 0"),
        (lambda: rw.Uncertain({"a": NORMAL}).values(np.zeros(3)), r"shape \(3,\)"),
    ],
)
def test_bad_inputs(make: object, words: str) -> None:
    with pytest.raises(rw.InputError, match=words):
        make()  # type: ignore[operator]


def test_exceedance_counts_cases_failures_and_any_limit() -> None:
    table = pd.DataFrame(
        {"pull": [1.0, 2.0, 3.0, np.nan], "gap": [0.1, 2.0, 0.5, np.nan], "error": ["", "", "", "EquilibriumError"]}
    )
    found = rw.exceedance(table, above={"pull": 2.0, "gap": 1.0}, below={"gap": 0.3})
    assert found.index.tolist() == ["pull", "gap", "gap below", "any"]
    assert found["passed"].tolist() == [1, 1, 1, 3]
    assert found["probability"].tolist() == pytest.approx([1 / 3, 1 / 3, 1 / 3, 1.0])
    assert set(found["solved"]) == {3}
    assert set(found["failed"]) == {1}
    # Clopper and Pearson by the beta distribution: the failed case is safe in one end and passed in the other.
    assert found.loc["pull", "low"] == pytest.approx(stats.beta.ppf(0.025, 1, 4))
    assert found.loc["pull", "high"] == pytest.approx(stats.beta.ppf(0.975, 3, 2))


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({}, "no limit"),
        ({"above": {"x": 1.0}}, "no column 'x'"),
        ({"above": {"text": 1.0}}, "has text"),
        ({"above": {"pull": 1.0}, "confidence": 1.0}, "confidence is 1"),
        ({"below": {"gone": 1.0}}, "no solved case"),
    ],
)
def test_bad_exceedance(arguments: dict[str, object], words: str) -> None:
    table = pd.DataFrame({"pull": [1.0, 2.0], "gone": [np.nan, np.nan], "text": ["a", "b"]})
    with pytest.raises(rw.InputError, match=re.escape(words)):
        rw.exceedance(table, **arguments)
