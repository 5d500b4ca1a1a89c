"""The catalogue: ropes, carriages and yarders from data files with their sources, and from tables of a user."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from difflib import get_close_matches
from functools import cache
from importlib.resources import as_file, files
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ropeway.components import table
from ropeway.components.argument_checks import checked
from ropeway.components.errors import InputError
from ropeway.components.table_file import name_and_unit

if TYPE_CHECKING:
    import pandas as pd

MODULUS = 93.1e9
"""Modulus of a 6-strand IWRC rope on its metallic area [Pa] (Lyons 2008, p. 32)."""

DENSITY = 9300.0
"""Mass of a 6x19 IWRC rope over its metallic area and length [kg/m3] (Lyons 2008, p. 32)."""

SIZES = (8, 9, 10, 11, 12, 13, 14, 16, 18, 19, 20, 22, 24, 26, 28, 32, 36, 40)
"""Diameters of the catalogue's ropes by factors [mm]."""

_NUMBERS = {"diameter": "m", "mass_per_length": "kg/m", "breaking_load": "N"}
_WEATHER = {"thermal_expansion": "1/K", "drag_coefficient": "1"}
_MORE = {"axial_stiffness": "N", "modulus": "Pa", **_WEATHER}
_TEXTS = ("use", "source")
_EXAMPLE = "name,diameter [mm],mass_per_length [kg/m],breaking_load [kN]\nskyline A,22,2.4,425"
_ROPE = table.TableLayout({"name": None, **_NUMBERS}, _EXAMPLE)
_FULL_ROPE = table.TableLayout({"name": None, **_NUMBERS, **_MORE}, _EXAMPLE)
_FACTORS = table.TableLayout({"construction": None, "W": "", "C": "", "K": "", "grades": None, "source": None}, "")
_FIBRES = table.TableLayout({"fibre": None, "M": "", "B2": "", "B3": "", "E": "", "source": None}, "")
_MACHINES = {
    "carriages": ({"mass": "kg"}, {"payload": "kg"}, "name,mass [kg],payload [kg]\nours,450,3000"),
    "yarders": (
        {"tower_height": "m"},
        {"line_pull": "N", "line_speed": "m/s", "drum_capacity": "m"},
        "name,tower_height [m],line_pull [kN]\nours,11.5,45",
    ),
}


@dataclass(frozen=True, slots=True)
class Construction:
    """EN 12385-4 factors of a construction: m = W d^2/100 [kg/m], A = C d^2 [mm2], F = K d^2 R/1000 [kN], and the
    rope grades R [N/mm2] of the catalogue."""

    mass: float
    area: float
    strength: float
    grades: tuple[int, ...]
    source: str


@dataclass(frozen=True, slots=True)
class CatalogueRope:
    """A rope of the catalogue, with its source. `use`: what it is meant for, or its construction; `weather`: its
    thermal_expansion [1/K] and drag_coefficient, where its table has them."""

    name: str
    diameter: float
    mass_per_length: float
    axial_stiffness: float
    breaking_load: float
    use: str
    source: str
    weather: Mapping[str, float] = field(default_factory=dict)


@cache
def constructions() -> Mapping[str, Construction]:
    """The constructions of the catalogue by name."""
    read = _own_table("constructions", _FACTORS)
    texts = (read.texts(name) for name in ("construction", "grades", "source"))
    found = {}
    for name, grades, source, (mass, area, strength) in zip(*texts, read.numbers("W", "C", "K").tolist(), strict=True):
        found[name] = Construction(mass, area, strength, tuple(int(g) for g in grades.split()), source)
    return found


def by_factors(name: str, construction: Construction, diameter: float, grade: float, modulus: float) -> CatalogueRope:
    """A rope of a diameter [m] and grade [N/mm2]; modulus on the metallic area [Pa]."""
    mm = diameter * 1e3
    return CatalogueRope(
        name,
        diameter,
        construction.mass * mm**2 / 100.0,
        modulus * construction.area * diameter**2,
        construction.strength * mm**2 * grade,
        "EN 12385-4",
        construction.source,
    )


