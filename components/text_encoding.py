"""Recognise the encoding of a text file, or ask for UTF-8, so that no label is garbled silently."""

from __future__ import annotations

import re
import warnings
from pathlib import Path

from ropeway.components.errors import InputError, RopewayWarning

_MARKS = (
    (b"\xef\xbb\xbf", "utf-8-sig"),
    (b"\xff\xfe\0\0", "utf-32"),
    (b"\0\0\xfe\xff", "utf-32"),
    (b"\xff\xfe", "utf-16"),
    (b"\xfe\xff", "utf-16"),
)
"""Byte order marks."""
_CONTROL = re.compile(r"[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x84\x86-\x9f]")
_SHARED = frozenset("äöüßéíóúâîôçë")
"""Letters with the same code in Windows-1252, Windows-1250 (Central Europe) and Windows-1254 (Turkey). á is excluded:
it is the ß of DOS."""
_ALPHABETS = tuple(
    frozenset("äöüß" + letters)
    for letters in (
        "àâæçéèêëîïôœùû",  # French
        "àèéìíîòóùú",  # Italian
        "áéíóúñçàèòï",  # Spanish, Catalan
        "áàâãçéêíóôõú",  # Portuguese
        "æøåéàèêóòô",  # Danish, Norwegian, Swedish, Finnish
        "áâéèêëíîïóôúû",  # Dutch
    )
)
"""Letters of Western languages besides a to z. German ones occur in names of places and makers in any language."""
_FOREIGN = "[À-ÖØ-öø-ÿŒœŠšŽžŸƒ]"
_LETTER = f"[A-Za-z{_FOREIGN[1:]}"
_BEFORE = r"\xa2-\xa6\xa8-\xaa\xac\xae\xaf\xb1-\xb4\xb6\xb8-\xba\xbc-\xbe\xf7\u2020\u2021\u02c6\u2030\u02dc\u2122"
_AFTER = r"\xa1\xa3-\xa6\xa8\xac\xaf\xb1\xb4\xb6\xb8\xb9\xbc-\xbf\u201a\u201e\u2020\u2021\u02c6\u2030\u02dc"
"""Characters that never precede or follow a word."""
_WORD = re.compile(rf"{_LETTER}+")
_GARBLED = re.compile(
    rf"{_LETTER}[^\x00-\x7f\xa0\xad\xb5\xb7\u2013\u2014\u2019{_LETTER[1:-1]}]{_LETTER}"  # Pi¹ta
    rf"|[{_BEFORE}]{_LETTER}|{_LETTER}[{_AFTER}]"  # ³ódka, Pary¿
    r"|[a-z\xdf-\xff][\u2013\u2014][a-z\xdf-\xff]"
    rf"|(?:{_LETTER}{{3}}|{_FOREIGN})³"  # dó³, but m³
    r"|[a-zà-öø-ÿœ][À-ÖØ-ÞŒ]"  # hÃhe
    rf"|{_FOREIGN}{{3}}|(?<!\w){_FOREIGN}{{2,}}(?!\w)"  # Îïîðà
    rf"|[ìù](?={_LETTER})"  # Vìra; Italian and French end in them
    r"|ñ(?![aeiouáéíóú])"  # Poznañ; a Spanish vowel follows
)
"""Characters that occur in words of other code pages read as Windows-1252, and never in Western languages."""


_BETWEEN = ' \t\r\n,;|"'
"""Separators of words and cells."""


def decoded(path: Path, data: bytes) -> str:
    """The text of a file.

    Parameters
    ----------
    path : Path
        Name for messages.
    data : bytes
        Content of the file: UTF-8, UTF-16 or UTF-32, else Windows-1252, which includes Latin-1.

    Returns
    -------
    str

    Raises
    ------
    InputError
        None of these, or as Windows-1252 it contains words of no Western language: it has another code page.

    Warns
    -----
    RopewayWarning
        As Windows-1252 it contains letters that are ambiguous: è may be č of another code page.
    """
    marked = next((name for mark, name in _MARKS if data.startswith(mark)), None)
    zeros = data[:200].count(0) * 3 > len(data[:200])  # UTF-16 without a byte order mark: every second byte is zero
    unmarked = ("utf-16-le" if data[1:2] == b"\0" else "utf-16-be") if zeros else "utf-8"
    found = _read(data, marked or unmarked)
    western = found is None and marked is None
    if western:
        found = _read(data, "cp1252")
    if found is None or _CONTROL.search(found):
        raise InputError(f"{path} is not a text file in a known encoding", "Save the table as CSV UTF-8")
    if western:
        _judge(path, found)
    return found


def _read(data: bytes, encoding: str) -> str | None:
    try:
        return data.decode(encoding)
    except UnicodeDecodeError:
        return None


def _judge(path: Path, text: str) -> None:
    """Raises InputError for a text that Windows-1252 garbles, and warns where it is ambiguous."""
    words = {word: {c for c in word.lower() if c > "\x7f"} for word in _WORD.findall(text)}
    letters = set[str]().union(*words.values())
    unsure = next((word for word, own in words.items() if not own <= _SHARED), "")
    garbled = _GARBLED.search(text)
    if garbled or not any(letters <= alphabet for alphabet in _ALPHABETS):
        sample = _around(text, *garbled.span()) if garbled else unsure
        raise InputError(
            f"{path} has an unknown encoding: it is not UTF-8, and as Windows-1252 it contains {sample!r}, "
            "which is not of a Western language",
            "Save the table as CSV UTF-8",
        )
    if unsure:
        warnings.warn(
            f"{path} is not UTF-8: it is read as Windows-1252, which gives names such as {unsure!r}. "
            "If they are wrong, save it as CSV UTF-8",
            RopewayWarning,
            stacklevel=2,
        )


def _around(text: str, begin: int, end: int) -> str:
    """The cell or word around a position."""
    left = max(text.rfind(mark, 0, begin) for mark in _BETWEEN) + 1
    right = min(place for mark in _BETWEEN if (place := (text + mark).find(mark, end)) >= 0)
    return text[left:right]
