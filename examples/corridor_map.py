"""From a raster of elevations and two points of the map to a GeoPackage, a DXF and a list for staking out.

The raster is made here: a slope with a ridge on a grid of 5 m in Swiss coordinates (LV95). Needs the extra `gis`.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import rasterio
from matplotlib.figure import Figure

import ropeway as rw

CORNER, CELL, CELLS = (2600000.0, 1200700.0), 5.0, 140
START, END = (2600120.0, 1200560.0), (2600450.0, 1200130.0)


def make_raster(path: Path) -> np.ndarray:
    """A hillside that falls to the south-east over a ridge; returns its elevations."""
    east, north = np.meshgrid(CELL * (np.arange(CELLS) + 0.5), -CELL * (np.arange(CELLS) + 0.5))
    down = 0.55 * east - 0.8 * north
    heights = 1180.0 - 0.36 * down + 13.0 * np.exp(-(((down - 430.0) / 45.0) ** 2)) + 6.0 * np.sin(east / 90.0)
    shape = {"driver": "GTiff", "width": CELLS, "height": CELLS, "count": 1, "dtype": "float64", "crs": "EPSG:2056"}
    with rasterio.open(path, "w", transform=rasterio.Affine(CELL, 0, CORNER[0], 0, -CELL, CORNER[1]), **shape) as file:
        file.write(heights, 1)
    return heights


def main(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    heights = make_raster(folder / "dem.tif")
    ground = rw.Profile.from_dem(folder / "dem.tif", START, END)
    rope = rw.Rope(mass_per_length=2.4, axial_stiffness=24e6, breaking_load=450e3)
    guys = [
        rw.Guyline(f"guy_{side}", rope, at=(-12.0, y, ground.elevation_at(0.0) + 5.0), pretension=15e3)
        for side, y in (("left", 14.0), ("right", -14.0))
    ]
    rig = rw.standing_skyline(
        ground,
        headspar=rw.GuyedSpar("head", station=8.0, height=12.0, mass=1500.0, guylines=tuple(guys)),
        supports=[rw.IntermediateSupport("jack", station=265.0, height=11.0)],
        tailspar=rw.TailSpar("tail", station=525.0, height=10.0),
        skyline=rope,
        tension=70e3,
        carriage=rw.Carriage("carriage", mass=400.0, depth=3.0),
        name="corridor 7",
    )
    study = rw.payload(rig, safety_factor=3.0, clearance=1.0, stations=np.arange(40.0, 520.0, 40.0))
    print(rw.places(rig)[["kind", "easting", "northing", "height", "azimuth", "slope_distance"]].round(2).to_string())
    print(f"{ground!r} in {ground.crs}, azimuth {ground.azimuth:.2f} degrees: {study!r}")
    for name in ("corridor.gpkg", "corridor.geojson", "corridor.dxf", "corridor.kml", "stakes.gpx"):
        rw.export_gis(study, folder / name)
    rw.export_gis(study, folder / "profile.dxf", view="profile")
    picture(folder / "corridor.gpkg", heights).savefig(folder / "corridor_map.png", dpi=110)


def picture(path: Path, heights: np.ndarray) -> Figure:
    """What the GeoPackage holds: the corridor over the contours of the raster, and its profile."""
    import geopandas

    layers = {layer: geopandas.read_file(path, layer=layer) for layer in ("rope", "guylines", "supports", "anchors")}
    carriage = geopandas.read_file(path, layer="carriage")
    figure = Figure(figsize=(13.0, 5.2), layout="constrained")
    plan, profile = figure.subplots(1, 2, width_ratios=[1.0, 1.35])
    cells = CELL * (np.arange(CELLS) + 0.5)
    thin = {"colors": "0.7", "linewidths": 0.7}
    lines = plan.contour(CORNER[0] + cells, CORNER[1] - cells, heights, levels=np.arange(900, 1200, 10), **thin)
    plan.clabel(lines, lines.levels[::2], fontsize=7)
    for layer, colour in (("rope", "tab:red"), ("guylines", "tab:orange")):
        layers[layer].plot(ax=plan, color=colour, lw=1.8 if layer == "rope" else 1.0, label=layer)
    for layer, marker in (("supports", "s"), ("anchors", "^")):
        layers[layer].plot(ax=plan, color="tab:brown", marker=marker, markersize=22, zorder=4, label=layer)
        for _, row in layers[layer].iterrows():
            side = -6 if layer == "anchors" else 6
            where = {"xytext": (side, 4), "textcoords": "offset points", "ha": "right" if side < 0 else "left"}
            plan.annotate(row["name"], (row.geometry.x, row.geometry.y), fontsize=8, **where)
    plan.set(xlim=(START[0] - 110.0, END[0] + 90.0), ylim=(END[1] - 60.0, START[1] + 60.0))
    plan.set(xlabel="easting [m]", ylabel="northing [m]", title="plan, EPSG:2056")
    plan.ticklabel_format(useOffset=False, style="plain")
    plan.locator_params(nbins=4)
    plan.legend(loc="lower left", fontsize="small")
    ground = geopandas.read_file(path, layer="ground").geometry[0]
    profile.plot(*stations(ground), color="0.35", lw=1.2, label="ground")
    for k, shape in enumerate(layers["rope"].geometry):
        profile.plot(*stations(shape), color="tab:red", lw=1.5, label=None if k else "bare skyline")
    profile.plot(carriage["station"], carriage["carriage_z"], "o", ms=4, color="tab:green", label="carriage, loaded")
    for _, row in layers["supports"].iterrows():
        profile.plot([row["station"]] * 2, [row["ground"], row["elevation"]], color="tab:brown", lw=2.5)
    for _, row in carriage.iterrows():
        text, place = f"{np.floor(row['payload'] / 10.0) * 10.0:.0f}", (row["station"], row["carriage_z"])
        profile.annotate(text, place, xytext=(-2, -12), textcoords="offset points", ha="right", fontsize=7)
    profile.set(xlabel="station [m]", ylabel="elevation [m]", title="profile, with the payload by station [kg]")
    profile.set_aspect("equal")
    profile.grid(alpha=0.3)
    profile.legend(loc="lower left", fontsize="small")
    return figure


def stations(shape: object) -> tuple[np.ndarray, np.ndarray]:
    """Horizontal distances from the corridor's start, and heights, of a line in map coordinates."""
    east, north, height = np.array(shape.coords).T  # type: ignore[attr-defined]
    return np.hypot(east - START[0], north - START[1]), height


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
