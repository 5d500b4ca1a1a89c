"""The C of an FMU: kernels of components are the same for all lines, and how they are joined is in tables."""

from pathlib import Path
from typing import Any

import pytest

import ropeway as rw
from ropeway.components.errors import CompiledError
from ropeway.fmu.exporting import networks
from ropeway.fmu.exporting.equations import ModelEquations
from support.fmus import ROPE, one_span


def equations(spans: int) -> ModelEquations:
    """Those of a line over idlers."""
    s = rw.System("line")
    nodes = [rw.Sheave(f"s{k}", at=(100.0 * k, 3.0 * (k % 2))) for k in range(1, spans)]
    s.string(ROPE, rw.Drum("a", at=(0, 0), speed=1.0), *nodes, rw.Drum("b", at=(100.0 * spans, 5.0)), tension=45e3)
    return ModelEquations.at(rw.equilibrium(s))


def test_lines_of_the_same_kinds_need_no_other_kernels() -> None:
    three, five = equations(3), equations(5)
    assert three.by_sections is not None
    assert five.by_sections is not None
    assert len(three.networks.sources) >= 6
    assert three.networks.sources == five.networks.sources
    assert three.by_sections.sources == five.by_sections.sources
    calls = [len(own.networks.lists["all"][0].kernels) for own in (three, five)]
    assert calls[1] > calls[0]


def test_a_line_by_sections_has_no_kernels_for_a_jacobian() -> None:
    assert equations(3).networks.lists["matrix"] == []
    s = rw.System("with a spring")
    s.string(ROPE, rw.SpringAnchor("a", at=(0, 0), stiffness=2e5), rw.Anchor("b", at=(100.0, 0.0)), length=101.0)
    general = ModelEquations.at(rw.equilibrium(s))
    assert general.by_sections is None
    (matrix,) = general.networks.lists["matrix"]
    assert any(matrix.entries)


def test_an_equation_without_a_form_in_c(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def without_a_form(*_: Any, **__: Any) -> None:
        raise CompiledError("An equation of 'own' has no form in C", "Leave out compiled=True")

    monkeypatch.setattr(networks, "swept_network", without_a_form)
    with pytest.raises(rw.fmu.FmuExportError, match="'own' has no form in C") as failed:
        rw.fmu.export(one_span(), tmp_path / "own.fmu", platforms=())
    assert "compiled" not in failed.value.remedy
