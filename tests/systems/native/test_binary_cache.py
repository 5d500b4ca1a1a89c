"""Compiled libraries are cached, checked, and compiled again if damaged."""

import ctypes
import subprocess
import sys
from pathlib import Path

import pytest

from ropeway.components.errors import CompilerError, WriteError
from ropeway.systems.native import binary_cache
from ropeway.systems.native.binary_cache import cache_info, clear_cache, libraries, library

SOURCE = {"answer.c": '__attribute__((visibility("default"))) int answer(void) { return %d; }\n'}


def answer(value: int) -> int:
    found = library({name: text % value for name, text in SOURCE.items()})
    return int(found.answer())


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A separate cache without loaded libraries."""
    monkeypatch.setenv("ROPEWAY_CACHE", str(tmp_path / "cache"))
    binary_cache._loaded.cache_clear()
    return tmp_path / "cache"


def kept(folder: Path) -> Path:
    (path,) = folder.glob("ropeway-*")
    return path


def test_libraries_are_compiled_side_by_side() -> None:
    sources = [{"answer.c": SOURCE["answer.c"] % value} for value in (5, 6, 7)]
    assert [found.answer() for found in libraries(sources)] == [5, 6, 7]
    assert cache_info().libraries == 3
    with pytest.raises(CompilerError, match="failed"):
        libraries([*sources, {"answer.c": "int answer("}])


def test_a_library_is_compiled_once(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert answer(41) == 41
    binary_cache._loaded.cache_clear()
    monkeypatch.setattr(binary_cache.compiler, "compile_library", None)  # would fail
    assert answer(41) == 41
    info = cache_info()
    assert (info.folder, info.libraries) == (folder, 1)
    assert info.size == kept(folder).stat().st_size
    assert clear_cache() == 1
    assert cache_info().libraries == 0


def test_a_truncated_file_is_compiled_again(folder: Path) -> None:
    assert answer(42) == 42
    whole = kept(folder).read_bytes()
    kept(folder).unlink()
    cut = folder / next(iter(["ropeway-x.so"]))
    cut.write_bytes(whole[:100])
    binary_cache._loaded.cache_clear()
    assert answer(42) == 42
    path = next(p for p in folder.glob("ropeway-*") if p != cut)
    path.rename(path)  # its content no longer has the digest of its name
    path.chmod(0o644)
    replaced = folder / "new"
    replaced.write_bytes(whole[: len(whole) // 2])
    replaced.replace(path)
    binary_cache._loaded.cache_clear()
    assert answer(42) == 42
    assert path.read_bytes() == whole


def test_another_processor_or_compiler_has_separate_libraries(monkeypatch: pytest.MonkeyPatch) -> None:
    assert answer(43) == 43
    monkeypatch.setattr(binary_cache, "processor", lambda: "another")
    assert answer(43) == 43
    monkeypatch.setenv("CFLAGS", "-O1")
    assert answer(43) == 43
    assert cache_info().libraries == 3


def test_a_cache_that_cannot_be_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("ROPEWAY_CACHE", str(tmp_path / "file" / "cache"))
    with pytest.raises(WriteError, match="ROPEWAY_CACHE"):
        answer(44)


@pytest.mark.parametrize(("compiler", "words"), [("no-such-compiler", "cannot be started"), ("false", "failed")])
def test_a_missing_or_bad_compiler(compiler: str, words: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CC", compiler)
    with pytest.raises(CompilerError, match=words):
        answer(45)


def test_two_processes_at_once(folder: Path) -> None:
    code = (
        "from ropeway.systems.native.binary_cache import library;"
        f"print(library({ {name: text % 46 for name, text in SOURCE.items()}!r}).answer())"
    )
    both = [subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) for _ in range(2)]
    assert [process.communicate()[0].strip() for process in both] == ["46", "46"]
    assert cache_info().libraries == 1
    assert isinstance(ctypes.CDLL(str(kept(folder))).answer(), int)


def test_asking_a_compiler_for_its_version_leaves_no_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The one of ziglang leaves an empty a.o where it runs when it compiles for macOS."""
    untidy, here = tmp_path / "untidy", tmp_path / "here"
    untidy.write_text("#!/bin/sh\ntouch a.o\necho 1.0\n")
    untidy.chmod(0o755)
    here.mkdir()
    monkeypatch.chdir(here)
    assert binary_cache.version_of((str(untidy),))[-1] == "1.0\n"
    assert not list(here.iterdir())
