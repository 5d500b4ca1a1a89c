"""Functional Mock-up Units: export of systems, import, co-simulation. Names are loaded when they are first used."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ropeway.fmu.cosimulation import CoSimulation as CoSimulation
    from ropeway.fmu.embedded import FmuComponent as FmuComponent
    from ropeway.fmu.embedded import component as component
    from ropeway.fmu.errors import FmuError as FmuError
    from ropeway.fmu.errors import FmuExportError as FmuExportError
    from ropeway.fmu.errors import FmuImportError as FmuImportError
    from ropeway.fmu.errors import FmuRunError as FmuRunError
    from ropeway.fmu.errors import FmuVariableError as FmuVariableError
    from ropeway.fmu.exporting import export as export
    from ropeway.fmu.imported import Fmu as Fmu
    from ropeway.fmu.imported import load as load
    from ropeway.fmu.slave import Slave as Slave
    from ropeway.fmu.stepping import StepControl as StepControl

_HOMES = {
    "cosimulation": "CoSimulation",
    "embedded": "FmuComponent component",
    "errors": "FmuError FmuExportError FmuImportError FmuRunError FmuVariableError",
    "exporting": "export",
    "imported": "Fmu load",
    "slave": "Slave",
    "stepping": "StepControl",
}
_HOME = {name: module for module, names in _HOMES.items() for name in names.split()}

__all__ = sorted(_HOME)


def __getattr__(name: str) -> Any:
    if name in _HOME:
        return getattr(import_module(f"ropeway.fmu.{_HOME[name]}"), name)
    raise AttributeError(f"module 'ropeway.fmu' has no attribute {name!r}")
