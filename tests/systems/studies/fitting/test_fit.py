"""Fits recover what synthetic measurements were made from, and say what they cannot."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
import pytest

import ropeway as rw
from support.measured import CASES, ROPE, Case, idlers, line_case, standing, standing_case


@pytest.mark.parametrize("name", CASES)
def test_exact_measurements_give_the_true_values(name: str) -> None:
    case = CASES[name]()
    fit = case.fit(case.exact, case.noisy(0.002, np.random.default_rng(0))[1])
    for quantity, value in case.true.items():
        assert fit.values[quantity] == pytest.approx(value, rel=1e-7), quantity
    assert fit.unidentifiable == ()
    assert (fit.residuals / fit.sigma).abs().max().max() < 1e-5


def test_standard_errors_are_those_of_repeated_fits() -> None:
    """The covariance is that of the values of fits to many tables with noise; of more kinds in the campaigns."""
    case, rng, count = CASES["running"](), np.random.default_rng(4), 25
    fits = [case.fit(*case.noisy(0.002, rng)) for _ in range(count)]
    off = np.array([(fit.values - pd.Series(case.true)) / fit.standard_errors for fit in fits])
    assert np.abs(off.mean(axis=0)).max() < 4.0 / np.sqrt(count)
    assert np.all(np.abs(off.std(axis=0) - 1.0) < 4.0 / np.sqrt(2.0 * count))


def test_sigma_is_estimated_where_none_is_given() -> None:
    case, rng = line_case(), np.random.default_rng(8)
    table = case.exact.drop(columns=["z", "low"])
    table["head"] += rng.normal(0.0, 300.0, len(table))
    columns = {"m1": "l1.mass", "head": "a.tension"}
    known = rw.fit(case.system, table, columns=columns, free="a.pretension", sigma=300.0)
    found = rw.fit(case.system, table, columns=columns, free="a.pretension")
    spread = float(found.sigma["head"].iloc[0])
    assert spread == pytest.approx(np.sqrt((found.residuals["head"] ** 2).sum() / found.degrees), rel=1e-9)
    assert found.standard_errors.iloc[0] == pytest.approx(known.standard_errors.iloc[0] * spread / 300.0, rel=1e-6)
    wide = (found.intervals(0.9)["high"] - found.values).iloc[0] / found.standard_errors.iloc[0]
    assert wide == pytest.approx(1.8331, abs=1e-3)  # Student's distribution with 9 degrees of freedom
    exact = rw.fit(case.system, case.exact, columns=columns, free=list(case.true))  # residuals are rounding errors
    assert exact.values.to_dict() == pytest.approx(case.true, rel=1e-7)
    with pytest.raises(rw.InputError, match="different units"):
        case.fit(case.exact, None)


def test_two_loads_at_one_place_are_known_by_their_sum_only() -> None:
    def line(a: float, b: float) -> rw.System:
        s = rw.System("one span")
        (span,) = s.string(ROPE, rw.Anchor("a", at=(0.0, 0.0)), rw.Anchor("b", at=(200.0, 5.0)), length=202.0)
        s.hang(rw.Load("one", mass=a), span, at=80.0)
        s.hang(rw.Load("two", mass=b), span, at=80.0)
        return s

    true = rw.equilibrium(line(500.0, 300.0))
    table = pd.DataFrame({"T": [true["a_b.tension_a"]], "z": [true["one.z"]], "H": [true["a_b.horizontal"]]})
    columns = {"T": "a_b.tension_a", "z": "one.z", "H": "a_b.horizontal"}
    sigma = {"T": 100.0, "z": 0.01, "H": 100.0}
    fit = rw.fit(line(400.0, 300.0), table, columns=columns, free=["one.mass", "two.mass", "a_b.length"], sigma=sigma)
    (lost,) = fit.unidentifiable
    assert set(lost.changes) == {"one.mass", "two.mass"}
    assert sum(lost.changes.values()) == pytest.approx(0.0, abs=1e-5)
    assert str(lost) == "two.mass +1 kg, one.mass -1 kg"  # the larger change of the two, by what is declared, first
    assert np.isinf(lost.standard_deviation)
    assert np.isinf(fit.standard_errors["one.mass"])
    assert np.isfinite(fit.standard_errors["a_b.length"])
    assert fit.values["one.mass"] + fit.values["two.mass"] == pytest.approx(800.0, rel=1e-5)
    assert fit.values["a_b.length"] == pytest.approx(202.0, rel=1e-7)
    known = rw.fit(
        line(400.0, 300.0), table, columns=columns, free=["one.mass", "two.mass"], sigma=sigma,
        prior={"two.mass": (300.0, 1.0)},
    )  # fmt: skip
    assert known.unidentifiable == ()
    assert known.values["one.mass"] == pytest.approx(500.0, abs=1e-3)
    assert known.correlations.loc["one.mass", "two.mass"] < -0.2


def test_carriage_and_payload_are_known_by_their_sum_only() -> None:
    case = standing_case()
    free = ["payload", "carriage.mass", "tension"]
    fit = rw.fit(case.system, case.exact, columns=case.columns, free=free, sigma={"head": 500.0, "z": 0.05})
    assert [sorted(one.changes) for one in fit.unidentifiable] == [["carriage.mass", "payload"]]
    assert np.isfinite(fit.standard_errors["tension"])


def test_a_sensor_with_unknown_gain_and_offset() -> None:
    case = line_case()
    table = case.exact.assign(head=1.04 * case.exact["head"] - 800.0)
    sigma = {"head": 100.0, "z": 0.01, "low": 0.01}
    free = ["l2.mass", "a.pretension", "head.gain", "head.offset"]
    fit = rw.fit(case.system, table, columns=case.columns, free=free, sigma=sigma)
    assert fit.values["head.gain"] == pytest.approx(1.04, rel=1e-6)
    assert fit.values["head.offset"] == pytest.approx(-800.0, rel=1e-4)
    assert fit.values["a.pretension"] == pytest.approx(32e3, rel=1e-6)
    assert list(fit.frame["unit"]) == ["kg", "N", "1", "N"]


def test_a_robust_loss_resists_outliers() -> None:
    case, rng = line_case(), np.random.default_rng(2)
    table, sigma = case.noisy(0.002, rng)
    table.loc[[2, 7], "head"] *= 1.3
    plain, robust = case.fit(table, sigma), case.fit(table, sigma, loss="cauchy")
    off = [abs(fit.values["a.pretension"] - 32e3) / fit.standard_errors["a.pretension"] for fit in (plain, robust)]
    assert off[0] > 10.0 > 3.0 > off[1]
    assert any("standard deviations off, first in row 3 of column 'head'" in note for note in robust.notes)


def test_bounds_hold_and_are_named() -> None:
    case = line_case()
    fit = case.fit(case.exact, 1.0, bounds={"a.pretension": (20e3, 31e3)})
    assert fit.values["a.pretension"] == pytest.approx(31e3, rel=1e-6)
    assert "a.pretension is at a bound" in fit.notes


def test_the_suggested_measurement_helps_as_much_as_it_says() -> None:
    """The one measurement is added to the table: the standard error falls to the share that was said."""
    case = line_case()
    sigma = {"head": 300.0, "z": 0.05, "low": 0.05}
    only = case.exact[["m1", "z"]]
    columns = {"m1": "l1.mass", "z": "l1.z"}
    fit = rw.fit(case.system, only, columns=columns, free=list(case.true), sigma=0.05)
    best = fit.suggestions.iloc[0]
    assert best["quantity"] in fit.suggestion
    assert fit.suggestions["gain"].is_monotonic_decreasing
    mass = float(best["state"].rpartition("=")[2])
    true = idlers(l2=280.0, tension=32e3)
    more = {"m1": mass, "new": rw.equilibrium(true, parameters={"l1.mass": mass})[best["quantity"]]}
    table = pd.concat([only, pd.DataFrame([more])], ignore_index=True)
    again = rw.fit(
        case.system, table, columns=columns | {"new": str(best["quantity"])}, free=list(case.true),
        sigma={"z": sigma["z"], "new": float(best["sigma"])},
    )  # fmt: skip
    share = again.standard_errors[best["helps"]] / fit.standard_errors[best["helps"]]
    assert share == pytest.approx(best["error_falls_to"], rel=0.03)


def test_picture_and_report(tmp_path: Any) -> None:
    case, rng = standing_case(), np.random.default_rng(1)
    fit = case.fit(*case.noisy(0.01, rng))
    figure = fit.plot()
    assert [axis.get_ylabel() for axis in figure.axes[:4:2]] == ["head [kN]", "z [m]"]
    page = fit.report(tmp_path / "fit.html").read_text(encoding="utf-8")
    assert "skyline.axial_stiffness" in page
    assert fit.suggestion in page
    assert "payload" in fit.to_csv(tmp_path / "fit.csv").read_text()


BAD: Mapping[str, tuple[dict[str, Any], str]] = {
    "unknown column": ({"columns": {"q": "a.tension"}}, "no column q"),
    "unknown quantity": ({"columns": {"head": "a.tention"}}, "a.tension"),
    "unknown free quantity": ({"free": ["l9.mass"]}, "l9.mass"),
    "unknown quantity of a sensor": ({"free": ["head.gian"]}, r"head\.gain or head\.offset"),
    "a result is free": ({"free": ["a.tension"]}, "is a result"),
    "nothing measured": ({"columns": {"m1": "l1.mass"}}, "No column is measured"),
    "free and given": ({"free": ["l1.mass"]}, "given in a column"),
    "twice free": ({"free": ["l2.mass", "l2.mass"]}, "once"),
    "more free than measured": (
        {"columns": {"head": "a.tension"}, "measured": 1, "free": ["l2.mass", "a.pretension"]}, "1 measured values"
    ),
    "bounds the wrong way": ({"bounds": {"l2.mass": (300.0, 100.0)}}, "low one first"),
    "bounds of what is not free": ({"bounds": {"l1.mass": (1.0, 9.0)}}, "not free"),
    "prior without width": ({"prior": {"l2.mass": (300.0, 0.0)}}, "above zero"),
    "sigma of nothing": ({"sigma": {"foot": 1.0}}, "No measured column"),
    "sigma missing": ({"sigma": {"head": 1.0}}, "no value for z, low"),
    "sigma zero": ({"sigma": 0.0}, "above zero"),
    "no scale of a robust loss": ({"columns": {"head": "a.tension"}, "sigma": None, "loss": "huber"}, "no scale"),
    "nothing left for sigma": (
        {"columns": {"head": "a.tension"}, "measured": 1, "sigma": None}, "how sure they are"
    ),
    "unknown loss": ({"loss": "l3"}, "loss"),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_bad_input(name: str) -> None:
    case = line_case()
    changes, message = BAD[name]
    rows = changes.pop("measured", len(case.exact))
    arguments = {"columns": case.columns, "free": ["l2.mass"], "sigma": 1.0} | changes
    with pytest.raises(rw.InputError, match=message):
        rw.fit(case.system, case.exact.iloc[:rows], **arguments)


def test_a_row_in_which_a_rig_has_no_equilibrium() -> None:
    case = standing_case()
    table = case.exact.copy()
    table.loc[4, "station"] = 400.0
    with pytest.raises(rw.InputError, match="outside the skyline"):
        case.fit(table, 1.0)
    with pytest.raises(rw.InputError, match="No column gives the station"):
        rw.fit(standing(), table, columns={"head": "headspar_tension"}, free="payload", sigma=1.0)
    with pytest.raises(rw.InputError, match="follow from each other"):
        rw.fit(standing(), case.exact, columns=case.columns, free=["tension", "length"], sigma=1.0)


def test_no_fit_is_found_where_bounds_leave_no_equilibrium() -> None:
    case: Case = line_case()
    with pytest.raises((rw.FitError, rw.SlackRopeError, rw.InputError)):
        rw.fit(
            case.system, case.exact.assign(head=1.0), columns=case.columns, free=["a.pretension"], sigma=1e-3,
            bounds={"a.pretension": (1.0, 2.0)},
        )  # fmt: skip


@pytest.mark.parametrize("sigma", [1e-300, {"head": 1e-13, "z": 1e-13}])
def test_a_sigma_below_rounding_is_refused(sigma: float | dict[str, float]) -> None:
    case = standing_case()
    with pytest.raises(rw.InputError, match="less than the rounding"):
        rw.fit(case.system, case.exact, columns=case.columns, free="tension", sigma=sigma)


@pytest.mark.parametrize(
    ("sigma", "prior"), [(1e200, {}), (10.0, {"tension": (5e4, 1e-250)}), (10.0, {"tension": (1e250, 1.0)})]
)
def test_deviations_whose_squares_no_number_holds_are_refused(
    sigma: float, prior: dict[str, tuple[float, float]]
) -> None:
    case = standing_case()
    with pytest.raises(rw.InputError, match="outside the floating-point range"):
        rw.fit(case.system, case.exact, columns=case.columns, free="tension", sigma=sigma, prior=prior)
