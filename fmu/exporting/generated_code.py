"""C of the functions of a system: a file for each, and one for each function of a component that they call.

Functions of components are the same in all systems that have such components: they are compiled once. What is left of
the others calls them, and is compiled without optimisation, which would take most of the time and hardly help.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from hashlib import sha256

import casadi as ca

from ropeway.systems.interrupts import stop_if_interrupted

_FUNCTION = re.compile(r"^(?:/\* (\S+):.*\n)?static int (casadi_f\d+)\((.*)\) ?\{\n", re.MULTILINE)
_HELPER = re.compile(r"^\w+ casadi_(\w+)\(.*\) \{(?:.*\}|\n(?:.*\n)*?\})\n", re.MULTILINE)
_HEAD = """#include <math.h>
#define casadi_real double
#define casadi_int int
"""
_NOT_OPTIMISED = """#if defined(__clang__)
#pragma clang optimize off
#elif defined(__GNUC__)
#pragma GCC optimize("O0")
#endif
"""


def c_files(functions: Iterable[ca.Function]) -> dict[str, str]:
    """The files, by name. Raises Interrupted."""
    files: dict[str, str] = {}
    for function in functions:
        stop_if_interrupted()
        name = function.name()
        generator = ca.CodeGenerator(f"{name}.c", {"casadi_int": "int", "with_export": False})
        generator.add(function)
        text, parts = _parted(generator.dump(), name)
        files |= {f"{name}.c": text, **parts}
    return files


def _parted(text: str, own: str) -> tuple[str, dict[str, str]]:
    """A file without the functions of components, and files of these."""
    helpers = {found[1]: found[0] for found in _HELPER.finditer(text)}
    parts: dict[str, str] = {}
    for found in reversed(list(_FUNCTION.finditer(text))):
        kind, name, arguments = found.groups()
        end = text.index("\n}\n", found.end()) + len("\n}\n")
        body = text[found.end() : end]
        reads = set(re.findall(r"\bcasadi_(\w+)", body)) - {"real", "int"}
        if kind in (None, own) or not reads <= helpers.keys():  # it calls others, or has tables
            continue
        part, content = _part(f"({arguments}) {{\n{body}", helpers)
        parts[f"{part}.c"] = content
        declared = f"int {part}({arguments});\n"
        text = re.sub(rf"\b{name}\b(?=\()", part, text[: found.start()] + declared + text[end:])
    return (_NOT_OPTIMISED + text if parts else text), parts


def _part(function: str, helpers: dict[str, str]) -> tuple[str, str]:
    """Name and file of a function, with what it calls."""
    used, waiting = dict[str, str](), [function]
    while waiting:
        for name in re.findall(r"\bcasadi_(\w+)\(", waiting.pop()):
            if name in helpers and name not in used:
                used[name] = helpers[name]
                waiting.append(helpers[name])
    shared = "".join(f"static {used[name]}" for name in sorted(used, reverse=True))
    name = f"rw_part_{sha256((shared + function).encode()).hexdigest()[:16]}"
    return name, f"{_HEAD}{shared}\nint {name}{function}"
