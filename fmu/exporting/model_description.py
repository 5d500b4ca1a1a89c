"""modelDescription.xml for FMI 2.0 and 3.0, and buildDescription.xml."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from xml.etree import ElementTree

from ropeway.components import units
from ropeway.fmu.exporting.interface import FmuVariable, Interface

CATEGORIES = {
    "logAll": "everything",
    "logEvents": "loads that cross supports, are held or released; carriages that reach or leave supports",
    "logStatusWarning": "limits: tension above the safe or breaking load, lift-off",
    "logStatusDiscard": "a call that failed and left the state unchanged",
    "logStatusError": "an invalid call, or a failure",
}
"""Log categories."""

_TYPES = {"Real": "Float64", "Integer": "Int32", "Boolean": "Boolean"}


@dataclass(frozen=True)
class About:
    """Attributes of a model description besides its variables."""

    name: str
    identifier: str
    fingerprint: str
    description: str
    version: str
    generated: str
    tolerance: float
    step: float


def model_description(fmi: str, about: About, interface: Interface, sources: Sequence[str]) -> bytes:
    """modelDescription.xml of FMI version `fmi`; `sources`: C files to compile."""
    root = _fmi2(about, interface, sources) if fmi == "2.0" else _fmi3(about, interface)
    return written(root)


def build_description(about: About, sources: Sequence[str]) -> bytes:
    """buildDescription.xml of FMI 3.0."""
    root = ElementTree.Element("fmiBuildDescription", fmiVersion="3.0")
    build = ElementTree.SubElement(root, "BuildConfiguration", modelIdentifier=about.identifier)
    files = ElementTree.SubElement(build, "SourceFileSet", language="C99")
    for name in sources:
        ElementTree.SubElement(files, "SourceFile", name=name)
    ElementTree.SubElement(build, "Library", name="m")
    return written(root)


def written(root: ElementTree.Element) -> bytes:
    """A document with indentation."""
    ElementTree.indent(root)
    written: bytes = ElementTree.tostring(root, encoding="UTF-8", xml_declaration=True)
    return written


def _attributes(**values: object) -> dict[str, str]:
    """XML attributes without those that are None."""

    def text(value: object) -> str:
        return (
            str(value).lower() if isinstance(value, bool) else repr(value) if isinstance(value, float) else str(value)
        )

    return {name: text(value) for name, value in values.items() if value is not None}


def _head(fmi: str, about: About, **more: object) -> ElementTree.Element:
    return ElementTree.Element(
        "fmiModelDescription",
        _attributes(
            fmiVersion=fmi,
            modelName=about.name,
            description=about.description,
            version=about.version,
            generationTool="ropeway",
            generationDateAndTime=about.generated,
            variableNamingConvention="structured",
            **more,
        ),
    )


def _common(root: ElementTree.Element, about: About, interface: Interface) -> None:
    definitions = ElementTree.SubElement(root, "UnitDefinitions")
    for symbol in dict.fromkeys(v.unit for v in interface.variables if v.kind == "Real"):
        definition = ElementTree.SubElement(definitions, "Unit", name=symbol)
        unit = units.parse(symbol)
        if unit is not None:
            factor = None if unit.factor == 1.0 else unit.factor
            offset = None if unit.offset == 0.0 else unit.offset
            ElementTree.SubElement(definition, "BaseUnit", _attributes(**unit.base(), factor=factor, offset=offset))
    categories = ElementTree.SubElement(root, "LogCategories")
    for name, description in CATEGORIES.items():
        ElementTree.SubElement(categories, "Category", name=name, description=description)
    ElementTree.SubElement(
        root, "DefaultExperiment", _attributes(startTime=0.0, tolerance=about.tolerance, stepSize=about.step)
    )


def _fmi2(about: About, interface: Interface, sources: Sequence[str]) -> ElementTree.Element:
    indicators = [v for v in interface.variables if v.name.startswith("event_indicator[")]
    root = _head("2.0", about, guid=about.fingerprint, numberOfEventIndicators=len(indicators))
    can = {
        "modelIdentifier": about.identifier,
        "canNotUseMemoryManagementFunctions": True,
        "canGetAndSetFMUstate": True,
        "canSerializeFMUstate": True,
        "providesDirectionalDerivative": True,
    }
    steps = {"canHandleVariableCommunicationStepSize": True, "canInterpolateInputs": True}
    for kind, more in (("ModelExchange", {}), ("CoSimulation", steps)):
        element = ElementTree.SubElement(root, kind, _attributes(**can, **more))
        files = ElementTree.SubElement(element, "SourceFiles")
        for name in sources:
            ElementTree.SubElement(files, "File", name=name)
    _common(root, about, interface)
    # FMI 2.0 requires no variable for time, and some importers require a start value for it.
    hidden = {v.reference for v in indicators}
    shown = [v for v in interface.variables if v.reference not in hidden and v.causality != "independent"]
    place = {v.reference: i for i, v in enumerate(shown, 1)}
    by_name = {v.name: v for v in shown}
    variables = ElementTree.SubElement(root, "ModelVariables")
    for v in shown:
        scalar = ElementTree.SubElement(variables, "ScalarVariable", _attributes(**_attributes_of(v)))
        of = place[by_name[v.state].reference] if v.state else None
        real = {"unit": v.unit, "nominal": v.nominal, "derivative": of} if v.kind == "Real" else {}
        ElementTree.SubElement(scalar, v.kind, _attributes(**real, start=v.start))
    structure = ElementTree.SubElement(root, "ModelStructure")
    outputs = [v for v in shown if v.causality == "output"]
    derivatives = [v for v in shown if v.state]
    groups = (("Outputs", outputs), ("Derivatives", derivatives), ("InitialUnknowns", _initial(shown)))
    for group, members in groups:
        if members:
            parent = ElementTree.SubElement(structure, group)
            for v in members:
                knowns = interface.depends_on(v, parameters=group == "InitialUnknowns")
                ElementTree.SubElement(
                    parent, "Unknown", index=str(place[v.reference]), dependencies=_list(place[r] for r in knowns)
                )
    return root


def _fmi3(about: About, interface: Interface) -> ElementTree.Element:
    root = _head("3.0", about, instantiationToken=about.fingerprint)
    can = {
        "modelIdentifier": about.identifier,
        "canGetAndSetFMUState": True,
        "canSerializeFMUState": True,
        "providesDirectionalDerivatives": True,
    }
    # A carriage continues from the last accepted step.
    accepted = {"needsCompletedIntegratorStep": True} if interface.equations.corridor else {}
    ElementTree.SubElement(root, "ModelExchange", _attributes(**can, **accepted))
    own = {
        "canHandleVariableCommunicationStepSize": True,
        "providesIntermediateUpdate": True,
        "hasEventMode": True,
    }
    ElementTree.SubElement(root, "CoSimulation", _attributes(**can, **own))
    _common(root, about, interface)
    by_name = {v.name: v for v in interface.variables}
    variables = ElementTree.SubElement(root, "ModelVariables")
    for v in interface.variables:
        real = {"unit": v.unit, "nominal": v.nominal} if v.kind == "Real" else {}
        of = by_name[v.state].reference if v.state else None
        within = True if v.kind == "Real" and v.causality == "input" and v.variability == "continuous" else None
        ElementTree.SubElement(
            variables,
            _TYPES[v.kind],
            _attributes(**_attributes_of(v), **real, start=v.start, derivative=of, intermediateUpdate=within),
        )
    structure = ElementTree.SubElement(root, "ModelStructure")
    groups = (
        ("Output", [v for v in interface.variables if v.causality == "output"]),
        ("ContinuousStateDerivative", [v for v in interface.variables if v.state]),
        ("InitialUnknown", _initial(interface.variables)),
        ("EventIndicator", [v for v in interface.variables if v.name.startswith("event_indicator[")]),
    )
    for name, members in groups:
        for v in members:
            knowns = interface.depends_on(v, parameters=name == "InitialUnknown")
            ElementTree.SubElement(structure, name, valueReference=str(v.reference), dependencies=_list(knowns))
    return root


def _attributes_of(v: FmuVariable) -> dict[str, object]:
    """Attributes of a variable in both versions."""
    return {
        "name": v.name,
        "valueReference": v.reference,
        "description": v.description,
        "causality": v.causality,
        "variability": v.variability,
        "initial": v.initial,
    }


def _initial(variables: Iterable[FmuVariable]) -> list[FmuVariable]:
    """Variables calculated at initialisation: outputs and derivatives."""
    return [v for v in variables if v.initial == "calculated" and (v.causality == "output" or v.state)]


def _list(numbers: Iterable[int]) -> str:
    return " ".join(str(n) for n in sorted(numbers))
