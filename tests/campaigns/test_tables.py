"""Random tables in random dialects, whole and damaged: the same numbers, or an InputError."""

import re
import warnings
from collections import Counter
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ropeway as rw
from ropeway.components import table

NAMES = {
    "cp1250": "Stožár Příčka Věž Důl Údolní Břeh Kočka Słup Łąka Poznań Święty Góra Żleb Dąbrowa Šoštanj Erdő Völgy",
    "iso8859-2": "Stožár Příčka Słup Łąka Święty Źródło Žleb Šumava Hrušková Málaga",
    "cp1251": "Опора Станция Мост Пик Дол",
    "koi8-r": "Опора Станция Мост Пик Дол",
    "cp1253": "Στήριξη Γέφυρα Κορυφή",
    "shift-jis": "支柱 山側 谷側停留場 鉄塔一",
    "gb2312": "支柱 上站 下站 铁塔",
    "cp850": "Höhe Stütze Weißbach Größe Rivière Vallée",
    "mac-roman": "Höhe Stütze Weißbach Größe Vallée",
    "cp1252": "Höhe Stütze Weißbach Größe Rivière Vallée Châtel Forêt Città Sørli Ås Málaga Peña São",
}
LAYOUT = table.TableLayout({"station": "m", "elevation": "m"}, "station,elevation\n0,846.4")


def written(value: float, mark: str, groups: str) -> str:
    whole, _, part = f"{value:,.4f}".rstrip("0").rstrip(".").partition(".")
    return whole.replace(",", groups) + (mark + part if part else "")


def random_table(rng: np.random.Generator) -> tuple[str, str, np.ndarray, bool]:
    """Text, encoding and numbers of a table, and whether its numbers can be read in one way only."""
    places, count = int(rng.integers(0, 5)), int(rng.integers(1, 8))
    values = np.round(rng.uniform(-1.0, 1.0, (count, 2)) * 10.0 ** rng.integers(0, 6), places) + 0.0
    separator, mark = str(rng.choice([",", ";", "\t", "|"])), str(rng.choice([".", ","]))
    groups = str(rng.choice(["", "", "'", "\u2019", " ", "\xa0", {".": ",", ",": "."}[mark]]))
    if (separator, groups) == (",", "."):
        groups = ""  # between commas a number such as 1.234 has a decimal point
    pad = " " * int(rng.integers(0, 3)) if separator != "\t" else ""
    cells = [[written(v, mark, groups) for v in row] for row in values]
    clear = not any(re.fullmatch(r"-?[1-9]\d{0,2}[.,]\d{3}", cell) for row in cells for cell in row)
    rows = [["Station", " ELEVATION", "Bemerkung"], *([*row, "Stütze; alt, neu"] for row in cells)]
    quoted = [[f'"{c}"' if separator in c or rng.random() < 0.1 else c for c in row] for row in rows]
    lines = [separator.join(pad + cell.strip() + pad for cell in row) for row in quoted]
    for _ in range(int(rng.integers(0, 3))):
        lines.insert(int(rng.integers(0, len(lines) + 1)), str(rng.choice(["", "# note; 1,5", "   "])))
    end = str(rng.choice(["\n", "\r\n", "\r"]))
    encodings = ["utf-8", "utf-8-sig", "utf-16", "utf-32"] + (["cp1252"] if "\u2019" not in groups else [])
    return end.join(lines) + end, str(rng.choice(encodings)), values, clear


def damaged(data: bytes, rng: np.random.Generator) -> bytes:
    """Bytes changed, lost or added at a few places."""
    changed = bytearray(data)
    for _ in range(int(rng.integers(1, 4))):
        at = int(rng.integers(0, len(changed)))
        new = int(rng.integers(0, 256)) if rng.random() < 0.5 else int(rng.choice(list(b';,."#\n\t 0-e')))
        if rng.random() < 0.4:
            changed[at] = new
        elif rng.random() < 0.5:
            changed.insert(at, new)
        else:
            del changed[at]
    return bytes(changed)


def attempt(call: Callable[[], Any]) -> Any:
    """What a call returns, or its InputError; any other exception is a failure."""
    try:
        return call()
    except rw.InputError as error:
        return error


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::ropeway.components.errors.RopewayWarning")  # of damaged texts
def test_tables(campaign: Any, tmp_path: Path) -> None:
    path, asked = tmp_path / "table.csv", 0
    for seed in range(campaign.size(10_000)):
        rng = np.random.default_rng([campaign.seed, seed])
        text, encoding, values, clear = random_table(rng)
        data = text.encode(encoding)
        path.write_bytes(data)
        found = attempt(lambda: table.read(path, LAYOUT).numbers("station", "elevation"))
        if isinstance(found, rw.InputError):
            assert not clear, f"seed {seed}: {found}"
            assert "decimal point and" in str(found), f"seed {seed}: {found}"
            asked += 1
        else:
            np.testing.assert_array_equal(found, values, err_msg=f"seed {seed}")
        path.write_bytes(damaged(data, rng))
        for read in (rw.Profile.from_csv, rw.Schedule.from_csv):
            refused = attempt(partial(read, path))
            assert not isinstance(refused, rw.InputError) or refused.remedy, f"seed {seed}"
    print(f"{asked} of {campaign.size(10_000)} tables asked for their decimal mark")


@pytest.mark.slow
def test_no_name_is_garbled_silently(campaign: Any, tmp_path: Path) -> None:
    """In any code page: the names as they were written, an error, or a warning. One in Windows-1252 is no error."""
    path, found = tmp_path / "table.csv", Counter[str]()
    for seed in range(campaign.size(20_000)):
        rng = np.random.default_rng([campaign.seed, seed])
        encoding = str(rng.choice([*NAMES, "utf-8"]))
        names = NAMES.get(encoding, " ".join(NAMES.values())).split()
        if encoding == "cp1252":  # German with one other language: never all of them in one file
            names = [*names[:4], names[int(rng.integers(4, len(names)))]]
        chosen = [str(name) for name in rng.choice(names, int(rng.integers(1, 6)))] + ["plain"]
        path.write_bytes(("name,x\n" + "".join(f"{name} {i},{i}\n" for i, name in enumerate(chosen))).encode(encoding))
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            read = attempt(lambda: table.read(path, table.TableLayout({"name": None}, "name\na")).texts("name"))
        if isinstance(read, rw.InputError):
            assert encoding not in ("utf-8", "cp1252"), f"seed {seed}: {read}"
            found["refused"] += 1
        elif read == [f"{name} {i}" for i, name in enumerate(chosen)]:
            found["read"] += 1
        else:
            assert told, f"seed {seed}: {encoding} {chosen} read as {read}"
            found["warned of"] += 1
    print(dict(found))
