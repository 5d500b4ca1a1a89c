"""An FMU file: its names, capabilities and variables."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from xml.etree import ElementTree

import fmpy
import pandas as pd

from ropeway.components import check, units
from ropeway.components.argument_checks import checked
from ropeway.fmu.errors import FmuImportError
from ropeway.fmu.importing.archive import ArchiveLimits, read_description, require_identifier
from ropeway.fmu.importing.description_tables import complete, defined_units, variable_tables
from ropeway.fmu.importing.interface import FmuInterface
from ropeway.fmu.importing.variable_types import Value


@checked
@dataclass(frozen=True, eq=False)
class Fmu(FmuInterface):
    """An FMU file; `rw.fmu.load` reads it.

    Parameters
    ----------
    path : Path
        The file.
    name : str
        Name of the model.
    fmi : str
        Version of FMI.
    kinds : tuple of str
        "ModelExchange", "CoSimulation", "ScheduledExecution".
    platforms : tuple of str
        Platforms of its binaries.
    description : object
        FMPy's model description.
    entries : mapping of str to Entry
        Types of the variables.
    arrays : mapping of str to tuple of str
        Names of the elements of each array.
    structure : mapping of str, optional
        Values of structural parameters other than their start values.
    limits : ArchiveLimits, optional
        Limits on the archive.
    checksum : str, optional
        Of the contents of the file when it was loaded.
    variables : DataFrame
        Index name; columns kind, causality, variability, unit, start, nominal, description, (value) reference and
        relative (FMI's relativeQuantity: the values are differences). An array `u` has a row for each element: `u[1]`,
        `u[2]`, or `u[1,2]`.
    units : mapping of str to Unit
        Units that it defines by SI base units; others are read by their symbols.
    isolated : bool, default False
        Whether its slaves run in processes of their own.
    timeout : float, optional
        Longest time of one call of an isolated slave [s].

    Examples
    --------
    >>> fmu = rw.fmu.load("span.fmu")
    >>> fmu.names("output")
    ['a.tension', 'b.tension']
    """

    variables: pd.DataFrame = field(default_factory=pd.DataFrame)
    units: Mapping[str, units.Unit] = field(default_factory=dict)
    isolated: bool = False
    timeout: float | None = 60.0

    def variable(self, name: str) -> pd.Series:
        """Row of a variable.

        Parameters
        ----------
        name : str
            Name of a scalar or of an element.

        Returns
        -------
        Series
            Its row of `variables`.

        Raises
        ------
        FmuVariableError
            An unknown variable.
        """
        self.entry(name)
        row: pd.Series = self.variables.loc[name]
        return row

    def shaped(self, structure: Mapping[str, Value]) -> Fmu:
        """The FMU with other structural parameters, and arrays of the sizes that follow.

        Parameters
        ----------
        structure : mapping of str
            Values of structural parameters.

        Returns
        -------
        Fmu
            The resized FMU.
        """
        variables, entries, arrays = variable_tables(self.description, structure)
        return replace(self, variables=variables, entries=entries, arrays=arrays, structure=dict(structure))


@checked
def load(
    path: str | Path,
    *,
    isolated: bool = False,
    timeout: float | None = 60.0,
    limits: ArchiveLimits | None = None,
) -> Fmu:
    """Read an FMU of version 2.0 or 3.0. Nothing of it runs before a slave is opened.

    Parameters
    ----------
    path : str or Path
        The file.
    isolated : bool, default False
        Whether its slaves run in processes of their own, so that a crash of the FMU does not end the session.
    timeout : float, optional
        Longest time of one call of an isolated slave [s]; None: unlimited.
    limits : ArchiveLimits, optional
        Limits on the archive.

    Returns
    -------
    Fmu
        Its description.

    Raises
    ------
    InputError
        A timeout that is not positive.
    FmuImportError
        The file is missing, not an FMU, of another version, or beyond the limits.

    Examples
    --------
    >>> rw.fmu.load("span.fmu").variables["unit"]["a.tension"]
    'N'
    """
    if timeout is not None:
        check.positive(timeout, "load", "timeout", "s")
    limits = limits or ArchiveLimits()
    file = Path(path).absolute()  # the working folder may change before it is opened
    if not file.is_file():
        raise FmuImportError(f"There is no file {path}", "Check the path")
    text, checksum = read_description(file, limits)
    try:
        root = ElementTree.fromstring(text)
    except (ElementTree.ParseError, LookupError, ValueError) as error:  # also unknown encodings
        raise FmuImportError(f"modelDescription.xml of {file.name} is not XML: {error}", "Export it again") from error
    version = root.get("fmiVersion", "?")
    if version != "2.0" and not version.startswith("3.0"):
        raise FmuImportError(f"{file.name} is of FMI version {version}", "Use version 2.0 or 3.0")
    try:
        described = fmpy.read_model_description(str(file), validate=False)
        complete(described, root)
        variables, entries, arrays = variable_tables(described, {})
        defined = defined_units(described)
        platforms = tuple(name for name in fmpy.supported_platforms(str(file)) if name != "c-code")
    except Exception as error:
        raise FmuImportError(f"{file.name} cannot be read: {error}", "Check it with fmpy validate") from error
    sections = {
        "ModelExchange": described.modelExchange,
        "CoSimulation": described.coSimulation,
        "ScheduledExecution": described.scheduledExecution,
    }
    kinds = tuple(kind for kind, section in sections.items() if section is not None)
    for kind in kinds:
        require_identifier(file, sections[kind].modelIdentifier or "")
    return Fmu(
        *(file, described.modelName, version, kinds, platforms, described, entries, arrays),
        variables=variables,
        units=defined,
        isolated=isolated,
        timeout=timeout,
        limits=limits,
        checksum=checksum,
    )
