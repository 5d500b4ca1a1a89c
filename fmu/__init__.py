"""Functional Mock-up Units: export of systems, import, co-simulation. Names are loaded when they are first used."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ropeway.fmu.cosimulation.cosimulation import CoSimulation as CoSimulation
    from ropeway.fmu.cosimulation.step_control import StepControl as StepControl
    from ropeway.fmu.errors import FmuError as FmuError
    from ropeway.fmu.errors import FmuExportError as FmuExportError
    from ropeway.fmu.errors import FmuImportError as FmuImportError
    from ropeway.fmu.errors import FmuRunError as FmuRunError
    from ropeway.fmu.errors import FmuVariableError as FmuVariableError
    from ropeway.fmu.exporting.export import export as export
    from ropeway.fmu.importing.fmu_component import FmuComponent as FmuComponent
    from ropeway.fmu.importing.fmu_component import component as component
    from ropeway.fmu.importing.fmu_file import Fmu as Fmu
    from ropeway.fmu.importing.fmu_file import load as load
    from ropeway.fmu.importing.participant import Slave as Slave

_HOMES = {
    "cosimulation.cosimulation": "CoSimulation",
    "cosimulation.step_control": "StepControl",
    "errors": "FmuError FmuExportError FmuImportError FmuRunError FmuVariableError",
    "exporting.export": "export",
    "importing.fmu_component": "FmuComponent component",
    "importing.fmu_file": "Fmu load",
    "importing.participant": "Slave",
}
_HOME = {name: module for module, names in _HOMES.items() for name in names.split()}

__all__ = sorted(_HOME)


def __getattr__(name: str) -> Any:
    if name in _HOME:
        return getattr(import_module(f"ropeway.fmu.{_HOME[name]}"), name)
    raise AttributeError(f"module 'ropeway.fmu' has no attribute {name!r}")
