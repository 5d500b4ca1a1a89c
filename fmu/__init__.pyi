"""The public names of ropeway.fmu, and where they are defined."""

from .cosimulation.cosimulation import CoSimulation as CoSimulation
from .cosimulation.run_report import run_report as run_report
from .cosimulation.step_control import StepControl as StepControl
from .errors import (
    FmuError as FmuError,
    FmuExportError as FmuExportError,
    FmuImportError as FmuImportError,
    FmuRunError as FmuRunError,
    FmuVariableError as FmuVariableError,
)
from .exporting.export import export as export
from .importing.archive import ArchiveLimits as ArchiveLimits
from .importing.embedded.fmu_component import FmuComponent as FmuComponent, component as component
from .importing.fmu_file import Fmu as Fmu, load as load
from .importing.participant import Slave as Slave
