"""What every component is: a named frozen dataclass with variables, ports and equations.

A component that a rope runs over, or ends at, is a node: its seats have a position and a rope travel. A rope
piece has rope ends: they take position and travel from the seats they are connected to, and give back a
force. `equations` is the only place with a component's physics. It is called once per kind of component
(class and structure) with CasADi symbols, never with a particular component's numbers; those stand in
`variables`.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Any, ClassVar, NamedTuple

from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.catenary import Vector
from ropeway.components.check import ANY, Range
from ropeway.components.errors import UnknownNameError
from ropeway.components.laws import Law
from ropeway.components.schedule import Schedule


class Kind(Enum):
    """The part that a variable plays in the differential-algebraic equations."""

    PARAMETER = "parameter"
    INPUT = "input"
    STATE = "state"
    ALGEBRAIC = "algebraic"
    DISCRETE = "discrete"
    RESIDUAL = "residual"
    OUTPUT = "output"


@dataclass(frozen=True, slots=True)
class Variable:
    """A variable of a component. `value` is a parameter's value or an unknown's start; with `size` above 1
    the variable is an array. `freed_by` names the parameter that is freed when this output is solved for;
    `range`: values that a parameter may have; `kept_at_rest`: `equilibrium` leaves this state at its value, as the
    travel of a drum that holds its rope, instead of solving for a rate of zero; `hidden`: results do not show
    it, and number its entries."""

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


@dataclass(frozen=True, slots=True)
class Site:
    """What a component knows of its surroundings: typical `force` [N] and `length` [m] for scaling, and for
    a span its number of load `slots` and the `tension` vector [N] at its end a to start from."""

    force: float
    length: float
    slots: int = 0
    tension: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Port:
    """A place where a component is joined to another."""

    owner: Component = field(repr=False)
    name: str

    def __str__(self) -> str:
        return f"{self.owner.name}.{self.name}"


@dataclass(frozen=True, slots=True)
class RopeEnd(Port):
    """An end of a rope piece. In equations: `position` and `travel`; the component returns its force."""


@dataclass(frozen=True, slots=True)
class Outlet(Port):
    """Where a source, as a power unit, feeds any number of other components."""


@dataclass(frozen=True, slots=True)
class Supply(Port):
    """Where a component, as a drive, is fed by a source."""


@dataclass(frozen=True, slots=True)
class SignalOutput(Port):
    """An output or state that drives inputs of other components, any number of them."""


@dataclass(frozen=True, slots=True)
class SignalInput(Port):
    """An input that another component may drive."""


@dataclass(frozen=True, slots=True)
class Seat(Port):
    """Where a rope sits on a node. In equations: `force` of the rope on the node [N], rope `speed` [m/s], and
    `carried`, the energy that each metre of the rope's travel brings or takes, T + T^2/2EA [N].

    `travel` names the node's variable with the rope's travel; None where the rope is fixed to the node. An
    `optional` seat may stay empty: no force acts there. `offset`: where the rope leaves the node beside its place,
    the variables `OFFSET_x` and `OFFSET_z` say how far [m], and `OFFSET_rope` adds to the travel there [m].
    """

    travel: str | None = None
    optional: bool = False
    offset: str | None = None


@dataclass(frozen=True, slots=True)
class Equations:
    """What `equations` returns, by name: rates of the states, residuals (all zero), outputs, and for each
    rope end the force on the component and the energy `carried` per metre of rope, T + T^2/2EA [N]."""

    rates: Mapping[str, Any] = field(default_factory=dict)
    residuals: Mapping[str, Any] = field(default_factory=dict)
    outputs: Mapping[str, Any] = field(default_factory=dict)
    forces: Mapping[str, Vector] = field(default_factory=dict)
    carried: Mapping[str, Any] = field(default_factory=dict)


class Energies(NamedTuple):
    """Of a component in a run: `kinetic` energy [J], `loss` [W], and the work `supplied` from outside so far [J], as by
    a weight that sinks; arrays over the records, or zero."""

    kinetic: Any = 0.0
    loss: Any = 0.0
    supplied: Any = 0.0


def _alone(component: Any) -> Hashable:
    """All values of a component; itself where one of them has no hash."""
    try:
        hash(component)
    except TypeError:
        return _Alone(component)
    return component


@dataclass(frozen=True, slots=True, eq=False)
class _Alone:
    """Equal to nothing else; it keeps the component, so that no other one takes its place in memory."""

    component: Any


def form_of(part: Any) -> Hashable:
    """Of what a component is made of, as its drive: its type and what shapes its equations where its own class says
    that by `structure`; else all its values. Frozen dataclasses are both equal and hashable by these."""
    return (type(part), part.structure) if "structure" in vars(type(part)) else part


@dataclass(frozen=True, slots=True)
class Limit:
    """An output that must stay within `low` and `high`; `event` says what happens when it does not."""

    output: str
    event: str
    low: float = -math.inf
    high: float = math.inf


@checked
@dataclass(frozen=True)
class Component(ABC):
    """A thing with a name. `equations(v)` reads its variables and ports as attributes of `v`, besides
    `v.time` [s] and `v.gravity` [m/s2]. `external`: it calls compiled code, which takes no scalar symbols."""

    external: ClassVar[bool] = False
    name: str

    def __post_init__(self) -> None:
        check.name(self.name, type(self).__name__)

    @property
    @abstractmethod
    def ports(self) -> tuple[Port, ...]:
        """All ports, in the order in which the rope runs."""

    @abstractmethod
    def variables(self, site: Site) -> tuple[Variable, ...]:
        """This component's variables with its own values, starts and nominals."""

    @abstractmethod
    def equations(self, v: Any) -> Equations:
        """The physics, on symbols."""

    def laws(self, v: Any) -> Mapping[str, Law]:
        """What holds at rest, by the name of the residual that says the same: an independent check of `equations`,
        on NumPy arrays with one column for each component of the kind. `v` has the variables, `v.gravity`, and each
        seat with the `force` of its rope (3, ...) [N] and the rope's `speed` [m/s]. A residual without a law is
        checked by its own value."""
        return {}

    @property
    def has_laws(self) -> bool:
        """Whether `laws` are of these equations: a subclass with equations of its own does not keep its parent's."""
        laws, equations = (next(k for k in type(self).__mro__ if n in vars(k)) for n in ("laws", "equations"))
        return laws is not Component and issubclass(laws, equations)

    @property
    def outlet(self) -> Outlet:
        """Where it feeds others, any number of them."""
        return Outlet(self, "outlet")

    @property
    def supply(self) -> Supply:
        """Where a source feeds it; it may stay open."""
        return Supply(self, "supply")

    @property
    def sums(self) -> tuple[str, ...]:
        """Of a source: what others ask of it by these names, summed, read as attributes of `v`."""
        return ()

    @property
    def shares(self) -> tuple[str, ...]:
        """Outputs of its source that it takes, read as attributes of `v`; each is 1 while its supply is open."""
        return ()

    def demand(self, v: Any) -> Mapping[str, Any]:
        """What it asks of its source, by the names of the source's `sums`, on symbols; not a function of its shares."""
        return {}

    def limits(self) -> tuple[Limit, ...]:
        """What is reported when it happens."""
        return ()

    def energies(self, read: Callable[[str], Any]) -> Energies:
        """What `Result.energy` counts besides the work on ropes; read(name): a variable of the component over time."""
        return Energies()

    def output(self, name: str) -> SignalOutput:
        """An output or a state by its name, to be connected to inputs. Raises UnknownNameError."""
        self._require(name, Kind.OUTPUT, Kind.STATE)
        return SignalOutput(self, name)

    def input(self, name: str) -> SignalInput:
        """An input by its name, to be connected to an output. Raises UnknownNameError."""
        self._require(name, Kind.INPUT)
        return SignalInput(self, name)

    def unit_of(self, name: str) -> str:
        """The unit of a variable; "" where it is not known."""
        return next(v.unit for v in self.variables(Site(1.0, 1.0)) if v.name == name)

    def driver(self, name: str) -> float | Schedule | None:
        """What drives an input that is not connected; None where it is left open."""
        driver: float | Schedule | None = getattr(self, name, None)
        return driver

    def _require(self, name: str, *kinds: Kind) -> None:
        known = [v.name for v in self.variables(Site(1.0, 1.0)) if v.kind in kinds]
        if name not in known:
            what = " or ".join(kind.value for kind in kinds)
            raise UnknownNameError(f"{self.name!r} has no {what} {name!r}", f"It has {', '.join(known[:12]) or 'none'}")

    def structure(self, site: Site) -> Hashable:
        """What shapes the equations besides the values of the variables.

        A class that defines this shares one function among all its components of equal structure: its equations may
        use numbers of the component only as variables, or through what is returned here. Each component of another
        class, a subclass too, has a function of its own.
        """
        return _alone(self)

    def form(self, site: Site) -> Hashable:
        """Components of equal form have equal equations."""
        shared = "structure" in vars(type(self))
        return (type(self), self.structure(site) if shared else _alone(self), site.slots)


