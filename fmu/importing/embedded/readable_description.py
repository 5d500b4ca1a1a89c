"""A model description that CasADi can read, without unsupported elements that a component does not need."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from xml.etree import ElementTree

_UNKNOWNS = "Output", "ContinuousStateDerivative", "InitialUnknown", "EventIndicator", "ClockedState"


def make_readable(folder: Path, *, tunes: bool) -> None:
    """Rewrite modelDescription.xml of an extracted FMU.

    `tunes`: whether tunable parameters stay tunable; otherwise they keep their start values. Discrete inputs become
    fixed parameters, as they may change at events only. In FMI 3.0 all variables except scalars of type Float64 are
    removed, and unknowns without `dependencies` depend on all inputs and states, as the standard defines.
    """
    path = folder / "modelDescription.xml"
    tree = ElementTree.parse(path)
    root = tree.getroot()
    three = root.get("fmiVersion", "").startswith("3")
    variables = root.find("ModelVariables")
    for variable in list(variables if variables is not None else ()):
        if three and (variable.tag != "Float64" or variable.find("Dimension") is not None or variable.get("clocks")):
            variables.remove(variable)  # type: ignore[union-attr]
            continue
        for alias in variable.findall("Alias"):
            variable.remove(alias)
        _fix(variable, tunes)
    if three:
        _complete(root, list(variables if variables is not None else ()))
    tree.write(path, encoding="utf-8", xml_declaration=True)


def _fix(variable: ElementTree.Element, tunes: bool) -> None:
    how = variable.get("causality"), variable.get("variability")
    if how[0] == "input":
        variable.attrib.pop("initial", None)
    if how == ("input", "discrete"):
        variable.set("causality", "parameter")
    if how == ("input", "discrete") or (how == ("parameter", "tunable") and not tunes):
        variable.set("variability", "fixed")


def _complete(root: ElementTree.Element, variables: Sequence[ElementTree.Element]) -> None:
    """Unknowns of the remaining variables only, each with its dependencies (FMI 3.0)."""
    present = {v.get("valueReference") for v in variables}
    states = {v.get("derivative") for v in variables} - {None}
    known = [r for v in variables if (r := v.get("valueReference")) in states or v.get("causality") == "input"]
    structure = root.find("ModelStructure")
    for unknown in list(structure if structure is not None else ()):
        if unknown.tag in _UNKNOWNS and unknown.get("valueReference") not in present:
            structure.remove(unknown)  # type: ignore[union-attr]
        elif (given := unknown.get("dependencies")) is None:
            unknown.set("dependencies", " ".join(str(r) for r in known if r != unknown.get("valueReference")))
            unknown.attrib.pop("dependenciesKind", None)
        elif any(r not in present for r in given.split()):
            unknown.set("dependencies", " ".join(r for r in given.split() if r in present))
            unknown.attrib.pop("dependenciesKind", None)
