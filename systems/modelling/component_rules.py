"""Rules for every component: names, units, counts, and equations on symbols."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import casadi as ca
import numpy as np

from ropeway.components import units
from ropeway.components.component import Component, RopeEnd
from ropeway.components.errors import InputError, RopewayError
from ropeway.components.node import Node
from ropeway.components.variable import Equations, Kind, Variable

RESERVED = ("time", "gravity", "weather")
"""Attributes of `v` besides those of a component."""
_UNKNOWNS = (Kind.STATE, Kind.ALGEBRAIC, Kind.PARAMETER)
_TRIES = 4


def require_declared(component: Component, variables: Sequence[Variable]) -> None:
    """Raises InputError for inconsistent variables, ports and limits."""
    if component.external:  # its names and units come from elsewhere
        return
    owner = _owner(component)
    for v in variables:
        if not isinstance(v, Variable):
            raise InputError(f"{owner}: variables() returns {v!r}", "Return Variable objects")
    for v in variables:
        _require_sound(v, owner)
    _require_names(component, variables)
    sizes = {kind: sum(v.size for v in variables if v.kind is kind) for kind in Kind}
    if sizes[Kind.ALGEBRAIC] != sizes[Kind.RESIDUAL]:
        raise InputError(
            f"{owner} has {sizes[Kind.ALGEBRAIC]} algebraic variables and {sizes[Kind.RESIDUAL]} residuals",
            "Declare one RESIDUAL for each ALGEBRAIC variable",
        )
    _require_references(component, {v.name: v.kind for v in variables})


def _require_names(component: Component, variables: Sequence[Variable]) -> None:
    owner = _owner(component)
    taken = dict.fromkeys(RESERVED, "a quantity that every component has")
    taken.update({port.name: "a port" for port in component.ports})
    taken.update(dict.fromkeys((*component.sums, *component.shares), "a signal"))
    for v in variables:
        if not v.name.isidentifier() and v.kind is not Kind.RESIDUAL:
            raise InputError(f"{owner}: {v.name!r} is not a valid name of a variable", "Use letters, digits and _")
        if v.name in taken:
            raise InputError(f"{owner}: variable {v.name!r} has the name of {taken[v.name]}", "Rename it")
    for kinds in ((*_UNKNOWNS, Kind.INPUT, Kind.DISCRETE, Kind.OUTPUT), (Kind.RESIDUAL,)):
        counts = Counter(v.name for v in variables if v.kind in kinds)
        twice = [name for name, count in counts.items() if count > 1]
        if twice:
            raise InputError(f"{owner}: two variables are named {twice[0]!r}", "Give each variable its own name")


def _require_sound(v: Variable, owner: str) -> None:
    named = f"{owner}: variable {v.name!r}"
    texts, numbers = (v.name, v.unit, v.description), (v.nominal, *np.ravel(np.array(v.value, dtype=object)))
    if not all(isinstance(text, str) for text in texts) or not isinstance(v.kind, Kind):
        raise InputError(f"{named} is {v!r}", "Give a name, a Kind, a unit and a description")
    if not all(isinstance(n, (int, float, np.number)) and not isinstance(n, bool) for n in numbers):
        raise InputError(f"{named} has the value {v.value!r} and the nominal value {v.nominal!r}", "Give numbers")
    if units.parse(v.unit) is None and v.unit:
        raise InputError(f"{named} has the unit {v.unit!r}, which is unknown", "Write it like 'N', 'm/s2' or '1'")
    if not (isinstance(v.size, int) and v.size >= 0):
        raise InputError(f"{named} has the size {v.size!r}", "Give an integer, 0 or more")
    if not (np.isfinite(v.nominal) and v.nominal > 0.0):
        raise InputError(f"{named} has the nominal value {v.nominal!r}", "Give a typical magnitude above zero")
    values = np.atleast_1d(np.asarray(v.value, dtype=float))
    if not np.isfinite(values).all():
        raise InputError(f"{named} has the value {v.value!r}", "Give finite numbers")
    if isinstance(v.value, tuple) and len(v.value) != v.size:
        raise InputError(f"{named} has {len(v.value)} values and the size {v.size}", "Give one value for each element")


def _require_references(component: Component, kinds: Mapping[str, Kind]) -> None:
    """Raises InputError if a limit, seat or balance names an unknown variable."""
    owner = _owner(component)

    def require(name: str | None, wanted: tuple[Kind, ...], what: str) -> None:
        if name is not None and not (name in kinds and kinds[name] in wanted):
            words = " or ".join(kind.value for kind in wanted)
            raise InputError(
                f"{owner}: {what} names {name!r}, which is not {words}", f"Declare {name!r} in variables()"
            )

    for limit in component.limits():
        require(limit.output, (Kind.OUTPUT,), f"the limit {limit.event!r}")
    if not isinstance(component, Node):
        return
    for axis in "xyz":
        require(axis, _UNKNOWNS, "the position of a node")
    require(component.drive_speed, (Kind.INPUT, *_UNKNOWNS), "drive_speed")
    for seat in component.seats:
        require(seat.travel, _UNKNOWNS, f"the travel of seat {seat.name!r}")
        for part in ("x", "z", "rope") if seat.offset else ():
            require(f"{seat.offset}_{part}", _UNKNOWNS, f"the offset of seat {seat.name!r}")
        require(component.balance_at(seat), (Kind.RESIDUAL,), "balance")
    for place, force in component.free:
        require(place, (Kind.ALGEBRAIC,), "free")
        require(force, (Kind.RESIDUAL,), "free")


def evaluated(component: Component, v: Any) -> Equations:
    """The equations of a component on symbols. Raises InputError if they cannot be evaluated on symbols."""
    owner = _owner(component)
    try:
        found = component.equations(v)
    except RopewayError:
        raise
    except AttributeError as error:
        if error.obj is not v:
            raise
        raise InputError(
            f"{owner}: its equations read v.{error.name}, which is neither a variable nor a port",
            f"Declare {error.name!r} in variables()",
        ) from error
    except (RuntimeError, TypeError, NotImplementedError) as error:
        raise InputError(
            f"{owner}: its equations use the value of a symbol ({str(error).strip().splitlines()[-1][:120]})",
            "Equations are evaluated once, on CasADi symbols: use casadi.if_else, fmax, fmin and sqrt instead of if, "
            "max, min and math.sqrt",
        ) from error
    if not isinstance(found, Equations):
        raise InputError(f"{owner}: equations() returns {type(found).__name__}", "Return Equations(...)")
    return found


def require_complete(component: Component, variables: Sequence[Variable], found: Equations) -> None:
    """Raises InputError unless the equations return exactly what is declared."""
    owner, ends = _owner(component), [port.name for port in component.ports if isinstance(port, RopeEnd)]
    for what, given, wanted in (
        ("rates", found.rates, [v.name for v in variables if v.kind is Kind.STATE]),
        ("residuals", found.residuals, [v.name for v in variables if v.kind is Kind.RESIDUAL]),
        ("outputs", found.outputs, [v.name for v in variables if v.kind is Kind.OUTPUT]),
        ("forces", found.forces, ends),
        ("carried", found.carried, ends),
    ):
        missing, extra = [n for n in wanted if n not in given], [n for n in given if n not in wanted]
        if missing:
            raise InputError(f"{owner}: its equations return no {what[:-1]} {missing[0]!r}", f"Add it to {what}")
        if extra:
            raise InputError(
                f"{owner}: its equations return {what} {extra[0]!r}, which is not declared",
                f"Declare it in variables(), or remove it from {what}",
            )
    sizes = {v.name: v.size for v in variables}
    for values in (found.rates, found.residuals, found.outputs):
        for name, value in values.items():
            count = value.numel() if isinstance(value, (ca.SX, ca.MX, ca.DM)) else np.size(value)
            if count != sizes[name]:
                raise InputError(f"{owner}: {name!r} has {count} values and the size {sizes[name]}", "Make them equal")
    for end in ends:
        if len(found.forces[end]) != 3:
            raise InputError(f"{owner}: the force of {end!r} has {len(found.forces[end])} components", "Give (x, y, z)")


def require_numbers(component: Component, function: ca.Function, names: Sequence[Sequence[str]]) -> None:
    """Raises InputError for a result that is always NaN, as after `math.sqrt` of a symbol."""
    rng = np.random.default_rng(1)
    shapes = [function.size_in(i) for i in range(function.n_in())]
    broken: list[np.ndarray] | None = None
    for _ in range(_TRIES):
        results = function.call([ca.DM(rng.uniform(0.5, 1.5, shape)) for shape in shapes])
        wrong = [np.isnan(np.asarray(result)).ravel() for result in results]
        broken = wrong if broken is None else [one & other for one, other in zip(broken, wrong, strict=True)]
    for owned, bad in zip(names, broken or [], strict=False):
        for name, is_bad in zip(owned, bad, strict=False):
            if is_bad:
                raise InputError(
                    f"{_owner(component)}: {name!r} is NaN for all values",
                    "Use functions of CasADi, such as casadi.sqrt, instead of those of math",
                )


def _owner(component: Component) -> str:
    return f"{type(component).__name__} {component.name!r}"
