"""The flat differential-algebraic equations, the input of every solver."""

from __future__ import annotations

import os
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, wraps
from threading import RLock
from typing import Any, Concatenate, ParamSpec, TypeVar

import casadi as ca
import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import maximum_bipartite_matching

from ropeway.components.argument_checks import checked
from ropeway.components.inertia import Inertia
from ropeway.components.schedule import Schedule
from ropeway.components.variable import Kind
from ropeway.systems.modelling.model_tables import Balance, Limits, RunLayout, VariableTable
from ropeway.systems.modelling.rope_path import Run
from ropeway.systems.modelling.sampled_control import Clock
from ropeway.systems.modelling.structure import Structure
from ropeway.systems.modelling.system import System

_Arguments = ParamSpec("_Arguments")
_Made = TypeVar("_Made")

BUILDING = RLock()
"""CasADi releases the interpreter's lock, but functions that threads build from the same expressions can disturb each
other: one is built at a time."""
if hasattr(os, "register_at_fork"):
    os.register_at_fork(before=BUILDING.acquire, after_in_parent=BUILDING.release, after_in_child=BUILDING.release)


def kept_with_model(
    make: Callable[Concatenate[Model, _Arguments], _Made],
) -> Callable[Concatenate[Model, _Arguments], _Made]:
    """Decorator of a function of a model, such as one that builds a solver: the model caches the result for its own
    lifetime. Threads that call it at the same time get the same object."""

    @wraps(make)
    def kept(model: Model, /, *args: _Arguments.args, **kwargs: _Arguments.kwargs) -> _Made:
        found: _Made = _known(model.derived, (make, args, *kwargs.values()), lambda: make(model, *args, **kwargs))
        return found

    return kept


def kept_with_structure(
    make: Callable[Concatenate[Model, _Arguments], _Made],
) -> Callable[Concatenate[Model, _Arguments], _Made]:
    """As `kept_with_model`, for what depends on the positions in a model's equations alone, not on names or values:
    models of equal structure share it."""

    @wraps(make)
    def kept(model: Model, /, *args: _Arguments.args, **kwargs: _Arguments.kwargs) -> _Made:
        derived = model.structure.derived
        found: _Made = _known(derived, (make, args, *kwargs.values()), lambda: make(model, *args, **kwargs))
        return found

    return kept


def _known(derived: dict[Hashable, Any], key: Hashable, make: Callable[[], Any]) -> Any:
    """The entry of a key, made at its first use."""
    if key not in derived:
        with BUILDING:
            if key not in derived:
                derived[key] = make()
    return derived[key]


