"""Objects that several libraries share are compiled once."""

import ctypes
from pathlib import Path

import pytest

from ropeway.systems.native import compiler
from ropeway.systems.native.binary_cache import cache_info
from ropeway.systems.native.object_cache import ObjectCache

SHOWN = '__attribute__((visibility("default"))) '


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A separate cache."""
    monkeypatch.setenv("ROPEWAY_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


def built(folder: Path, number: int, factor: int = 2) -> tuple[int, list[str]]:
    """What a library of two files computes, and the files that were compiled for it."""
    folder.mkdir()
    (folder / "factor.h").write_text(f"#define FACTOR {factor}\n")
    (folder / "shared.c").write_text('#include "factor.h"\nint twice(int n) { return FACTOR * n; }\n')
    (folder / "own.c").write_text(f"int twice(int n);\n{SHOWN}int answer(void) {{ return twice({number}); }}\n")
    compiled: list[str] = []

    class Noted(ObjectCache):
        def keep(self, objects: object, sources: object) -> None:
            compiled.extend(sources)  # type: ignore[call-overload]
            super().keep(objects, sources)  # type: ignore[arg-type]

    library = folder / f"answer{compiler.suffix(compiler.host())}"
    kept = Noted(folder, compiler.host(), "own.c")
    compiler.compile_library(folder, ["own.c", "shared.c"], compiler.host(), library, kept)
    return int(ctypes.CDLL(str(library)).answer()), compiled


def test_a_shared_object_is_compiled_once(tmp_path: Path) -> None:
    assert built(tmp_path / "a", 21) == (42, ["own.c", "shared.c"])
    assert built(tmp_path / "b", 4) == (8, ["own.c"])
    assert cache_info().libraries == 1
    assert built(tmp_path / "c", 4, factor=3) == (12, ["own.c", "shared.c"]), "its header has changed"


def test_a_damaged_object_is_compiled_again(tmp_path: Path, cache: Path) -> None:
    built(tmp_path / "a", 21)
    (path,) = cache.glob("*.o")
    path.write_bytes(path.read_bytes()[:50])
    assert built(tmp_path / "b", 4) == (8, ["own.c", "shared.c"])


def test_a_cache_that_cannot_be_written_is_not_needed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("ROPEWAY_CACHE", str(tmp_path / "file" / "cache"))
    assert built(tmp_path / "a", 21)[0] == 42
