"""A Model Exchange FMU as a component of a system, solved together with all other equations."""

from __future__ import annotations

import shutil
import tempfile
import weakref
import zipfile
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import casadi as ca
import numpy as np
import pandas as pd

from ropeway.components import check, units
from ropeway.components.argument_checks import checked
from ropeway.components.component import Component, Port
from ropeway.components.variable import Equations, Kind, Site, Variable
from ropeway.fmu.errors import FmuError, FmuImportError, FmuRunError
from ropeway.fmu.importing.embedded.eventful_fmu import EventfulFmu, FmuEvents, called
from ropeway.fmu.importing.embedded.readable_description import make_readable
from ropeway.fmu.importing.fmu_file import Fmu, load
from ropeway.fmu.importing.instance import Instance, require_kind
from ropeway.fmu.importing.model_exchange_integrator import Integrator
from ropeway.fmu.importing.participant import OpenFmu, require_causality


@checked
@dataclass(frozen=True, eq=False)
class FmuComponent(Component):
    """A Model Exchange FMU as a component; `rw.fmu.component` creates it.

    Parameters
    ----------
    name : str
        Identifier; dotted names of results begin with it.
    fmu : Fmu
        The FMU.
    function : casadi.Function
        (t, x, u, p) -> (ode, y), which calls the FMU in its own units.
    owned : tuple of Variable
        Its variables in SI units.
    scales : mapping of str
        Factor and offset of each variable to SI units.
    events : FmuEvents, optional
        Its events; `function` then has its mode as a further argument.

    Examples
    --------
    >>> unit = rw.fmu.component("unit", "span.fmu", ignore_events=True)
    >>> unit.name
    'unit'
    """

    external: ClassVar[bool] = True
    fmu: Fmu
    function: ca.Function
    owned: tuple[Variable, ...]
    scales: Mapping[str, tuple[float, float]]
    events: FmuEvents | None = None

    __eq__, __hash__ = object.__eq__, object.__hash__  # the equations are those of one open FMU

    @property
    def external_events(self) -> FmuEvents | None:
        return self.events

    @property
    def ports(self) -> tuple[Port, ...]:
        return ()

    def structure(self, site: Site) -> Hashable:
        return self

    def variables(self, site: Site) -> tuple[Variable, ...]:
        return self.owned

    def driver(self, name: str) -> float:
        """Start value of an input that is not connected."""
        return next(float(v.value) for v in self.owned if v.name == name and isinstance(v.value, float))

    def equations(self, v: Any) -> Equations:
        raw = {kind: [w.name for w in self.owned if w.kind is kind] for kind in Kind}
        vectors = [
            ca.vertcat(ca.MX(0, 1), *((getattr(v, n) - self.scales[n][1]) / self.scales[n][0] for n in raw[kind]))
            for kind in (Kind.STATE, Kind.INPUT, Kind.PARAMETER)
        ]
        mode = [] if self.events is None else [getattr(v, self.events.mode)]
        ode, y = self.function(v.time, *vectors, *mode)
        return Equations(
            rates={n: self.scales[n][0] * ode[i] for i, n in enumerate(raw[Kind.STATE])},
            outputs={n: self.scales[n][0] * y[i] + self.scales[n][1] for i, n in enumerate(raw[Kind.OUTPUT])},
        )


@checked
def component(
    name: str,
    fmu: Fmu | str | Path,
    *,
    parameters: Mapping[str, float] | None = None,
    ignore_events: bool = False,
) -> FmuComponent:
    """A Model Exchange FMU of version 2.0 or 3.0 as a component of a system.

    Connect its inputs, outputs and states with `input` and `output`; all are in SI units. Unconnected and discrete
    inputs, and variables that are not real, keep their start values. The states start from the FMU's own
    initialisation. Jacobians are exact if the FMU has directional derivatives and no events, otherwise finite
    differences; they do not include an explicit dependence on time.

    State and time events of the FMU are located within the steps of the simulation; the FMU must be able to save its
    state. An FMU that ends itself ends the run. A system with an FMU cannot be exported, and runs several times slower
    than one without.

    Parameters
    ----------
    name : str
        Identifier; dotted names of results begin with it.
    fmu : Fmu, str or Path
        The FMU, or its file.
    parameters : mapping of str to float, optional
        Values of its parameters. Tunable parameters of an FMU without events are parameters of the model as well.
    ignore_events : bool, default False
        Whether its events are not handled, which is faster: only correct if the equations are the same on both sides,
        as in exported systems without loads that cross supports.

    Returns
    -------
    FmuComponent
        The component.

    Raises
    ------
    InputError
        An invalid name or value.
    FmuImportError
        The file cannot be used, or the FMU has events and cannot save its state.
    FmuVariableError
        An unknown parameter.
    FmuRunError
        The initialisation failed.

    Examples
    --------
    >>> rw.fmu.component("other", "span.fmu", ignore_events=True).output("a.tension").name
    'a.tension'
    """
    check.name(name, "FMU component")
    file = fmu if isinstance(fmu, Fmu) else load(fmu)
    if file.isolated:
        raise FmuImportError(
            f"{file.path.name} is isolated: a component runs in the process of the session",
            "Load it with isolated=False, or couple it by CoSimulation",
        )
    require_kind(file, "ModelExchange")
    values = dict(parameters or {})
    for key, value in values.items():
        require_causality(file, key, "parameter")
        check.number(value, f"FMU component {name!r}", key)
    if ignore_events:
        return _embedded(file, name, values)
    opened = EventfulFmu(file, name, values)
    if opened.has_events or any(v.variable.dimensions for v in file.description.derivatives):
        return _with_events(file, name, opened)
    try:
        return _embedded(file, name, values)
    except _RefusedError:  # CasADi cannot read it
        return _with_events(file, name, opened)