@checked
@dataclass(frozen=True, eq=False)
class Model:
    """The flat model of a system; `rw.assemble` creates it.

    Parameters
    ----------
    system : System
        A copy of the declarations.
    tables : dict of Kind to VariableTable
        Names, units, descriptions, values, nominals and ranges of the variables of each kind.
    structure : Structure
        The equations `dae` and `outputs`, which models of equal structure share.
    signals : tuple of float, Schedule or None
        Value of each input; None: an open input.
    runs : tuple of Run
        The ropes with their supports, spans and loads.
    layouts : tuple of RunLayout
        Positions of the variables of each run in the vectors.
    balances : tuple of Balance
        Residuals of travels and free positions.
    swaps : dict of str to str
        The parameter that is freed when an output is solved for.
    limits : Limits
        Bounds of outputs.
    clocks : tuple of Clock, default ()
        Sampled responses.
    kept : ndarray
        Positions in the discrete vector that do not follow from the loads.
    free_states : tuple of str, default ()
        States that `equilibrium` solves for.
    rate_of : dict of str to str, default {}
        Variables that are rates of change of others, and these.
    inertia : Inertia, optional
        The inertia that its components have.

    Examples
    --------
    >>> model = rw.assemble(line)
    >>> len(model.z.names), model.x.names[:2]
    (19, ('c1.travel', 'c2.travel'))
    """

    system: System
    tables: dict[Kind, VariableTable]
    structure: Structure
    signals: tuple[float | Schedule | None, ...]
    runs: tuple[Run, ...]
    layouts: tuple[RunLayout, ...]
    balances: tuple[Balance, ...]
    swaps: dict[str, str]
    limits: Limits
    clocks: tuple[Clock, ...]
    kept: np.ndarray
    free_states: tuple[str, ...] = ()
    rate_of: dict[str, str] = field(default_factory=dict)
    inertia: Inertia | None = None

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name != "derived"}

    @cached_property
    def derived(self) -> dict[Hashable, Any]:
        """Cached results of functions decorated with `kept_with_model`; not copied to other processes."""
        return {}

    def __repr__(self) -> str:
        sizes = ", ".join(f"{len(table)} {kind.value}" for kind, table in self.tables.items())
        return f"<Model of {self.name!r}: {sizes}>"

    @property
    def name(self) -> str:
        """The system's name."""
        return self.system.name

    @property
    def dae(self) -> ca.Function:
        """(t, x, z, u, p, d) -> (ode, alg), in SI units, unscaled."""
        return self.structure.dae

    @property
    def outputs(self) -> ca.Function:
        """(t, x, z, u, p, d) -> y, in SI units, unscaled."""
        return self.structure.outputs

    @property
    def compiled(self) -> bool:
        """Whether solvers of this model use compiled code."""
        return self.structure.compiled

    @property
    def weather(self) -> bool:
        """Whether temperature, ice and wind are among its inputs and parameters."""
        return self.system.environment is not None

    @cached_property
    def external(self) -> bool:
        """Whether the model contains external compiled code; it then has no scalar graph."""
        return any(c.external for c in self.system.components.values())

    @property
    def sym(self) -> Callable[..., Any]:
        """Constructor of symbols for its functions: scalar symbols unless the model is external."""
        make: Callable[..., Any] = ca.MX.sym if self.external else ca.SX.sym
        return make

    @property
    def x(self) -> VariableTable:
        """Differential states."""
        return self.tables[Kind.STATE]

    @property
    def z(self) -> VariableTable:
        """Algebraic variables."""
        return self.tables[Kind.ALGEBRAIC]

    @property
    def u(self) -> VariableTable:
        """Inputs."""
        return self.tables[Kind.INPUT]

    @property
    def p(self) -> VariableTable:
        """Parameters."""
        return self.tables[Kind.PARAMETER]

    @property
    def d(self) -> VariableTable:
        """Discrete variables."""
        return self.tables[Kind.DISCRETE]

    @property
    def y(self) -> VariableTable:
        """Outputs."""
        return self.tables[Kind.OUTPUT]

    @property
    def r(self) -> VariableTable:
        """Residuals."""
        return self.tables[Kind.RESIDUAL]

    @cached_property
    def determined(self) -> np.ndarray:
        """The algebraic variable matched with each residual, shape (nz,); -1 without a match."""
        return _determined(self)

    def travels(self, x: np.ndarray, z: np.ndarray) -> list[np.ndarray]:
        """Travels of the supports of each run [m]."""
        return [layout.travel.read(x, z) for layout in self.layouts]


def in_code(model: Model, *, compiled: bool) -> Model:
    """The model whose solvers use compiled code, or the one whose solvers do not."""
    if compiled == model.compiled:
        return model
    if "other" not in model.derived:
        other = replace(model, structure=model.structure.in_code(compiled=compiled))
        other.derived["other"] = model
        model.derived.setdefault("other", other)
    found: Model = model.derived["other"]
    return found


def component_of(name: str) -> str:
    """The component of a variable, such as `a.c1` in a subsystem."""
    return name.rpartition(".")[0] or name


def nearest(name: str, names: Sequence[str]) -> str:
    """A hint for an unknown name: names of the same component, or a few similar ones."""
    import difflib

    same = [n for n in names if n.startswith(component_of(name) + ".")]
    found = same[:12] or difflib.get_close_matches(name, names, n=5, cutoff=0.5)
    return f"Did you mean {', '.join(found)}?" if found else "See the frame for all names"


@kept_with_structure
def _determined(model: Model) -> np.ndarray:
    pattern = model.dae.jac_sparsity(1, 2)
    graph = csr_matrix((np.ones(pattern.nnz()), (pattern.row(), pattern.get_col())), shape=pattern.shape)
    return np.asarray(maximum_bipartite_matching(graph, perm_type="column"))
