"""Small FMUs of examples.c, known from textbooks, for Model Exchange."""

import subprocess
import zipfile
from pathlib import Path

import fmpy

from ropeway.systems.native import compiler

_MODELS: dict[str, tuple[int, tuple[str, ...], tuple[str, ...], dict[str, float], int]] = {
    "vanderpol": (1, ("x0", "x1"), (), {"mu": 1.0}, 0),
    "ball": (2, ("h", "v"), ("bounces",), {"g": 9.81, "e": 0.7, "v_min": 0.1}, 1),
    "stair": (3, (), ("counter",), {"width": 1.0, "last": 10.0}, 0),
    "roberts": (4, ("y1", "y2", "y3"), ("levels",), {}, 2),
}
"""Number of each model, its states, outputs and parameters, and number of event indicators."""
_STARTS = {"x0": 2.0, "h": 1.0, "y1": 1.0}


def example_fmu(folder: Path, name: str, *, keeps_states: bool = True) -> Path:
    """Compiles a model and writes it with its description."""
    number, states, outputs, parameters, indicators = _MODELS[name]
    path = folder / f"{name}.fmu"
    library = path.with_suffix(".so")
    flags = [f"-DMODEL={number}", "-O1", "-std=c99", "-shared", "-fPIC"]
    include = f"-I{Path(fmpy.__file__).with_name('c-code')}"
    source = Path(__file__).with_name("examples.c")
    command = [*compiler.command(compiler.host()), *flags, include, str(source), "-o", str(library), "-lm"]
    subprocess.run(command, check=True)
    variables: list[str] = []

    def add(shown: str, how: str, real: str = "") -> None:
        head = f'name="{shown}" valueReference="{len(variables)}"'
        variables.append(f"<ScalarVariable {head} {how}><Real {real}/></ScalarVariable>")

    for state in states:
        add(state, 'causality="output" initial="exact"', f'start="{_STARTS.get(state, 0.0)}"')
    for i, state in enumerate(states):
        add(f"der({state})", 'causality="local"', f'derivative="{i + 1}"')
    for output in outputs:
        add(output, 'causality="output" variability="discrete"')
    for parameter, value in parameters.items():
        add(parameter, 'causality="parameter" variability="fixed"', f'start="{value}"')
    n = len(states)
    shown = [i + 1 for i in range(n)] + [2 * n + i + 1 for i in range(len(outputs))]
    rates = "".join(f'<Unknown index="{n + i + 1}"/>' for i in range(n))
    derivatives = f"<Derivatives>{rates}</Derivatives>" if n else ""
    can = f'modelIdentifier="{name}" canGetAndSetFMUstate="{str(keeps_states).lower()}"'
    text = f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="{name}" guid="{name}" numberOfEventIndicators="{indicators}">
<ModelExchange {can}/><ModelVariables>{"".join(variables)}</ModelVariables>
<ModelStructure><Outputs>{"".join(f'<Unknown index="{i}"/>' for i in shown)}</Outputs>{derivatives}</ModelStructure>
</fmiModelDescription>"""
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", text)
        archive.write(library, f"binaries/linux64/{name}.so")
    return path
