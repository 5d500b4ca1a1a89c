"""Kernels of kinds of components: a component's function of the entries that it reads, with derivatives, as C.

A kernel depends on the function and on what its inputs are: which are constants, the same entry, or an expression of
entries. Components of one kind that are joined alike share it; how many they are and what they read is in tables.
"""

from __future__ import annotations

import threading
from collections.abc import Hashable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import casadi as ca

from ropeway.components.errors import CompiledError
from ropeway.systems.interrupts import stop_if_interrupted
from ropeway.systems.native.binary_cache import libraries
from ropeway.systems.native.c_library import address
from ropeway.systems.native.kernel_source import hidden_kernel, kernel_source

MOST = 2_000
"""Parts that a thread keeps."""


@dataclass(eq=False)
class Kernel:
    """A kernel, with its text in C; `entries`: result and input of each derivative that follows the `results`.
    `address`: where it is once it is compiled."""

    function: ca.Function
    source: str
    results: int
    entries: tuple[tuple[int, int], ...] = ()
    address: int = 0

    @cached_property
    def hidden(self) -> tuple[str, str]:
        """Its name and its file for a library that does not show it."""
        return hidden_kernel(self.function)


def compile_all(kernels: Iterable[Kernel]) -> None:
    """Compiles the kernels that are not compiled yet. Raises CompilerError, WriteError, Interrupted."""
    missing = list(dict.fromkeys(kernel for kernel in kernels if not kernel.address))
    for kernel, found in zip(missing, libraries([{"kernel.c": one.source} for one in missing]), strict=True):
        kernel.address = address(found, "kernel")


@dataclass(eq=False)
class Part:
    """Some results of a component's function in terms of its inputs `read`, symbols; `used`: those that they depend
    on. `kept`: the function, whose identity counts."""

    read: tuple[Any, ...]
    results: Any
    used: tuple[int, ...]
    kept: ca.Function | None = None
    _kernels: dict[tuple[int, ...], Kernel] = field(default_factory=dict)

    def kernel(self, active: tuple[int, ...]) -> Kernel:
        """The kernel with derivatives by the inputs `active`, a part of `used`. It reads the inputs `used`. Raises
        CompiledError for an operation that has no form in C, Interrupted."""
        if active not in self._kernels:
            self._kernels[active] = self._made(active)
        return self._kernels[active]

    @cached_property
    def tangent(self) -> Kernel:
        """The kernel of the changes of the results. It reads the inputs `used`, then a change of each. Raises
        CompiledError, Interrupted."""
        stop_if_interrupted()
        given = self._given
        seeds = ca.SX.sym("s", given.numel())
        changes = ca.jtimes(self.results, given, seeds) if given.numel() else ca.SX(self.results.numel(), 1)
        return self._kernel(ca.vertcat(given, seeds), ca.cse(changes), ())

    @property
    def _given(self) -> Any:
        return ca.vertcat(ca.SX(0, 1), *(self.read[i] for i in self.used))

    def _made(self, active: tuple[int, ...]) -> Kernel:
        stop_if_interrupted()
        matrix = ca.jacobian(self.results, ca.vertcat(ca.SX(0, 1), *(self.read[i] for i in active)))
        pattern = matrix.sparsity()
        entries = tuple((row, active[column]) for row, column in zip(pattern.row(), pattern.get_col(), strict=True))
        result = ca.vertcat(*ca.cse([self.results, ca.vertcat(ca.SX(0, 1), *matrix.nonzeros())]))
        return self._kernel(self._given, result, entries)

    def _kernel(self, given: Any, result: Any, entries: tuple[tuple[int, int], ...]) -> Kernel:
        function = ca.Function("kernel", [given], [ca.densify(result)])
        try:
            return Kernel(function, kernel_source(function, "kernel"), self.results.numel(), entries)
        except NotImplementedError as error:
            what = "An equation" if self.kept is None else f"An equation of {self.kept.name()!r}"
            raise CompiledError(f"{what} has no form in C: {error}", "Leave out compiled=True") from error


class KnownParts(threading.local):
    """The parts that a thread has met. CasADi counts references without a lock: each thread has its own."""

    def __init__(self) -> None:
        self._known: dict[Hashable, Part] = {}
        self._expressions: dict[int, tuple[str, tuple[Any, ...], Any]] = {}

    def find(
        self, function: ca.Function | None, inputs: Sequence[Sequence[Any]], wanted: Sequence[tuple[int, int]]
    ) -> tuple[Part, list[Any]]:
        """The part with the entries `wanted` of the results of a function, by result and entry; without a function,
        of the inputs themselves. With it the entries of vectors or earlier calls that it reads, in order."""
        read, forms, of = list[Any](), list[Hashable](), dict[int, int]()
        for vector in inputs:
            for entry in vector:
                if entry.is_constant():
                    forms.append(float(entry))
                    continue
                text, leaves, _ = self._expression(entry)
                for leaf in leaves:
                    if leaf.element_hash() not in of:
                        of[leaf.element_hash()] = len(read)
                        read.append(leaf)
                forms.append((text, *(of[leaf.element_hash()] for leaf in leaves)))
        name = None if function is None else function.__hash__()
        key = (name, tuple(forms), tuple(wanted))
        if key not in self._known:
            if len(self._known) > MOST:
                self._known.clear()
                self._expressions.clear()
            self._known[key] = self._made(function, inputs, wanted, read)
        return self._known[key], read

    def _expression(self, entry: Any) -> tuple[str, tuple[Any, ...], Any]:
        """An expression as a text that does not name what it reads, and what it reads."""
        if entry.is_symbolic():
            return "", (entry,), entry
        known = entry.element_hash()
        if known not in self._expressions:
            leaves = ca.symvar(entry)
            named = [ca.SX.sym(f"a{i}") for i in range(len(leaves))]
            text = str(ca.substitute(entry, ca.vertcat(*leaves), ca.vertcat(*named)))
            self._expressions[known] = (text, tuple(leaves), entry)
        return self._expressions[known]

    def _made(
        self,
        function: ca.Function | None,
        inputs: Sequence[Sequence[Any]],
        wanted: Sequence[tuple[int, int]],
        read: list[Any],
    ) -> Part:
        vectors = [ca.vertcat(ca.SX(0, 1), *vector) for vector in inputs]
        found = vectors if function is None else function.call(vectors)
        results = ca.vertcat(*(found[i][j] for i, j in wanted))
        reads = {symbol.element_hash() for symbol in ca.symvar(results)}
        used = tuple(i for i, leaf in enumerate(read) if leaf.element_hash() in reads)
        return Part(tuple(read), results, used, function)


PARTS = KnownParts()
