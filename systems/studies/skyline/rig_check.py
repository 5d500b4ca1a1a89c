"""Check that a solved point of a rig is a physical, stable equilibrium, and whether it is unique."""

from __future__ import annotations

import copy
from collections.abc import Sequence

import numpy as np

from ropeway.components.errors import EquilibriumError, OutOfReachError
from ropeway.components.guyed_spar import GuyedSpar
from ropeway.components.intermediate_support import IntermediateSupport
from ropeway.systems.modelling.dae_model import Model, component_of
from ropeway.systems.modelling.model_tables import Balance
from ropeway.systems.rigs.rope_paths import roller_name
from ropeway.systems.rigs.skyline_rig import SkylineRig
from ropeway.systems.solvers.newton import Newton, outputs_of
from ropeway.systems.solvers.points import Point
from ropeway.systems.statics.condensed_stiffness import CondensedStiffness, places_of
from ropeway.systems.studies.skyline.log_check import LogCheck

SLACK = 2.4
"""A rope with w L / H above this hangs on the slack branch: the least support tension of a level span comes at
w L / H = 2.40. The difference asinh(v/H) between both ends is w L / H, for steep ropes too."""

NON_PHYSICAL = 10.0
"""Tension over minimum breaking load above which a root is non-physical."""

LEAN = 0.1
"""Lean of a guyed spar over its height, below which a stable position is unique."""


class RigCheck:
    """Checks the points of one model of a rig: with its carriage in a span, or `on` a support's shoe."""

    def __init__(
        self, rig: SkylineRig, model: Model, newton: Newton, roles: Sequence[str], on: int | None, *, by_height: bool
    ) -> None:
        self.rig, self.model, self.newton = rig, model, newton
        y, spans = (
            model.y.index,
            [(span, role) for run, role in zip(model.runs, roles, strict=True) for span in run.spans],
        )
        # Ropes whose length or tension is an unknown have a slack root besides the taut one.
        free = ("mainline", "haulback", *(("skyline",) if by_height else ()))
        self.taut = tuple(span.name for span, role in spans if role in free)
        self._must_be_taut = np.array([role in free for _, role in spans])
        self._runs_through = np.array([role in ("skyline", *free) for _, role in spans])
        self._lengths = np.array([y[f"{span.name}.length"] for span, _ in spans])
        across, down, up, a, b = (
            np.array([y[f"{span.name}.{quantity}"] for span, _ in spans])
            for quantity in ("horizontal", "vertical_a", "vertical_b", "tension_a", "tension_b")
        )
        self._across, self._ends, self._tensions = across, np.array([down, up]), np.array([a, b])
        self._most = NON_PHYSICAL * np.array([span.rope.breaking_load for span, _ in spans])
        self._roles = [role for _, role in spans]
        self._pushing = None if rig.kind.keeps_length or not by_height else model.p.index[f"{rig.skyline_drum}.tension"]
        self._leans = [
            (y[f"{spar.name}.lean"], LEAN * (spar.height or 0.0))
            for spar in (rig.headspar, rig.tailspar)
            if isinstance(spar, GuyedSpar)
        ]
        self.log = None if rig.turn is None else LogCheck(rig.turn, rig.terrain, rig.carriage.name, model)
        along, others = _free_places(rig, model, on)
        self._free = CondensedStiffness(newton, [*others, *along], _under_carriage(rig, model))
        self._along, self._on = along, on
        self._beside: dict[int, CondensedStiffness] = {}
        self._x = model.z.index.get(f"{rig.carriage.name}.x")
        self._outputs = outputs_of(model)

    def of(self, rig: SkylineRig) -> RigCheck:
        """The same check for a rig with the same parts at other places."""
        other = copy.copy(self)
        other.rig = rig
        return other

    def require(self, point: Point) -> bool:
        """Raises EquilibriumError for a non-physical or unstable root. Returns whether the root is unique: all
        through-running ropes are taut, guyed spars nearly upright, and a log hangs free."""
        outputs = self._outputs(*point.arguments)[0].copy()
        names = self.model.y.names
        lengths = outputs[self._lengths]
        if not lengths.min() > 0.0:
            name = component_of(names[self._lengths[int(np.argmin(lengths))]])
            raise EquilibriumError(f"No rope is left in span {name!r}", "Increase the rope length", name)
        with np.errstate(divide="ignore", invalid="ignore"):  # a vertical rope is not slack
            on_slack_branch = np.arcsinh(outputs[self._ends] / outputs[self._across]).sum(axis=0) > SLACK
        slack = on_slack_branch & self._must_be_taut
        if slack.any():
            name = component_of(names[self._lengths[int(np.argmax(slack))]])
            raise EquilibriumError(f"Rope {name!r} would hang slack", "Increase its tension", name)
        excess = outputs[self._tensions].max(axis=0) / self._most
        if excess.max() > 1.0:
            k = int(np.argmax(excess))
            name = component_of(names[self._lengths[k]])
            role = self._roles[k] or "guyline"
            raise OutOfReachError(
                f"Rope {name!r} would carry {NON_PHYSICAL * float(excess[k]):.0f} times its minimum breaking load",
                "Increase its length, or the sag at the carriage",
                name,
                f"{self.rig.kind.carrying_rope if role == 'skyline' else role} tension",
            )
        if self._pushing is not None and point.p[self._pushing] <= 0.0:
            raise EquilibriumError("The haulback would have to push", "Lower the carriage", "haulback")
        unique = not (on_slack_branch & self._runs_through).any() and all(
            outputs[k] < limit for k, limit in self._leans
        )
        if self.log is not None:
            unique &= self.log.require(point, outputs)
        self._require_stable(point)
        return bool(unique)

    def _require_stable(self, point: Point) -> None:
        """Raises EquilibriumError unless the condensed stiffness of all free positions and travels is positive
        definite.

        A carriage on or next to a shoe is held at its station: where it would jump over the shoe, its balance along the
        path is unstable, but the drum's length is still valid. Tensions on both sides of that shoe are equal."""
        shoe = self._on
        if shoe is None and self._x is not None:
            shoe = self.rig.shoe_near(float(point.z[self._x]))
        if shoe is not None and shoe not in self._beside:
            self._beside[shoe] = self._free_beside(self.rig.supports[shoe])
        free = self._free if shoe is None else self._beside[shoe]
        if not free.balances:
            return
        jacobian = self._jacobian_at(point)
        pivots = _pivots(free, jacobian)
        if pivots.min() > 0.0:
            return
        for name, tops in self._tops().items():
            if _pivots(free.condensed(tops), jacobian).min() <= 0.0:
                raise OutOfReachError(
                    f"The guylines of {name!r} do not stabilise it: it would topple",
                    "Spread their anchors around the spar, or increase their pretension",
                    name,
                    f"guylines of {name}",
                )
        name = component_of(self.model.z.names[free.balances[int(np.argmax(pivots <= 0.0))].travel])
        raise EquilibriumError(f"The balance at {name!r} is unstable", "Increase the tension of the ropes", name)

    def _free_beside(self, support: IntermediateSupport) -> CondensedStiffness:
        """Stiffness with the carriage fixed along its path and equal tensions on both sides of a support."""
        travels = [self.model.z.index.get(f"{name}.travel") for name in (support.name, roller_name(support))]
        free = [b for b in self._free.balances if b not in self._along and b.travel not in travels]
        kept = np.concatenate([places_of(self._along), self._free.kept], axis=1)
        return CondensedStiffness(self.newton, free, kept)

    def _jacobian_at(self, point: Point) -> np.ndarray:
        """The entries of the Jacobian of the scaled residuals by the scaled unknowns."""
        return self.newton.jacobian_values(point)

    def _tops(self) -> dict[str, list[Balance]]:
        """The balances of the top of each guyed spar."""
        names = self.model.z.names
        return {
            spar.name: [b for b in self._free.balances if names[b.travel] in (f"{spar.name}.x", f"{spar.name}.y")]
            for spar in (self.rig.headspar, self.rig.tailspar)
            if isinstance(spar, GuyedSpar)
        }


