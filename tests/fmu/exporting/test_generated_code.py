"""The C of an FMU: functions of components are the same for all lines; a line by sections needs no Jacobian."""

import ropeway as rw
from ropeway.fmu.exporting.equations import ModelEquations
from ropeway.fmu.exporting.generated_code import c_files
from support.fmus import ROPE


def files(spans: int) -> dict[str, str]:
    """Generated C of a line over idlers."""
    s = rw.System("line")
    nodes = [rw.Sheave(f"s{k}", at=(100.0 * k, 3.0 * (k % 2))) for k in range(1, spans)]
    s.string(ROPE, rw.Drum("a", at=(0, 0), speed=1.0), *nodes, rw.Drum("b", at=(100.0 * spans, 5.0)), tension=45e3)
    equations = ModelEquations.at(rw.equilibrium(s))
    assert equations.by_sections is not None
    return {**c_files(equations.functions), **equations.by_sections.sources}


def test_lines_of_the_same_kinds_share_their_functions() -> None:
    three, five = files(3), files(5)
    shared = {name for name in three if name.startswith(("rw_part_", "rw_span_", "rw_support_"))}
    assert len(shared) >= 6
    assert {name: three[name] for name in shared} == {
        name: text for name, text in five.items() if name in shared or name.startswith("rw_part_")
    }
    assert three["rw_dae.c"] != five["rw_dae.c"]
    assert "sqrt(" not in five["rw_dae.c"] + five["rw_tangent.c"], "functions of components are files of their own"


def test_a_line_by_sections_has_no_jacobian() -> None:
    assert "rw_jacobian.c" not in files(3)
    s = rw.System("with a spring")
    s.string(ROPE, rw.SpringAnchor("a", at=(0, 0), stiffness=2e5), rw.Anchor("b", at=(100.0, 0.0)), length=101.0)
    equations = ModelEquations.at(rw.equilibrium(s))
    assert equations.by_sections is None
    assert "rw_jacobian.c" in c_files(equations.functions)
