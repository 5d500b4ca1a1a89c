"""First-order reliability (FORM): the probability that a limit is passed, and what it depends on."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.errors import InputError
from ropeway.systems.interrupts import interruptible
from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.modelling.system import System
from ropeway.systems.studies.sweeps.sweep import Study
from ropeway.systems.studies.sweeps.workers import Workers
from ropeway.systems.studies.uncertainty.design_point import DesignPoint, design_point, second_order
from ropeway.systems.studies.uncertainty.limit_state import LimitState, densities, reader_of
from ropeway.systems.studies.uncertainty.uncertain import Uncertain

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@checked
@dataclass(frozen=True, eq=False)
class Reliability:
    """The probability that a limit is passed, as `rw.reliability` returns it.

    Attributes
    ----------
    output : str
        The result with the limit.
    limit : float
        The limit, in the unit of the result.
    upper : bool
        Whether the limit is passed above it.
    index : float
        Reliability index: distance of the limit from the median, in standard deviations of independent standard normal
        variables; negative if the median is beyond the limit.
    probability : float
        First-order probability that the limit is passed.
    second_order : float
        The probability with the curvature of the limit at the most probable failure (Hohenbichler and Rackwitz). NaN
        if the curvature is too strong. Where both differ by more than a few per cent, sample the cases.
    per_limit : float
        Derivative of the first-order probability by the limit.
    frame : DataFrame
        A row an input: `median`; `design`, its value in the most probable failure, and its normal `score`;
        `importance`, its share in the variance of the linearised result there, with a sum of 1; `per_mean` and
        `per_deviation`, derivatives of the first-order probability by the mean and by the standard deviation of its
        distribution.
    solves : int
        Evaluations of the limit and its derivatives, without those of the curvature.

    Examples
    --------
    >>> from scipy.stats import norm
    >>> inputs = rw.Uncertain({"load": norm(10.0, 2.0), "strength": norm(20.0, 1.5)})
    >>> rw.reliability(lambda load, strength: strength - load, inputs, below=0.0).frame["importance"].round(2).to_dict()
    {'load': 0.64, 'strength': 0.36}
    """

    output: str
    limit: float
    upper: bool
    index: float
    probability: float
    second_order: float
    per_limit: float
    frame: pd.DataFrame
    solves: int

    def __repr__(self) -> str:
        words = "above" if self.upper else "below"
        first = self.frame["importance"].idxmax()
        return (
            f"<Reliability: {self.output} {words} {self.limit:g} with a probability of {self.probability:.3g}, index "
            f"{self.index:.3g}, {self.frame.loc[first, 'importance']:.0%} by {first}>"
        )

    def plot(self) -> Figure:
        """The importance of each input.

        Returns
        -------
        Figure
            Bars, the most important input at the top.
        """
        from ropeway.components.notebook_figure import new_figure

        shares = self.frame["importance"].sort_values()
        figure = new_figure(figsize=(7.0, 1.2 + 0.3 * len(shares)), layout="constrained")
        axis = figure.subplots()
        axis.barh([str(name) for name in shares.index], 100.0 * shares.to_numpy(), color="#4c78a8")
        axis.set(xlabel="importance [%]", xlim=(0.0, 100.0))
        words = "above" if self.upper else "below"
        axis.set_title(f"{self.output} {words} {self.limit:g}: probability {self.probability:.2g}", loc="left")
        axis.grid(axis="x", alpha=0.3)
        return figure


@checked
@interruptible
def reliability(
    study: Study | System | Model,
    inputs: Uncertain,
    output: str = "value",
    *,
    above: float | None = None,
    below: float | None = None,
    workers: Workers = 1,
) -> Reliability:
    """First-order probability (FORM) that a result passes a limit.

    The point of the limit with the highest probability density is found in standard normal space, and the limit is
    replaced by its tangent plane there. Some ten equilibria suffice where random cases take thousands. Its error comes
    from the curvature of the limit, which `second_order` corrects.

    Parameters
    ----------
    study : System, Model or callable
        A line, whose equilibrium is differentiated exactly; or a function as in `rw.sweep`, differentiated by
        central differences.
    inputs : Uncertain
        Distributions of parameters of the line, named as in `rw.sweep`, or of the function's arguments.
    output : str, default "value"
        The result with a limit; "value" for a function that returns a number.
    above : float, optional
        The upper limit, in the unit of the result.
    below : float, optional
        The lower limit; one of both is given.
    workers : int or dask.distributed.Client, default 1
        Of a function, as in `rw.sweep`.

    Returns
    -------
    Reliability

    Raises
    ------
    InputError, UnknownNameError
        No limit or two, an unknown name, or a line that is invalid as declared.
    DesignPointError
        The search did not converge, or the study fails on its way.

    Examples
    --------
    >>> from scipy import stats
    >>> inputs = rw.Uncertain({"pull": stats.norm(100.0, 10.0), "strength": stats.norm(130.0, 10.0)})
    >>> rw.reliability(lambda pull, strength: strength - pull, inputs, below=0.0).probability.__round__(4)
    0.0169
    """
    if (above is None) == (below is None):
        raise InputError("reliability has no limit, or two", "Give above= or below=")
    limit = float(below if above is None else above)  # type: ignore[arg-type]  # one of them is given
    check.number(limit, "reliability", "the limit")
    state = LimitState(inputs, reader_of(study, inputs, output, workers), limit, above is not None)
    point = design_point(state)
    return _result(state, output, point)


def _result(state: LimitState, output: str, point: DesignPoint) -> Reliability:
    from scipy.special import ndtr
    from scipy.stats import norm

    inputs, alpha = state.inputs, point.direction
    z = inputs.factor @ point.u
    values = inputs.values(z)
    by_score = np.linalg.solve(inputs.factor.T, alpha)  # of the linearised limit, by the normal scores
    density = float(norm.pdf(point.index))
    # A shift of a distribution changes the normal score of the design point, and by it the index.
    shift = densities(inputs, values) / np.maximum(norm.pdf(z), 1e-300)
    means = np.array([d.mean() for d in inputs.distributions.values()])
    deviations = np.array([d.std() for d in inputs.distributions.values()])
    frame = pd.DataFrame(
        {
            "median": inputs.values(np.zeros(len(z))),
            "design": values,
            "score": z,
            "importance": by_score**2 / float(by_score @ by_score),
            "per_mean": density * by_score * shift,
            "per_deviation": density * by_score * shift * (values - means) / deviations,
        },
        index=pd.Index(inputs.names, name="input"),
    )
    slope = density / point.steepness
    return Reliability(
        output=output,
        limit=state.limit,
        upper=state.upper,
        index=point.index,
        probability=float(ndtr(-point.index)),
        second_order=second_order(state, point),
        per_limit=-slope if state.upper else slope,
        frame=frame,
        solves=point.solves,
    )
