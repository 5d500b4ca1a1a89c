"""The flat differential-algebraic equations, the input of every solver."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, wraps
from typing import Any, Concatenate, ParamSpec, TypeVar

import casadi as ca
import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import maximum_bipartite_matching

from ropeway.components.argument_checks import checked
from ropeway.components.check import Range
from ropeway.components.inertia import Inertia
from ropeway.components.schedule import Schedule
from ropeway.components.variable import Kind
from ropeway.systems.modelling.rope_path import Run
from ropeway.systems.modelling.sampled_control import Clock
from ropeway.systems.modelling.structure import Structure
from ropeway.systems.modelling.system import System


@dataclass(frozen=True)
class VariableTable:
    """All variables of one kind in the order of their vector: parallel tuples and arrays of shape (n,). `hidden` has
    the names that results omit; the first `shared` belong to no component: gravity, the weather."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    descriptions: tuple[str, ...]
    values: np.ndarray
    nominals: np.ndarray
    ranges: tuple[Range, ...]
    hidden: frozenset[str] = frozenset()
    shared: int = 0

    @cached_property
    def index(self) -> dict[str, int]:
        """Position of each name."""
        return {name: i for i, name in enumerate(self.names)}

    @cached_property
    def shown(self) -> tuple[int, ...]:
        """Positions of the variables that results show."""
        return tuple(i for i, name in enumerate(self.names) if name not in self.hidden)

    def __len__(self) -> int:
        return len(self.names)


def shared_places(tables: Mapping[Kind, VariableTable]) -> list[tuple[Kind, int]]:
    """Vector and entry of what all components have in common: gravity, with weather also the values of `Weather.of`."""
    inputs, parameters = tables[Kind.INPUT].shared, tables[Kind.PARAMETER].shared
    places = [(Kind.PARAMETER, 0), *((Kind.INPUT, i) for i in range(inputs))]
    return places + [(Kind.PARAMETER, i) for i in range(1, parameters)]


