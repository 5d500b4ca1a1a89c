"""A cable system as an FMU: FMI 2.0 or 3.0, Model Exchange and Co-Simulation in one file, no Python inside."""

from __future__ import annotations

import datetime
import hashlib
import re
import tempfile
import uuid
import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Literal

import ropeway
from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.errors import CompilerError, InputError
from ropeway.components.inertia import Inertia
from ropeway.components.whole_files import whole
from ropeway.fmu.errors import FmuExportError
from ropeway.fmu.exporting import documentation, model_description, model_tables
from ropeway.fmu.exporting.binaries import binary_folder, universal
from ropeway.fmu.exporting.carriage_corridor import Corridor
from ropeway.fmu.exporting.equations import ModelEquations
from ropeway.fmu.exporting.generated_code import c_files
from ropeway.fmu.exporting.inertial_solution import InertialSolution
from ropeway.fmu.exporting.interface import Interface
from ropeway.fmu.exporting.terminals import terminals, terminals_and_icons
from ropeway.systems.dynamics.inertia.inertial_system import carries_loads
from ropeway.systems.interrupts import interruptible
from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.modelling.system import System
from ropeway.systems.native import compiler
from ropeway.systems.native.core import core_files
from ropeway.systems.native.object_cache import ObjectCache
from ropeway.systems.rigs.skyline_rig import SkylineRig
from ropeway.systems.solvers.line_sections import UnfitError
from ropeway.systems.statics.equilibrium import Equilibrium
from ropeway.systems.statics.equilibrium_solver import equilibrium

_TEMPLATES = Path(__file__).with_name("templates")
_HEADERS = {
    "2.0": ("fmi2Functions.h", "fmi2FunctionTypes.h", "fmi2TypesPlatform.h"),
    "3.0": ("fmi3Functions.h", "fmi3FunctionTypes.h", "fmi3PlatformTypes.h"),
}
_NAMESPACE = uuid.UUID("6f1f3d52-6c2b-4c0e-9d5b-1d0d3c7a9f10")


