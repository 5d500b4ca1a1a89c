"""Functional Mock-up Units: export of systems, import, co-simulation."""

from ropeway.fmu.export import export

__all__ = ["export"]
