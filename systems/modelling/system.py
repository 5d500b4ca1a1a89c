"""Declarations of a user: components, their connections, and the loads on their ropes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, TypeVar, overload

from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.component import Component, Port, Seat
from ropeway.components.environment import TEMPERATURES, Environment
from ropeway.components.errors import InputError
from ropeway.components.ground import Ground
from ropeway.components.load import Load
from ropeway.components.node import Node
from ropeway.components.notebook_table import html_of
from ropeway.components.response import check_precedence
from ropeway.components.rope import Rope
from ropeway.components.span import Span
from ropeway.components.terrain import Profile
from ropeway.systems.modelling.connections.ports import connect
from ropeway.systems.modelling.connections.rope_loads import feed, hang
from ropeway.systems.modelling.connections.stringing import string_over
from ropeway.systems.modelling.connections.subsystem import Subsystem, include
from ropeway.systems.modelling.declarations import Declarations, require_weather
from ropeway.systems.modelling.user_code import caller

if TYPE_CHECKING:
    from matplotlib.figure import Figure

GRAVITY = 9.80665
"""Standard gravity [m/s2]."""

STRUNG = 15.0
"""Temperature at which ropes are strung, if nothing is said [degrees C]."""

_Added = TypeVar("_Added", bound=Component)


@checked
class System(Declarations):
    """Components and their connections. Declarations only: nothing is solved here.

    Parameters
    ----------
    name : str, default "system"
        Any text.
    gravity : float, default 9.80665
        Gravity [m/s2].
    precedence : str, default "all at once"
        Which control sheaves act if several respond at one sample: "all at once", "upstream first", "downstream first",
        "worst first" or "neighbours locked out".
    terrain : Profile, optional
        The ground under it: its stations are x, its map is that of the system.
    temperature : float, default 15
        Temperature at which its ropes are strung, for which their lengths hold [degrees C].

    Raises
    ------
    InputError
        A gravity that is not positive, an impossible temperature, or an unknown precedence.

    Examples
    --------
    >>> s = rw.System("one span")
    >>> (span,) = s.string(rope, rw.Anchor("a", at=(0.0, 0.0)), rw.Anchor("b", at=(400.0, -60.0)), length=408.0)
    >>> load = s.hang(rw.Load("turn", mass=6000.0), span, at=190.0)
    >>> list(s.components)
    ['a', 'b', 'a_b']
    """

    def __init__(
        self,
        name: str = "system",
        *,
        gravity: float = GRAVITY,
        precedence: str = "all at once",
        terrain: Profile | None = None,
        temperature: float = STRUNG,
    ) -> None:
        check_precedence(precedence)
        check.positive(gravity, f"System {name!r}", "gravity", "m/s2")
        check.number(temperature, f"System {name!r}", "temperature", "degrees C", TEMPERATURES)
        super().__init__(name, gravity, precedence, temperature)
        if terrain is not None:
            self.ground, self.map_frame = Ground(terrain), terrain.map_frame

    def __repr__(self) -> str:
        spans = sum(isinstance(c, Span) for c in self.components.values())
        feeds = f", {len(self.feeds)} feeds" if self.feeds else ""
        return (
            f"<System {self.name!r}: {len(self.components) - spans} components, {spans} spans, {len(self.hung)} loads"
            f"{feeds}>"
        )

    def _repr_html_(self) -> str:
        """Its components in a table, for notebooks."""
        rows = [
            {
                "name": str(name),
                "kind": type(c).__name__,
                "place [m]": ", ".join(f"{v:g}" for v in c.at) if isinstance(c, Node) else "",
                "length [m]": c.length if isinstance(c, Span) else float("nan"),
            }
            for name, c in self.components.items()
        ]
        return html_of(repr(self), rows)

    def plot(self, view: str = "elevation") -> Figure:
        """Plot the supports as they are declared, with straight spans.

        Parameters
        ----------
        view : {"elevation", "3d"}, default "elevation"

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        InputError
            There is no support, or no such view.
        """
        from ropeway.systems.modelling.system_plot import system_figure

        return system_figure(self, view)

    @property
    def precedence(self) -> str:
        """Which control sheaves act if several respond at one sample."""
        return self.precedences[""]

    @precedence.setter
    def precedence(self, value: str) -> None:
        check_precedence(value)
        self.precedences = dict.fromkeys(self.precedences, value)

    def precedence_of(self, component: str) -> tuple[str, str]:
        """Subsystem of a component, "" for none, and the precedence among its control sheaves."""
        own = max((g for g in self.precedences if not g or component.startswith(f"{g}.")), key=len)
        return own, self.precedences[own]

    @overload
    def add(self, component: _Added) -> _Added: ...

    @overload
    def add(self, component: System, name: str) -> Subsystem: ...

    def add(self, component: _Added | System, name: str | None = None) -> _Added | Subsystem:
        """Add a component, or a system as a part of this one.

        Parameters
        ----------
        component : Component or System
            A component, or a system: its components become `name.component`, its loads `name.load`. Its open ports are
            connected here. Its sheaves keep their own precedence.
        name : str, optional
            Name of the subsystem.

        Returns
        -------
        Component or Subsystem
            The component; for a system its components by their own names: `line = outer.add(inner, name="a")`,
            `line["c1"].supply`.

        Raises
        ------
        InputError
            The name is used already, or the system has another gravity, temperature or environment.
        """
        if isinstance(component, System):
            return include(self, component, name, caller())
        if name is not None:
            raise InputError(f"{component.name!r} has a name", "Give name= with a system")
        known = self.components.get(component.name)
        if known is component:
            return component
        if known is not None or component.name in self.load_names:
            first = self.origin(component.name, "; the first was added at {}")
            raise InputError(f"Two components are named {component.name!r}{first}", "Give each component its own name")
        self.components[component.name] = component
        self.origins[component.name] = caller()
        return component

    def connect(self, one: Port, other: Port) -> None:
        """Connect two ports.

        A rope end and a seat: same position and rope travel, forces sum to zero. The supply of a drive and the outlet
        of a power unit, which feeds any number of drives. An `output` of a component and the `input` of another, whose
        own value it replaces.

        Parameters
        ----------
        one, other : Port
            The ports, in any order.

        Raises
        ------
        InputError
            A port is connected already, or the ports do not match.
        """
        connect(self, one, other)

    def string(
        self,
        rope: Rope,
        *over: Node | Seat,
        length: float | None = None,
        tension: float | None = None,
        name: str | None = None,
    ) -> tuple[Span, ...]:
        """String a rope over supports, from the first to the last.

        The empty rope at rest has equal tension on both sides of each support. This determines its length in each span,
        also where a drive then holds it.

        Parameters
        ----------
        rope : Rope
            The rope.
        *over : Node or Seat
            The supports, two or more; a seat for a node with several seats.
        length : float, optional
            Total unstretched length [m]; give either length or tension.
        tension : float, optional
            Tension of the empty rope at rest at the first support [N]; of two lengths with it the shorter one.
        name : str, optional
            Prefix of the names of the spans, for two ropes between the same supports.

        Returns
        -------
        tuple of Span
            The spans, named `from_to` or `name_from_to`.

        Raises
        ------
        InputError
            Invalid supports, or both or none of length and tension.
        SlackRopeError
            The tension is too low for the weight of the rope.
        """
        strung = string_over(rope, over, gravity=self.gravity, length=length, tension=tension, name=name)
        trial = self.copy()  # the system is unchanged if a part is invalid
        for component in (*strung.nodes, *strung.spans):
            trial.add(component)
        for span, a, b in zip(strung.spans, strung.leaving, strung.arriving, strict=True):
            trial.connect(span.a, a)
            trial.connect(span.b, b)
        self.components, self.connections, self.origins = trial.components, trial.connections, trial.origins
        self.seated = trial.seated
        return strung.spans

    def hang(self, load: Load, spans: Span | Sequence[Span], at: float) -> Load:
        """Clamp a load to a rope.

        Parameters
        ----------
        load : Load
            The load.
        spans : Span or sequence of Span
            A span, or consecutive spans, in which `equilibrium` then finds the load.
        at : float
            Unstretched distance from end a of the first span [m].

        Returns
        -------
        Load
            The load.

        Raises
        ------
        InputError
            The distance is beyond the rope, or the rope has a feed.
        """
        on = (spans,) if isinstance(spans, Span) else tuple(spans)
        hang(self, load, on, at)
        return load

    def feed(
        self, spans: Sequence[Span], *, spacing: float, masses: float | Sequence[float], drag_area: float = 0.0
    ) -> None:
        """Fill a rope with loads at a spacing; more enter at the first support as the rope moves.

        Parameters
        ----------
        spans : sequence of Span
            All spans of the rope.
        spacing : float
            Unstretched length of rope between loads [m].
        masses : float or sequence of float
            Masses [kg], used in order and repeated; 0 is a missing load.
        drag_area : float, default 0
            Drag coefficient times area of each load in the wind [m2].

        Raises
        ------
        InputError
            An invalid value, or a rope that carries loads already.
        """
        feed(self, tuple(spans), spacing=spacing, masses=masses, drag_area=drag_area)

    def in_weather(self, environment: Environment) -> System:
        """The same declarations in other weather.

        Temperature, wind pressure and direction become inputs of its model, ice its parameters.

        Parameters
        ----------
        environment : Environment
            The weather.

        Returns
        -------
        System
            A copy.

        Raises
        ------
        InputError
            Wind or ice on a rope without a diameter; wind across a shoe.
        """
        other = self.copy()
        other.environment = environment
        require_weather(other)
        return other

    def copy(self) -> System:
        """Copy the declarations, so that later ones do not change an existing model.

        Returns
        -------
        System
            The copy.
        """
        other = System(self.name, gravity=self.gravity, temperature=self.temperature)
        other.environment = self.environment
        other.precedences = dict(self.precedences)
        other.components, other.connections = dict(self.components), dict(self.connections)
        other.supplies, other.links = dict(self.supplies), dict(self.links)
        other.hung, other.feeds, other.origins = list(self.hung), list(self.feeds), dict(self.origins)
        other.seated = set(self.seated)
        other.ground, other.map_frame = self.ground, self.map_frame
        return other
