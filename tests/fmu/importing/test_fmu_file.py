"""Reading FMUs, and what a bad one gets."""

import zipfile
from pathlib import Path

import pytest

import ropeway as rw
from ropeway.fmu import FmuImportError, FmuRunError, FmuVariableError, Slave, export, load
from support.fmus import one_span


def test_variables_as_a_table(line2: Path, line3: Path) -> None:
    for path, version in ((line2, "2.0"), (line3, "3.0")):
        fmu = load(path)
        assert (fmu.name, fmu.fmi, fmu.kinds) == ("line", version, ("ModelExchange", "CoSimulation"))
        row = fmu.variable("c1.tension_in")
        assert (row["kind"], row["causality"], row["unit"]) == ("Real", "output", "N")
        assert fmu.names("input")[-1] == "c4.speed"
        assert fmu.units["N"].base() == {"kg": 1, "m": 1, "s": -2}


def test_missing_variable_is_named(line2: Path) -> None:
    with pytest.raises(FmuVariableError, match=r"line2\.fmu has no variable 'c1\.tensoin'.*c1\.tension_in") as caught:
        load(line2).variable("c1.tensoin")
    assert caught.value.variable == "c1.tensoin"


def write(path: Path, files: dict[str, str]) -> Path:
    with zipfile.ZipFile(path, "w") as archive:
        for name, text in files.items():
            archive.writestr(name, text)
    return path


def test_what_is_not_an_fmu(tmp_path: Path) -> None:
    text = tmp_path / "text.fmu"
    text.write_text("no zip")
    cases = {
        tmp_path / "none.fmu": "There is no file",
        text: "not a zip",
        write(tmp_path / "empty.fmu", {"a": "b"}): "has no modelDescription",
        write(tmp_path / "broken.fmu", {"modelDescription.xml": "<"}): "is not XML",
        write(tmp_path / "old.fmu", {"modelDescription.xml": '<fmiModelDescription fmiVersion="1.0"/>'}): "version 1.0",
        write(
            tmp_path / "bare.fmu", {"modelDescription.xml": '<fmiModelDescription fmiVersion="2.0"/>'}
        ): "cannot be read",
    }
    for path, cause in cases.items():
        with pytest.raises(FmuImportError, match=cause):
            load(path)


def test_no_binary_for_this_platform(tmp_path: Path) -> None:
    path = export(one_span(), tmp_path / "sources.fmu", platforms=())
    with pytest.raises(FmuImportError, match=r"sources\.fmu has no binary for"):
        Slave(load(path))


@pytest.mark.parametrize("kind", ["CoSimulation", "ModelExchange"])
def test_a_slave_runs(line2: Path, kind: str) -> None:
    result = rw.simulate(_line(), 10.0)
    with Slave(load(line2), kind=kind) as slave:
        slave.enter(0.0, {"c1.speed": 1.0})
        slave.leave()
        for _ in range(10):
            slave.step(1.0, {}, {})
        names = ["c1.tension_in", "c2.tension_out"]
        assert list(slave.get(names)) == pytest.approx(result.frame.iloc[-1][names].to_list(), rel=1e-8)


def _line() -> rw.System:
    from support.fmus import example_line

    return example_line()


def test_an_error_has_the_log_of_the_slave(line2: Path) -> None:
    with Slave(load(line2), "winch") as slave:
        slave.enter(0.0, {})
        with pytest.raises(FmuRunError, match=r"'winch' \(line2\.fmu\) rejected.*must be above 0"):
            slave.set({"c1.grip_friction": -1.0})
