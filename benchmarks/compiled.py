"""The compiled core against the same work without it, in one run: simulation, equilibria, sweeps, an FMU, studies of
rigs, long lines, and the work of the spans in C written by hand, which is the limit.

    python benchmarks/compiled.py
    python benchmarks/compiled.py --spans 20 --until 600

Processor times of this process, the least of several tries. A simulation counts from the assembled model and its
equilibrium to the result's frame. The limit (`span_limit.c`) is the time of as many iterations of Newton's method as
the spans had in the run, two for each span at each record, with nothing between them.
"""

from __future__ import annotations

import ctypes
import tempfile
import time
import tracemalloc
from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import control
import lines
import numpy as np
import skylines
import typer

import ropeway as rw
from ropeway.systems.native.binary_cache import library
from ropeway.systems.solvers.line_sections import line_sections
from ropeway.systems.studies.skyline.station_solver import Stations

CASES = 10_000
EXAMPLE = Path(__file__).parents[1] / "examples" / "line.csv"


def least(run: Callable[[], object], tries: int = 3) -> float:
    """The least processor time of several tries [s]."""
    found = np.inf
    for _ in range(tries):
        before = time.process_time()
        run()
        found = min(found, time.process_time() - before)
    return found


def limit(kernels: int) -> float:
    """Time [s] of the work of so many spans with two loads in one iteration each, in C written by hand. Its results are
    those of the kernel of such spans."""
    line = lines.driven(5)
    sections = line_sections(rw.assemble(line))
    if isinstance(sections, str):
        raise TypeError(sections)
    rope, (kernel, form) = lines.ROPE, (sections.forms[0].kernel(2), sections.forms[0])
    gravity, force, length, at, masses = line.gravity, [4e4, 100.0, -800.0], 101.0, [30.0, 70.0], [300.0, 350.0]
    way = [99.0, 5.0, 3.0]
    own = [length, rope.mass_per_length, rope.strain.c1, rope.breaking_load][: form.parameters]
    v = np.array([gravity, *force, *own, *masses, *at, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, *way, 0.0])
    given = [*force, rope.mass_per_length * gravity, rope.strain.c1, length, *at, *(m * gravity for m in masses), *way]
    found = library({"limit.c": (Path(__file__).parent / "span_limit.c").read_text()})
    for call in (found.once, found.loop):
        call.argtypes, call.restype = (
            [ctypes.c_void_p, ctypes.c_void_p, *([ctypes.c_int] if call is found.loop else [])],
            None,
        )
    q, r = np.array(given), np.zeros(24)
    found.once(q.ctypes.data, r.ctypes.data)
    np.testing.assert_allclose(r, np.array(kernel(v)).ravel(), rtol=1e-9, atol=1e-9)
    return least(lambda: found.loop(q.ctypes.data, r.ctypes.data, kernels))


