"""Kernels are found in the cache by what they are made from, and only where that determines them."""

from collections.abc import Mapping
from pathlib import Path

import pytest

import ropeway as rw
from ropeway.components.variable import Kind
from ropeway.systems.native import binary_cache, kernel_marks
from ropeway.systems.native.binary_cache import cache_info, named_library
from ropeway.systems.native.kernel_marks import kernel_mark


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A separate cache without loaded libraries."""
    monkeypatch.setenv("ROPEWAY_CACHE", str(tmp_path / "cache"))
    binary_cache._loaded.cache_clear()
    return tmp_path / "cache"


def files() -> dict[str, str]:
    return {"answer.c": '__attribute__((visibility("default"))) int answer(void) { return 47; }\n'}


def unexpected() -> Mapping[str, str]:
    raise AssertionError("the files are not needed")


def test_files_are_made_once() -> None:
    assert named_library("a mark", files).answer() == 47
    binary_cache._loaded.cache_clear()
    assert named_library("a mark", unexpected).answer() == 47
    with pytest.raises(AssertionError):
        named_library("another mark", unexpected)


def test_a_library_that_cannot_be_loaded(folder: Path) -> None:
    named_library("a mark", files)
    (path,) = folder.glob("ropeway-*")
    content = b"not a library"
    name = path.name.rpartition("-")[0]
    path.unlink()
    (folder / f"{name}-{binary_cache._digest(content)}{path.suffix}").write_bytes(content)
    binary_cache._loaded.cache_clear()
    with pytest.raises(rw.CompilerError, match=r"cannot be loaded.*ropeway cache clear"):
        named_library("a mark", unexpected)
    assert cache_info().libraries == 1


def test_marks_tell_forms_apart(monkeypatch: pytest.MonkeyPatch) -> None:
    class Own(rw.Sheave):
        pass

    sheave = (rw.Sheave, (True, 1.0), Kind.PARAMETER, None)
    mark = kernel_mark("support", sheave)
    assert mark == kernel_mark("support", (rw.Sheave, (True, 1.0), Kind.PARAMETER, None))
    assert len({mark, kernel_mark("span", sheave), kernel_mark("support", (rw.Sheave, (1, 1.0)))}) == 3
    assert kernel_mark("support", (Own, True)) is None
    assert kernel_mark("support", (rw.Sheave, frozenset([1]))) is None
    monkeypatch.setattr(kernel_marks, "_code", lambda: "other code")
    assert kernel_mark("support", sheave) != mark