@checked
@interruptible
def export(
    system: System | Model | Equilibrium | SkylineRig,
    path: str | Path,
    fmi: Literal["2.0", "3.0"] = "2.0",
    *,
    inputs: Sequence[str] | None = None,
    outputs: Sequence[str] | None = None,
    parameters: Sequence[str] | None = None,
    platforms: Sequence[str] = ("host",),
    tolerance: float = 1e-6,
    station: float | None = None,
    payload: float | None = None,
    emergency_stop: float | None = None,
    inertia: Inertia | None = None,
) -> Path:
    """Export a system as an FMU for Model Exchange and Co-Simulation.

    The FMU starts from the system's equilibrium, or from the given one. The carriage of a skyline rig runs over the
    supports as the mainline's drum turns. A line in weather, as `line.in_weather(environment)`, has temperature, wind
    pressure and direction as inputs.

    Parameters
    ----------
    system : System, Model, Equilibrium or SkylineRig
        What to export.
    path : str or Path
        The file to write; it ends in .fmu.
    fmi : {"2.0", "3.0"}, default "2.0"
        Version of FMI.
    inputs : sequence of str, optional
        Names of the inputs, which may include switches (Booleans `c1.brake`, `c1.pressure_lost`); by default all inputs
        without a Schedule.
    outputs : sequence of str, optional
        Names of the outputs; by default all outputs, states, travels and coordinates.
    parameters : sequence of str, optional
        Names of the parameters; by default all, and the masses of the loads.
    platforms : sequence of str, default ("host",)
        Platforms of the binaries: "host", "x86_64-linux", "aarch64-linux", "x86-linux", "x86_64-windows",
        "x86-windows", "x86_64-macos", "aarch64-macos"; () for sources only.
    tolerance : float, default 1e-6
        Tolerance of the integrator in Co-Simulation, relative and absolute on scaled variables, unless the importer
        gives one.
    station : float, optional
        Start of the carriage of a skyline rig [m]; by default the middle of the first span.
    payload : float, optional
        Payload of a skyline rig [kg]; by default that of its carriage.
    emergency_stop : float, optional
        Deceleration [m/s2] of a Boolean input `emergency_stop`, by which an importer stops all drives during a run, as
        an `Intervention` does; by default there is none.
    inertia : Inertia, optional
        The inertia of ropes, loads and wheels; loads run over supports as in `simulate`. Booleans `span.broken` and
        `carriage.dropped` can be inputs. By default the line is in equilibrium at every time.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        An invalid path or value, or an open input that is not exported.
    UnknownNameError
        An unknown name in inputs, outputs or parameters.
    EquilibriumError
        The system has no equilibrium.
    FmuExportError
        The compiler failed, a component is an FMU itself, or loads run over supports of a line with inertia that the
        compiled core does not have, as one whose drives share a power unit.
    WriteError
        The file could not be written.
    Interrupted
        The user interrupted.

    Examples
    --------
    >>> rw.fmu.export(span, "span.fmu", outputs=["a.tension", "b.tension"]).name
    'span.fmu'
    """
    check.positive(tolerance, "export", "tolerance")
    if emergency_stop is not None:
        check.positive(emergency_stop, "export", "emergency_stop", "m/s2")
    target = Path(path)
    if target.suffix != ".fmu":
        raise InputError(f"{str(path)!r} does not end in .fmu", f"Rename it to {target.stem or 'line'}.fmu")
    if not target.parent.is_dir():
        raise InputError(f"There is no folder {target.parent}", "Create it, or choose another")
    names = compiler.resolved(platforms)
    if isinstance(system, SkylineRig) and system.environment is not None:
        raise InputError(
            f"The FMU of a rig such as {system.name!r} has no weather", "Export the rig without environment"
        )
    if isinstance(system, SkylineRig):
        if inertia is not None:
            raise InputError(f"The FMU of a rig such as {system.name!r} has no inertia", "Export rig.system(...)")
        corridor = Corridor(system, station, payload)
        rest, equations = corridor.rest, ModelEquations(corridor.state, corridor)
    elif station is not None or payload is not None:
        raise InputError("station and payload apply to skyline rigs only", "Omit them")
    else:
        rest = system if isinstance(system, Equilibrium) else equilibrium(system)
        _require_exportable(rest.model)
        equations = ModelEquations.at(rest, inertia)
        _require_crossings(equations)
    interface = Interface(equations, inputs, outputs, parameters, stops=emergency_stop is not None)
    settings = model_tables.Settings(tolerance, emergency_stop)
    with whole(target) as file:  # a full disk of the compiler's folder is a WriteError as well
        content = _content(interface, rest, fmi, settings, names)
        with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
            for name, data in content.items():
                archive.writestr(name, data)
    return target


def _require_exportable(model: Model) -> None:
    """Raises FmuExportError for a model that an FMU cannot have."""
    if model.external:
        raise FmuExportError(
            f"A component of {model.name!r} is an FMU itself",
            "Export the system without it, and couple both by CoSimulation",
        )


def _require_crossings(equations: ModelEquations) -> None:
    """Raises FmuExportError where loads run over supports of a system with inertia that the core does not have."""
    moving = next((run for run in equations.model.runs if carries_loads(run)), None)
    if moving is not None and isinstance(equations.inertial, UnfitError):
        raise FmuExportError(
            f"Loads of {moving.name} run over its supports, which an FMU with inertia cannot solve: "
            f"{equations.inertial}",
            "Export the system, or an equilibrium of it, without inertia",
        )


def _content(
    interface: Interface, rest: Equilibrium, fmi: str, settings: model_tables.Settings, platforms: Sequence[str]
) -> dict[str, bytes]:
    """All files of an FMU, by their path in the archive."""
    sources = write_sources(interface, fmi, settings)
    about = _about(rest, sources["model_data.c"], settings.tolerance)
    compiled = tuple(name for name in sources if name.endswith(".c"))
    place, seen = ("model.png", "../model.png") if fmi == "2.0" else ("documentation/diagram.png", "diagram.png")
    return {
        "modelDescription.xml": model_description.model_description(fmi, about, interface, compiled),
        **({place: documentation.picture(rest)} if rest.runs else {}),
        "documentation/index.html": documentation.page(about, interface, seen if rest.runs else None).encode(),
        **{f"sources/{name}": text.encode() for name, text in sources.items()},
        "sources/buildDescription.xml": model_description.build_description(about, compiled),
        **_terminals(interface, fmi),
        **_binaries(sources, compiled, fmi, about.identifier, platforms),
    }


