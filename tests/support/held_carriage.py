"""A carriage on a skyline, held by its mainline, as tests with inertia drop its payload."""

from __future__ import annotations

import ropeway as rw


def held_carriage(skyline: rw.Rope) -> tuple[rw.System, rw.Equilibrium]:
    """In the middle of a span of 300 m, with a payload of 700 kg; and the system at rest."""
    rig = rw.standing_skyline(
        None,
        headspar=rw.HeadSpar("head", at=(0.0, 15.0)),
        tailspar=rw.TailSpar("tail", at=(300.0, -20.0)),
        skyline=skyline,
        tension=70e3,
        carriage=rw.Carriage("carriage", mass=450.0),
        mainline=rw.Rope(mass_per_length=0.73, axial_stiffness=8e6, breaking_load=120e3),
    )
    system = rig.system(0, 150.0, 700.0)
    return system, rw.equilibrium(system, given={"carriage.x": 150.0}, solve_for="mainline.travel")
