"""A co-simulation as a system structure (SSP): what is written of it, and how it is made again."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

from ropeway.components.errors import InputError
from ropeway.fmu.cosimulation.connections import Connection
from ropeway.fmu.cosimulation.coupling import Scheme
from ropeway.fmu.cosimulation.participants import Participant, conversion
from ropeway.fmu.cosimulation.step_control import StepControl
from ropeway.fmu.errors import FmuImportError, FmuVariableError
from ropeway.fmu.importing.fmu_file import Fmu
from ropeway.fmu.importing.variable_types import Mapped
from ropeway.fmu.ssp.reading import SspConnection, SspSlave, SspSystem

_MASTER, _CONTROL = "CoSimulation", "StepControl"


def new_file(path: str | Path) -> Path:
    """The file to write. Raises InputError."""
    target = Path(path)
    if target.suffix != ".ssp":
        raise InputError(f"{str(path)!r} does not end in .ssp", f"Rename it to {target.stem or 'yard'}.ssp")
    if not target.parent.is_dir():
        raise InputError(f"There is no folder {target.parent}", "Create it, or choose another")
    return target


def settings_of(step: float, scheme: Scheme, control: StepControl | None) -> dict[str, dict[str, str]]:
    """Settings of a master as attributes of annotations."""
    found = {_MASTER: _texts({"step": step, **asdict(scheme)})}
    return found if control is None else {**found, _CONTROL: _texts(asdict(control))}


def arguments_of(system: SspSystem, step: float | None) -> dict[str, Any]:
    """Arguments of the master of a system structure. Raises InputError, FmuImportError."""
    found = _values(system.settings.get(_MASTER, {}), ("step", *(f.name for f in fields(Scheme))))
    if _CONTROL in system.settings:
        known = [f.name for f in fields(StepControl)]
        found["control"] = StepControl(**_values(system.settings[_CONTROL], known))
    steps = [float(s) for slave in system.slaves if (s := _experiment(slave.fmu, "stepSize")) is not None]
    chosen = step if step is not None else found.get("step", min(steps, default=None))
    if chosen is None:
        raise InputError("The system structure has no communication step", "Give it: from_ssp(path, step=0.1)")
    return {**found, "step": chosen}


def _experiment(fmu: Fmu, name: str) -> str | None:
    found = getattr(fmu.description.defaultExperiment, name, None)
    return None if found is None else str(found)


def slave(name: str, one: Participant) -> SspSlave:
    """A participant; structural parameters are start values as well."""
    isolated = {"isolated": True, "timeout": one.fmu.timeout} if one.fmu.isolated else {}
    given = {"open": list(one.open), "step": one.step, **isolated}
    options = _texts({key: value for key, value in given.items() if value})
    return SspSlave(name, one.fmu, one.kind, {**one.fmu.structure, **one.start}, options)


def options_of(one: SspSlave) -> dict[str, Any]:
    """What else is known of a participant. Raises FmuImportError."""
    return _values(one.settings, ("open", "step", "isolated", "timeout"))


def connection(one: Connection, participants: Mapping[str, Participant]) -> SspConnection:
    """A connection; it is plain if it converts units, and nothing else."""
    plain = (one.factor, one.offset) == _units(one, participants)
    return SspConnection(one.source, one.target, one.factor, one.offset, plain, _mapping(one, participants))


def _mapping(one: Connection, participants: Mapping[str, Participant]) -> dict[Mapped, Mapped] | None:
    """The table of a connection: between enumerations by the names of their items."""
    if not one.mapping:
        return None
    ends = (end.partition(".") for end in (one.source, one.target))
    items = [participants[name].fmu.entry(variable).items for name, _, variable in ends]
    first, second = ({number: item for item, number in own.items()} for own in items)
    if not first or not second:
        return dict(one.mapping)
    return {first[int(key)]: second[int(value)] for key, value in one.mapping.items()}


def _units(one: Connection, participants: Mapping[str, Participant]) -> tuple[float, float] | None:
    """Factor and offset of the units of a connection; (1, 0) unless both ends are real, None without a conversion."""
    ends = [
        (participants[name].fmu, variable)
        for name, _, variable in (one.source.partition("."), one.target.partition("."))
    ]
    if any(fmu.entry(variable).kind != "Real" for fmu, variable in ends):
        return 1.0, 0.0
    try:
        return conversion(*ends[0], *ends[1])
    except FmuVariableError:
        return None


def _texts(values: Mapping[str, object]) -> dict[str, str]:
    return {name: json.dumps(value) for name, value in values.items()}


def _values(texts: Mapping[str, str], known: Sequence[str]) -> dict[str, Any]:
    if unknown := [name for name in texts if name not in known]:
        raise FmuImportError(f"A setting of the master is unknown: {unknown[0]!r}", "Remove the annotation")
    try:
        return {name: json.loads(text) for name, text in texts.items()}
    except json.JSONDecodeError as error:
        raise FmuImportError(f"A setting of the master cannot be read: {error}", "Remove the annotation") from error
