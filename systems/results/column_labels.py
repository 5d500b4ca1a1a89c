"""Units and descriptions of a frame's columns."""

from __future__ import annotations

from typing import Any, NoReturn

from ropeway.components.errors import InputError


class Labels(dict[str, str]):
    """A dictionary that does not change. pandas copies all that is in `attrs` deeply at every operation on a frame,
    which takes longer the more columns there are; what does not change need not be copied."""

    def __deepcopy__(self, memo: dict[int, Any]) -> Labels:
        return self

    def __reduce__(self) -> tuple[type[Labels], tuple[dict[str, str]]]:
        return Labels, (dict(self),)

    def _refuse(self, *args: Any, **named: Any) -> NoReturn:
        raise InputError(
            "The labels of a frame are shared by its copies and do not change",
            'Give the frame others: frame.attrs["units"] = {**frame.attrs["units"], "column": "kN"}',
        )

    __setitem__ = __delitem__ = __ior__ = update = setdefault = _refuse
    pop = popitem = clear = _refuse