def _pivots(free: CondensedStiffness, jacobian: np.ndarray) -> np.ndarray:
    """Pivots of the stiffness; zeros if the other equations are singular."""
    try:
        return free.pivots(jacobian)
    except RuntimeError:
        return np.zeros(len(free.balances))


def _free_places(rig: SkylineRig, model: Model, on: int | None) -> tuple[list[Balance], list[Balance]]:
    """The balances of the carriage along its path, and all others."""
    name, z, r = rig.carriage.name, model.z.index, model.r.index
    free = list(model.balances)
    if rig.ideal:
        # The ideal force acts on the balance in x; the rope runs through the carriage by its tension law.
        free.append(Balance(z[f"{name}.travel"], r[f"{name}.tension_law"], 1.0))
        if on is None:
            free += [Balance(z[f"{name}.{axis}"], r[f"{name}.balance_{axis}"], 1.0) for axis in "yz"]
        return [], free
    if on is not None:
        return [Balance(z[f"{name}.x"], r[f"{name}.balance"], 1.0)], free
    along = [b for b in free if b.travel == z[f"{name}.x"]]
    return along, [b for b in free if b not in along]


def _under_carriage(rig: SkylineRig, model: Model) -> np.ndarray:
    """Rows and columns of a log and its dropline, whose pull on the carriage is fixed in the stability check.
    `LogCheck` checks the log itself."""
    if rig.turn is None:
        return np.zeros((2, 0), int)
    log = rig.turn.log.name
    owners = (f"{log}.", f"{rig.carriage.name}_{log}.")
    return np.array(
        [[k for name, k in index.items() if name.startswith(owners)] for index in (model.r.index, model.z.index)], int
    )
