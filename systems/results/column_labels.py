"""Units and descriptions of a frame's columns."""

from __future__ import annotations

from typing import Any, NoReturn

from ropeway.components.errors import InputError


class Labels(dict[str, str]):
    """An immutable dictionary. pandas makes a deep copy of `attrs` in every operation on a frame, which takes time in
    proportion to the columns. An immutable object needs no copy."""

    def __deepcopy__(self, memo: dict[int, Any]) -> Labels:
        return self

    def __reduce__(self) -> tuple[type[Labels], tuple[dict[str, str]]]:
        return Labels, (dict(self),)

    def _refuse(self, *args: Any, **named: Any) -> NoReturn:
        raise InputError(
            "The labels of a frame are shared with its copies and cannot change",
            'Assign new labels: frame.attrs["units"] = {**frame.attrs["units"], "column": "kN"}',
        )

    __setitem__ = __delitem__ = __ior__ = update = setdefault = _refuse
    pop = popitem = clear = _refuse
