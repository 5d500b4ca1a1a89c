"""Texts of system structures (SSP) as other tools write them: by the rules of the standard, on the FMU of a mass."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd

from support.masses import pair

NAMES = (
    'xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription" '
    'xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon" '
    'xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues" '
    'xmlns:ssm="http://ssp-standard.org/SSP1/SystemStructureParameterMapping" '
    'xmlns:ssb="http://ssp-standard.org/SSP1/SystemStructureSignalDictionary"'
)
ONE = {"mass": 1.0, "spring": 1.0, "damper": 0.1, "stiffness": 20.0, "damping": 5.0, "x": 1.0}
TWO = {"mass": 2.0, "spring": 2.0, "damper": 0.5}


def description(system: str, more: str = "", version: str = "1.0") -> str:
    return (
        f'<?xml version="1.0" encoding="UTF-8"?>\n<ssd:SystemStructureDescription {NAMES} version="{version}" '
        f'name="yard"><ssd:System name="yard">{system}</ssd:System>{more}</ssd:SystemStructureDescription>'
    )


def connectors(unit: str = "", **kinds: str) -> str:
    real = f'<ssc:Real unit="{unit}"/>' if unit else "<ssc:Real/>"
    each = (f'<ssd:Connector name="{n}" kind="{kind}">{real}</ssd:Connector>' for n, kind in kinds.items())
    return f"<ssd:Connectors>{''.join(each)}</ssd:Connectors>"


def values(given: dict[str, float], unit: str = "") -> str:
    how = f' unit="{unit}"' if unit else ""
    rows = (f'<ssv:Parameter name="{n}"><ssv:Real value="{v}"{how}/></ssv:Parameter>' for n, v in given.items())
    inside = f"<ssv:Parameters>{''.join(rows)}</ssv:Parameters>"
    return f'<ssv:ParameterSet {NAMES} version="1.0" name="set">{inside}</ssv:ParameterSet>'


def bound(inside: str, prefix: str = "", mapping: str = "") -> str:
    return (
        f'<ssd:ParameterBindings><ssd:ParameterBinding prefix="{prefix}"><ssd:ParameterValues>{inside}'
        f"</ssd:ParameterValues>{mapping}</ssd:ParameterBinding></ssd:ParameterBindings>"
    )


def component(name: str, inside: str, source: str = "resources/mass.fmu") -> str:
    kind = "application/x-fmu-sharedlibrary"
    return f'<ssd:Component name="{name}" type="{kind}" source="{source}">{inside}</ssd:Component>'


def connections(*ends: str) -> str:
    """Each "element.connector element.connector", an element of the system itself without a name; then what follows."""
    found = []
    for text in ends:
        one, other, *inside = text.split(" ", 2)
        shown = []
        for side, end in (("start", one), ("end", other)):
            element, _, connector = end.partition(".") if "." in end else ("", "", end)
            shown.append((f'{side}Element="{element}" ' if element else "") + f'{side}Connector="{connector}"')
        found.append(f"<ssd:Connection {' '.join(shown)} {''.join(inside) or '/>'}")
    return f"<ssd:Connections>{''.join(found)}</ssd:Connections>"


MASS_ENDS = {"x": "output", "v": "output", "f": "output", "x_in": "input", "v_in": "input", "force": "input"}
PAIR = connections("two.x one.x_in", "one.v_in two.v", "one.f two.force")
"""The second is from the input to the output: the kinds of connectors give the direction."""


Pack = Callable[..., Path]
"""Writes a package with a description, the FMU and more files."""


def two_masses(version: str = "1.0") -> str:
    parts = (component(n, connectors(**MASS_ENDS) + bound(values(v))) for n, v in (("one", ONE), ("two", TWO)))
    experiment = '<ssd:DefaultExperiment startTime="0" stopTime="3.0"/>'
    return description(f"<ssd:Elements>{''.join(parts)}</ssd:Elements>{PAIR}", experiment, version)


def as_coupled_here(frame: pd.DataFrame, mass: Path) -> bool:
    """Whether the values of two slaves are exactly those of the pair that is coupled call by call."""
    return np.array_equal(frame.to_numpy(), pair(mass, 0.05).run(frame.index[-1]).to_numpy())
