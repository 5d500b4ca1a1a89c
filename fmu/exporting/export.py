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

import casadi as ca

import ropeway
from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.errors import CompilerError, InputError
from ropeway.components.whole_files import whole
from ropeway.fmu.errors import FmuExportError
from ropeway.fmu.exporting import documentation, model_description, model_tables
from ropeway.fmu.exporting.binaries import binary_folder, universal
from ropeway.fmu.exporting.carriage_corridor import Corridor
from ropeway.fmu.exporting.equations import ModelEquations
from ropeway.fmu.exporting.interface import Interface
from ropeway.systems.interrupts import interruptible, stop_if_interrupted
from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.modelling.system import System
from ropeway.systems.native import compiler
from ropeway.systems.native.core import core_files
from ropeway.systems.rigs.skyline_rig import SkylineRig
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
) -> Path:
    """Writes a system as an FMU; returns its path.

    It starts from the system's equilibrium, or from the one given. Of a skyline rig the carriage starts at a `station`
    [m] with a `payload` [kg], by default in the middle of the first span with that of the carriage; it runs over the
    supports as the mainline's drum turns. inputs, outputs, parameters: names of the
    variables to show; by default all inputs that no Schedule drives; all outputs, states, travels and coordinates; all
    parameters and load masses. inputs may name switches too: `c1.brake` and `c1.pressure_lost`, Booleans. platforms:
    "host" and names of `ropeway.systems.native.compiler.PLATFORMS`; () for sources only. tolerance: of the integrator
    in Co-Simulation, relative and absolute on scaled variables.

    Raises InputError, UnknownNameError, EquilibriumError, FmuExportError, WriteError, Interrupted.
    """
    check.positive(tolerance, "export", "tolerance")
    target = Path(path)
    if target.suffix != ".fmu":
        raise InputError(f"{str(path)!r} does not end in .fmu", f"Call it {target.stem or 'line'}.fmu")
    if not target.parent.is_dir():
        raise InputError(f"There is no folder {target.parent}", "Make it, or choose another")
    names = compiler.resolved(platforms)
    if isinstance(system, SkylineRig):
        corridor = Corridor(system, station, payload)
        rest, equations = corridor.rest, ModelEquations(corridor.state, corridor)
    elif station is not None or payload is not None:
        raise InputError("station and payload are for skyline rigs", "Leave them out")
    else:
        rest = system if isinstance(system, Equilibrium) else equilibrium(system)
        equations = ModelEquations.at(rest)
    if rest.model.external:
        raise FmuExportError(f"A part of {rest.model.name!r} is an FMU itself", "Export the rest, use CoSimulation")
    interface = Interface(equations, inputs, outputs, parameters)
    with whole(target) as file:  # what is short of room on the way, as a folder for the compiler, counts too
        content = _content(interface, rest, fmi, tolerance, names)
        with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
            for name, data in content.items():
                archive.writestr(name, data)
    return target


def _content(
    interface: Interface, rest: Equilibrium, fmi: str, tolerance: float, platforms: Sequence[str]
) -> dict[str, bytes]:
    """All files of an FMU, by their place in the archive."""
    sources = write_sources(interface, fmi, tolerance)
    about = _about(rest, sources["model_data.c"], tolerance)
    compiled = tuple(name for name in sources if name.endswith(".c"))
    place, seen = ("model.png", "../model.png") if fmi == "2.0" else ("documentation/diagram.png", "diagram.png")
    return {
        "modelDescription.xml": model_description.model_description(fmi, about, interface, compiled),
        **({place: documentation.picture(rest)} if rest.runs else {}),
        "documentation/index.html": documentation.page(about, interface, seen if rest.runs else None).encode(),
        **{f"sources/{name}": text.encode() for name, text in sources.items()},
        "sources/buildDescription.xml": model_description.build_description(about, compiled),
        **_binaries(sources, compiled, fmi, about.identifier, platforms),
    }


def write_sources(interface: Interface, fmi: str, tolerance: float) -> dict[str, str]:
    """All C files and headers of an FMU, by name. The fingerprint is that of what they compute."""
    import fmpy

    headers = Path(fmpy.__file__).with_name("c-code")
    model, functions = _model_code(interface.equations)
    data = model_tables.fill(interface, tolerance)
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
    """The generated C of the equations, a file for each function as they are long, and their declarations."""
    files = {}
    for function in equations.functions:
        stop_if_interrupted()
        name = f"{function.name()}.c"
        generator = ca.CodeGenerator(name, {"casadi_int": "int", "with_export": False})
        generator.add(function)
        files[name] = _spared(generator.dump())
    declarations = "\n".join(
        f"int {f.name()}(const double **arg, double **res, int *iw, double *w, int mem);" for f in equations.functions
    )
    return files, declarations


_LONG = 1_000_000
"""Characters of C over which clang takes minutes."""
_SPARE = """#if defined(__clang__)
#define RW_SPARED __attribute__((optnone))
#else
#define RW_SPARED
#endif
"""


def _spared(code: str) -> str:
    """Long code in which clang does not optimise the functions that only call those of components: they are what is
    long, and make a step slower by a third only."""
    if len(code) < _LONG:
        return code
    calls = r"(/\* (?:rw_\w+|fwd\d+_(?:dae|outputs)):.*\n)(static int)"
    return _SPARE + re.sub(calls, r"\1RW_SPARED \2", code)


def _about(rest: Equilibrium, data: str, tolerance: float) -> model_description.About:
    found = re.search(r'rw_fingerprint\[\d+\] = "([^"]+)"', data)
    name = rest.model.name
    return model_description.About(
        name=name,
        identifier=_identifier(name),
        fingerprint=found[1] if found else "",
        description=_described(rest),
        version=ropeway.__version__,
        generated=datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%dT%H:%M:%SZ"),
        tolerance=tolerance,
        step=0.1,
    )


def _described(rest: Equilibrium) -> str:
    """What a system consists of, in a line."""
    if not rest.runs:
        return f"System of {', '.join(f'{type(c).__name__} {c.name}' for c in rest.model.system.components.values())}"
    numbers = (sum(len(run.spans) for run in rest.runs), "span"), (len(rest.runs), "rope"), (len(rest.loads), "load")
    spans, ropes, loads = (f"{n} {what}{'' if n == 1 else 's'}" for n, what in numbers)
    return f"Cable system of {spans} on {ropes}, {loads} at the start"


def _identifier(name: str) -> str:
    """A name as a C identifier: what FMI wants of a model's, and a file name on every platform."""
    plain = re.sub(r"\W", "_", name, flags=re.ASCII)
    return plain if re.match("[A-Za-z]", plain) else f"system_{plain}"


def _binaries(
    sources: Mapping[str, str], compiled: Sequence[str], fmi: str, identifier: str, platforms: Sequence[str]
) -> dict[str, bytes]:
    """Shared libraries by their place in the archive."""
    found: dict[str, dict[str, bytes]] = {}
    with tempfile.TemporaryDirectory() as folder:
        for name, text in sources.items():
            (Path(folder) / name).write_text(text)
        for platform in platforms:
            library = Path(folder) / f"{platform}{compiler.suffix(platform)}"
            try:
                compiler.compile_library(Path(folder), compiled, platform, library)
            except CompilerError as error:
                raise FmuExportError(error.cause, error.remedy) from error
            place = f"binaries/{binary_folder(fmi, platform, platforms)}/{identifier}{library.suffix}"
            found.setdefault(place, {})[platform.split("-")[0]] = library.read_bytes()
    return {
        place: next(iter(slices.values())) if len(slices) == 1 else universal(slices) for place, slices in found.items()
    }
