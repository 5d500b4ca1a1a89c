"""The interface of an FMU: what a slave needs of its description, in a process of its own as well."""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ropeway.components.argument_checks import checked
from ropeway.fmu.errors import FmuVariableError
from ropeway.fmu.importing.archive import ArchiveLimits, unpack
from ropeway.fmu.importing.variable_types import Entry, Value, taken_by


@checked
@dataclass(frozen=True, eq=False)
class FmuInterface:
    """Names, capabilities and types of the variables of an FMU; see `Fmu`."""

    path: Path
    name: str
    fmi: str
    kinds: tuple[str, ...]
    platforms: tuple[str, ...]
    description: Any
    entries: Mapping[str, Entry]
    arrays: Mapping[str, tuple[str, ...]]
    structure: Mapping[str, Value] = field(default_factory=dict)
    limits: ArchiveLimits = ArchiveLimits()  # noqa: RUF009
    checksum: str = ""

    def unpack(self, folder: str | Path) -> None:
        """Unpack the file into a folder.

        Parameters
        ----------
        folder : str or Path
            The folder.

        Raises
        ------
        FmuImportError
            The file changed since it was loaded, is broken or beyond its limits.
        """
        unpack(self.path, Path(folder), self.limits, self.checksum)

    def entry(self, name: str) -> Entry:
        """Type of a variable.

        Parameters
        ----------
        name : str
            Name of a scalar or of an element.

        Returns
        -------
        Entry
            Its type.

        Raises
        ------
        FmuVariableError
            An unknown variable.
        """
        if name not in self.entries:
            raise self._unknown(name)
        return self.entries[name]

    def _unknown(self, name: str) -> FmuVariableError:
        if elements := self.arrays.get(name):
            cause = f"{name!r} of {self.path.name} is an array of {len(elements)}"
            return FmuVariableError(cause, f"Name one of its elements, {', '.join(elements[:3])}", name)
        near = difflib.get_close_matches(name, list(self.entries), n=5, cutoff=0.4)
        remedy = f"Did you mean {', '.join(near)}?" if near else "List them with fmu.variables"
        return FmuVariableError(f"{self.path.name} has no variable {name!r}", remedy, name)

    def names(self, causality: str, *kinds: str) -> list[str]:
        """Names of the variables of a causality.

        Parameters
        ----------
        causality : str
            Such as "input", "output" or "parameter".
        *kinds : str
            Kinds of variables, such as "Boolean"; by default "Real".

        Returns
        -------
        list of str
            The names.
        """
        wanted = kinds or ("Real",)
        return [n for n, entry in self.entries.items() if entry.causality == causality and entry.kind in wanted]

    def outputs(self, *kinds: str) -> list[str]:
        """Names of the outputs that can be read at any communication point.

        Parameters
        ----------
        *kinds : str
            Kinds of variables; by default "Real".

        Returns
        -------
        list of str
            The names.
        """
        return [n for n in self.names("output", *kinds) if not self.entries[n].clocked]

    def values(self, given: Mapping[str, object]) -> dict[str, Value]:
        """Values converted to the types of the FMU.

        Parameters
        ----------
        given : mapping of str
            Values by name; those of an array as a sequence, nested or flat.

        Returns
        -------
        dict of str
            Values by name of scalars and elements.

        Raises
        ------
        FmuVariableError
            An unknown variable, or a value of the wrong type or size.
        """
        found: dict[str, Value] = {}
        for name, value in given.items():
            elements = self.arrays.get(name)
            if elements is None:
                found[name] = taken_by(self.entry(name), name, self.path.name, value)
                continue
            parts = _flat(value)
            if len(parts) != len(elements):
                cause = f"{name!r} of {self.path.name} is an array of {len(elements)}; {len(parts)} values were given"
                raise FmuVariableError(cause, "Give a value for each element", name)
            found |= {n: taken_by(self.entries[n], n, self.path.name, v) for n, v in zip(elements, parts, strict=True)}
        return found


def _flat(value: object) -> list[object]:
    """The elements of nested sequences, in order."""
    if isinstance(value, str | bytes) or not hasattr(value, "__iter__"):
        return [value]
    return [part for one in value for part in _flat(one)]
