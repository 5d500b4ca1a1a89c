"""The archive of an FMU: limits on what it unpacks to, and a checksum of its contents."""

from __future__ import annotations

import hashlib
import lzma
import struct
import zipfile
import zlib
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.fmu.errors import FmuImportError

_DESCRIPTION = "modelDescription.xml"
_BROKEN = OSError, ValueError, RuntimeError, EOFError, struct.error, zlib.error, lzma.LZMAError, zipfile.BadZipFile
"""Errors that a broken archive causes."""
_SMALL = 10e6
"""Unpacked size below which the ratio does not matter [bytes]."""


@checked
@dataclass(frozen=True)
class ArchiveLimits:
    """Limits on the archive of an FMU, against files that unpack to far more than they are.

    Parameters
    ----------
    unpacked : float, default 2e9
        Largest size of all unpacked files [bytes].
    ratio : float, default 100
        Largest ratio of the unpacked size to that of the archive; it does not matter below 10 MB.
    files : int, default 10000
        Largest number of files.

    Raises
    ------
    InputError
        A limit that is not positive.

    Examples
    --------
    >>> rw.fmu.load("span.fmu", limits=rw.fmu.ArchiveLimits(unpacked=50e6)).fmi
    '2.0'
    """

    unpacked: float = 2e9
    ratio: float = 100.0
    files: int = 10_000

    def __post_init__(self) -> None:
        for name in ("unpacked", "ratio", "files"):
            check.positive(getattr(self, name), "ArchiveLimits", name)


def read_description(path: Path, limits: ArchiveLimits) -> tuple[bytes, str]:
    """The model description of an FMU, and the checksum of its contents. Raises FmuImportError."""
    if not zipfile.is_zipfile(path):
        raise FmuImportError(f"{path.name} is not a zip archive", "Export the FMU again")
    try:
        with zipfile.ZipFile(path) as archive:
            entries = archive.infolist()
            if _DESCRIPTION not in archive.namelist():
                raise FmuImportError(f"{path.name} has no {_DESCRIPTION}", "It is a zip archive, but not an FMU")
            require_within(path, entries, limits)
            return archive.read(_DESCRIPTION), _checksum(entries)
    except _BROKEN as error:
        raise FmuImportError(f"{path.name} cannot be read: {error}", "Export the FMU again") from error


def unpack(path: Path, folder: Path, limits: ArchiveLimits, checksum: str) -> None:
    """Unpacks an FMU into a folder. Raises FmuImportError, also if its checksum is another one (unless it is empty)."""
    try:
        with zipfile.ZipFile(path) as archive:
            entries = archive.infolist()
            if checksum and _checksum(entries) != checksum:
                raise FmuImportError(f"{path.name} has changed since it was loaded", "Load it again")
            require_within(path, entries, limits)
            archive.extractall(folder)
    except _BROKEN as error:
        raise FmuImportError(f"{path.name} cannot be unpacked: {error}", "Export the FMU again") from error


def require_identifier(path: Path, identifier: str) -> None:
    """Raises FmuImportError if the name of a binary could lead out of the folder of the FMU."""
    if identifier in ("", "..") or identifier != PurePosixPath(identifier).name or set(identifier) & set('\\:\0"<>|*?'):
        raise FmuImportError(
            f"modelIdentifier of {path.name} is {identifier!r:.80}: it is not the name of a file",
            "Do not run this FMU, or export it again",
        )


def require_within(path: Path, entries: list[zipfile.ZipInfo], limits: ArchiveLimits) -> None:
    """Raises FmuImportError. `zipfile` reads no more of an entry than the size that it declares."""
    unpacked = sum(entry.file_size for entry in entries)
    ratio = unpacked / max(path.stat().st_size, 1)
    found = None
    if len(entries) > limits.files:
        found = f"holds {len(entries)} files; at most {limits.files} are allowed", "files"
    elif unpacked > limits.unpacked:
        found = f"unpacks to {unpacked / 1e6:.0f} MB; at most {limits.unpacked / 1e6:.0f} MB are allowed", "unpacked"
    elif unpacked > _SMALL and ratio > limits.ratio:
        found = f"unpacks to {ratio:.0f} times its size; at most {limits.ratio:g} times are allowed", "ratio"
    if found is not None:
        raise FmuImportError(
            f"{path.name} {found[0]}",
            f"If you trust the FMU, load it with limits=rw.fmu.ArchiveLimits({found[1]}=...)",
        )
    for entry in entries:
        name = entry.filename
        if "\\" in name or ":" in name or name.startswith("/") or ".." in PurePosixPath(name).parts:
            raise FmuImportError(
                f"{path.name} has a file with the path {name!r:.80}, which is not one inside its folder",
                "Do not run this FMU, or export it again",
            )


def _checksum(entries: list[zipfile.ZipInfo]) -> str:
    """Of names, sizes and the archive's own checksums."""
    listed = "\n".join(f"{e.filename}\t{e.file_size}\t{e.CRC}" for e in entries)
    return hashlib.sha256(listed.encode(errors="replace")).hexdigest()
