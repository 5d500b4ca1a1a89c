"""Identifiers for dotted names, from any text."""

from __future__ import annotations

import re
import unicodedata

from ropeway.components.errors import InputError

_LETTERS = str.maketrans(
    {
        **{"ä": "ae", "ö": "oe", "ü": "ue", "Ä": "Ae", "Ö": "Oe", "Ü": "Ue", "ß": "ss", "ẞ": "SS"},
        **{"æ": "ae", "Æ": "Ae", "œ": "oe", "Œ": "Oe", "ø": "oe", "Ø": "Oe", "þ": "th", "Þ": "Th", "ð": "d", "Ð": "D"},
        **{"đ": "d", "Đ": "D", "ł": "l", "Ł": "L", "\u0131": "i"},
    }
)
_OTHER = re.compile(r"[^A-Za-z0-9_]")


def identifier(label: str) -> str:
    """The identifier of a label.

    Parameters
    ----------
    label : str
        Any text. Umlauts become ae, oe, ue and ss, accents are dropped, any other character that is not a letter, digit
        or underscore becomes an underscore; n precedes a digit at the start.

    Raises
    ------
    InputError
        The label is blank.
    """
    text = unicodedata.normalize("NFC", label.strip())
    if not text:
        raise InputError("A name is blank", "Give a name")
    plain = unicodedata.normalize("NFD", text.translate(_LETTERS))
    name = _OTHER.sub("_", "".join(c for c in plain if not unicodedata.combining(c)))
    return f"n{name}" if name[0].isdigit() else name
