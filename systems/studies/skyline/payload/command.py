"""The payload study of a corridor from a few numbers, for the command line: table, CSV and picture."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from ropeway.components.carriage import Carriage
from ropeway.components.errors import InputError
from ropeway.components.intermediate_support import IntermediateSupport
from ropeway.components.rope import Rope
from ropeway.components.spar import HeadSpar, TailSpar
from ropeway.components.terrain import Profile
from ropeway.components.whole_files import whole
from ropeway.systems.rigs.skyline_rig import SkylineRig
from ropeway.systems.rigs.standing_skyline import standing_skyline
from ropeway.systems.studies.skyline.load_path import default_stations
from ropeway.systems.studies.skyline.payload.study import PayloadStudy, payload


@dataclass(frozen=True, kw_only=True)
class CorridorRequest:
    """A standing skyline over a corridor, in a few numbers.

    corridor: its table (station, elevation); skyline [its bare `tension` at the headspar, N] and mainline; head, tail:
    stations of the spars [m], by default the profile's ends, and their heights [m]; supports: "STATION:HEIGHT" each
    [m]; mass of the carriage [kg]; load_depth: from the skyline to the lowest point of the load [m]; clearance of the
    load [m]; spacing of the stations [m].
    """

    corridor: str | Path
    skyline: Rope
    tension: float
    mainline: Rope | None = None
    head: float | None = None
    head_height: float = 15.0
    tail: float | None = None
    tail_height: float = 8.0
    supports: tuple[str, ...] = ()
    carriage_mass: float = 400.0
    load_depth: float = 0.0
    safety_factor: float = 3.0
    clearance: float = 1.0
    spacing: float = 5.0

    def rig(self) -> SkylineRig:
        """The rig. Raises InputError, SlackRopeError."""
        ground = Profile.from_csv(self.corridor)
        head = ground.station[0] if self.head is None else self.head
        tail = ground.station[-1] if self.tail is None else self.tail
        return standing_skyline(
            ground,
            headspar=HeadSpar("head", station=head, height=self.head_height),
            supports=[_support(text, i) for i, text in enumerate(self.supports, 1)],
            tailspar=TailSpar("tail", station=tail, height=self.tail_height),
            skyline=self.skyline,
            tension=self.tension,
            mainline=self.mainline,
            carriage=Carriage("carriage", mass=self.carriage_mass, depth=self.load_depth),
            name=Path(self.corridor).stem,
        )


def payload_command(request: CorridorRequest, out: str | Path) -> tuple[PayloadStudy, tuple[Path, Path]]:
    """Payloads along a corridor. Writes payload.csv and payload.png into the folder `out`, and returns the study and
    their paths. Raises InputError, SlackRopeError."""
    rig = request.rig()
    stations = default_stations(rig, request.spacing)
    study = payload(rig, safety_factor=request.safety_factor, clearance=request.clearance, stations=stations)
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
