"""Variables of a component, and what its equations return."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Any, NamedTuple

from ropeway.components.catenary import Vector
from ropeway.components.check import ANY, Range


class Kind(Enum):
    """The role of a variable in the differential-algebraic equations.

    Examples
    --------
    >>> rw.Kind.STATE
    <Kind.STATE: 'state'>
    """

    PARAMETER = "parameter"
    INPUT = "input"
    STATE = "state"
    ALGEBRAIC = "algebraic"
    DISCRETE = "discrete"
    RESIDUAL = "residual"
    OUTPUT = "output"

    __hash__ = object.__hash__  # members are single objects; every vector and table is found by one


@dataclass(frozen=True, slots=True)
class Variable:
    """A variable of a component.

    Parameters
    ----------
    name : str
        Identifier within the component.
    kind : Kind
        Its role in the equations.
    unit : str
        Symbol of its SI unit; "1" without a unit.
    description : str
        Text in tables and FMUs.
    value : float or tuple of float, default 0
        Value of a parameter; initial guess or initial value of an unknown.
    nominal : float, default 1
        Typical magnitude, by which it is scaled.
    size : int, default 1
        Number of elements; above 1 it is an array.
    freed_by : str, optional
        Parameter that is freed when this output is solved for.
    range : Range, optional
        Valid values of a parameter.
    kept_at_rest : bool, default False
        Whether `equilibrium` keeps this state at its value, such as the travel of a drum, instead of solving for a rate
        of zero.
    hidden : bool, default False
        Whether results omit it.
    rate_of : str, optional
        Variable of the same component of which this one is the rate of change.

    Examples
    --------
    >>> rw.Variable("tension", rw.Kind.OUTPUT, "N", "tension of the rope", nominal=1e4).unit
    'N'
    """

    name: str
    kind: Kind
    unit: str
    description: str
    value: float | tuple[float, ...] = 0.0
    nominal: float = 1.0
    size: int = 1
    freed_by: str | None = None
    range: Range = ANY
    kept_at_rest: bool = False
    hidden: bool = False
    rate_of: str | None = None


@dataclass(frozen=True, slots=True)
class Site:
    """Surroundings of a component.

    Parameters
    ----------
    force, length : float
        Typical force [N] and length [m], for scaling.
    slots : int, default 0
        Number of load slots of a span.
    tension : tuple of float, default (0, 0, 0)
        Initial guess of the tension vector at end a of a span [N].
    weather : bool, default False
        Whether equations read `v.weather`: temperature, ice and wind. Otherwise that is None.

    Examples
    --------
    >>> rw.Site(force=50e3, length=90.0).force
    50000.0
    """

    force: float
    length: float
    slots: int = 0
    tension: tuple[float, float, float] = (0.0, 0.0, 0.0)
    weather: bool = False


@dataclass(frozen=True, slots=True)
class Equations:
    """What `equations` returns, by name.

    Parameters
    ----------
    rates : mapping of str, optional
        Time derivatives of the states.
    residuals : mapping of str, optional
        Residuals, which are zero in a solution.
    outputs : mapping of str, optional
        Outputs.
    forces : mapping of str, optional
        Force on the component at each rope end, a vector [N].
    carried : mapping of str, optional
        Energy that each metre of rope carries at each rope end, T + T^2/2EA [N].
    inertia : mapping of str, optional
        Of an inertial component: inertia of the rope at each rope end, a vector [N].
    expansion : float, default 1
        Length of the rope without tension over that at which it was strung.

    Examples
    --------
    >>> rw.Equations(outputs={"tension": 5e3}).outputs
    {'tension': 5000.0}
    """

    rates: Mapping[str, Any] = field(default_factory=dict)
    residuals: Mapping[str, Any] = field(default_factory=dict)
    outputs: Mapping[str, Any] = field(default_factory=dict)
    forces: Mapping[str, Vector] = field(default_factory=dict)
    carried: Mapping[str, Any] = field(default_factory=dict)
    inertia: Mapping[str, Vector] = field(default_factory=dict)
    expansion: Any = 1.0


class Energies(NamedTuple):
    """Energies of a component in a run, arrays over its records.

    Parameters
    ----------
    kinetic : array_like, default 0
        Kinetic energy [J].
    loss : array_like, default 0
        Power lost [W].
    supplied : array_like, default 0
        Work done from outside since the start [J], such as by a falling weight.

    Examples
    --------
    >>> rw.Energies(kinetic=120.0, loss=3.0).kinetic
    120.0
    """

    kinetic: Any = 0.0
    loss: Any = 0.0
    supplied: Any = 0.0


class MovingMass(NamedTuple):
    """A mass that moves with a variable of a node, for `rw.modes`.

    Parameters
    ----------
    place : str
        Name of the variable: a coordinate of the position, or a travel.
    mass : float
        Mass [kg]; for a travel referred to the rope.
    forces : mapping of str to float
        Residuals in which a force along the variable appears, each with its factor.

    Examples
    --------
    >>> rw.MovingMass("x", 450.0, {"balance_x": 1.0}).mass
    450.0
    """

    place: str
    mass: Any
    forces: Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class Limit:
    """An output that must stay within bounds.

    Parameters
    ----------
    output : str
        Name of the output.
    event : str
        What is reported when it leaves the bounds.
    low, high : float, optional
        Bounds; by default none.

    Examples
    --------
    >>> rw.Limit("tension", "too tight", high=60e3).high
    60000.0
    """

    output: str
    event: str
    low: float = -math.inf
    high: float = math.inf
