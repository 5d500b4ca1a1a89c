"""GeoPackage and GeoJSON, written by geopandas and GDAL."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ropeway.components.errors import InputError
from ropeway.components.map_frame import WGS84
from ropeway.systems.exchange.gis_features import Drawing, Feature


def write_geopackage(drawing: Drawing, path: Path) -> None:
    """A layer for each of the drawing's, in its own coordinate system."""
    for layer, features in drawing.layers.items():
        _write(_table(drawing, features, degrees=False), path, driver="GPKG", layer=layer)


def write_geojson(drawing: Drawing, path: Path) -> None:
    """All features in one collection by RFC 7946: longitude and latitude with nine decimals, 0.1 mm."""
    table = _table(drawing, drawing.features, degrees=True)
    _write(table, path, driver="GeoJSON", RFC7946="YES", COORDINATE_PRECISION="9", WRITE_NAME="NO")


def _table(drawing: Drawing, features: tuple[Feature, ...] | list[Feature], *, degrees: bool) -> Any:
    """The features as a GeoDataFrame."""
    try:
        import geopandas
        import pyogrio  # noqa: F401
        import shapely
    except ImportError as error:
        raise InputError("Writing a GeoPackage or GeoJSON needs geopandas", "pip install ropeway[gis]") from error
    rows, shapes = [], []
    for feature in features:
        rows.append({"layer": feature.layer, "name": feature.name, **feature.attributes})
        at = drawing.in_degrees(feature) if degrees else drawing.on_map(feature)
        shapes.append(shapely.Point(at[0]) if feature.is_point else shapely.LineString(at))
    if not degrees:  # the layer of a GeoPackage says it
        rows = [{key: value for key, value in row.items() if key != "layer"} for row in rows]
    return geopandas.GeoDataFrame(rows, geometry=shapes, crs=WGS84 if degrees else drawing.frame.crs)


def _write(table: Any, path: Path, **options: str) -> None:
    from pyogrio.errors import DataLayerError, DataSourceError

    try:
        table.to_file(path, engine="pyogrio", **options)
    except (DataSourceError, DataLayerError) as error:
        raise OSError(str(error)) from error
