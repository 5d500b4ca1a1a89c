"""ropeway: cable logging systems and material ropeways as composable components.

    import ropeway as rw

The public names are listed in `__init__.pyi`. A name is loaded when it is first used, so the import itself is light.
"""

from lazy_loader import attach_stub

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)
__version__ = "0.2.0"