def _terminals(interface: Interface, fmi: str) -> dict[str, bytes]:
    """The terminals of FMI 3.0."""
    found = terminals(interface) if fmi == "3.0" else []
    return {"terminalsAndIcons/terminalsAndIcons.xml": terminals_and_icons(found)} if found else {}


def write_sources(interface: Interface, fmi: str, settings: model_tables.Settings) -> dict[str, str]:
    """All C files and headers of an FMU, by name. The fingerprint identifies their content."""
    import fmpy

    headers = Path(fmpy.__file__).with_name("c-code")
    model, functions = _model_code(interface.equations)
    data = model_tables.fill(interface, settings)
    templates = {**core_files(), "fmi_shared.h": (_TEMPLATES / "fmi_shared.h").read_text()}
    wrapper = f"fmi{fmi[0]}.c"
    content = hashlib.sha256("".join([fmi, *model.values(), data.source(), *templates.values()]).encode()).hexdigest()
    data.fingerprint(f"{{{uuid.uuid5(_NAMESPACE, content)}}}")
    return {
        wrapper: (_TEMPLATES / wrapper).read_text(),
        **templates,
        **model,
        "model_data.c": data.source(),
        "model_data.h": data.header(functions),
        **{name: (headers / name).read_text() for name in _HEADERS[fmi]},
    }


def _model_code(equations: ModelEquations) -> tuple[dict[str, str], str]:
    """Generated C of the equations, and their declarations."""
    files = c_files(equations.functions)
    if equations.by_sections is not None:
        files |= equations.by_sections.sources
    if isinstance(equations.inertial, InertialSolution):
        files |= equations.inertial.sources
    declarations = "\n".join(
        f"int {f.name()}(const double **arg, double **res, int *iw, double *w, int mem);" for f in equations.functions
    )
    return files, declarations


def _about(rest: Equilibrium, data: str, tolerance: float) -> model_description.About:
    found = re.search(r'rw_fingerprint\[\d+\] = "([^"]+)"', data)
    name = rest.model.name
    return model_description.About(
        name=name,
        identifier=_identifier(name),
        fingerprint=found[1] if found else "",
        description=_summary(rest),
        version=ropeway.__version__,
        generated=datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%dT%H:%M:%SZ"),
        tolerance=tolerance,
        step=0.1,
    )


def _summary(rest: Equilibrium) -> str:
    """Summary of a system in one line."""
    if not rest.runs:
        return f"System of {', '.join(f'{type(c).__name__} {c.name}' for c in rest.model.system.components.values())}"
    numbers = (sum(len(run.spans) for run in rest.runs), "span"), (len(rest.runs), "rope"), (len(rest.loads), "load")
    spans, ropes, loads = (f"{n} {what}{'' if n == 1 else 's'}" for n, what in numbers)
    return f"Cable system of {spans} on {ropes}, {loads} at the start"


def _identifier(name: str) -> str:
    """A name as a C identifier, for FMI and as a file name on any platform."""
    plain = re.sub(r"\W", "_", name, flags=re.ASCII)
    return plain if re.match("[A-Za-z]", plain) else f"system_{plain}"


def _binaries(
    sources: Mapping[str, str], compiled: Sequence[str], fmi: str, identifier: str, platforms: Sequence[str]
) -> dict[str, bytes]:
    """Shared libraries by their path in the archive."""
    found: dict[str, dict[str, bytes]] = {}
    with tempfile.TemporaryDirectory() as folder:
        for name, text in sources.items():
            (Path(folder) / name).write_text(text)
        for platform in platforms:
            library = Path(folder) / f"{platform}{compiler.suffix(platform)}"
            try:
                kept = ObjectCache(Path(folder), platform, "model_data.c")
                compiler.compile_library(Path(folder), compiled, platform, library, kept)
            except CompilerError as error:
                raise FmuExportError(error.cause, error.remedy) from error
            place = f"binaries/{binary_folder(fmi, platform, platforms)}/{identifier}{library.suffix}"
            found.setdefault(place, {})[platform.split("-")[0]] = library.read_bytes()
    return {
        place: next(iter(slices.values())) if len(slices) == 1 else universal(slices) for place, slices in found.items()
    }
