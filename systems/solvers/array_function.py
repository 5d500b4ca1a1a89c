"""A CasADi function on NumPy arrays: one pass of its scalar graph evaluates it for all components and cases at once.

Every operation acts on each entry by itself, so that a result does not depend on how many others are in the array.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import casadi as ca
import numpy as np

from ropeway.systems.native.function_steps import CHOICE, Step, function_steps

Array = np.ndarray


def _kept_where(condition: Array, value: Array) -> Array:
    return np.where(condition, value, 0.0)


def _inverse(value: Array) -> Array:
    return 1.0 / value


def _twice(value: Array) -> Array:
    return value + value


_UNARY: dict[int, Callable[..., Any]] = {
    ca.OP_ASSIGN: np.positive,
    ca.OP_NEG: np.negative,
    ca.OP_EXP: np.exp,
    ca.OP_LOG: np.log,
    ca.OP_SQRT: np.sqrt,
    ca.OP_SQ: np.square,
    ca.OP_TWICE: _twice,
    ca.OP_SIN: np.sin,
    ca.OP_COS: np.cos,
    ca.OP_TAN: np.tan,
    ca.OP_ASIN: np.arcsin,
    ca.OP_ACOS: np.arccos,
    ca.OP_ATAN: np.arctan,
    ca.OP_SINH: np.sinh,
    ca.OP_COSH: np.cosh,
    ca.OP_TANH: np.tanh,
    ca.OP_ASINH: np.arcsinh,
    ca.OP_ACOSH: np.arccosh,
    ca.OP_ATANH: np.arctanh,
    ca.OP_LOG1P: np.log1p,
    ca.OP_EXPM1: np.expm1,
    ca.OP_FLOOR: np.floor,
    ca.OP_CEIL: np.ceil,
    ca.OP_FABS: np.abs,
    ca.OP_SIGN: np.sign,
    ca.OP_INV: _inverse,
    ca.OP_NOT: np.logical_not,
}
_OTHERS: dict[int, Callable[..., Any]] = {
    ca.OP_ADD: np.add,
    ca.OP_SUB: np.subtract,
    ca.OP_MUL: np.multiply,
    ca.OP_DIV: np.divide,
    ca.OP_POW: np.power,
    ca.OP_CONSTPOW: np.power,
    ca.OP_FMIN: np.fmin,
    ca.OP_FMAX: np.fmax,
    ca.OP_ATAN2: np.arctan2,
    ca.OP_HYPOT: np.hypot,
    ca.OP_COPYSIGN: np.copysign,
    ca.OP_LT: np.less,
    ca.OP_LE: np.less_equal,
    ca.OP_EQ: np.equal,
    ca.OP_NE: np.not_equal,
    ca.OP_AND: np.logical_and,
    ca.OP_OR: np.logical_or,
    ca.OP_IF_ELSE_ZERO: _kept_where,
    CHOICE: np.where,
}
_TRUTHS = {ca.OP_LT, ca.OP_LE, ca.OP_EQ, ca.OP_NE, ca.OP_NOT, ca.OP_AND, ca.OP_OR}
"""Operations whose results are truth values."""
_TAKE_TRUTHS = {ca.OP_NOT: 1, ca.OP_AND: 2, ca.OP_OR: 2, ca.OP_IF_ELSE_ZERO: 1, CHOICE: 1}
"""How many of what an operation reads are truth values, the first ones."""


class ArrayFunction:
    """The first result of a function of dense vectors.

    Called with one sequence of arrays for each argument, an array for each of its entries, all of shapes that broadcast
    together; returns one array for each entry of the result.
    """

    def __init__(self, function: ca.Function) -> None:
        found = function_steps(function)
        self._inputs = [(k, step.argument, step.place) for k, step in enumerate(found) if step.op == ca.OP_INPUT]
        self._constants = [(k, np.array(step.value)) for k, step in enumerate(found) if step.op == ca.OP_CONST]
        self._steps: list[tuple[Callable[..., Any], int, tuple[int, ...]]] = []
        self._results = [-1] * function.nnz_out(0)
        # Each result has a place of its own, so that none is overwritten.
        self._size = len(found)
        truth = {k for k, step in enumerate(found) if step.op in _TRUTHS}
        for k, step in enumerate(found):
            if step.op == ca.OP_OUTPUT:
                self._results[step.place] = step.read[0]
            elif step.op not in (ca.OP_INPUT, ca.OP_CONST):
                form = (_UNARY if len(step.read) == 1 else _OTHERS).get(step.op)
                if form is None:
                    raise NotImplementedError(f"Operation {step.op} of {function.name()!r} has no form on arrays")
                self._steps.append((form, k, tuple(self._read(step, i, truth) for i in range(len(step.read)))))
        self._drop = self._last_reads()

    def _read(self, step: Step, i: int, truth: set[int]) -> int:
        """Where a step finds what it reads as number i: a truth value as a number, unless it takes truth values."""
        place = step.read[i]
        if place not in truth or i < _TAKE_TRUTHS.get(step.op, 0):
            return place
        self._steps.append((_as_number, self._size, (place,)))
        self._size += 1
        return self._size - 1

    def _last_reads(self) -> list[tuple[int, ...]]:
        """For each step the places that nothing reads after it."""
        seen, drops = set(self._results), list[tuple[int, ...]]()
        for _, written, read in reversed(self._steps):
            seen.add(written)
            last = tuple(i for i in dict.fromkeys(read) if i not in seen)
            seen.update(last)
            drops.append(last)
        return drops[::-1]

    def __call__(self, *arguments: Sequence[Array]) -> list[Array]:
        """Results, one array for each entry."""
        work: list[Any] = [None] * self._size
        for place, argument, i in self._inputs:
            work[place] = arguments[argument][i]
        for place, value in self._constants:
            work[place] = value
        for (step, written, read), drop in zip(self._steps, self._drop, strict=True):
            work[written] = step(*[work[i] for i in read])
            for i in drop:
                work[i] = None
        return [work[i] for i in self._results]


def _as_number(truth: Array) -> Array:
    return np.asarray(truth, dtype=float)
