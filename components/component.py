"""What every component is: a named frozen dataclass with variables, ports and equations.

A node is a component that a rope runs over or ends at: its seats have a position and a rope travel. A piece of rope has
rope ends, which take position and travel from the seats that they are connected to, and return a force. `equations` is
the only place with a component's physics. It is called once for each form of a component (class and structure), on
CasADi symbols. The numbers of a component are in `variables`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.errors import UnknownNameError
from ropeway.components.external_events import ExternalEvents
from ropeway.components.form import by_values
from ropeway.components.inertia import Inertia
from ropeway.components.laws import Law
from ropeway.components.schedule import Schedule
from ropeway.components.variable import Energies, Equations, Kind, Limit, Site, Variable


@dataclass(frozen=True, slots=True)
class Port:
    """A connection point of a component."""

    owner: Component = field(repr=False)
    name: str

    def __str__(self) -> str:
        return f"{self.owner.name}.{self.name}"


@dataclass(frozen=True, slots=True)
class RopeEnd(Port):
    """An end of a piece of rope.

    In equations it has `position` and `travel`; the component returns the force at it. An inertial component also has
    `velocity` and `acceleration` of the node (vectors), `speed` and `rope_acceleration`, the first and second
    derivatives of the travel.

    Parameters
    ----------
    owner : Component
        The component.
    name : str
        Identifier of the port.

    Examples
    --------
    >>> rw.Span("a_b", rope=rope, length=90.0).a.name
    'a'
    """


@dataclass(frozen=True, slots=True)
class Outlet(Port):
    """Port of a source, such as a power unit, that feeds any number of components."""


@dataclass(frozen=True, slots=True)
class Supply(Port):
    """Port of a component, such as a drive, that a source feeds."""


@dataclass(frozen=True, slots=True)
class SignalOutput(Port):
    """An output or state that drives inputs of any number of other components."""


@dataclass(frozen=True, slots=True)
class SignalInput(Port):
    """An input that another component can drive."""


@dataclass(frozen=True, slots=True)
class Seat(Port):
    """Where a rope sits on a node.

    In equations it has the `force` of the rope on the node [N], the rope `speed` [m/s], and `carried`, the energy that
    each metre of rope carries in or out, T + T^2/2EA [N]; `expansion`, the length of the rope without tension over that
    at which it was strung. An inertial node also has the `inertia` of the rope at the seat, a vector [N] that the rope
    must overcome, its component `along` the rope from a to b, and `side`: 1 where the rope leaves, -1 where it arrives.

    Parameters
    ----------
    owner : Component
        The component.
    name : str
        Identifier of the port.
    travel : str, optional
        The variable of the node with the rope's travel; None where the rope is fixed to the node.
    optional : bool, default False
        Whether the seat may stay empty; the force is then zero.
    offset : str, optional
        Prefix of the variables with the point where the rope leaves the node: `OFFSET_x` and `OFFSET_z` from the
        position of the node [m]; `OFFSET_rope` adds to the travel there [m].
    speed, acceleration : str, optional
        Variables of the node with the rate of the rope's travel [m/s] and the rate of that [m/s2]; None where they are
        zero or unknown.
    rates : str, default ""
        Prefix of the variables `velocity_x` ... `acceleration_z` with which the end of the rope moves there; by default
        those of the node.

    Examples
    --------
    >>> rw.Sheave("s1", at=(90.0, 8.0)).seats[0].travel
    'travel'
    """

    travel: str | None = None
    optional: bool = False
    offset: str | None = None
    speed: str | None = None
    acceleration: str | None = None
    rates: str = ""


@checked
@dataclass(frozen=True)
class Component(ABC):
    """Base class of all components.

    A component of your own is a frozen dataclass that inherits from this one, or from `Node` if a rope sits on it.
    `external`: whether its equations call compiled code, which takes no scalar symbols. `inertial`: whether its ports
    have, besides, what its equations need for inertia (`with_inertia`).

    Parameters
    ----------
    name : str
        Identifier; dotted names of results begin with it.

    Examples
    --------
    >>> rw.Sheave("s1", at=(90.0, 8.0)).output("wrap").name
    'wrap'
    """

    external: ClassVar[bool] = False
    inertial: ClassVar[bool] = False
    name: str

    def __post_init__(self) -> None:
        check.name(self.name, type(self).__name__)

    @property
    @abstractmethod
    def ports(self) -> tuple[Port, ...]:
        """All ports, in the order in which the rope runs."""

    @abstractmethod
    def variables(self, site: Site) -> tuple[Variable, ...]:
        """Variables with this component's values, initial guesses and nominals.

        Parameters
        ----------
        site : Site
            Typical force and length, for nominals; number of load slots.

        Returns
        -------
        tuple of Variable
            Parameters, inputs, states, unknowns, residuals and outputs.
        """

    @abstractmethod
    def equations(self, v: Any) -> Equations:
        """The physics, on symbols.

        Parameters
        ----------
        v : object
            The variables and ports as attributes, `v.time` [s], `v.gravity` [m/s2], and `v.weather`, which is None
            unless the system has an environment.

        Returns
        -------
        Equations
            Rates, residuals, outputs and forces. No Python `if` on a symbol.
        """

    def laws(self, v: Any) -> Mapping[str, Law]:
        """What holds at rest: a check that is independent of `equations`.

        Parameters
        ----------
        v : object
            The variables as NumPy arrays with a column for each component of the form, `v.gravity`, and each seat with
            the `force` of its rope (3, ...) [N] and the rope's `speed` [m/s].

        Returns
        -------
        mapping of str to Law
            A law for each residual, by its name. A residual without a law is checked by its own value.
        """
        return {}

    def with_inertia(self, inertia: Inertia) -> Component:
        """The component with the inertia of its rope, its load or its wheel.

        Parameters
        ----------
        inertia : Inertia
            What is taken into account.

        Returns
        -------
        Component
            By default itself: its own equations hold at each time.
        """
        return self

    @property
    def has_laws(self) -> bool:
        """Whether `laws` belong to these equations: a subclass that overrides `equations` loses those of its parent."""
        laws, equations = (next(k for k in type(self).__mro__ if n in vars(k)) for n in ("laws", "equations"))
        return laws is not Component and issubclass(laws, equations)

    @property
    def external_events(self) -> ExternalEvents | None:
        """Events of its own, of a component whose equations are code from outside."""
        return None

    @property
    def outlet(self) -> Outlet:
        """Port that feeds any number of other components."""
        return Outlet(self, "outlet")

    @property
    def supply(self) -> Supply:
        """Port that a source feeds; it may stay open."""
        return Supply(self, "supply")

    @property
    def sums(self) -> tuple[str, ...]:
        """Of a source: demands on it, summed over the components that it feeds, read as attributes of `v`."""
        return ()

    @property
    def shares(self) -> tuple[str, ...]:
        """Outputs of its source that it uses, read as attributes of `v`; each is 1 if its supply is open."""
        return ()

    def demand(self, v: Any) -> Mapping[str, Any]:
        """Demand on its source, on symbols.

        Parameters
        ----------
        v : object
            The variables and ports as attributes, without `shares`.

        Returns
        -------
        mapping of str
            Demands by the names of the source's `sums`.
        """
        return {}

    def limits(self) -> tuple[Limit, ...]:
        """Outputs that must stay within bounds.

        Returns
        -------
        tuple of Limit
            Each is reported as an event when its output leaves the bounds.
        """
        return ()

    def energies(self, read: Callable[[str], Any]) -> Energies:
        """Energies that `Result.energy` counts besides the work on ropes.

        Parameters
        ----------
        read : callable
            `read(name)` returns a variable of the component over time.

        Returns
        -------
        Energies
            Arrays over the records of the run.
        """
        return Energies()

    def output(self, name: str) -> SignalOutput:
        """An output or a state, to be connected to inputs.

        Parameters
        ----------
        name : str
            Name of the output or state.

        Returns
        -------
        SignalOutput
            For `System.connect`.

        Raises
        ------
        UnknownNameError
            The component has no such output or state.
        """
        self._require(name, Kind.OUTPUT, Kind.STATE)
        return SignalOutput(self, name)

    def input(self, name: str) -> SignalInput:
        """An input, to be connected to an output.

        Parameters
        ----------
        name : str
            Name of the input.

        Returns
        -------
        SignalInput
            For `System.connect`.

        Raises
        ------
        UnknownNameError
            The component has no such input.
        """
        self._require(name, Kind.INPUT)
        return SignalInput(self, name)

    def unit_of(self, name: str) -> str:
        """Unit of a variable.

        Parameters
        ----------
        name : str
            Name of the variable.

        Returns
        -------
        str
            Its symbol; "" if it is unknown.
        """
        return next(v.unit for v in self.variables(Site(1.0, 1.0)) if v.name == name)

    def driver(self, name: str) -> float | Schedule | None:
        """Value of an input that is not connected.

        Parameters
        ----------
        name : str
            Name of the input.

        Returns
        -------
        float, Schedule or None
            None leaves it open as an input of the model.
        """
        driver: float | Schedule | None = getattr(self, name, None)
        return driver

    def _require(self, name: str, *kinds: Kind) -> None:
        known = [v.name for v in self.variables(Site(1.0, 1.0)) if v.kind in kinds]
        if name not in known:
            what = " or ".join(kind.value for kind in kinds)
            raise UnknownNameError(f"{self.name!r} has no {what} {name!r}", f"It has {', '.join(known[:12]) or 'none'}")

    def structure(self, site: Site) -> Hashable:
        """What determines the form of the equations besides the values of the variables.

        Components of one class that defines this, and of equal structure, share one CasADi function. Their equations
        may use numbers of the component only as variables, or through the value returned here. A subclass has a
        function of its own.

        Parameters
        ----------
        site : Site
            Number of load slots.

        Returns
        -------
        hashable
            By default all values of the component.
        """
        return by_values(self)

    def form(self, site: Site) -> Hashable:
        """Key of the equations: components of equal form have equal equations.

        Parameters
        ----------
        site : Site
            Number of load slots.

        Returns
        -------
        hashable
            Class, structure, number of load slots, and whether there is weather.
        """
        shared = "structure" in vars(type(self))
        return (type(self), self.structure(site) if shared else by_values(self), site.slots, site.weather)
