"""Inputs that other components drive.

Such an input becomes an algebraic variable, with a residual that equates it to its source. A loop of outputs and inputs
is so solved together with all other equations.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import casadi as ca

from ropeway.components.variable import Kind, Variable
from ropeway.systems.modelling.declarations import Declarations

Owned = Mapping[str, tuple[Variable, ...]]
"""Variables of each component."""


def with_links(system: Declarations, variables: Owned) -> dict[str, tuple[Variable, ...]]:
    """The variables, with each driven input as an algebraic variable behind all others of its component.

    Its nominal is at least that of its source.
    """
    nominals = {(name, v.name): v.nominal for name, owned in variables.items() for v in owned}

    def driven(name: str, v: Variable) -> Variable:
        return replace(v, kind=Kind.ALGEBRAIC, nominal=max(v.nominal, nominals[system.links[name, v.name]]))

    return {
        name: (
            *(v for v in owned if (name, v.name) not in system.links),
            *(driven(name, v) for v in owned if (name, v.name) in system.links),
        )
        for name, owned in variables.items()
    }


def with_residuals(system: Declarations, variables: Owned) -> dict[str, tuple[Variable, ...]]:
    """The variables of `with_links`, with the residual of each driven input behind all others of its component."""
    return {
        name: (*owned, *(replace(v, kind=Kind.RESIDUAL) for v in owned if (name, v.name) in system.links))
        for name, owned in variables.items()
    }


def differences(
    system: Declarations, component: str, owned: Sequence[Variable], quantity: Callable[[str, str], ca.MX]
) -> list[ca.MX]:
    """Each driven input of a component minus its source; `quantity(component, name)`: a variable or an output."""
    return [
        quantity(component, v.name) - quantity(*system.links[component, v.name])
        for v in owned
        if (component, v.name) in system.links
    ]
