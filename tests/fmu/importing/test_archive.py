"""Archives and descriptions that mean harm, or are broken."""

import zipfile
from pathlib import Path
from typing import Any

import pytest

import ropeway as rw
from ropeway.fmu import ArchiveLimits, FmuImportError, load
from support.hostiles import described, hostile_fmu


@pytest.fixture
def text(tmp_path: Path) -> Path:
    """Stands for a binary."""
    path = tmp_path / "hostile.so"
    path.write_text("text")
    return path


def test_a_bomb_is_not_unpacked(tmp_path: Path, text: Path) -> None:
    bomb = hostile_fmu(tmp_path / "bomb.fmu", text, [("resources/zeros", bytes(20_000_000))])
    assert bomb.stat().st_size < 50_000
    with pytest.raises(FmuImportError, match=r"bomb\.fmu unpacks to \d+ times its size; at most 100 times") as ratio:
        load(bomb)
    assert "limits=rw.fmu.ArchiveLimits(ratio=...)" in ratio.value.remedy
    assert load(bomb, limits=ArchiveLimits(ratio=2000.0)).name == "hostile"
    with pytest.raises(FmuImportError, match=r"unpacks to 20 MB; at most 10 MB are allowed.*unpacked="):
        load(bomb, limits=ArchiveLimits(unpacked=10e6))
    with pytest.raises(FmuImportError, match=r"holds 3 files; at most 2 are allowed"):
        load(bomb, limits=ArchiveLimits(files=2))


def test_a_bomb_in_the_description(tmp_path: Path) -> None:
    path = tmp_path / "bomb.fmu"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("modelDescription.xml", b" " * 20_000_000)
    with pytest.raises(FmuImportError, match="times its size"):
        load(path)


@pytest.mark.parametrize("name", ["../outside", "/tmp/outside", "resources/../../outside", "C:/outside", "a\\b"])
def test_files_outside_the_folder(tmp_path: Path, text: Path, name: str) -> None:
    path = hostile_fmu(tmp_path / "path.fmu", text, [(name, b"1")])
    with pytest.raises(FmuImportError, match=r"path\.fmu has a file with the path .* not one inside its folder"):
        load(path)


@pytest.mark.parametrize("name", ["../../hostile", "/tmp/hostile", "..", "", "a\\b", "x" * 200 + "/y"])
def test_a_binary_outside_the_folder(tmp_path: Path, text: Path, name: str) -> None:
    path = hostile_fmu(tmp_path / "name.fmu", text, modelIdentifier=name)
    with pytest.raises(FmuImportError, match=r"modelIdentifier of name\.fmu is .*: it is not the name of a file"):
        load(path)


@pytest.mark.parametrize(
    ("y1", "cause"),
    [
        ('nominal="xyz"', r"nominal of 'y1' is 'xyz', which is not a finite number"),
        ('nominal="nan"', r"nominal of 'y1' is 'nan'"),
        ('start="one"', r"start of 'y1' is 'one'"),
        ('unit="m" unit="m"', "is not XML"),
        ('declaredType="Nothing"', "cannot be read"),
    ],
)
def test_values_that_are_no_numbers(tmp_path: Path, text: Path, y1: str, cause: str) -> None:
    with pytest.raises(FmuImportError, match=cause):
        load(hostile_fmu(tmp_path / "value.fmu", text, y1=y1))


def test_an_unknown_encoding(tmp_path: Path) -> None:
    path = tmp_path / "encoding.fmu"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", described().replace("UTF-8", "unknown"))
    with pytest.raises(FmuImportError, match="is not XML: unknown encoding"):
        load(path)


ENTITIES = {
    "expanding": "".join(f'<!ENTITY e{k} "{f"&e{k - 1};" * 10 if k else "x" * 10}">' for k in range(10)),
    "external": '<!ENTITY e9 SYSTEM "file:///etc/passwd">',
}


@pytest.mark.parametrize("kind", ENTITIES)
def test_entities_are_refused(tmp_path: Path, kind: str) -> None:
    text = described(y1='description="&e9;"').replace("<fmi", f"<!DOCTYPE fmi [{ENTITIES[kind]}]><fmi", 1)
    path = tmp_path / "entities.fmu"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", text)
    with pytest.raises(FmuImportError, match="is not XML"):
        load(path)


def test_broken_archives(tmp_path: Path, text: Path) -> None:
    path = hostile_fmu(tmp_path / "whole.fmu", text, [("resources/data", bytes(range(256)) * 40)])
    whole, refused = path.read_bytes(), 0
    for k in range(0, len(whole), 61):
        path.write_bytes(whole[:k] + bytes([whole[k] ^ 0x55]) + whole[k + 1 :])
        try:
            load(path)
        except FmuImportError:
            refused += 1
    assert refused > 10


@pytest.mark.parametrize("wrong", [{"unpacked": 0.0}, {"ratio": -1.0}, {"files": 0}, {"files": "many"}])
def test_bad_limits(wrong: dict[str, Any]) -> None:
    with pytest.raises(rw.InputError):
        ArchiveLimits(**wrong)
