"""Lines and rigs for geographic information systems and CAD."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from ropeway.components.argument_checks import checked
from ropeway.components.errors import InputError, WriteError
from ropeway.components.whole_files import whole
from ropeway.systems.exchange.gis_dxf import View, write_dxf
from ropeway.systems.exchange.gis_features import Drawing
from ropeway.systems.exchange.gis_line import drawing_of_line
from ropeway.systems.exchange.gis_rig import drawing_of_rig
from ropeway.systems.exchange.gis_vector import write_geojson, write_geopackage
from ropeway.systems.exchange.gis_xml import write_gpx, write_kml
from ropeway.systems.exchange.places import OfRig
from ropeway.systems.modelling.system import System
from ropeway.systems.results.run_data import RunData
from ropeway.systems.rigs.skyline_rig import SkylineRig
from ropeway.systems.statics.equilibrium import Equilibrium
from ropeway.systems.statics.equilibrium_solver import equilibrium

_WRITERS = {
    ".gpkg": write_geopackage,
    ".geojson": write_geojson,
    ".kml": write_kml,
    ".gpx": write_gpx,
}


@checked
def export_gis(
    what: SkylineRig | System | Equilibrium | RunData | OfRig,
    path: str | Path,
    *,
    stations: pd.DataFrame | None = None,
    view: View = "3d",
) -> Path:
    """Writes a line or rig with its map coordinates, in the format that the path's ending names, see `docs/gis.md`.

    Parameters
    ----------
    what : SkylineRig, System, Equilibrium, Result, or a study of a rig
        A rig is written with its bare skyline, a study with the carriage at each row of its frame too; a System at
        rest, a Result at its last time.
    path : str or Path
        Ends in .gpkg (GeoPackage), .geojson, .dxf, .kml or .gpx.
    stations : DataFrame, optional
        Positions of a rig's carriage, such as those of `load_path`; by default the frame of the study.
    view : {"3d", "plan", "profile"}
        Of a DXF.

    Returns
    -------
    Path
        The path.

    Raises
    ------
    InputError
        No map coordinates, no coordinate system, an unknown ending, a missing extra.
    WriteError
        The folder does not exist, or the file cannot be written.
    SlackRopeError, EquilibriumError
        The ropes have no state at rest.

    Examples
    --------
    >>> rw.export_gis(rig, "corridor.dxf").name
    'corridor.dxf'
    """
    target = require_gis_path(path)
    ending = target.suffix.lower()
    drawing = _drawing(what, stations)
    with whole(target) as beside:
        if ending == ".dxf":
            write_dxf(drawing, beside, view)
        else:
            _WRITERS[ending](drawing, beside)
    return target


def require_gis_path(path: str | Path) -> Path:
    """A path for a map file. Raises InputError for its ending, WriteError where its folder does not exist."""
    target = Path(path)
    ending = target.suffix.lower()
    if ending not in (*_WRITERS, ".dxf"):
        raise InputError(
            f"{target.name!r} ends in {ending!r}", f"Give a path that ends in {', '.join(_WRITERS)} or .dxf"
        )
    if not target.parent.is_dir():
        raise WriteError(f"{target} cannot be written: there is no folder {target.parent}", "Make the folder first")
    return target


def _drawing(what: SkylineRig | System | Equilibrium | RunData | OfRig, stations: pd.DataFrame | None) -> Drawing:
    if isinstance(what, SkylineRig):
        return drawing_of_rig(what, stations)
    if isinstance(what, System):
        return drawing_of_line(equilibrium(what))
    if isinstance(what, Equilibrium):
        return drawing_of_line(what)
    if isinstance(what, RunData):
        return drawing_of_line(what.record(len(what.records) - 1))
    frame = getattr(what, "frame", None)
    return drawing_of_rig(what.rig, stations if stations is not None else frame)