def fmu_time(line: rw.System, until: float) -> float:
    """Time [s] of an exported FMU's steps of a second."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "line.fmu"
        rw.fmu.export(line, path)
        with rw.fmu.Slave(rw.fmu.load(path)) as slave:
            slave.enter(0.0, {})
            slave.leave()
            before = time.process_time()
            for _ in range(int(until)):
                slave.step(1.0, {}, {})
            return time.process_time() - before


def measured(name: str, line: rw.System, until: float) -> tuple[rw.Result, float]:
    """One line in time, with its frame: prints the ratio; returns the compiled result and its time [s]."""
    model = rw.assemble(line)
    start = rw.equilibrium(model)
    before = time.perf_counter()
    rw.simulate(model, 1.0, start=start, compiled=True, progress=False)
    first = time.perf_counter() - before
    rw.simulate(model, 1.0, start=start, progress=False)
    run, whole = {True: np.inf, False: np.inf}, {True: np.inf, False: np.inf}
    for compiled in 3 * (False, *8 * (True,)):  # in turn, short runs more often: the machine may be busy
        begin = time.process_time()
        result = rw.simulate(model, until, start=start, compiled=compiled, progress=False)
        run[compiled] = min(run[compiled], time.process_time() - begin)
        _ = result.frame
        whole[compiled] = min(whole[compiled], time.process_time() - begin)
    print(
        f"{name}, {until:g} s: {whole[False] / whole[True]:.1f} times faster with the frame "
        f"({1e3 * whole[False]:.0f} and {1e3 * whole[True]:.0f} ms), {run[False] / run[True]:.1f} times without "
        f"({1e3 * run[False]:.0f} and {1e3 * run[True]:.0f} ms); first use {1e3 * first:.0f} ms"
    )
    return result, run[True]


def simulations(spans: int, until: float, fmu: bool) -> None:
    """The driven line in time, and with hydraulic drives and threshold responses."""
    line = lines.driven(spans)
    result, run = measured(f"driven({spans})", line, until)
    print(f"  the limit, a bare loop of as many spans: {1e3 * limit(2 * spans * len(result.records)):.1f} ms")
    if fmu:
        own = fmu_time(line, until)
        print(f"  the exported FMU: {1e3 * own:.0f} ms, {own / run:.1f} times the compiled run")
    hydraulic = lines.driven(spans, drive=control.DRIVE, response=control.RESPONSE)
    measured(f"  with hydraulic drives and responses, driven({spans})", hydraulic, until)


def one_hour(spans: int) -> None:
    """An hour of a line with hydraulic drives, compiled, with its frame."""
    model = rw.assemble(lines.driven(spans, drive=control.DRIVE))
    start = rw.equilibrium(model)
    rw.simulate(model, 1.0, start=start, compiled=True, progress=False)

    def hour() -> None:
        _ = rw.simulate(model, 3600.0, start=start, compiled=True, progress=False).frame

    spent = least(hour, 2)
    print(f"one hour of driven({spans}) with hydraulic drives: {spent:.2f} s, {3600.0 / spent:.0f} times real time")


def growth(sizes: tuple[int, ...], until: float) -> None:
    """Compiled runs of long lines: time and memory of the result for each span and simulated second."""
    for spans in sizes:
        model = rw.assemble(lines.driven(spans))
        start = rw.equilibrium(model, compiled=True)

        def run(model: rw.Model = model, start: rw.Equilibrium = start) -> rw.Result:
            return rw.simulate(model, until, start=start, compiled=True, progress=False)

        run()
        spent = least(run, 3)
        tracemalloc.start()
        kept = run()
        size, _ = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        print(
            f"driven({spans}), {until:g} s, {len(kept.records)} records: {spent:.3f} s, "
            f"{1e6 * spent / spans / until:.2f} us and {size / spans / until:.0f} bytes for each span and second"
        )


def equilibria(spans: int) -> None:
    """Warm equilibria, and a sweep."""
    model = rw.assemble(lines.driven(spans))
    rest = rw.equilibrium(model)
    heavier = {f"{load.load}.mass": 1.02 * load.mass for load in rest.loads.itertuples()}
    warm = {
        compiled: least(lambda c=compiled: rw.equilibrium(model, start=rest, parameters=heavier, compiled=c), 30)
        for compiled in (False, True)
    }
    ratio = warm[False] / warm[True]
    print(f"warm equilibrium of {spans} spans: {ratio:.2f} times faster ({1e3 * warm[True]:.2f} ms)")


def sweeps(cases: int) -> None:
    """A sweep of the line of 20 spans, all loads and heights varied, and some of its cases one by one."""
    line = lines.driven(20)
    model = rw.assemble(line)
    bounds = {f"{load}.mass": (100.0, 500.0) for load in rw.equilibrium(model).loads["load"]}
    bounds |= {n: (v - 1.0, v + 1.0) for n, v in zip(model.p.names, model.p.values, strict=True) if n.endswith(".z")}
    table = rw.latin_hypercube(bounds, cases)
    few = table.iloc[:200].to_dict("records")
    rest = rw.equilibrium(model)
    alone = least(lambda: [rw.equilibrium(model, start=rest, parameters=case).outputs for case in few], 1) / len(few)
    for compiled in (False, True):
        spent = least(lambda c=compiled: rw.sweep(line, table, workers=1, compiled=c, progress=False), 2)
        words = "compiled" if compiled else "without a compiler"
        print(f"sweep of {cases} cases, {words}: {spent:.2f} s, {alone * cases / spent:.1f} times one by one")


def rigs() -> None:
    """Studies of the corridor of the examples; each rig is new, and its kinds of parts have been met before."""
    stations = np.linspace(4.0, 476.0, 100)
    trees = [rw.Candidate(f"tree_{i}", 100.0 + 30.0 * i, (7.0, 10.0)) for i in range(10)]
    studies: dict[str, Callable[[bool], object]] = {
        "load path, 100 stations": lambda c: rw.load_path(skylines.corridor(), 1500.0, stations, compiled=c),
        "payload, 20 stations": lambda c: rw.payload(
            skylines.corridor(), clearance=1.0, stations=stations[::5], compiled=c
        ),
        "set-up": lambda c: rw.set_up(skylines.corridor(), station=150.0, payload=2000.0, tension=150e3, compiled=c),
        "supports, ten trees": lambda c: rw.optimise_supports(
            skylines.corridor(), trees, payload=1500.0, clearance=3.0, compiled=c
        ),
        "inhaul of 100 m": lambda c: rw.inhaul(skylines.corridor(), payload=1500.0, start=300.0, end=200.0, compiled=c),
    }
    for name, study in studies.items():
        spent = dict.fromkeys((False, True), np.inf)
        for _ in range(6):
            for compiled in spent:
                spent[compiled] = min(spent[compiled], least(lambda c=compiled, run=study: run(c), 1))
        print(f"{name}: {spent[False] / spent[True]:.2f} times faster ({1e3 * spent[True]:.0f} ms)")
    solver = {compiled: Stations(skylines.corridor(), compiled=compiled) for compiled in (False, True)}
    near = {compiled: one.solve(150.0, 1500.0) for compiled, one in solver.items()}
    for what, call in (
        ("Newton's method of a rig", lambda at: at.at.newton.solve(at.point.copy(), target=np.array([151.0]))),
        ("check of a state of a rig", lambda at: at.at.check.require(at.point)),
    ):
        spent = {c: least(lambda one=one, call=call: [call(one) for _ in range(50)]) / 50 for c, one in near.items()}
        print(f"{what}: {spent[False] / spent[True]:.2f} times faster ({1e6 * spent[True]:.0f} us)")


def main(
    spans: Annotated[list[int] | None, typer.Option(help="Numbers of spans.")] = None,
    until: Annotated[float, typer.Option(help="Duration of the runs [s].")] = 600.0,
    cases: Annotated[int, typer.Option(help="Cases of the sweep.")] = CASES,
    fmu: Annotated[bool, typer.Option(help="Export FMUs too.")] = True,
) -> None:
    """Prints the ratios."""
    for n in spans or [20, 100]:
        simulations(n, until, fmu)
        equilibria(n)
    example = rw.monocable(
        lines.ROPE, supports=EXAMPLE, tension=lines.TENSION, speed=1.0, load_mass=300.0, load_spacing=50.0
    )
    measured("the example line", example, until)
    one_hour(100)
    growth((250, 500, 1000, 2000), 60.0)
    sweeps(cases)
    rigs()


if __name__ == "__main__":
    typer.run(main)
