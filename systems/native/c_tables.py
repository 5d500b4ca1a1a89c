"""Tables in C: sizes, numbers, texts and kernels, as a source file (see model_data.h)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np


class Tables:
    """Definitions of the tables."""

    def __init__(self) -> None:
        self._sizes: dict[str, str] = {}
        self._functions: dict[str, str] = {}
        self._body: list[str] = []

    def size(self, name: str, value: float) -> None:
        """A number among the sizes."""
        self._sizes[name] = _double(value) if isinstance(value, float) else str(int(value))

    def numbers(self, name: str, values: Iterable[float]) -> None:
        """Doubles."""
        self._array("double", name, [_double(v) for v in values])

    def integers(self, name: str, values: Iterable[int], *, shown: bool = True) -> None:
        """Integers; only this file has them where they are not shown."""
        self._array("int", name, [str(int(v)) for v in values], shown=shown)

    def texts(self, name: str, values: Iterable[str]) -> None:
        """Strings."""
        self._array("char *const", name, [f'"{v}"' for v in values])

    def _array(self, kind: str, name: str, values: Sequence[str], *, shown: bool = True) -> None:
        cells = list(values) or ["0"]  # C does not allow empty arrays
        lines = [", ".join(cells[i : i + 12]) for i in range(0, len(cells), 12)]
        head = "const" if shown else "static const"
        self._body.append(f"{head} {kind} rw_{name}[{len(cells)}] = {{\n    " + ",\n    ".join(lines) + "};")

    def kernels(self, name: str, values: Sequence[str]) -> None:
        """Kernels of components."""
        for kernel in values:
            self._functions[kernel] = f"void {kernel}(const double *v, double *r);"
        self._body.append(f"static const rs_kernel rw_{name}[] = {{{', '.join(values) or '0'}}};")

    def pattern(
        self, name: str, colind: Iterable[int], row: Iterable[int], order: Sequence[int], diagonal: Sequence[int]
    ) -> None:
        """A square sparse matrix, the order in which its columns are eliminated, and the rows that they should take."""
        for part, values in (("colind", colind), ("row", row), ("order", order), ("diagonal", diagonal)):
            self.integers(f"{name}_{part}", values, shown=part == "colind")
        count, ends = str(len(order)), f"rw_{name}_colind + 1"
        parts = {"n": count, "inner": count, "column_end": ends}
        parts |= {part: f"rw_{name}_{part}" for part in ("row", "order", "diagonal")}
        self.structure("rn_pattern", name, parts)

    def structure(self, kind: str, name: str, fields: Mapping[str, str]) -> None:
        """A structure with some fields; the others are 0."""
        cells = ", ".join(f".{field} = {value}" for field, value in fields.items())
        self._body.append(f"const {kind} rw_{name} = {{{cells}}};")

    def structures(self, kind: str, name: str, values: Sequence[str]) -> None:
        """An array of structures, each by its initialiser; without one it is a structure of zeros."""
        self._body.append(
            f"const {kind} rw_{name}[{max(1, len(values))}]" + (f" = {{{', '.join(values)}}};" if values else ";")
        )

    def source(self, fingerprint: str) -> str:
        """model_data.c, with what identifies the content of its FMU."""
        sizes = ", ".join(f".{name} = {value}" for name, value in self._sizes.items())
        head = ['/* Generated. */\n#include "model_data.h"\n', *self._functions.values()]
        known = [
            f"const rw_sizes rw_size = {{{sizes}}};",
            f'const char rw_fingerprint[RW_FINGERPRINT] = "{fingerprint}";',
        ]
        return "\n".join([*head, *known, *self._body]) + "\n"


def _double(value: float) -> str:
    """A number in C; infinity as 1e300."""
    if np.isinf(value):
        return "1e300" if value > 0.0 else "-1e300"
    return repr(float(value))
