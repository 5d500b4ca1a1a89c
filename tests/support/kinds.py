"""A small FMU written by hand (kinds.c) with variables of all kinds, for both versions of FMI."""

import subprocess
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import Literal

import fmpy

from ropeway.systems.native import compiler

_FIXED = {"level": 7, "stop_at": 8, "discard_at": 9, "error_at": 10}
_TYPES = {"Float32": 60, "Int8": 62, "UInt8": 64, "Int16": 66, "UInt16": 68, "UInt32": 70, "Int64": 72, "UInt64": 74}
_KINDS = 'canGetAndSetFMU{}tate="true"'


def kinds_fmu(path: Path, fmi: Literal["2.0", "3.0"]) -> Path:
    """Compiles it and writes it with its description."""
    folder, library = Path(__file__).parent, path.with_suffix(".so")
    flags = [f"-DFMI={fmi[0]}", "-O1", "-std=c99", "-shared", "-fPIC", f"-I{Path(fmpy.__file__).with_name('c-code')}"]
    command = [*compiler.command(compiler.host()), *flags, str(folder / "kinds.c"), "-o", str(library)]
    subprocess.run(command, check=True)
    return described(path, fmi, library)


def described(
    path: Path,
    fmi: Literal["2.0", "3.0"],
    library: Path,
    *,
    kinds: Sequence[str] = ("ModelExchange", "CoSimulation"),
    varies_steps: bool = True,
) -> Path:
    """Writes it with another description."""
    platform = "linux64" if fmi == "2.0" else "x86_64-linux"
    steps = f'canHandleVariableCommunicationStepSize="{str(varies_steps).lower()}"'
    can = _KINDS.format("s" if fmi == "2.0" else "S")
    sections = {
        "ModelExchange": f'<ModelExchange modelIdentifier="kinds" {can}/>',
        "CoSimulation": f'<CoSimulation modelIdentifier="kinds" {can} {steps}/>',
    }
    sections["ScheduledExecution"] = '<ScheduledExecution modelIdentifier="kinds"/>'
    chosen = "".join(sections[kind] for kind in kinds)
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", (_two if fmi == "2.0" else _three)(chosen))
        archive.write(library, f"binaries/{platform}/kinds.so")
    return path


