"""An FMU as a file: what it is called, what it can do, and its variables as a table."""

from __future__ import annotations

import difflib
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import fmpy
import pandas as pd

from ropeway.components import units
from ropeway.components.checked import checked
from ropeway.fmu.errors import FmuImportError, FmuVariableError

_COLUMNS = ("kind", "causality", "variability", "unit", "start", "nominal", "description", "reference")


@checked
@dataclass(frozen=True, eq=False)
class Fmu:
    """An FMU file. `kinds`: "ModelExchange", "CoSimulation"; `platforms`: those that it has a binary for.

    `variables`: index name; columns kind, causality, variability, unit, start, nominal, description and (value)
    reference. `units`: those that it defines by SI base units; `ropeway.components.units` reads
    the others by their symbols. `description` is FMPy's.
    """

    path: Path
    name: str
    fmi: str
    kinds: tuple[str, ...]
    platforms: tuple[str, ...]
    variables: pd.DataFrame
    units: Mapping[str, units.Unit]
    description: Any

    def variable(self, name: str) -> pd.Series:
        """A variable's row. Raises FmuVariableError."""
        if name not in self.variables.index:
            near = difflib.get_close_matches(name, list(self.variables.index), n=5, cutoff=0.4)
            remedy = f"Did you mean {', '.join(near)}?" if near else "Look at its variables"
            raise FmuVariableError(f"{self.path.name} has no variable {name!r}", remedy, name)
        row: pd.Series = self.variables.loc[name]
        return row

    def names(self, causality: str, *kinds: str) -> list[str]:
        """Names of the variables of a causality and of these kinds, by default the real ones."""
        chosen = (self.variables["causality"] == causality) & self.variables["kind"].isin(kinds or ("Real",))
        return [str(n) for n in self.variables.index[chosen]]


@checked
def load(path: str | Path) -> Fmu:
    """Reads an FMU of version 2.0 or 3.0. Raises FmuImportError."""
    file = Path(path)
    if not file.is_file():
        raise FmuImportError(f"There is no file {file}", "Check the path")
    if not zipfile.is_zipfile(file):
        raise FmuImportError(f"{file.name} is not a zip archive", "An FMU is one; export it anew")
    with zipfile.ZipFile(file) as archive:
        if "modelDescription.xml" not in archive.namelist():
            raise FmuImportError(f"{file.name} has no modelDescription.xml", "It is a zip archive, but not an FMU")
        try:
            version = ElementTree.fromstring(archive.read("modelDescription.xml")).get("fmiVersion", "?")
        except ElementTree.ParseError as error:
            raise FmuImportError(
                f"modelDescription.xml of {file.name} is not XML: {error}", "Export it anew"
            ) from error
    if version != "2.0" and not version.startswith("3.0"):
        raise FmuImportError(f"{file.name} is of FMI version {version}", "Versions 2.0 and 3.0 can be used")
    try:
        described = fmpy.read_model_description(str(file), validate=False)
    except Exception as error:
        raise FmuImportError(f"{file.name} cannot be read: {error}", "Check it with fmpy validate") from error
    kinds = tuple(
        kind
        for kind, section in (("ModelExchange", described.modelExchange), ("CoSimulation", described.coSimulation))
        if section is not None
    )
    platforms = tuple(name for name in fmpy.supported_platforms(str(file)) if name != "c-code")
    return Fmu(file, described.modelName, version, kinds, platforms, _table(described), _units(described), described)


def _table(described: Any) -> pd.DataFrame:
    rows = {
        v.name: (
            {"Float64": "Real", "Float32": "Real", "Int32": "Integer"}.get(v.type, v.type),
            v.causality,
            v.variability,
            v.unit or (v.declaredType.unit if v.declaredType is not None else None) or "",
            None if v.start is None else str(v.start),
            None if v.nominal is None else float(v.nominal),
            v.description or "",
            v.valueReference,
        )
        for v in described.modelVariables
    }
    table = pd.DataFrame.from_dict(rows, orient="index", columns=list(_COLUMNS))
    return table.rename_axis("name")


def _units(described: Any) -> dict[str, units.Unit]:
    found = {}
    for unit in described.unitDefinitions:
        base = unit.baseUnit
        if base is not None:
            exponents = {s: int(getattr(base, s) or 0) for s in units.BASE}
            found[unit.name] = units.from_base(exponents, float(base.factor or 1.0), float(base.offset or 0.0))
    return found
