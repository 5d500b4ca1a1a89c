"""A CasADi function of scalars as plain C: one vector in, one vector out, no memory of its own."""

from __future__ import annotations

from collections import Counter
from hashlib import sha256

import casadi as ca

from ropeway.systems.native.function_steps import CHOICE, function_steps

_UNARY = {
    ca.OP_ASSIGN: "{0}",
    ca.OP_NEG: "-{0}",
    ca.OP_SQ: "{0} * {0}",
    ca.OP_TWICE: "2.0 * {0}",
    ca.OP_INV: "1.0 / {0}",
    ca.OP_NOT: "!{0}",
    ca.OP_SIGN: "({0} > 0.0) - ({0} < 0.0)",
    **{
        op: f"{name}({{0}})"
        for op, name in (
            (ca.OP_EXP, "exp"),
            (ca.OP_LOG, "log"),
            (ca.OP_SQRT, "sqrt"),
            (ca.OP_SIN, "sin"),
            (ca.OP_COS, "cos"),
            (ca.OP_TAN, "tan"),
            (ca.OP_ASIN, "asin"),
            (ca.OP_ACOS, "acos"),
            (ca.OP_ATAN, "atan"),
            (ca.OP_SINH, "sinh"),
            (ca.OP_COSH, "cosh"),
            (ca.OP_TANH, "tanh"),
            (ca.OP_ASINH, "asinh"),
            (ca.OP_ACOSH, "acosh"),
            (ca.OP_ATANH, "atanh"),
            (ca.OP_LOG1P, "log1p"),
            (ca.OP_EXPM1, "expm1"),
            (ca.OP_FLOOR, "floor"),
            (ca.OP_CEIL, "ceil"),
            (ca.OP_FABS, "fabs"),
            (ca.OP_ERF, "erf"),
        )
    },
}
_OTHERS = {
    ca.OP_ADD: "{0} + {1}",
    ca.OP_SUB: "{0} - {1}",
    ca.OP_MUL: "{0} * {1}",
    ca.OP_DIV: "{0} / {1}",
    ca.OP_POW: "pow({0}, {1})",
    ca.OP_CONSTPOW: "pow({0}, {1})",
    ca.OP_FMIN: "fmin({0}, {1})",
    ca.OP_FMAX: "fmax({0}, {1})",
    ca.OP_ATAN2: "atan2({0}, {1})",
    ca.OP_HYPOT: "hypot({0}, {1})",
    ca.OP_FMOD: "fmod({0}, {1})",
    ca.OP_REMAINDER: "remainder({0}, {1})",
    ca.OP_COPYSIGN: "copysign({0}, {1})",
    ca.OP_LT: "{0} < {1}",
    ca.OP_LE: "{0} <= {1}",
    ca.OP_EQ: "{0} == {1}",
    ca.OP_NE: "{0} != {1}",
    ca.OP_AND: "{0} && {1}",
    ca.OP_OR: "{0} || {1}",
    ca.OP_IF_ELSE_ZERO: "{0} ? {1} : 0.0",
    CHOICE: "{0} ? {1} : {2}",
}

_EXPORTED = """#ifdef _WIN32
__declspec(dllexport)
#else
__attribute__((visibility("default")))
#endif
"""
_LONG = ((40_000, "O0"), (10_000, "O1"))
"""Lines of a kernel above which GCC takes minutes, and what it compiles such a kernel with."""


def hidden_kernel(function: ca.Function) -> tuple[str, str]:
    """A kernel for a library that does not show it: a name that its content determines, and its file. Raises
    NotImplementedError."""
    text = kernel_source(function, "rw_kernel", exported=False)
    name = f"rw_kernel_{sha256(text.encode()).hexdigest()[:16]}"
    return name, text.replace("rw_kernel(", f"{name}(")


def kernel_source(function: ca.Function, name: str, *, exported: bool = True) -> str:
    """A file with one function of that name, `void name(const double *v, double *r)`, visible outside of its library
    if it is exported. Raises NotImplementedError for an operation that it has no form for."""
    steps = function_steps(function)
    divisors = Counter(step.read[1] for step in steps if step.op == ca.OP_DIV)
    lines = []
    for k, step in enumerate(steps):
        if step.op == ca.OP_OUTPUT:
            lines.append(f"    r[{step.place}] = a{step.read[0]};")
            continue
        if step.op == ca.OP_CONST:
            text = repr(float(step.value))
        elif step.op == ca.OP_INPUT:
            text = f"v[{step.place}]"
        elif step.op == ca.OP_DIV and divisors[step.read[1]] > 1:
            text = f"a{step.read[0]} * b{step.read[1]}"
        else:
            form = (_UNARY if len(step.read) == 1 else _OTHERS).get(step.op)
            if form is None:
                raise NotImplementedError(f"Operation {step.op} of {function.name()!r} has no form in C")
            text = form.format(*(f"a{i}" for i in step.read))
        lines.append(f"    const double a{k} = {text};")
        if divisors[k] > 1:  # one division is as long as five products
            lines.append(f"    const double b{k} = 1.0 / a{k};")
    body = "\n".join(lines)
    level = next((level for most, level in _LONG if len(lines) > most), None)
    pragma = f'#if defined(__GNUC__) && !defined(__clang__)\n#pragma GCC optimize ("{level}")\n#endif\n'
    head = f"{pragma if level else ''}#include <math.h>\n{_EXPORTED if exported else ''}"
    return f"{head}void {name}(const double *v, double *r)\n{{\n{body}\n}}\n"
