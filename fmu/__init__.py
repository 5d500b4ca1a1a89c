"""Functional Mock-up Units: export of systems, import, co-simulation.

The public names are listed in `__init__.pyi`. A name is loaded when it is first used.
"""

from lazy_loader import attach_stub

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)
