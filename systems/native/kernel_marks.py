"""What determines a kernel, as text: a kernel that is kept in the cache is then found without being generated."""

from __future__ import annotations

from collections.abc import Hashable
from enum import Enum
from functools import lru_cache
from hashlib import sha256
from pathlib import Path

import casadi as ca

_PACKAGE = Path(__file__).parents[2]
_CODE = ("components", "systems/modelling", "systems/solvers", "systems/native")
"""Folders of this package that have a part in a kernel."""


def kernel_mark(*parts: Hashable) -> str | None:
    """The mark of a kernel by what it is made from: classes of this package, numbers, text. None where that does not
    determine it, as a class of the user's: its code may change."""
    found = _text(parts)
    return None if found is None else f"{found} {_code()}"


def _text(part: Hashable) -> str | None:
    if isinstance(part, tuple):
        texts = [_text(each) for each in part]
        return None if None in texts else f"({', '.join(map(str, texts))})"
    if isinstance(part, type):
        name = f"{part.__module__}.{part.__qualname__}"
        return name if name.startswith("ropeway.") and "<locals>" not in name else None
    if isinstance(part, Enum):
        return str(part)
    return repr(part) if part is None or type(part) in (bool, int, float, str) else None


@lru_cache(maxsize=1)
def _code() -> str:
    """Versions of the code that makes kernels."""
    digest = sha256(ca.__version__.encode())
    for folder in _CODE:
        for path in sorted((_PACKAGE / folder).rglob("*.py")):
            digest.update(path.read_bytes())
    return digest.hexdigest()