def _two(kinds: str) -> str:
    variables: list[str] = []

    def add(name: str, reference: int, kind: str, how: str, start: object = None, more: str = "") -> None:
        given = "" if start is None else f'start="{start}"'
        value = f"<{kind} {given} {more}/>"
        variables.append(f'<ScalarVariable name="{name}" valueReference="{reference}" {how}>{value}</ScalarVariable>')

    fixed, discrete = 'causality="parameter" variability="fixed"', 'variability="discrete"'
    add("x", 2, "Real", 'causality="output" initial="exact"', 0)
    add("der(x)", 3, "Real", 'causality="local"', None, 'derivative="1"')
    add("u", 1, "Real", 'causality="input"', 0)
    add("d", 4, "Real", f'causality="input" {discrete}', 0)
    add("d_out", 5, "Real", f'causality="output" {discrete}')
    add("gain", 6, "Real", 'causality="parameter" variability="tunable"', 0)
    for name, reference in _FIXED.items():
        add(name, reference, "Real", fixed, 1e9)
    add("start_told", 11, "Real", 'causality="output"')
    add("stop_told", 12, "Real", 'causality="output"')
    for name, reference, kind, start, more in (
        ("count", 20, "Integer", 0, ""),
        ("brake", 30, "Boolean", "false", ""),
        ("text", 40, "String", "none", ""),
        ("gear", 50, "Enumeration", 1, 'declaredType="Gear"'),
    ):
        add(name, reference, kind, f'causality="input" {discrete}', start, more)
        add(f"{name}_out", reference + 1, kind, f'causality="output" {discrete}', None, more)
    add("limit", 32, "Boolean", f'causality="output" {discrete}')
    outputs = [i + 1 for i, text in enumerate(variables) if 'causality="output"' in text]
    unknowns = "".join(f'<Unknown index="{i}"/>' for i in outputs)
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="kinds" guid="kinds" numberOfEventIndicators="1">
{kinds}
<TypeDefinitions><SimpleType name="Gear"><Enumeration><Item name="low" value="1"/><Item name="high" value="2"/>
</Enumeration></SimpleType></TypeDefinitions>
<ModelVariables>{"".join(variables)}</ModelVariables>
<ModelStructure><Outputs>{unknowns}</Outputs><Derivatives><Unknown index="2"/></Derivatives>
<InitialUnknowns><Unknown index="2"/></InitialUnknowns></ModelStructure>
</fmiModelDescription>"""


def _three(kinds: str) -> str:
    variables: list[str] = []

    def add(kind: str, name: str, reference: int, how: str, start: object = None, inside: str = "") -> None:
        given = "" if start is None else f'start="{start}"'
        variables.append(f'<{kind} name="{name}" valueReference="{reference}" {how} {given}>{inside}</{kind}>')

    input_, output, tunable = 'causality="input"', 'causality="output"', 'causality="parameter" variability="tunable"'
    add("Float64", "time", 0, 'causality="independent"')
    add("Float64", "u", 1, input_, 0)
    add("Float64", "x", 2, f'{output} initial="exact"', 0)
    add("Float64", "der(x)", 3, 'derivative="2"')
    add("Float64", "d", 4, f'{input_} variability="discrete"', 0)
    add("Float64", "d_out", 5, f'{output} variability="discrete"')
    add("Float64", "gain", 6, tunable, 0)
    for name, reference in _FIXED.items():
        add("Float64", name, reference, 'causality="parameter"', 1e9)
    add("Float64", "start_told", 11, output)
    add("Float64", "stop_told", 12, output)
    for kind, name, reference, start, more in (
        ("Int32", "count", 20, 0, ""),
        ("Boolean", "brake", 30, "false", ""),
        ("Enumeration", "gear", 50, 1, 'declaredType="Gear"'),
        *((kind, kind.lower(), reference, 0, 'variability="discrete"') for kind, reference in _TYPES.items()),
    ):
        add(kind, name, reference, f"{input_} {more}", start)
        add(kind, f"{name}_out", reference + 1, f"{output} {more}")
    for kind, name, reference, start in (("String", "text", 40, "none"), ("Binary", "binary", 76, "")):
        add(kind, name, reference, input_, None, f'<Start value="{start}"/>')
        add(kind, f"{name}_out", reference + 1, output)
    add("Boolean", "limit", 32, output)
    of_size, two = '<Dimension valueReference="80"/>', '<Dimension start="2"/>'
    add("UInt64", "n", 80, 'causality="structuralParameter"', 3)
    add("Float64", "v", 81, input_, "0 0 0", of_size)
    add("Float64", "w", 82, output, None, of_size)
    add("Float64", "m", 83, tunable, "0 0 0 0", two + two)
    add("Float64", "trace", 84, output)
    add("Boolean", "flags", 85, input_, "false false", two)
    add("Boolean", "flags_out", 86, output, None, two)
    add("Clock", "tick", 90, f'{output} intervalVariability="triggered"')
    add("Float64", "ticked", 91, f'{output} variability="discrete" clocks="90"')
    references = [t.split('valueReference="')[1].split('"')[0] for t in variables if 'causality="output"' in t]
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="kinds" instantiationToken="kinds">
{kinds}
<TypeDefinitions><EnumerationType name="Gear"><Item name="low" value="1"/><Item name="high" value="2"/>
</EnumerationType></TypeDefinitions>
<ModelVariables>{"".join(variables)}</ModelVariables>
<ModelStructure>{"".join(f'<Output valueReference="{r}"/>' for r in references)}
<ContinuousStateDerivative valueReference="3"/><EventIndicator valueReference="3"/></ModelStructure>
</fmiModelDescription>"""
