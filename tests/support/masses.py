"""A small FMU written by hand (fmu/mass.c), to try importing and coupling against closed forms."""

import subprocess
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pandas as pd

from ropeway.fmu import CoSimulation, Fmu
from ropeway.systems.native import compiler

_OUTPUTS = ("x", "v", "der(x)", "a", "f")
_INPUTS = ("force", "x_in", "v_in")
_PARAMETERS = {
    "mass": 1.0,
    **dict.fromkeys(("spring", "damper", "stiffness", "cubic", "damping", "gravity"), 0.0),
    "floor": -1e9,
    "bounce": 0.0,
    "kick_time": 1e9,
    "kick": 0.0,
    "longest_step": 1e9,
}


def mass_fmu(
    path: Path,
    *,
    keeps_states: bool = True,
    differentiates: bool = True,
    interpolates: bool = True,
    co_simulates: bool = True,
) -> Path:
    """Compiles it and writes its description, with abilities as asked for."""
    source, library = Path(__file__).with_name("mass.c"), path.with_suffix(".so")
    flags = ["-O2", "-std=c99", "-shared", "-fPIC", f"-I{Path(fmpy.__file__).with_name('c-code')}"]
    command = [*compiler.command(compiler.host()), *flags, str(source), "-o", str(library), "-lm"]
    subprocess.run(command, check=True)
    with zipfile.ZipFile(path, "w") as archive:
        description = _description(keeps_states, differentiates, interpolates, co_simulates)
        archive.writestr("modelDescription.xml", description)
        archive.write(library, "binaries/linux64/mass.so")
    return path


def _description(keeps_states: bool, differentiates: bool, interpolates: bool, co_simulates: bool) -> str:
    variables, names = [], (*_OUTPUTS, *_INPUTS, *_PARAMETERS)
    for i, name in enumerate(names):
        kind, real = 'causality="output"', ""
        if name in ("x", "v"):
            kind, real = f'{kind} initial="exact"', 'start="0"'
        elif name == "der(x)" or name == "a":
            real = f'derivative="{1 if name == "der(x)" else 2}"'
            kind = 'causality="output"' if name == "a" else 'causality="local"'
        elif name in _INPUTS:
            kind, real = 'causality="input"', 'start="0"'
        elif name in _PARAMETERS:
            kind, real = 'causality="parameter" variability="fixed"', f'start="{_PARAMETERS[name]}"'
        variables.append(f'<ScalarVariable name="{name}" valueReference="{i}" {kind}><Real {real}/></ScalarVariable>')
    states, slopes, linear = (str(v).lower() for v in (keeps_states, differentiates, interpolates))
    abilities = f'modelIdentifier="mass" canGetAndSetFMUstate="{states}" providesDirectionalDerivative="{slopes}"'
    steps = f'canInterpolateInputs="{linear}" canHandleVariableCommunicationStepSize="true"'
    co_simulation = f"<CoSimulation {abilities} {steps}/>" if co_simulates else ""
    unknowns = [i + 1 for i, n in enumerate(_OUTPUTS) if n != "der(x)"]
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="mass" guid="mass" numberOfEventIndicators="1">
<ModelExchange {abilities}/>
{co_simulation}
<ModelVariables>{"".join(variables)}</ModelVariables>
<ModelStructure>
<Outputs>{"".join(f'<Unknown index="{i}"/>' for i in unknowns)}</Outputs>
<Derivatives><Unknown index="3"/><Unknown index="4"/></Derivatives>
<InitialUnknowns><Unknown index="3"/><Unknown index="4"/><Unknown index="5"/></InitialUnknowns>
</ModelStructure>
</fmiModelDescription>"""


_ONE = {"mass": 1.0, "spring": 1.0, "damper": 0.1, "stiffness": 20.0, "damping": 5.0, "x": 1.0}
_TWO = {"mass": 2.0, "spring": 2.0, "damper": 0.5}


def pair(path: Path | Fmu, step: float, start: Mapping[str, float] | None = None, **more: Any) -> CoSimulation:
    """Two masses: the first sees where the other is, the other the force between them. `start`: more for the first."""
    together = CoSimulation(step, **more)
    together.add("one", path, start={**_ONE, **(start or {})})
    together.add("two", path, start=_TWO)
    together.connect("two.x", "one.x_in")
    together.connect("two.v", "one.v_in")
    together.connect("one.f", "two.force")
    return together


def exact_pair(times: pd.Index) -> np.ndarray:
    """one.x, one.v, two.x, two.v of the pair, by the eigenvectors of their equations."""
    k, d = _ONE["stiffness"], _ONE["damping"]
    rates = np.zeros((4, 4))
    rates[0, 1] = rates[2, 3] = 1.0
    rates[1] = np.array([-_ONE["spring"] - k, -_ONE["damper"] - d, k, d]) / _ONE["mass"]
    rates[3] = np.array([k, d, -_TWO["spring"] - k, -_TWO["damper"] - d]) / _TWO["mass"]
    values, vectors = np.linalg.eig(rates)
    shares = np.linalg.solve(vectors, [_ONE["x"], 0.0, 0.0, 0.0])
    exact: np.ndarray = ((vectors * shares) @ np.exp(np.outer(values, times))).real.T
    return exact
