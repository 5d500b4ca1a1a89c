"""Fit of a system or a rig to measured values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ropeway.components.argument_checks import checked
from ropeway.components.errors import InputError, UnknownNameError
from ropeway.components.table import Source as Table
from ropeway.systems.interrupts import interruptible
from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.modelling.system import System
from ropeway.systems.rigs.skyline_rig import SkylineRig
from ropeway.systems.studies.fitting.fit_result import Fit
from ropeway.systems.studies.fitting.least_squares import Loss, Prior, Problem
from ropeway.systems.studies.fitting.line_source import LineSource
from ropeway.systems.studies.fitting.measured import Measured, Sigma, read_measured
from ropeway.systems.studies.fitting.observations import Observations
from ropeway.systems.studies.fitting.rig_source import RigSource
from ropeway.systems.studies.fitting.run_source import RunSource
from ropeway.systems.studies.fitting.solved_fit import fit_of
from ropeway.systems.studies.fitting.sources import Source


@checked
@interruptible
def fit(
    system: System | Model | SkylineRig,
    measured: Table,
    *,
    columns: Mapping[str, str] | None = None,
    free: str | Sequence[str],
    sigma: Sigma | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    prior: Mapping[str, tuple[float, float]] | None = None,
    loss: Loss = "linear",
) -> Fit:
    """Fit quantities of a system or a rig to measured values.

    Each row of the table is a state: an equilibrium, or a rig with its carriage at a station. With a column of times
    the rows are a series: a simulation from rest at time 0. Least squares with exact derivatives; the start are the
    declared values.

    Parameters
    ----------
    system : System, Model or SkylineRig
        Its declarations.
    measured : DataFrame, str or Path
        The table or its file. A blank cell of a measured column is skipped, a row with a blank given value left out;
        `Fit.notes` counts both.
    columns : mapping of str to str, optional
        The quantity that each column holds: {"A": "c2.tension_in"}; by default columns are named after quantities.
        Results are measured: tensions, forces, pressures, displacements; columns of a load path of a rig; "a_b.rope_z",
        the height of a point on a span's rope; "a_b.return_time", in which a blow on it returns [s]. Others are given
        in each row: parameters, inputs, masses; "station", "payload" and "height" of a rig; "a_b.rope_x" (and rope_y),
        the place of the point in plan; "time" [s] of a series, at regular intervals, whose given columns are inputs.
        Values are in SI units unless the header or the key has a unit ("A [kN]") or the name ends with one (skyline_kN,
        load_t).
    free : str or sequence of str
        Quantities to fit: those of `sensitivities`, and "A.gain" and "A.offset" of the sensor of column A.
    sigma : float or mapping of str to (float or sequence of float), optional
        Standard deviation of the measured values, in SI units; by column, and by row of the table. By default it is
        estimated from the residuals.
    bounds : mapping of str to (float, float), optional
        Lowest and highest value of a free quantity.
    prior : mapping of str to (float, float), optional
        What is known of a free quantity without the table: expected value and standard deviation.
    loss : {"linear", "huber", "soft_l1", "cauchy"}, default "linear"
        Loss of the squared residuals; all but the first are robust against outliers.

    Returns
    -------
    Fit
        Values, standard errors, covariance, residuals, what is unidentifiable, and the measurement that would help
        most.

    Raises
    ------
    InputError, UnknownNameError
        Before the fit: an unknown column or quantity, a unit that does not fit, fewer measured values than free
        quantities, contradicting bounds.
    EquilibriumError, SimulationError
        The declared system has no solution for a row.
    FitError
        The fit did not converge.

    Examples
    --------
    >>> measured = pd.DataFrame({"a.tension": [6400.0, 6500.0], "b.z": [5.0, 5.02]})
    >>> found = rw.fit(span, measured, free=["a_b.length"], sigma=100.0)
    >>> found.frame["standard_error"].shape
    (1,)
    """
    names = [free] if isinstance(free, str) else list(free)
    if not names or len(set(names)) != len(names):
        raise InputError(f"free is {names}", "Name each quantity to fit once")
    source, table = _read(system, measured, columns)
    observations = Observations(source, table, names)
    declared = np.array([observations.declared(name) for name in names])
    units = [observations.unit(name) for name in names]
    usual = np.array([observations.usual(name, value) for name, value in zip(names, declared.tolist(), strict=True)])
    known = _prior(names, usual, bounds or {}, prior or {})
    _require_enough(table, known, sigma is not None, loss)
    problem = Problem(observations, table.sigmas(sigma), known)
    solution = problem.solve(declared, loss, known_sigma=sigma is not None)
    return fit_of(problem, solution, declared, units, sigma is not None)


def _read(
    system: System | Model | SkylineRig, measured: Table, columns: Mapping[str, str] | None
) -> tuple[Source, Measured]:
    """The source of predictions, and the table. Raises InputError."""
    if isinstance(system, SkylineRig):
        source: Source = RigSource(system)
        table = read_measured(measured, columns, source.role, source.unit)
        if table.time is not None:
            raise InputError(f"{system.name!r} has a column of times", "Give the station of the carriage in each row")
        return source, table
    source = LineSource(system)
    table = read_measured(measured, columns, source.role, source.unit)
    return (RunSource(source) if table.time is not None else source), table


def _require_enough(table: Measured, known: Prior, known_sigma: bool, loss: Loss) -> None:
    """Raises InputError where the table does not suffice for the free quantities."""
    count, free = int(np.isfinite(table.cells).sum()), len(known.scale)
    least = free - int(np.isfinite(known.sigma).sum())
    if count < max(least, 1):
        raise InputError(
            f"The table has {count} measured values for {free} free quantities",
            "Measure more, fit fewer quantities, or give a prior",
        )
    if not known_sigma and count == least:
        raise InputError(
            f"{count} measured values for {free} free quantities do not tell how sure they are",
            "Give sigma, the standard deviation of the measured values",
        )
    if not known_sigma and loss != "linear":
        raise InputError(f"Loss {loss!r} has no scale", "Give sigma, the standard deviation of values without outliers")


def _prior(
    names: Sequence[str],
    scale: np.ndarray,
    bounds: Mapping[str, tuple[float, float]],
    prior: Mapping[str, tuple[float, float]],
) -> Prior:
    """Bounds, priors and usual changes (`scale`) as arrays. Raises InputError, UnknownNameError."""
    for what, given in (("bounds", bounds), ("prior", prior)):
        if unknown := [name for name in given if name not in names]:
            raise UnknownNameError(f"{what} has {unknown[0]!r}, which is not free", f"Free are {', '.join(names)}")
    low, high = np.full(len(names), -np.inf), np.full(len(names), np.inf)
    mean, sigma = np.zeros(len(names)), np.full(len(names), np.inf)
    for i, name in enumerate(names):
        if name in bounds:
            low[i], high[i] = bounds[name]
            if not low[i] < high[i]:
                raise InputError(f"Bounds of {name!r} are {low[i]:g} and {high[i]:g}", "Give the low one first")
        if name in prior:
            mean[i], sigma[i] = prior[name]
            if not (sigma[i] > 0.0 and np.isfinite(mean[i])):
                raise InputError(
                    f"prior of {name!r} is {mean[i]:g} with a standard deviation of {sigma[i]:g}",
                    "Give the expected value and a standard deviation above zero",
                )
            scale[i] = min(sigma[i], scale[i])
    return Prior(low, high, mean, sigma, scale)
