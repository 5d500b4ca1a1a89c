"""Results in archives: the declarations that their models are made of, and the numbers that were found."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd

from ropeway.components.schedule import Schedule
from ropeway.systems.dynamics.inertia.inertial_system import with_inertia
from ropeway.systems.dynamics.result import Result
from ropeway.systems.exchange.project_text import Json, Keys
from ropeway.systems.exchange.project_values import Decoder, Encoder, FileKind
from ropeway.systems.modelling.assembly import assemble, assembled
from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.modelling.rope_path import Loads, Run
from ropeway.systems.results.quasi_static import without_inertia
from ropeway.systems.results.run_data import Event
from ropeway.systems.solvers.points import Point
from ropeway.systems.statics.equilibrium import Equilibrium
from ropeway.systems.statics.line_records import Record
from ropeway.systems.statics.pending_events import Pending
from ropeway.systems.statics.record_blocks import Records

_VECTORS = ("x", "z", "u", "p", "d")


def _write_frame(encoder: Encoder, frame: pd.DataFrame) -> dict[str, Json]:
    name = f"table{len(encoder.frames) + 1}.parquet"
    frame = frame.copy(deep=False)
    frame.attrs = {key: dict(v) if isinstance(v, dict) else v for key, v in frame.attrs.items()}
    encoder.frames[name] = frame
    return {"file": name}


def _read_frame(decoder: Decoder, data: Mapping[str, Json], keys: Keys) -> pd.DataFrame:
    decoder.require_fields(data, keys, ("kind", "file"), ("file",))
    if data["file"] not in decoder.frames:
        raise decoder.error((*keys, "file"), f"the archive has no {data['file']!r}", "Save it again")
    return decoder.frames[data["file"]]


def _write_model(encoder: Encoder, model: Model) -> dict[str, Json]:
    slots: Json = [layout.slots.count.tolist() for layout in model.layouts]
    if model.inertia is None:
        return {"system": encoder.value(model.system, model.name), "slots": slots}
    system = encoder.value(without_inertia(model.system), model.name)
    return {"system": system, "slots": slots, "inertia": encoder.value(model.inertia, "inertia")}


def _read_model(decoder: Decoder, data: Mapping[str, Json], keys: Keys) -> Model:
    system = decoder.thing(data["system"], (*keys, "system"))
    if "inertia" not in data:
        return assemble(system, slots=data["slots"])
    inertia = decoder.part(data["inertia"], (*keys, "inertia"))
    return assembled(with_inertia(system, inertia), data["slots"], inertia)


def _loads(runs: Sequence[Run]) -> list[Json]:
    """The loads of runs, which change in a simulation."""
    arrays = ("mass", "place", "pinned", "at", "drag")
    return [
        {"names": list(map(str, run.loads.names)), "first": int(run.loads.first)}
        | {name: getattr(run.loads, name).tolist() for name in arrays}
        for run in runs
    ]


def _runs(model: Model, data: Sequence[Mapping[str, Json]]) -> tuple[Run, ...]:
    """The runs of a model with other loads."""
    return tuple(replace(run, loads=_loads_of(own)) for run, own in zip(model.runs, data, strict=True))


def _loads_of(data: Mapping[str, Json]) -> Loads:
    mass, place, at = (np.array(data[name], dtype=float) for name in ("mass", "place", "at"))
    drag = np.array(data.get("drag", np.zeros(len(mass))), dtype=float)
    return Loads(tuple(data["names"]), mass, place, np.array(data["pinned"], dtype=int), at, data["first"], drag)


def _pending(pending: Pending) -> Json:
    ticks = [[*clock, time] for clock, time in pending.ticks.items()]
    stopping = pending.stopping
    if stopping is None:
        return {"ticks": ticks}
    signals = {name: [list(s.times), list(s.speeds)] for name, s in stopping.items()}
    return {"ticks": ticks, "stopping": signals, "emergency": pending.emergency}


def _read_pending(data: Mapping[str, Json]) -> Pending:
    ticks = {(period, phase): time for period, phase, time in data["ticks"]}
    stopping = data.get("stopping")
    if stopping is None:
        return Pending(ticks)
    return Pending(ticks, {n: Schedule(t, s) for n, (t, s) in stopping.items()}, data.get("emergency", True))


def _write_equilibrium(encoder: Encoder, line: Equilibrium) -> dict[str, Json]:
    numbers = {name: encoder.value(getattr(line.point, name), name) for name in _VECTORS}
    return {
        "model": encoder.value(line.model, line.model.name),
        "loads": _loads(line.runs),
        "point": {"t": line.point.t, **numbers},
        "passed": [p.tolist() for p in line.passed],
        "held": list(line.held),
        "pending": _pending(line.pending),
        "given": [list(pair) for pair in line.given],
    }


def _read_equilibrium(decoder: Decoder, data: Mapping[str, Json], keys: Keys) -> Equilibrium:
    model = decoder.thing(data["model"], (*keys, "model"))
    vectors = {name: np.array(decoder.value(data["point"][name], keys), dtype=float) for name in _VECTORS}
    return Equilibrium(
        model,
        Point(**vectors, t=float(data["point"]["t"])),
        _runs(model, data["loads"]),
        tuple(np.array(p, dtype=int) for p in data["passed"]),
        tuple(data["held"]),
        _read_pending(data["pending"]),
        tuple((name, float(value)) for name, value in data["given"]),
    )


def _write_result(encoder: Encoder, result: Result) -> dict[str, Json]:
    pending: list[Json] = []
    which: list[int] = []
    for record in result.records:
        own = _pending(record.pending)
        if not pending or pending[-1] != own:
            pending.append(own)
        which.append(len(pending) - 1)
    columns: dict[str, Any] = {"time": result.times, "on_grid": result.on_grid, "exact": result.exact, "pending": which}
    rows = result.records.rows(np.arange(len(result.records)))
    for name in ("x", "z", "u", "kept"):
        columns |= _columns(name, getattr(rows, name))
    nodes = np.cumsum([len(run.nodes) for run in result.runs])[:-1]
    for k, passed in enumerate(np.split(rows.passed, nodes, axis=1) if result.runs else ()):
        columns |= _columns(f"passed{k}", passed)
    return {
        "model": encoder.value(result.model, result.model.name),
        "loads": _loads(result.runs),
        "parameters": encoder.value(result.parameters, "parameters"),
        "records": encoder.value(pd.DataFrame(columns), "records"),
        "pending": pending,
        "noted": encoder.value(pd.DataFrame(result.noted, columns=list(Event._fields)), "noted"),
        "tolerance": result.tolerance,
    }


def _columns(name: str, rows: np.ndarray) -> dict[str, np.ndarray]:
    return {f"{name}[{i}]": column for i, column in enumerate(rows.T)}


def _read_result(decoder: Decoder, data: Mapping[str, Json], keys: Keys) -> Result:
    model = decoder.thing(data["model"], (*keys, "model"))
    runs = _runs(model, data["loads"])
    table = decoder.thing(data["records"], (*keys, "records"))
    pending = [_read_pending(each) for each in data["pending"]]
    groups = ["x", "z", "u", "kept", *(f"passed{k}" for k in range(len(runs)))]
    arrays = [table.filter(regex=rf"^{name}\[").to_numpy() for name in groups]
    times, which = table["time"].to_numpy(), table["pending"].to_numpy()
    records = [
        Record(float(t), x, z, u, tuple(passed), kept, pending[i])
        for t, i, x, z, u, kept, *passed in zip(times, which, *arrays, strict=True)
    ]
    noted = decoder.thing(data["noted"], (*keys, "noted"))
    return Result(
        model,
        runs,
        np.array(decoder.value(data["parameters"], keys), dtype=float),
        Records([records]),
        table["on_grid"].to_numpy(dtype=bool),
        table["exact"].to_numpy(dtype=bool),
        tuple(Event(*row) for row in noted.itertuples(index=False, name=None)),
        float(data["tolerance"]),
    )


KINDS = (
    FileKind("result", Result, _write_result, _read_result),
    FileKind("equilibrium", Equilibrium, _write_equilibrium, _read_equilibrium),
    FileKind("model", Model, _write_model, _read_model),
    FileKind("table", pd.DataFrame, _write_frame, _read_frame),
)
"""The forms of results in archives."""
