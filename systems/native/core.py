"""The source files of the C core, which are independent of FMI."""

from pathlib import Path

INSIDE = ("sections.c", "inertial_system.c", "inertial_steps.c")
"""Lines by sections, and systems with inertia: below all others."""
SOURCES = (
    "ropeway_sparse.c",
    "ropeway_log.c",
    "ropeway_slots.c",
    "ropeway_functions.c",
    "ropeway_lines.c",
    "ropeway_inertial.c",
    "ropeway_solve.c",
    "ropeway_places.c",
    "ropeway_evaluate.c",
    "ropeway_integrator.c",
    "ropeway_zones.c",
    "ropeway_loads.c",
    "ropeway_trajectory.c",
    "ropeway_ahead.c",
    "ropeway_step.c",
    "ropeway_instance.c",
)
"""Compiled besides the generated equations and tables; each calls only those before it."""
_HEADERS = ("sections.h", "inertial.h", "ropeway.h")
_FOLDER = Path(__file__).parent


def core_files() -> dict[str, str]:
    """Text of each source and header, by name. Of an FMU's library only the standard's functions are visible."""
    files = {name: (_FOLDER / name).read_text() for name in (*INSIDE, *SOURCES, *_HEADERS)}
    return {**files, **{name: f"#define RS_INSIDE\n{files[name]}" for name in INSIDE}}
