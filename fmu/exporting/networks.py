"""Equations of an FMU as networks of kernels: kinds of components are compiled, how they are joined is in tables."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from ropeway.systems.native.c_library import CALL_INTEGERS
from ropeway.systems.native.c_tables import Tables
from ropeway.systems.solvers.kernels.call_graph import CallGraph, graph_of
from ropeway.systems.solvers.kernels.kernel_network import Network, swept_network

if TYPE_CHECKING:
    from ropeway.fmu.exporting.carriage_corridor import Corridor
    from ropeway.systems.modelling.dae_model import Model

_X, _Z = 1, 2
"""Of the vectors t, x, z, u, p, d."""


class Networks:
    """The networks of a system by their names in model_data.h, a list for each: of the places of a carriage, of the
    clocks, or one. What the compiled core has itself is left out: of a line `by_sections` its equations, of it and of
    others `by_pieces` the derivatives. Raises CompiledError, Interrupted."""

    def __init__(self, model: Model, corridor: Corridor | None, *, by_sections: bool, by_pieces: bool) -> None:
        graphs = [_graph_of_model(model)] if corridor is None else _graphs_of_places(corridor)
        first, clocks = graphs[0], graphs[0].results[3:]
        limits = [first.y[int(i)] for i in model.limits.output] if corridor is None else []
        self.lists: dict[str, list[Network]] = {
            "equations": [] if by_sections else [swept_network(g, [*g.ode, *g.alg]) for g in graphs],
            "all": [swept_network(g, [*g.ode, *g.alg, *g.y], tangents=True) for g in graphs],
            "matrix": [] if by_pieces else [swept_network(g, [*g.ode, *g.alg], (_X, _Z)) for g in graphs],
            "rates": [swept_network(first, first.ode)],
            "coupling": [swept_network(first, first.ode, (_X, _Z))],
            "limits": [swept_network(first, limits)],
            "margins": [] if corridor is None else [swept_network(g, g.results[3]) for g in graphs],
            "clock": [] if corridor is not None else [swept_network(first, rows) for rows in clocks],
        }

    @property
    def sources(self) -> dict[str, str]:
        """A file in C for each kernel."""
        every = [kernel for own in self.lists.values() for net in own for kernel in (*net.kernels, *net.tangents)]
        return {f"{name}.c": text for name, text in (kernel.hidden for kernel in dict.fromkeys(every))}

    def fill(self, tables: Tables) -> None:
        """Writes the tables of all networks, and the room that they need."""
        every = [net for own in self.lists.values() for net in own]
        most = max((len(read) for net in every for read in net.inputs), default=0)
        tables.size("values", max(net.size for net in every) + 2 * most)
        for name, own in self.lists.items():
            tables.structures("rw_network", f"net_{name}", [self._written(tables, name, i) for i in range(len(own))])

    def _written(self, tables: Tables, name: str, number: int) -> str:
        """One network as the initialiser of an rw_network; its arrays are written."""
        net, label = self.lists[name][number], f"net_{name}_{number}"
        entries = [entry for own in net.entries for entry in own]
        arrays: dict[str, Iterable[int]] = {
            "result": net.results,
            "inputs_end": _ends(net.inputs),
            "input": [place for read in net.inputs for place in read],
            "end": _ends(net.entries),
            "first": [result + own.results for result, own in zip(net.results, net.kernels, strict=True)],
            "entry": [row for row, _ in entries],
            "by": [by for _, by in entries],
            "row": net.rows,
        }
        for part, values in arrays.items():
            tables.integers(f"{label}_{part}", values, shown=False)
        for part, kernels in (("kernels", net.kernels), ("tangents", net.tangents)):
            tables.kernels(f"{label}_{part}", [kernel.hidden[0] for kernel in kernels])
        calls = ", ".join(f"rw_{label}_{part}" for part in (*CALL_INTEGERS, "kernels"))
        derivatives = ", ".join(f"rw_{label}_{part}" for part in ("end", "first", "entry", "by"))
        own = f"{{{len(net.kernels)}, {net.size}, {calls}}}, {{{derivatives}}}, rw_{label}_tangents"
        return f"{{{own}, {len(net.rows)}, rw_{label}_row}}"


def _ends(lists: Sequence[Sequence[object]]) -> list[int]:
    """Where each of some lists ends, one after the other."""
    found, end = list[int](), 0
    for own in lists:
        end += len(own)
        found.append(end)
    return found


def _graph_of_model(model: Model) -> CallGraph:
    """Rates, residuals, outputs, then the new values of each clock."""
    arguments = model.dae.mx_in()
    results = [*model.dae.call(arguments, True, False), *model.outputs.call(arguments, True, False)]
    results += [clock.update.call(arguments, True, False)[0] for clock in model.clocks]
    return graph_of(arguments, results, (model.outputs,))


def _graphs_of_places(corridor: Corridor) -> list[CallGraph]:
    """Rates, residuals, outputs and margins of each place."""
    united, symbols = corridor.united, corridor.united.symbols
    return [
        graph_of(symbols, [united.rates, *(own(*symbols) for own in cases)], (united.parts[0].model.dae,))
        for cases in zip(united.residuals, united.views, corridor.margin_functions, strict=True)
    ]
