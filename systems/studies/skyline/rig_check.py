"""Whether a solved point of a rig is an equilibrium that its ropes can have, and whether it can be the only one."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ropeway.components.errors import EquilibriumError, OutOfReachError
from ropeway.components.guyed_spar import GuyedSpar
from ropeway.systems.modelling.dae_model import Balance, Model, component_of
from ropeway.systems.rigs.skyline_rig import SkylineRig
from ropeway.systems.solvers.newton import Buffered, Newton, Point, outputs_of
from ropeway.systems.statics.condensed_stiffness import CondensedStiffness, places_of
from ropeway.systems.studies.skyline.log_check import LogCheck

SLACK = 2.4
"""A rope with w L / H above this hangs on the slack branch: the least support tension of a level span comes at
w L / H = 2.40. The difference asinh(v/H) between both ends is w L / H, for steep ropes too."""

ABSURD = 10.0
"""No rope carries this multiple of its minimum breaking load: such a root is no state of a rig."""

LEAN = 0.1
"""A stable guyed spar that leans less than this part of its height has no second stable place so near."""


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
        self._most = ABSURD * np.array([span.rope.breaking_load for span, _ in spans])
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
        self._outputs, self._jacobian = outputs_of(model), Buffered(newton.jacobian)

    def require(self, point: Point) -> bool:
        """Raises EquilibriumError for a root that no rope can have, or that is unstable. Returns whether there can be
        no other root: all ropes that run through are taut, guyed spars about upright, a log as it must be."""
        outputs = self._outputs(*point.arguments)[0].copy()
        names = self.model.y.names
        lengths = outputs[self._lengths]
        if not lengths.min() > 0.0:
            name = component_of(names[self._lengths[int(np.argmin(lengths))]])
            raise EquilibriumError(f"No rope is left in span {name!r}", "Give more rope", name)
        with np.errstate(divide="ignore", invalid="ignore"):  # a plumb rope is not slack
            loose = np.arcsinh(outputs[self._ends] / outputs[self._across]).sum(axis=0) > SLACK
        slack = loose & self._must_be_taut
        if slack.any():
            name = component_of(names[self._lengths[int(np.argmax(slack))]])
            raise EquilibriumError(f"Rope {name!r} would hang slack", "Ask for more pull", name)
        excess = outputs[self._tensions].max(axis=0) / self._most
        if excess.max() > 1.0:
            k = int(np.argmax(excess))
            name = component_of(names[self._lengths[k]])
            role = self._roles[k] or "guyline"
            raise OutOfReachError(
                f"Rope {name!r} would carry {ABSURD * float(excess[k]):.0f} times its minimum breaking load",
                "Give it more length, or the carriage more sag",
                name,
                f"{self.rig.kind.carrying_rope if role == 'skyline' else role} tension",
            )
        if self._pushing is not None and point.p[self._pushing] <= 0.0:
            raise EquilibriumError("The haulback would have to push", "Ask for a lower carriage", "haulback")
        alone = not (loose & self._runs_through).any() and all(outputs[k] < most for k, most in self._leans)
        if self.log is not None:
            alone &= self.log.require(point, outputs)
        self._require_stable(point)
        return bool(alone)

    def _require_stable(self, point: Point) -> None:
        """The stiffness of all free places and travels, forces in balance, must be positive definite.

        A carriage at its station on a shoe or beside one is held there: where it would run over at once its own
        balance along its path is the unstable one, and its drum has that length all the same. Tensions on both sides of
        that shoe are equal: of the rope between them each side has a part that counts from the shoe's middle only."""
        near = self._on
        if near is None and self._x is not None:
            near = self.rig.shoe_near(float(point.z[self._x]))
        if near is not None and near not in self._beside:
            self._beside[near] = self._free_beside(self.rig.supports[near].name)
        free = self._free if near is None else self._beside[near]
        if not free.balances:
            return
        jacobian = self._jacobian_at(point)
        pivots = _pivots(free, jacobian)
        if pivots.min() > 0.0:
            return
        for name, tops in self._tops().items():
            if _pivots(free.condensed(tops), jacobian).min() <= 0.0:
                raise OutOfReachError(
                    f"The guylines of {name!r} do not hold it: it would topple",
                    "Spread their anchors around the spar, or give them more pretension",
                    name,
                    f"guylines of {name}",
                )
        name = component_of(self.model.z.names[free.balances[int(np.argmax(pivots <= 0.0))].travel])
        raise EquilibriumError(f"The balance at {name!r} is unstable", "Give the ropes more tension", name)

    def _free_beside(self, support: str) -> CondensedStiffness:
        """With the carriage kept in its path, and tensions on both sides of a support equal."""
        travels = [self.model.z.index.get(f"{name}.travel") for name in (support, f"{support}_mainline")]
        free = [b for b in self._free.balances if b not in self._along and b.travel not in travels]
        kept = np.concatenate([places_of(self._along), self._free.kept], axis=1)
        return CondensedStiffness(self.newton, free, kept)

    def _jacobian_at(self, point: Point) -> np.ndarray:
        """The entries of the Jacobian of the scaled residuals by the scaled unknowns."""
        arguments = self.newton.arguments(point)
        return self._jacobian(*arguments._replace(target=np.zeros(self.newton.jacobian.size1_in("target"))))[0]

    def _tops(self) -> dict[str, list[Balance]]:
        """The balances of the top of each guyed spar."""
        names = self.model.z.names
        return {
            spar.name: [b for b in self._free.balances if names[b.travel] in (f"{spar.name}.x", f"{spar.name}.y")]
            for spar in (self.rig.headspar, self.rig.tailspar)
            if isinstance(spar, GuyedSpar)
        }


def _pivots(free: CondensedStiffness, jacobian: np.ndarray) -> np.ndarray:
    """Its pivots; zeros where the equations of all else are singular."""
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
    """Rows and columns of a log and its dropline: the carriage is stable or not under what they pull. Whether the log
    itself is as it must be `LogCheck` says."""
    if rig.turn is None:
        return np.zeros((2, 0), int)
    log = rig.turn.log.name
    owners = (f"{log}.", f"{rig.carriage.name}_{log}.")
    return np.array(
        [[k for name, k in index.items() if name.startswith(owners)] for index in (model.r.index, model.z.index)], int
    )
