"""Small FMUs that misbehave (hostile.c), and archives that mean harm."""

import subprocess
import zipfile
from collections.abc import Sequence
from pathlib import Path

import fmpy

from ropeway.systems.native import compiler

DEEDS = ["nothing", "segfault", "exit", "abort", "hang", "bus", "move", "overflow", "trash", "noise", "fatal"]


def library(path: Path, *flags: str) -> Path:
    """Compiles hostile.c."""
    own = ["-O0", "-w", "-std=gnu99", "-shared", "-fPIC", f"-I{Path(fmpy.__file__).with_name('c-code')}"]
    source = Path(__file__).with_name("hostile.c")
    subprocess.run([*compiler.command(compiler.host()), *own, *flags, str(source), "-o", str(path)], check=True)
    return path


def described(**attributes: object) -> str:
    """A model description, with other attributes of Co-Simulation; `y1`: more of its first output."""
    y1 = attributes.pop("y1", "")
    section = {"modelIdentifier": "hostile", "canHandleVariableCommunicationStepSize": "true", **attributes}
    how = " ".join(f'{name}="{value}"' for name, value in section.items())
    rows = [f'name="u{k + 1}" valueReference="{k}" causality="input"><Real start="0"' for k in range(10)]
    rows += [f'name="y{k + 1}" valueReference="{10 + k}" causality="output"><Real {"" if k else y1}' for k in range(10)]
    rows.append('name="t" valueReference="20" causality="output"><Real')
    rows.append('name="when" valueReference="21" causality="parameter" variability="fixed"><Real start="1e9"')
    rows.append('name="deed" valueReference="22" causality="parameter" variability="fixed"><Integer start="0"')
    variables = "".join(f"<ScalarVariable {row}/></ScalarVariable>" for row in rows)
    outputs = "".join(f'<Unknown index="{k}" dependencies="{max(k - 10, 0) or ""}"/>' for k in range(11, 21))
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="hostile" guid="hostile">
<CoSimulation {how}/>
<ModelVariables>{variables}</ModelVariables>
<ModelStructure><Outputs>{outputs}<Unknown index="21" dependencies=""/></Outputs></ModelStructure>
</fmiModelDescription>"""


def hostile_fmu(path: Path, binary: Path, files: Sequence[tuple[str, bytes]] = (), **attributes: object) -> Path:
    """Writes the FMU, with more files."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("modelDescription.xml", described(**attributes))
        archive.write(binary, "binaries/linux64/hostile.so")
        for name, data in files:
            archive.writestr(name, data)
    return path
