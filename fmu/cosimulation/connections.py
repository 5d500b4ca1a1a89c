"""Connections of a co-simulation as they are declared: ends, units and tables of values, checked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from ropeway.components import check
from ropeway.components.errors import InputError
from ropeway.fmu.cosimulation.participants import Participant, conversion
from ropeway.fmu.errors import FmuVariableError
from ropeway.fmu.importing.fmu_file import Fmu
from ropeway.fmu.importing.participant import require_connectable
from ropeway.fmu.importing.variable_types import Entry, Mapped, fits, taken_by

_MAPPED = "Boolean", "Integer", "Enumeration"


@dataclass(frozen=True)
class Connection:
    """An output that drives an input, "slave.variable" each.

    A real input is factor times the output plus offset; with a `mapping` the input is the value that it has for that of
    the output. `held`: the input changes at communication points only.
    """

    source: str
    target: str
    factor: float = 1.0
    offset: float = 0.0
    held: bool = False
    mapping: Mapping[Mapped, Mapped] = field(default_factory=dict, hash=False)


@dataclass(frozen=True)
class Conversion:
    """How the value of an output becomes that of an input; see `CoSimulation.connect`."""

    factor: float = 1.0
    offset: float = 0.0
    convert_units: bool = True
    mapping: Mapping[Mapped, Mapped] | None = None

    def __post_init__(self) -> None:
        check.number(self.factor, "connect", "factor")
        check.number(self.offset, "connect", "offset")

    @property
    def scales(self) -> bool:
        """Whether there is a factor or an offset."""
        return (self.factor, self.offset) != (1.0, 0.0)


def connected(participants: Mapping[str, Participant], source: str, target: str, how: Conversion) -> Connection:
    """The connection of two variables. Raises InputError, FmuVariableError."""
    first, second = (_end(participants, end, causality) for end, causality in ((source, "output"), (target, "input")))
    one, other = (fmu.entry(variable) for fmu, variable in (first, second))
    held = one.kind != "Real" or not other.continuous
    if how.mapping is not None:
        mapping = _taken(how.mapping, (source, one), (target, other))
        if how.scales:
            raise InputError(f"{target!r} has a factor and a mapping", "Give one of them")
        return Connection(source, target, held=True, mapping=mapping)
    if not fits(one, other):
        raise FmuVariableError(
            f"{source!r} is of type {one.type}, {target!r} of type {other.type}: they cannot be connected",
            "Connect variables of the same kind, or enumerations with the same items, or give a mapping of values",
            second[1],
        )
    real = one.kind == other.kind == "Real"
    if how.scales and not real:
        raise FmuVariableError(f"{target!r} is driven by a value that cannot be scaled", "Scale real values only")
    factor, offset = conversion(*first, *second) if real and how.convert_units else (1.0, 0.0)
    if how.scales:
        factor, offset = how.factor * factor, how.factor * offset + how.offset
    return Connection(source, target, factor, offset, held)


def _end(participants: Mapping[str, Participant], end: str, causality: str) -> tuple[Fmu, str]:
    slave, _, variable = end.partition(".")
    if slave not in participants:
        raise InputError(f"{end!r}: no slave is named {slave!r}", f"Slaves are {', '.join(participants)}")
    fmu = participants[slave].fmu
    require_connectable(fmu, variable, causality)
    return fmu, variable


def _taken(
    mapping: Mapping[Mapped, Mapped], source: tuple[str, Entry], target: tuple[str, Entry]
) -> dict[Mapped, Mapped]:
    """A table of values in the types of both ends. Raises InputError, FmuVariableError."""
    for name, entry in (source, target):
        if entry.kind not in _MAPPED:
            raise FmuVariableError(
                f"{name!r} is of type {entry.type}: its values cannot be mapped",
                "Map values of Booleans, integers and enumerations",
            )
    if not mapping:
        raise InputError(f"The mapping to {target[0]!r} is empty", "Give a value of the input for each of the output")
    found: dict[Mapped, Mapped] = {}
    for row in mapping.items():
        key, value = (_whole(entry, name, v) for (name, entry), v in zip((source, target), row, strict=True))
        if found.setdefault(key, value) != value:
            raise InputError(f"The mapping to {target[0]!r} has two values for {row[0]!r}", "Give one")
    return found


def _whole(entry: Entry, name: str, value: Mapped) -> Mapped:
    """A Boolean or a whole number for a variable. Raises FmuVariableError."""
    taken = taken_by(entry, name, name.partition(".")[0], value)
    return taken if isinstance(taken, bool) else int(taken)
