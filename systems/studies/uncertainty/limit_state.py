"""The distance of a result to its limit, and its derivatives by the uncertain inputs.

Of a line the derivatives are exact (`sensitivities`); of a function they are central differences.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
import pandas as pd

from ropeway.components.errors import DesignPointError, RopewayError, UnknownNameError
from ropeway.systems.modelling.assembly import assemble
from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.modelling.system import System
from ropeway.systems.studies.sensitivity.sensitivities import sensitivities
from ropeway.systems.studies.sweeps.cases import table_of
from ropeway.systems.studies.sweeps.line_study import LineStudy, line_study, line_unit
from ropeway.systems.studies.sweeps.sweep import Study, sweep
from ropeway.systems.studies.sweeps.workers import Workers
from ropeway.systems.studies.uncertainty.uncertain import Uncertain

_STEP = 1e-3
"""Difference of a normal score."""

Read = Callable[[np.ndarray], tuple[float, np.ndarray]]
"""A result and its derivatives by the normal scores, for normal scores z (n,). Raises DesignPointError."""


@dataclass(frozen=True)
class LimitState:
    """g = limit - result, or result - limit for a lower limit: the limit is passed where g is negative."""

    inputs: Uncertain
    read: Read
    limit: float
    upper: bool

    def at(self, u: np.ndarray) -> tuple[float, np.ndarray]:
        """g and its derivatives by the independent standard normal numbers u (n,). Raises DesignPointError."""
        result, slopes = self.read(self.inputs.factor @ u)
        sign = -1.0 if self.upper else 1.0
        return sign * (result - self.limit), sign * (self.inputs.factor.T @ slopes)


def reader_of(study: Study | System | Model, inputs: Uncertain, output: str, workers: Workers) -> Read:
    """The reader of a line or of a function. Raises InputError, UnknownNameError."""
    if not isinstance(study, (System, Model)):
        return partial(_of_function, study, inputs, output, workers)
    model = study if isinstance(study, Model) else assemble(study)
    rows = pd.DataFrame([np.zeros(len(inputs.names)), np.ones(len(inputs.names))], columns=list(inputs.names))
    in_si = table_of(rows, partial(line_unit, model))  # a name may have a unit in brackets
    names, (offset, one) = tuple(in_si.columns), in_si.to_numpy(dtype=float)
    line = line_study(model, names, [output])
    return partial(_of_line, line, inputs, names, one - offset, offset)


def _of_line(
    line: LineStudy, inputs: Uncertain, names: tuple[str, ...], factor: np.ndarray, offset: np.ndarray, z: np.ndarray
) -> tuple[float, np.ndarray]:
    values = offset + factor * inputs.values(z)
    try:
        rest = line.at(dict(zip(names, values.tolist(), strict=True)))
        (output,) = line.outputs
        slopes = sensitivities(rest, of=output, to=names).to_numpy()[0]
    except RopewayError as error:
        raise _failed(inputs, values, str(error)) from error
    return float(rest[output]), slopes * factor * _value_slopes(inputs, z)


def _of_function(
    study: Study, inputs: Uncertain, output: str, workers: Workers, z: np.ndarray
) -> tuple[float, np.ndarray]:
    steps = _STEP * np.eye(len(z))
    points = np.vstack([z, z + steps, z - steps])
    table = sweep(
        study, pd.DataFrame(inputs.values(points), columns=list(inputs.names)), workers=workers, progress=False
    )
    failed = table[table["error"] != ""]
    if len(failed):
        raise _failed(inputs, inputs.values(points[failed.index[0]]), failed["message"].iloc[0])
    if output not in table:
        known = ", ".join(str(c) for c in table.columns if c not in (*inputs.names, "error", "message"))
        raise UnknownNameError(f"The study does not return {output!r}", f"It returns {known}")
    found = table[output].to_numpy(dtype=float)
    if not np.isfinite(found).all():
        place = int(np.argmin(np.isfinite(found)))
        raise _failed(inputs, inputs.values(points[place]), f"{output} is {found[place]}")
    up, down = np.split(found[1:], 2)
    return float(found[0]), (up - down) / (2.0 * _STEP)


def densities(inputs: Uncertain, values: np.ndarray) -> np.ndarray:
    """Probability density of each input at its value, (n,)."""
    return np.array([float(d.pdf(x)) for d, x in zip(inputs.distributions.values(), values, strict=True)])


def _value_slopes(inputs: Uncertain, z: np.ndarray) -> np.ndarray:
    """Derivatives of each input by its normal score, (n,)."""
    from scipy.stats import norm

    return norm.pdf(z) / np.maximum(densities(inputs, inputs.values(z)), 1e-300)


def _failed(inputs: Uncertain, values: np.ndarray, message: str) -> DesignPointError:
    case = ", ".join(f"{name} = {value:.6g}" for name, value in zip(inputs.names, values, strict=True))
    return DesignPointError(f"The study fails at {case}: {message}", "Narrow the distributions, or sweep their cases")
