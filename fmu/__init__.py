"""Functional Mock-up Units: export of systems, import, co-simulation."""

from ropeway.fmu.cosimulation import CoSimulation
from ropeway.fmu.errors import FmuError, FmuExportError, FmuImportError, FmuRunError, FmuVariableError
from ropeway.fmu.export import export
from ropeway.fmu.imported import Fmu, load
from ropeway.fmu.slave import Slave

__all__ = [
    "CoSimulation",
    "Fmu",
    "FmuError",
    "FmuExportError",
    "FmuImportError",
    "FmuRunError",
    "FmuVariableError",
    "Slave",
    "export",
    "load",
]