@dataclass(frozen=True)
class Travel:
    """Positions of the travels of a run's supports, shapes (supports,), in the states or in the algebraic variables; -1
    where absent. A travel in neither is zero."""

    state: np.ndarray
    algebraic: np.ndarray

    def read(self, x: np.ndarray, z: np.ndarray) -> np.ndarray:
        """Travels [m] from the states and algebraic variables."""
        q = np.zeros(len(self.state))
        (in_x, from_x), (in_z, from_z) = self._places
        q[in_x] = x[from_x]
        q[in_z] = z[from_z]
        return q

    def write(self, q: np.ndarray, x: np.ndarray, z: np.ndarray) -> None:
        """Writes travels to the states and algebraic variables."""
        (in_x, from_x), (in_z, from_z) = self._places
        x[from_x] = q[in_x]
        z[from_z] = q[in_z]

    @cached_property
    def _places(self) -> tuple[tuple[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]:
        """Supports with a travel among the states, and its positions; the same for algebraic variables."""
        in_x, in_z = np.flatnonzero(self.state >= 0), np.flatnonzero(self.algebraic >= 0)
        return (in_x, self.state[in_x]), (in_z, self.algebraic[in_z])


@dataclass(frozen=True)
class LoadSlots:
    """Positions of a run's load slots in the discrete vector: the first slot of each kind in each span (spans,), and
    the number of slots (spans,). `drag`: without weather -1."""

    count: np.ndarray
    mass: np.ndarray
    at: np.ndarray
    ride: np.ndarray
    empty: np.ndarray
    drag: np.ndarray

    @cached_property
    def _cells(self) -> tuple[np.ndarray, np.ndarray]:
        """Span and slot number of every slot."""
        return _cells(np.arange(len(self.count)), self.count)

    @cached_property
    def _every(self) -> tuple[np.ndarray, ...]:
        """As `_places` of all spans."""
        return self._places(*self._cells)

    def _places(self, span: np.ndarray, slot: np.ndarray) -> tuple[np.ndarray, ...]:
        """Of slots their spans and numbers, and the places of mass, at, ride, empty and drag area."""
        return (span, slot, *(first[span] + slot for first in (self.mass, self.at, self.ride, self.empty, self.drag)))

    def filled(self, d: np.ndarray) -> int:
        """Number of slots with a load."""
        span, slot = self._cells
        return len(span) - int(np.count_nonzero(d[self.empty[span] + slot]))

    def write(
        self, d: np.ndarray, run: Run, passed: np.ndarray, start: np.ndarray, spans: np.ndarray | None = None
    ) -> None:
        """Fills the slots of all or of some spans according to `passed`. `start` (supports,) is the rope coordinate at
        each support at zero travel [m]. `d` (..., nd) and `passed` (..., supports) may contain many records."""
        loads = run.loads
        if len(loads.place) == 0:
            return
        places = self._every if spans is None else self._places(*_cells(spans, self.count[spans]))
        span, slot, mass, at, ride, empty, drag = places
        load = passed[..., span] - 1 - slot
        full = load >= passed[..., span + 1]
        load = np.where(full, load, 0)
        pinned = full & (loads.pinned[load] >= 0)
        d[..., mass] = np.where(full, loads.mass[load], 0.0)
        d[..., at] = np.where(pinned, loads.at[load], np.where(full, loads.place[load] - start[span], 0.0))
        d[..., ride] = full & ~pinned
        d[..., empty] = ~full
        if self.drag[0] >= 0:
            d[..., drag] = np.where(full, loads.drag[load], 0.0)


def _cells(spans: np.ndarray, count: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Span and number of each slot of some spans."""
    span = np.repeat(spans, count)
    first = np.concatenate([[0], np.cumsum(count)[:-1]])
    return span, np.arange(len(span)) - np.repeat(first, count)


@dataclass(frozen=True)
class RunLayout:
    """Positions of a run's variables in the vectors of the model: travels, slots, initial length, mass per length,
    compliance and tension vector of each span (spans,). `held` (supports,) is -1 for supports that cannot hold a load.
    `aside` (2, spans) is the rope between a node and the end of a span, -1 for a span that ends at the node. `grip` is
    the reference travel of a saddle's friction, -1 without one."""

    travel: Travel
    slots: LoadSlots
    length_start: np.ndarray
    mass_per_length: np.ndarray
    compliance: np.ndarray
    force: np.ndarray
    held: np.ndarray
    held_travel: np.ndarray
    aside: np.ndarray
    grip: np.ndarray

    def start(self, p: np.ndarray) -> np.ndarray:
        """Rope coordinate at each support at zero travel [m], shape (supports,)."""
        found = np.zeros(len(self.length_start) + 1)
        p[self.length_start].cumsum(out=found[1:])
        return found

    @property
    def key(self) -> Hashable:
        """The positions that equations of solvers depend on."""
        return tuple(a.tobytes() for a in (self.length_start, self.slots.count, self.slots.at, self.slots.ride))

    @cached_property
    def holding(self) -> np.ndarray:
        """The supports whose idlers can hold a load."""
        return np.flatnonzero(self.held >= 0)

    def free(self, z: np.ndarray) -> np.ndarray:
        """Length of each span minus the rope between its nodes (spans,) [m]; negative on shoes."""
        more, less = np.where(self.aside >= 0, z[self.aside], 0.0)
        return np.asarray(more - less)


@dataclass(frozen=True)
class Balance:
    """A travel among the algebraic variables and the residual of its tension balance, or a free node's coordinate and
    the sum of forces along it. `sign` is +1 if more travel lowers the residual of a stable line, -1 if it raises it."""

    travel: int
    residual: int
    sign: float


@dataclass(frozen=True)
class Limits:
    """All limits of a model as parallel arrays: position of the output, bounds, event and component."""

    output: np.ndarray
    low: np.ndarray
    high: np.ndarray
    events: tuple[str, ...]
    components: tuple[str, ...]

    def broken(self, outputs: np.ndarray) -> np.ndarray:
        """Limits exceeded by outputs of shape (..., ny), as booleans of shape (..., limits)."""
        values = outputs[..., self.output]
        return np.asarray((values < self.low) | (values > self.high))


_Arguments = ParamSpec("_Arguments")
_Made = TypeVar("_Made")


def kept_with_model(
    make: Callable[Concatenate[Model, _Arguments], _Made],
) -> Callable[Concatenate[Model, _Arguments], _Made]:
    """Decorator of a function of a model, such as one that builds a solver: the model caches the result for its own
    lifetime. Threads that call it at the same time get the same object."""

    @wraps(make)
    def kept(model: Model, /, *args: _Arguments.args, **kwargs: _Arguments.kwargs) -> _Made:
        key = (make, args, *kwargs.values())
        if key not in model.derived:
            model.derived.setdefault(key, make(model, *args, **kwargs))
        found: _Made = model.derived[key]
        return found

    return kept


def kept_with_structure(
    make: Callable[Concatenate[Model, _Arguments], _Made],
) -> Callable[Concatenate[Model, _Arguments], _Made]:
    """As `kept_with_model`, for what depends on the positions in a model's equations alone, not on names or values:
    models of equal structure share it."""

    @wraps(make)
    def kept(model: Model, /, *args: _Arguments.args, **kwargs: _Arguments.kwargs) -> _Made:
        derived, key = model.structure.derived, (make, args, *kwargs.values())
        if key not in derived:
            derived.setdefault(key, make(model, *args, **kwargs))
        found: _Made = derived[key]
        return found

    return kept


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