@checked
@dataclass(frozen=True)
class Node(Component):
    """A component at a place `at` = (x, z) or (x, y, z) [m], where ropes sit. `label`: any text, which pictures and
    messages show; by default its name."""

    interchangeable: ClassVar[bool] = False
    """Whether a rope takes any seat that is still open."""
    role: ClassVar[str] = "other support"
    """What pictures call it: supports of one role have one marker."""

    at: tuple[float, ...]
    label: str = field(default="", kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "label", self.label or self.name)
        object.__setattr__(self, "at", check.point(self.at, self.described))

    @property
    def described(self) -> str:
        """How error messages name it."""
        return f"{type(self).__name__} {self.label!r}"

    @property
    def arriving(self) -> Seat:
        """The seat where a rope arrives."""
        return self.seats[0]

    @property
    def leaving(self) -> Seat:
        """The seat where a rope leaves."""
        return self.seats[-1]

    @property
    @abstractmethod
    def seats(self) -> tuple[Seat, ...]:
        """The seats, in the order in which the rope runs."""

    @property
    def ports(self) -> tuple[Port, ...]:
        return self.seats

    @property
    def drive_speed(self) -> str | None:
        """Name of the variable with the commanded or driven rope speed; None if it does not drive."""
        return None

    @property
    def drive_power(self) -> str | None:
        """Name of the output with the drive's power into the rope [W]; None if it does not drive a rope through."""
        return None

    def through(self, seat: Seat) -> Seat | None:
        """The seat where the rope that arrives at `seat` goes on; None where it ends."""
        return None

    @property
    def kept_tension(self) -> float | None:
        """Tension that the node keeps by letting rope run [N]; None if it does not."""
        return None

    @property
    def balance(self) -> str | None:
        """Name of the residual that determines the node's travel, where that is an algebraic variable."""
        return None

    def balance_at(self, seat: Seat) -> str | None:
        """The same for the rope at a seat, where several ropes run over the node."""
        return self.balance

    @property
    def free(self) -> tuple[tuple[str, str], ...]:
        """Algebraic variables of a place that ropes hold, each with the residual of the forces along it."""
        return ()

    def place(self) -> tuple[Variable, ...]:
        """The parameters of its position."""
        return tuple(
            Variable(axis, Kind.PARAMETER, "m", f"{axis} coordinate of the support", value, 100.0)
            for axis, value in zip("xyz", self.at, strict=True)
        )
