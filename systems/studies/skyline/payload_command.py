"""The payload study of a corridor from a few numbers, for the command line: table, CSV and picture."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ropeway.components.carriage import Carriage
from ropeway.components.errors import InputError
from ropeway.components.intermediate_support import IntermediateSupport
from ropeway.components.rope import Rope
from ropeway.components.spar import HeadSpar, TailSpar
from ropeway.components.terrain import Profile
from ropeway.components.whole_files import whole
from ropeway.systems.rigs.standing_skyline import standing_skyline
from ropeway.systems.studies.skyline.load_path import default_stations
from ropeway.systems.studies.skyline.payload import PayloadStudy, payload


def payload_command(
    corridor: str | Path,
    *,
    skyline: Rope,
    tension: float,
    mainline: Rope | None = None,
    head_height: float = 15.0,
    tail_height: float = 8.0,
    head: float | None = None,
    tail: float | None = None,
    supports: Sequence[str] = (),
    carriage_mass: float = 400.0,
    load_depth: float = 0.0,
    safety_factor: float = 3.0,
    clearance: float = 1.0,
    spacing: float = 5.0,
    out: str | Path = "ropeway-payload",
) -> tuple[PayloadStudy, tuple[Path, Path]]:
    """Payloads along a standing skyline over a corridor's CSV (station, elevation).

    head, tail: stations of the spars [m], by default the profile's ends; supports: "STATION:HEIGHT" each [m].
    Writes payload.csv and payload.png into the folder `out`, and returns the study and their paths. Raises
    InputError, SlackRopeError.
    """
    ground = Profile.from_csv(corridor)
    rig = standing_skyline(
        ground,
        headspar=HeadSpar("head", station=ground.station[0] if head is None else head, height=head_height),
        supports=[_support(text, i) for i, text in enumerate(supports, 1)],
        tailspar=TailSpar("tail", station=ground.station[-1] if tail is None else tail, height=tail_height),
        skyline=skyline,
        tension=tension,
        mainline=mainline,
        carriage=Carriage("carriage", mass=carriage_mass, depth=load_depth),
        name=Path(corridor).stem,
    )
    study = payload(rig, safety_factor=safety_factor, clearance=clearance, stations=default_stations(rig, spacing))
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    table, picture = folder / "payload.csv", folder / "payload.png"
    study.to_csv(table)
    with whole(picture) as file:
        study.plot().savefig(file, dpi=110)
    return study, (table, picture)


def _support(text: str, number: int) -> IntermediateSupport:
    """An intermediate support from "STATION:HEIGHT"."""
    try:
        station, height = (float(part) for part in text.split(":"))
    except ValueError as error:
        raise InputError(f"Support {text!r} is not STATION:HEIGHT", "Write for example 260:9, in metres") from error
    return IntermediateSupport(f"jack{number}", station=station, height=height)
