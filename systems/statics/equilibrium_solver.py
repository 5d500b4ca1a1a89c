"""The equilibrium of a system: solved from a start or from geometry, certified, and checked against its ropes."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ropeway.components.argument_checks import checked
from ropeway.components.environment import Environment
from ropeway.components.errors import EquilibriumError, InputError, RopewayWarning, UnbalancedSystemError
from ropeway.components.variable import Kind
from ropeway.systems.interrupts import interruptible
from ropeway.systems.modelling.assembly import in_weather
from ropeway.systems.modelling.dae_model import Model, in_code
from ropeway.systems.modelling.system import System
from ropeway.systems.modelling.user_code import caller
from ropeway.systems.progress_bar import bar
from ropeway.systems.solvers.compiled_line import compiled_line
from ropeway.systems.solvers.kernels.compiled_newton import require_kernels
from ropeway.systems.solvers.line_sections import line_sections
from ropeway.systems.statics.certificate.certify import certify
from ropeway.systems.statics.certificate.checks import Certificate
from ropeway.systems.statics.equilibrium import Equilibrium
from ropeway.systems.statics.given_values import solve_swapped
from ropeway.systems.statics.line_state import LineState
from ropeway.systems.statics.resting import at_rest_model, on_model
from ropeway.systems.statics.settling import TooHeavyError, keep_taut_root, let_out, loaded, settle, share_lengths
from ropeway.systems.statics.warm_start import carried_over, declared_alike, undriven


@checked
@interruptible
def equilibrium(
    system: System | Model,
    *,
    given: Mapping[str, float] | None = None,
    solve_for: str | Sequence[str] = (),
    parameters: Mapping[str, float] | None = None,
    start: Equilibrium | None = None,
    compiled: bool = False,
    environment: Environment | None = None,
) -> Equilibrium:
    """Solve for the stable, taut equilibrium of a system at rest.

    After the solve the travel of all idlers is zero: a run starts from the equilibrium. A solution that fails its
    certificate is solved again from another start. A RopewayWarning says where a tension is above the rope's minimum
    breaking load.

    Parameters
    ----------
    system : System or Model
        Its declarations, or `assemble` of them.
    given : mapping of str to float, optional
        Values that variables, outputs or quantities of loads must have (`{"a_b.tension_a": 150e3}`).
    solve_for : str or sequence of str, optional
        As many parameters, span lengths or load masses that are solved for in exchange.
    parameters : mapping of str to float, optional
        Other values for parameters, inputs, states (the travel of a drive) and masses of loads in this solve. The
        length of one span over idlers counts from the lengths of all spans at rest.
    start : Equilibrium, optional
        A nearby equilibrium of the same declarations, for a warm start; or `result.at(t)`, without its brakes and
        responses.
    compiled : bool, default False
        Whether to solve in compiled code, which needs a C compiler at first use.
    environment : Environment, optional
        Weather, instead of that of the system; its values are then inputs and parameters of the model, unless it is
        calm.

    Returns
    -------
    Equilibrium
        With a `certificate`.

    Raises
    ------
    InputError, UnknownNameError, UnbalancedSystemError
        Before the solve.
    CompiledError, CompilerError, WriteError
        Of `compiled`: the core does not support this, has no compiler, or its cache cannot be written.
    EquilibriumError
        After a failed solve, with the component of the worst residual.

    Examples
    --------
    >>> rope = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)
    >>> s = rw.System("one span")
    >>> (span,) = s.string(rope, rw.Anchor("a", at=(0.0, 0.0)), rw.Anchor("b", at=(400.0, -60.0)), length=408.0)
    >>> round(rw.equilibrium(s, given={"a_b.tension_a": 60e3}, solve_for="a_b.length")["a_b.length"], 1)
    404.7
    """
    freed = [solve_for] if isinstance(solve_for, str) else list(solve_for)
    wanted = dict(given or {})
    if len(wanted) != len(freed):
        raise UnbalancedSystemError(
            f"given has {len(wanted)} values, solve_for {len(freed)} names",
            "Name one quantity in solve_for for each value in given",
        )
    for name, value in wanted.items():
        if not np.isfinite(value):
            raise InputError(f"given {name} is {value!r}", "Give a finite number")
    model = in_weather(system, environment, parameters or ())
    if model.inertia is not None:
        raise InputError(f"{model.name!r} is a model with inertia", "Give the system, or `assemble` of it")
    by_sections = compiled and not wanted and require_compiled(model)
    freed = [model.swaps.get(name, name) for name in freed]
    in_kernels = model.compiled or (compiled and not by_sections)
    solved_on = in_code(at_rest_model(model) if model.free_states else model, compiled=in_kernels)
    first: EquilibriumError | None = None
    for way in ("near", "from geometry", "let out", "loaded"):
        if (way == "near" and start is None) or (way == "loaded" and wanted):
            continue
        state = _near(model, start, parameters) if way == "near" and start else _cold(solved_on, parameters)
        try:
            if way == "near" and model.free_states:
                state = on_model(state, solved_on)
            state.model = in_code(state.model, compiled=in_kernels)
            found, certificate = _at_rest(state, wanted, freed, way, by_sections=by_sections)
        except TooHeavyError as error:
            raise error from first
        except EquilibriumError as error:
            first = first or error
            continue
        _warn(certificate)
        return found if solved_on is model else _of(model, found)
    raise first or EquilibriumError(f"{model.name!r} has no equilibrium")


def require_compiled(model: Model) -> bool:
    """Whether the compiled core solves a model by its sections; otherwise it solves all equations together. Raises
    CompiledError where it can do neither, CompilerError, WriteError."""
    if model.free_states or isinstance(line_sections(model), str):
        require_kernels(model)
        return False
    compiled_line(model)
    return True


def _cold(model: Model, parameters: Mapping[str, float] | None) -> LineState:
    """A state from geometry."""
    state = LineState.cold(model)
    if parameters:
        share_lengths(state, parameters)
        state.set(parameters)
        state.restart()
    return state


def _near(model: Model, start: Equilibrium, parameters: Mapping[str, float] | None) -> LineState:
    """A state from a nearby equilibrium."""
    rest = start if declared_alike(start, model.system) else carried_over(start, model)
    state = LineState(rest.model, rest.point.copy(), rest.runs, rest.passed)
    for r, k, _ in state.standing():
        state.release(r, k)
    undriven(state)
    if parameters:
        state.set(parameters)
    return state


def _at_rest(
    state: LineState, wanted: Mapping[str, float], freed: Sequence[str], way: str, *, by_sections: bool
) -> tuple[Equilibrium, Certificate]:
    """The equilibrium of a state with values `wanted` and others `freed` in exchange, and its certificate. The way
    "let out" comes from a taut rope, the way "loaded" from light loads. Raises EquilibriumError."""
    declared = state.point.p.copy()
    if way == "let out":
        with bar("equilibrium: rope let out", 1.0) as advance:
            state = let_out(state, advance=advance)
    elif way == "loaded":
        with bar("equilibrium: loads added", 1.0) as advance:
            state = loaded(state, advance)
    if wanted:
        solve_swapped(state, wanted, freed, from_chord=way != "let out")
    elif way in ("near", "from geometry"):
        settle(state, by_sections=by_sections)
        if way == "from geometry":
            keep_taut_root(state)
    for name in freed:
        kind, k = state.find(name)
        if kind is Kind.PARAMETER:
            declared[k] = state.point.p[k]
    rope = [_rope(state, r, declared) for r in range(len(state.runs))]
    state.rezero()
    certificate = certify(state.model, state.point, state.runs, state.passed, given=wanted, rope=rope)
    certificate.require(state.model)
    runs, passed = tuple(state.runs), tuple(state.passed)
    return Equilibrium(state.model, state.point, runs, passed, state.held, given=tuple(wanted.items())), certificate


def _of(model: Model, rest: Equilibrium) -> Equilibrium:
    """An equilibrium of `at_rest_model(model)`, or of the model in other code, as one of the model."""
    if not model.free_states:
        return replace(rest, model=in_code(rest.model, compiled=model.compiled))
    plain = in_code(rest.model, compiled=model.compiled)
    state = on_model(LineState(plain, rest.point, rest.runs, rest.passed), model)
    return replace(rest, model=state.model, point=state.point, runs=tuple(state.runs))


def still(line: Equilibrium) -> Equilibrium:
    """An equilibrium with its free states as algebraic variables: how the line at rest changes with a parameter."""
    if not line.model.free_states:
        return line
    state = on_model(LineState(line.model, line.point, line.runs, line.passed), at_rest_model(line.model))
    return replace(line, model=state.model, point=state.point, runs=tuple(state.runs))


def _rope(state: LineState, r: int, declared: np.ndarray) -> float:
    """Unstretched rope of a run [m]: what was declared, and what its ends have let in."""
    layout = state.model.layouts[r]
    travel = layout.travel.read(state.point.x, state.point.z)
    return float(declared[layout.length_start].sum() + travel[0] - travel[-1])


def _warn(certificate: Certificate) -> None:
    """Warns of a rope that cannot bear its tension."""
    used = certificate.utilisation
    if used is not None and not used.holds:
        warn_overloaded(used.component, used.value)


def warn_overloaded(span: str, times: float, when: str = "at rest") -> None:
    """Warns of a tension of so many `times` the breaking load, in the name of the user's line of code."""
    path, _, line = caller().rpartition(":")
    warnings.warn_explicit(
        f"The highest tension in span {span!r} {when} is {times:.3g} times the rope's minimum "
        "breaking load. Take lighter loads, more sag or a stronger rope",
        RopewayWarning,
        path or "?",
        int(line) if line.isdigit() else 1,
    )
