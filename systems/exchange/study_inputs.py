"""What a study is asked: its name, the system or rig, and its arguments, as data that can be saved."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from ropeway.components.argument_checks import checked
from ropeway.systems.exchange.project_text import Json, Keys
from ropeway.systems.exchange.project_values import Decoder, Encoder, FileKind
from ropeway.systems.modelling.system import System
from ropeway.systems.rigs.skyline_rig import SkylineRig


@checked
@dataclass(frozen=True, eq=False)
class StudyInputs:
    """A study with its inputs.

    Parameters
    ----------
    study : str
        A name of `rw.STUDIES`, such as "payload" or "simulate".
    of : System or SkylineRig
        What is studied.
    arguments : mapping, optional
        The arguments of the study by name, such as {"safety_factor": 3.0}.

    Examples
    --------
    >>> inputs = rw.StudyInputs("payload", rig, {"stations": [150.0], "clearance": 1.0})
    >>> rw.run_study(inputs).frame["limited_by"].tolist()
    ['skyline tension']
    """

    study: str
    of: System | SkylineRig
    arguments: Mapping[str, Any] = field(default_factory=dict)

    def __repr__(self) -> str:
        given = ", ".join(f"{name}={value!r}" for name, value in self.arguments.items())
        return f"<StudyInputs: {self.study} of {self.of.name!r}{', ' if given else ''}{given}>"


def _write(encoder: Encoder, inputs: StudyInputs) -> dict[str, Json]:
    arguments = encoder.value(dict(inputs.arguments), inputs.study)
    return {"study": inputs.study, "arguments": arguments, "of": encoder.value(inputs.of, inputs.study)}


def _read(decoder: Decoder, data: Mapping[str, Json], keys: Keys) -> StudyInputs:
    decoder.require_fields(data, keys, ("kind", "study", "arguments", "of"), ("study", "of"))
    arguments = decoder.require_object(data.get("arguments", {}), (*keys, "arguments"))
    given = {name: decoder.value(v, (*keys, "arguments", name)) for name, v in arguments.items()}
    of = decoder.thing(decoder.require_object(data["of"], (*keys, "of")), (*keys, "of"))
    made: StudyInputs = decoder.made(StudyInputs, keys, {"study": data["study"], "of": of, "arguments": given})
    return made


KIND = FileKind("study", StudyInputs, _write, _read)