class _RefusedError(FmuImportError):
    """CasADi cannot use an FMU."""


def _with_events(fmu: Fmu, name: str, opened: EventfulFmu) -> FmuComponent:
    """A component that is called through Python, with its events."""
    groups = {Kind.STATE: opened.states, Kind.INPUT: opened.inputs, Kind.OUTPUT: opened.outputs}
    owned, scales = _variables(fmu, groups, dict(zip(groups, opened.starts(), strict=True)))
    events = FmuEvents(opened, scales)
    mode = Variable(events.mode, Kind.DISCRETE, "1", "number of a saved state of the FMU")
    nominals = [
        np.array([v.nominal / abs(scales[v.name][0]) for v in owned if v.kind is kind])
        for kind in (Kind.STATE, Kind.INPUT)
    ]
    return FmuComponent(name, fmu, called(name, opened, nominals), (*owned, mode), scales, events)


def _embedded(file: Fmu, name: str, values: Mapping[str, float]) -> FmuComponent:
    """A component that CasADi calls."""
    folder = tempfile.mkdtemp(prefix="ropeway-")
    try:
        file.unpack(folder)
        make_readable(Path(folder), tunes=_tunes(file, name, values))
        dae = ca.DaeBuilder(name, folder)
        # CasADi reads only real outputs.
        dae.set_y([n for n in file.outputs() if dae.has(n) and n not in dae.x()])
        groups = {Kind.STATE: dae.x(), Kind.INPUT: dae.u(), Kind.PARAMETER: dae.p(), Kind.OUTPUT: dae.y()}
        starts = _starts(file, name, values, groups)  # reports values that the FMU rejects
        for key, value in values.items():
            dae.set(key, value)
        # Directional derivatives of CasADi 3.8.2 are wrong for a zero direction; Jacobians are correct.
        options = {"enable_forward": False, "enable_reverse": False}
        function = dae.create(name, ["t", "x", "u", "p"], ["ode", "y"], options)
        function.jacobian()(0.0, *list(starts.values())[:3], 0, 0)  # fails here if it cannot be evaluated
    except FmuError:
        shutil.rmtree(folder, ignore_errors=True)
        raise
    except RuntimeError as error:
        shutil.rmtree(folder, ignore_errors=True)
        raise _RefusedError(
            f"CasADi cannot use {file.path.name} in a component: {_reason(file, error)}",
            "Couple it by CoSimulation",
        ) from error
    owned, scales = _variables(file, groups, starts)
    made = FmuComponent(name, file, function, owned, scales)
    weakref.finalize(made, shutil.rmtree, folder, ignore_errors=True)
    return made


def _reason(fmu: Fmu, error: RuntimeError) -> str:
    reason = str(error).strip().splitlines()[-1]
    if fmu.fmi == "2.0" or "memory object" not in reason:
        return reason
    with zipfile.ZipFile(fmu.path) as archive:
        if any(name.startswith("resources/") and not name.endswith("/") for name in archive.namelist()):
            return "it reads resource files, and CasADi passes their folder without the final slash"
    return reason


def _tunes(fmu: Fmu, name: str, values: Mapping[str, float]) -> bool:
    """Whether tunable parameters can be set at any time, as CasADi does.

    The standard allows it at events only.
    """
    tunable = [n for n in fmu.names("parameter") if fmu.entries[n].variability == "tunable"]
    if not tunable:
        return True
    instance = Instance(fmu, name, "ModelExchange")
    try:
        instance.enter(0.0, values)
        instance.leave()
        Integrator(instance, 1e-6).begin()
        present = instance.read(tunable)
        try:
            instance.set(dict(zip(tunable, present, strict=True)))
        except FmuRunError:
            return False
        return True
    finally:
        instance.close()


def _starts(
    fmu: Fmu, name: str, values: Mapping[str, float], groups: Mapping[Kind, Sequence[str]]
) -> dict[Kind, np.ndarray]:
    """Values after the FMU's own initialisation."""
    with OpenFmu(fmu, name, "ModelExchange") as slave:
        slave.enter(0.0, values)
        slave.leave()
        return {kind: slave.get(list(names)) for kind, names in groups.items()}


def _variables(
    fmu: Fmu, groups: Mapping[Kind, Sequence[str]], starts: Mapping[Kind, np.ndarray]
) -> tuple[tuple[Variable, ...], dict[str, tuple[float, float]]]:
    """The variables in SI units, and their factors and offsets. The start value replaces a missing nominal."""
    owned, scales = [], {}
    for kind, names in groups.items():
        for name, start in zip(names, starts[kind], strict=True):
            row = fmu.variable(name)
            unit, factor, offset = units.to_si(str(row["unit"]), fmu.units, difference=bool(row["relative"]))
            nominal = max(1.0, abs(float(start))) if pd.isna(row["nominal"]) else abs(float(row["nominal"])) or 1.0
            scales[name] = factor, offset
            value = float(factor * start + offset)
            described = str(row["description"])
            owned.append(Variable(name, kind, unit, described, value, abs(factor) * nominal, kept_at_rest=True))
    return tuple(owned), scales