@cache
def _built_in() -> Mapping[str, CatalogueRope]:
    """All ropes of the data files, by name."""
    found = [*_ropes_of(_own_table("ropes", _FULL_ROPE, _ROPE))]
    for kind, construction in constructions().items():
        for grade in construction.grades:
            for mm in SIZES:
                found.append(by_factors(f"{kind} {mm} {grade}", construction, mm / 1e3, grade, MODULUS))
    fibres = _own_table("fibres", _FIBRES)
    for name, source, (mass, b2, b3, stiffness) in zip(
        fibres.texts("fibre"), fibres.texts("source"), fibres.numbers("M", "B2", "B3", "E").tolist(), strict=True
    ):
        for mm in SIZES:
            d = mm / 1e3
            strength = float(b2 * d**2 + b3 * d**3)
            found.append(
                CatalogueRope(
                    f"{name} {mm}", d, float(mass * d**2), float(stiffness * strength), strength, "synthetic", source
                )
            )
    return {rope.name: rope for rope in found}


def all_ropes(own: Sequence[table.Source] = ()) -> Mapping[str, CatalogueRope]:
    """The ropes of the catalogue and of tables of a user, which come first where names are equal. Raises InputError."""
    found: dict[str, CatalogueRope] = {}
    for source in own:
        found.update({rope.name: rope for rope in _ropes_of(_user_table(source, _FULL_ROPE, _ROPE))})
    return {**found, **{name: rope for name, rope in _built_in().items() if name not in found}}


def _ropes_of(read: table.Table) -> list[CatalogueRope]:
    more = [name for name in _MORE if name in read.keys]
    values = read.numbers(*_NUMBERS, optional=more)
    texts = {name: read.texts(name) if name in read.keys else [""] * len(read) for name in _TEXTS}
    found = []
    for i, name in enumerate(read.texts("name")):
        if not name:
            raise read.error("a rope has no name", "Name it", i, "name")
        own = dict(zip((*_NUMBERS, *more), map(float, values[i]), strict=True))
        stiffness, modulus = own.get("axial_stiffness", math.nan), own.get("modulus", math.nan)
        if math.isnan(stiffness):
            stiffness = (MODULUS if math.isnan(modulus) else modulus) * own["mass_per_length"] / DENSITY
        for key in _NUMBERS:
            if own[key] <= 0.0:
                raise read.error(f"{name!r}: {key} is {own[key]:g}", "Give a number above zero", i, key)
        numbers = own["diameter"], own["mass_per_length"], stiffness, own["breaking_load"]
        weather = {key: own[key] for key in _WEATHER if not math.isnan(own.get(key, math.nan))}
        found.append(CatalogueRope(name, *numbers, texts["use"][i], texts["source"][i], weather))
    return found


@checked
def ropes(*own: table.Source) -> pd.DataFrame:
    """The ropes of the catalogue. `Rope.named(name)` makes one.

    Parameters
    ----------
    *own : str, Path or DataFrame
        Tables of yours (CSV, Excel, TOML or DataFrame), see `docs/catalogue.md`.

    Returns
    -------
    DataFrame
        Index name; columns diameter [m], mass_per_length [kg/m], axial_stiffness [N], breaking_load [N], use, source.

    Raises
    ------
    InputError
        With file, line and column.

    Examples
    --------
    >>> print(f"{rw.ropes().loc['6x19 IWRC 22 1960', 'breaking_load'] / 1e3:.1f} kN")
    337.7 kN
    """
    import pandas as pd

    found = [(r.name, *(getattr(r, name) for name in _COLUMNS)) for r in all_ropes(own).values()]
    frame = pd.DataFrame(found, columns=["name", *_COLUMNS]).set_index("name")
    frame.attrs["units"] = {**_NUMBERS, "axial_stiffness": "N", "use": "", "source": ""}
    return frame


_COLUMNS = ("diameter", "mass_per_length", "axial_stiffness", "breaking_load", "use", "source")


@checked
def carriages(*own: table.Source) -> pd.DataFrame:
    """The carriages of the catalogue, which have a public data sheet, and of tables of yours.

    Parameters
    ----------
    *own : str, Path or DataFrame
        Tables of yours (CSV, Excel, TOML or DataFrame), see `docs/catalogue.md`.

    Returns
    -------
    DataFrame
        Index name; columns mass [kg], payload [kg], source.

    Raises
    ------
    InputError
        With file, line and column.

    Examples
    --------
    >>> rw.carriages().columns.tolist()
    ['mass', 'payload', 'source']
    """
    return _machines("carriages", own)


