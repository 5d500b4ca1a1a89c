"""The hydraulic drive of the tests."""

import ropeway as rw

SETTINGS = {
    "displacement": 127e-6,
    "gear_ratio": 20.0,
    "sheave_radius": 0.5,
    "relief_pressure": 250e5,
    "pump_flow": 7e-3,
    "engine_power": 60e3,
    "inertia": 800.0,
}


def hydraulic_drive(**changes: object) -> rw.HydraulicDrive:
    """The drive, with other values where they are given."""
    return rw.HydraulicDrive(**{**SETTINGS, **changes})  # type: ignore[arg-type]
