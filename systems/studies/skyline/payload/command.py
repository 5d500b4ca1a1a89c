"""The payload study of a corridor for the command line: table, CSV and figure."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ropeway.components.carriage import Carriage
from ropeway.components.environment import Environment
from ropeway.components.errors import InputError
from ropeway.components.intermediate_support import IntermediateSupport
from ropeway.components.rope import Rope
from ropeway.components.spar import HeadSpar, TailSpar
from ropeway.components.terrain import Profile
from ropeway.components.whole_files import whole
from ropeway.systems.rigs.live_skyline import gravity_skyline, live_skyline
from ropeway.systems.rigs.running_skyline import running_skyline
from ropeway.systems.rigs.skyline_rig import SkylineRig
from ropeway.systems.rigs.standing_skyline import standing_skyline
from ropeway.systems.studies.skyline.load_path import default_stations
from ropeway.systems.studies.skyline.payload.study import PayloadStudy, payload


@dataclass(frozen=True, kw_only=True)
class CorridorRequest:
    """A skyline over a corridor, described by a few numbers.

    `corridor` is its table (station, elevation), or a raster of elevations with the corridor's `start` and `end` as
    "EASTING,NORTHING". `tension` is that of the bare skyline at the headspar [N]. `head` and
    `tail` are stations of the spars [m], by default the ends of the profile; heights are in m. Each support is
    "STATION:HEIGHT" [m]. `carriage_mass` is in kg. `load_depth` is the distance from the skyline to the lowest point of
    the load [m]. `clearance` of the load and `spacing` of the stations are in m. `kind` is standing, live, gravity or
    running; `environment` its weather; `compiled`: in compiled code.
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
    kind: str = "standing"
    start: str | None = None
    end: str | None = None
    environment: Environment | None = None
    compiled: bool = False

    def ground(self) -> Profile:
        """The ground. Raises InputError."""
        if self.start is None and self.end is None:
            return Profile.from_csv(self.corridor)
        if self.start is None or self.end is None:
            raise InputError("A corridor over a raster has two ends", "Give both --start and --end")
        return Profile.from_dem(self.corridor, _map_point(self.start), _map_point(self.end))

    def rig(self) -> SkylineRig:
        """The rig. Raises InputError, SlackRopeError."""
        ground = self.ground()
        head = ground.station[0] if self.head is None else self.head
        tail = ground.station[-1] if self.tail is None else self.tail
        parts: dict[str, Any] = {
            "headspar": HeadSpar("head", station=head, height=self.head_height),
            "tailspar": TailSpar("tail", station=tail, height=self.tail_height),
            "tension": self.tension,
            "carriage": Carriage("carriage", mass=self.carriage_mass, depth=self.load_depth),
            "name": Path(self.corridor).stem,
        }
        supports = [_support(text, i) for i, text in enumerate(self.supports, 1)]
        if self.kind in ("gravity", "running"):
            if self.mainline is None or supports:
                what = "no mainline" if self.mainline is None else "intermediate supports"
                raise InputError(f"A {self.kind} skyline has {what}", "Give --mainline, and no --support")
            if self.kind == "gravity":
                return gravity_skyline(ground, skyline=self.skyline, mainline=self.mainline, **parts)
            return running_skyline(ground, haulback=self.skyline, mainline=self.mainline, **parts)
        if self.kind not in ("standing", "live"):
            raise InputError(f"There is no {self.kind!r} skyline", "Choose standing, live, gravity or running")
        make = standing_skyline if self.kind == "standing" else live_skyline
        return make(ground, skyline=self.skyline, mainline=self.mainline, supports=supports, **parts)


def payload_command(request: CorridorRequest, out: str | Path) -> tuple[PayloadStudy, tuple[Path, Path]]:
    """Payloads along a corridor. Writes payload.csv and payload.png to the folder `out`. Returns the study and both
    paths. Raises InputError, SlackRopeError, WriteError."""
    rig = request.rig()
    stations = default_stations(rig, request.spacing)
    study = payload(
        rig,
        safety_factor=request.safety_factor,
        clearance=request.clearance,
        stations=stations,
        environment=request.environment,
        compiled=request.compiled,
    )
    return study, write_payload(study, out)


def write_payload(study: PayloadStudy, out: str | Path) -> tuple[Path, Path]:
    """Writes payload.csv and payload.png of a study into a folder. Raises WriteError."""
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    table, picture = folder / "payload.csv", folder / "payload.png"
    study.to_csv(table)
    with whole(picture) as file:
        study.plot().savefig(file, dpi=110)
    return table, picture


def _support(text: str, number: int) -> IntermediateSupport:
    """An intermediate support from "STATION:HEIGHT"."""
    try:
        station, height = (float(part) for part in text.split(":"))
    except ValueError as error:
        raise InputError(f"Support {text!r} is not STATION:HEIGHT", "Give for example 260:9, in metres") from error
    return IntermediateSupport(f"jack{number}", station=station, height=height)


def _map_point(text: str) -> tuple[float, float]:
    """A point of the map from "EASTING,NORTHING"."""
    try:
        east, north = (float(part) for part in text.split(","))
    except ValueError as error:
        raise InputError(f"Point {text!r} is not EASTING,NORTHING", "Give for example 2600120,1200560") from error
    return east, north