@checked
def yarders(*own: table.Source) -> pd.DataFrame:
    """The yarders of the catalogue and of tables of yours.

    Parameters
    ----------
    *own : str, Path or DataFrame
        Tables of yours (CSV, Excel, TOML or DataFrame), see `docs/catalogue.md`.

    Returns
    -------
    DataFrame
        Index name; columns tower_height [m], line_pull [N], line_speed [m/s], drum_capacity [m of rope], source; NaN
        where the source has no value.

    Raises
    ------
    InputError
        With file, line and column.

    Examples
    --------
    >>> print(rw.yarders()["tower_height"].max(), "m")
    13.716 m
    """
    return _machines("yarders", own)


def _machines(kind: str, own: Sequence[table.Source]) -> pd.DataFrame:
    import pandas as pd

    needed, more, example = _MACHINES[kind]
    layouts = [table.TableLayout({"name": None, **columns}, example) for columns in (needed | more, needed)]
    tables = [_user_table(source, *layouts) for source in own]
    columns = [*needed, *more, "source"]
    with as_file(files("ropeway.components") / "catalogue" / f"{kind}.csv") as path:
        if sum(not line.startswith("#") for line in path.read_text(encoding="utf-8").splitlines()) > 1:
            tables.append(table.read(path, *layouts))
    rows: dict[str, list[Any]] = {}
    for read in tables:
        present = [name for name in more if name in read.keys]
        values = read.numbers(*needed, optional=present)
        sources = read.texts("source") if "source" in read.keys else [""] * len(read)
        for name, source, numbers in zip(read.texts("name"), sources, values, strict=True):
            given = dict(zip((*needed, *present), map(float, numbers), strict=True))
            rows.setdefault(name, [*(given.get(c, math.nan) for c in columns[:-1]), source])
    frame = pd.DataFrame.from_dict(rows, orient="index", columns=columns).rename_axis("name")
    frame = frame.astype({**dict.fromkeys(columns[:-1], float), "source": object})
    frame.attrs["units"] = {**needed, **more, "source": ""}
    return frame


def _own_table(name: str, *layouts: table.TableLayout) -> table.Table:
    with as_file(files("ropeway.components") / "catalogue" / f"{name}.csv") as path:
        return table.read(path, *layouts)


def _user_table(source: table.Source, *layouts: table.TableLayout) -> table.Table:
    """A table of a user, in TOML too: an array of tables, such as [[rope]]. Raises InputError."""
    if isinstance(source, str | Path) and Path(source).suffix.lower() == ".toml":
        return _toml_table(source, *layouts)
    return _clear(table.read(source, *layouts), layouts)


def _clear(read: table.Table, layouts: Sequence[table.TableLayout]) -> table.Table:
    """The table. Raises InputError for a name that occurs twice, and for a misspelt column."""
    names = read.texts("name")
    for i, name in enumerate(names):
        if name and name in names[:i]:
            raise read.error(
                f"{name!r} is also in {read.lines[names.index(name)]}", "Give each its own name", i, "name"
            )
    known = {*_TEXTS, *(column for layout in layouts for column in layout.columns)}
    for key, column in zip(read.keys, read.columns, strict=True):
        near = get_close_matches(name_and_unit(column)[0].casefold(), known - {*read.keys}, n=1, cutoff=0.8)
        if key not in known and near:
            raise read.error(f"there is no quantity {column!r}", f"Is it {near[0]}?", table.HEADER, key)
    return read


def _toml_table(source: str | Path, *layouts: table.TableLayout) -> table.Table:
    import pandas as pd

    try:
        content = tomllib.loads(Path(source).read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise InputError(f"There is no file {source}", "Check the path") from error
    except (OSError, ValueError) as error:
        raise InputError(f"{source}: {error}", "Correct it there") from error
    entries = [v for v in content.values() if isinstance(v, list) and v and all(isinstance(e, dict) for e in v)]
    if len(entries) != 1:
        raise InputError(f"{source} has {len(entries)} arrays of tables", "Give one, as [[rope]] with name = ...")
    try:
        return _clear(table.read(pd.DataFrame(entries[0]), *layouts), layouts)
    except InputError as error:
        raise InputError(f"{source}: {error.cause}", error.remedy) from error
