"""A skyline rig: its parts, its kind, and its System with the carriage in one of the spans."""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING

from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.carriage import Carriage
from ropeway.components.carriage_on_shoe import CarriageOnShoe
from ropeway.components.environment import Environment
from ropeway.components.errors import EquilibriumError, InputError
from ropeway.components.map_frame import MapFrame
from ropeway.components.notebook_table import html_of
from ropeway.systems.modelling.declarations import require_weather
from ropeway.systems.modelling.system import System
from ropeway.systems.rigs import carriage_guess
from ropeway.systems.rigs.guylines import string_guylines
from ropeway.systems.rigs.rig_kind import RigKind
from ropeway.systems.rigs.rig_parts import RigParts
from ropeway.systems.rigs.rope_paths import string_haulback, string_mainline

if TYPE_CHECKING:
    from matplotlib.figure import Figure

STEEPEST = 0.98
"""Sine of the steepest slope of a shoe on which a carriage can stand."""


@checked
@dataclass(frozen=True, eq=False, kw_only=True)
class SkylineRig(RigParts):
    """A skyline with its carriage.

    `rw.standing_skyline`, `rw.live_skyline`, `rw.gravity_skyline` and `rw.running_skyline` create rigs.

    Parameters
    ----------
    terrain : Profile or None
        The ground; None where spars and supports are given by position.
    headspar : HeadSpar
        The headspar, at its position on the terrain like all supports.
    supports : tuple of IntermediateSupport
        Supports in the order of their stations.
    tailspar : TailSpar or GuyedSpar
        The tailspar, at the far end of the last span.
    skyline : Rope
        Rope that supports the carriage; in a running skyline the haulback.
    length : float or None
        Unstretched length from the headspar to the end of the skyline [m]; None for a running skyline.
    tension : float or None
        Tension of the bare skyline at the headspar, or at the drum of a running skyline [N].
    mainline : Rope or None
        Rope from the headspar to the carriage.
    haulback : Rope or None
        Rope that pulls the carriage out; None for a running skyline, which has it as its skyline.
    haulback_tension : float or None
        Tension at the haulback's drum [N].
    haulback_block : Block or None
        Block near the tailspar.
    carriage : Carriage
        The carriage, with an ideal holding force if no rope or clamp holds it.
    turn : Turn or None
        A log on a dropline.
    name : str
        Name in results and messages.
    gravity : float
        Gravitational acceleration [m/s2].
    temperature : float
        Temperature at which its ropes are strung [degrees C].
    environment : Environment or None
        Weather.
    kind : RigKind
        Kind of the rig: standing, live, gravity or running skyline.

    Examples
    --------
    >>> rig = rw.standing_skyline(
    ...     None, headspar=rw.HeadSpar("head", at=(0.0, 0.0)), tailspar=rw.TailSpar("tail", at=(200.0, -20.0)),
    ...     skyline="RHOL-IWRC 29", length=207.0, carriage=rw.Carriage("carriage", mass=400.0),
    ... )
    >>> rig
    <SkylineRig 'standing skyline': head at 0 m, tail at 200 m>
    >>> round(rw.equilibrium(rig.system(station=120.0, payload=2000.0))["carriage.z"], 2)
    -36.84
    """

    kind: RigKind

    def __repr__(self) -> str:
        stations = ", ".join(f"{node.name} at {node.at[0]:g} m" for node in self.stands)
        return f"<SkylineRig {self.name!r}: {stations}>"

    def _repr_html_(self) -> str:
        """Its spars and supports in a table, for notebooks."""
        rows = [
            {"name": node.name, "kind": type(node).__name__, "station [m]": node.at[0], "top [m]": node.at[2]}
            for node in self.stands
        ]
        return html_of(repr(self), rows)

    def plot(self, view: str = "elevation") -> Figure:
        """Plot the ground, spars, supports and the bare skyline.

        Parameters
        ----------
        view : {"elevation", "3d"}, default "elevation"

        Returns
        -------
        matplotlib.figure.Figure
            To scale in elevation.

        Raises
        ------
        InputError
            There is no such view.
        """
        from ropeway.systems.rigs.rig_plot import rig_figure

        return rig_figure(self, view)

    @property
    def map_frame(self) -> MapFrame | None:
        """The map frame of its terrain."""
        return None if self.terrain is None else self.terrain.map_frame

    @property
    def skyline_drum(self) -> str:
        """Name of the drum that sets the skyline's length or tension.

        The tension on a running skyline; "" on a standing skyline.
        """
        return self.kind.skyline_drum(self)

    def in_weather(self, environment: Environment) -> SkylineRig:
        """The same rig in other weather.

        Parameters
        ----------
        environment : Environment
            The weather.

        Returns
        -------
        SkylineRig
            Its ropes strung as before.

        Raises
        ------
        InputError
            Wind or ice on a rope without a diameter; wind across a shoe.
        """
        rig = replace(self, environment=environment)
        require_weather(rig.system())
        return rig

    def span_of(self, station: float) -> int:
        """The span of a station.

        Parameters
        ----------
        station : float
            Between headspar and tailspar [m].

        Returns
        -------
        int
            Index from 0; at a support, the span before it.

        Raises
        ------
        InputError
            The station is outside the skyline.
        """
        x = [node.at[0] for node in self.stands]
        if not x[0] < station < x[-1]:
            raise InputError(
                f"Station {station:g} m is outside the skyline",
                f"Choose one between {x[0]:g} m and {x[-1]:g} m",
            )
        return bisect_left(x, station) - 1

    def chord(self, span: int, station: float) -> float:
        """Height z of the chord of a span.

        Parameters
        ----------
        span : int
            Index from 0.
        station : float
            [m].

        Returns
        -------
        float
            [m].

        Raises
        ------
        InputError
            There is no such span.
        """
        check.index(span, self.spans, self.name, "span")
        a, b = self.stands[span].at, self.stands[span + 1].at
        return a[2] + (b[2] - a[2]) * (station - a[0]) / (b[0] - a[0])

    def shoe_near(self, station: float) -> int | None:
        """The support with a shoe near a station.

        Parameters
        ----------
        station : float
            [m].

        Returns
        -------
        int or None
            Index of the support from 0; None if no shoe is within its own diameter of the station.
        """
        for k, support in enumerate(self.supports):
            if abs(station - support.at[0]) < 2.0 * support.radius:
                return k
        return None

    def start(self, span: int, station: float, payload: float, height: float | None = None) -> carriage_guess.Start:
        """An initial guess for the carriage, from geometry.

        Parameters
        ----------
        span : int
            Index from 0.
        station : float
            [m].
        payload : float
            [kg].
        height : float, optional
            Prescribed z of the carriage [m].

        Returns
        -------
        Start
            Height z [m], skyline tension and mainline pull [N].

        Raises
        ------
        InputError
            There is no such span, or the station is outside the skyline.
        """
        check.index(span, self.spans, self.name, "span")
        if not self.stands[0].at[0] <= station <= self.stands[-1].at[0]:
            raise InputError(f"Station {station:g} m is outside the skyline", "Choose a station between its spars")
        return self.kind.guess(self, span, station, payload, height)

    def on_shoe_start(self, on: int, station: float, payload: float) -> carriage_guess.Start:
        """An initial guess for the carriage on a support's shoe.

        Parameters
        ----------
        on : int
            Index of the support from 0.
        station : float
            [m].
        payload : float
            [kg].

        Returns
        -------
        Start
            Height z [m], approximate skyline tension, and pull along the shoe [N].

        Raises
        ------
        InputError
            There is no such support.
        EquilibriumError
            The station is off the shoe.
        """
        check.index(on, len(self.supports), self.name, "on")
        support = self.supports[on]
        x = station - support.centre[0]
        if abs(x) > STEEPEST * support.radius:
            raise EquilibriumError(f"Station {station:g} m is off the shoe of {support.name!r}", "Choose one on it")
        rise = (support.radius**2 - x * x) ** 0.5
        tension = self.start(on, support.at[0] - support.radius, payload).tension
        pull = (self.carriage.mass + payload) * self.gravity * x / support.radius
        return carriage_guess.Start(support.centre[1] + rise, tension, pull)

    def system(
        self,
        span: int = 0,
        station: float | None = None,
        payload: float | None = None,
        *,
        on: int | None = None,
        rollers: int | None = None,
    ) -> System:
        """The System with the carriage in a span or on a shoe.

        `equilibrium(rig.system(0, 120.0))` solves it. With an ideal holding force the station is exact (`carriage.x` is
        a parameter). Otherwise fix `carriage.x` and solve for the travel of the mainline's drum (or of the clamp of a
        clamped carriage).

        Parameters
        ----------
        span : int, default 0
            Index from 0.
        station : float, optional
            Approximate station of the carriage [m]; by default mid-span.
        payload : float, optional
            Payload [kg]; by default that of the carriage.
        on : int, optional
            Index from 0 of a support with a radius, whose shoe supports the carriage.
        rollers : int, optional
            Number of supports with a roller under the mainline; by default all supports that the carriage has passed.

        Returns
        -------
        System
            System with all ropes of the rig, guylines and log.

        Raises
        ------
        InputError
            The station is not in the span, or the support has no shoe.
        SlackRopeError
            The bare skyline does not hang taut.
        """
        mass = self.carriage.payload if payload is None else payload
        carriage, start = self._carriage(span, station, mass) if on is None else self._on_shoe(on, station, mass)
        span = span if on is None else on
        system = self.empty_system()
        for spar in self.guyed_spars:
            string_guylines(system, spar)
        self.kind.string(system, self, carriage, span, on)
        string_mainline(system, self, carriage, span if rollers is None else rollers, start.pull)
        string_haulback(system, self, carriage)
        if self.turn is not None:
            x, y, z = carriage.at
            log = self.turn.under(x, y, z, mass, self.terrain)
            system.string(self.turn.dropline, carriage.dropline, log, length=self.turn.length)
        return system

    def _carriage(self, span: int, station: float | None, mass: float) -> tuple[Carriage, carriage_guess.Start]:
        """The carriage near a station of a span."""
        if not 0 <= span < self.spans:
            raise InputError(f"Span {span} of {self.spans} does not exist", f"Choose from 0 to {self.spans - 1}")
        before, after = self.stands[span].at, self.stands[span + 1].at
        x = (before[0] + after[0]) / 2.0 if station is None else station
        if not before[0] < x < after[0]:
            ends = f"{self.stands[span].name} and {self.stands[span + 1].name}"
            raise InputError(
                f"Station {x:g} m is not between {ends}", f"They stand at {before[0]:g} m and {after[0]:g} m"
            )
        start = self.start(span, x, mass)
        share = (x - before[0]) / (after[0] - before[0])
        position = (x, before[1] + share * (after[1] - before[1]), start.z)
        return replace(self.carriage, at=position, payload=mass if self.turn is None else 0.0), start

    def _on_shoe(self, on: int, station: float | None, mass: float) -> tuple[Carriage, carriage_guess.Start]:
        """The carriage on a support's shoe."""
        if not 0 <= on < len(self.supports) or self.supports[on].radius <= 0.0:
            raise InputError(f"{self.name} has no shoe {on}", "Give the support a radius")
        support = self.supports[on]
        x = support.at[0] if station is None else station
        start = self.on_shoe_start(on, x, mass)
        attributes = {f.name: getattr(self.carriage, f.name) for f in fields(self.carriage)}
        attributes.update(at=(x, support.at[1], start.z), payload=mass if self.turn is None else 0.0)
        return CarriageOnShoe(**attributes, support=support, mainline_on_roller=self.pulled), start


def studied_in(rig: SkylineRig, environment: Environment | None) -> SkylineRig:
    """The rig of a study with an argument `environment`: without one, as it is; in a calm one, without weather. Raises
    InputError."""
    if environment is None:
        return rig
    return replace(rig, environment=None) if environment.is_calm(rig.temperature) else rig.in_weather(environment)
