"""The operations of a CasADi function of scalars one after the other, from which C code and code on arrays are made."""

from __future__ import annotations

from typing import NamedTuple

import casadi as ca

CHOICE = -1
"""An operation that CasADi does not have: the second of what it reads where the first is true, else the third."""


class Step(NamedTuple):
    """An operation `op` of CasADi, or `CHOICE`, on the results of the steps `read`. A constant has a `value`; an input
    is the entry `place` of `argument`, an output that of the result."""

    op: int
    read: tuple[int, ...] = ()
    value: float = 0.0
    argument: int = 0
    place: int = 0


def function_steps(function: ca.Function) -> list[Step]:
    """The steps of a function, those that nothing reads left out. CasADi writes a choice as the sum of what holds where
    a condition is true and of what holds where it is false."""
    steps, number = list[Step](), dict[int, int]()
    for k in range(function.n_instructions()):
        op = function.instruction_id(k)
        read, written = function.instruction_input(k), function.instruction_output(k)
        if op == ca.OP_CONST:
            step = Step(op, value=function.instruction_constant(k))
        elif op == ca.OP_INPUT:
            step = Step(op, argument=read[0], place=read[1])
        elif op == ca.OP_OUTPUT:
            step = Step(op, (number[read[0]],), place=written[1])
        else:
            step = _chosen(steps, Step(op, tuple(number[i] for i in read)))
        if op != ca.OP_OUTPUT:
            number[written[0]] = len(steps)
        steps.append(step)
    return _needed(steps)


def _chosen(steps: list[Step], step: Step) -> Step:
    """A sum as the choice that it stands for; any other step as it is."""
    if step.op != ca.OP_ADD:
        return step
    one, other = (steps[i] for i in step.read)
    if one.op != ca.OP_IF_ELSE_ZERO or other.op != ca.OP_IF_ELSE_ZERO:
        return step
    for this, that in ((one, other), (other, one)):
        no = steps[that.read[0]]
        if no.op == ca.OP_NOT and no.read[0] == this.read[0]:
            return Step(CHOICE, (this.read[0], this.read[1], that.read[1]))
    return step


def _needed(steps: list[Step]) -> list[Step]:
    """The steps that lead to an output, numbered anew."""
    used = [step.op == ca.OP_OUTPUT for step in steps]
    for k in range(len(steps) - 1, -1, -1):
        if used[k]:
            for i in steps[k].read:
                used[i] = True
    number, found = list[int](), list[Step]()
    for step, needed in zip(steps, used, strict=True):
        number.append(len(found))
        if needed:
            found.append(step._replace(read=tuple(number[i] for i in step.read)))
    return found
