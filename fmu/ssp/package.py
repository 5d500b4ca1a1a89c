"""Files of a system structure: a package (.ssp), or a description (.ssd) with the files beside it."""

from __future__ import annotations

import shutil
import zipfile
from pathlib import Path, PurePosixPath
from urllib.parse import unquote, urlsplit
from urllib.request import url2pathname

from ropeway.fmu.errors import FmuImportError
from ropeway.fmu.importing.archive import ArchiveLimits, require_within

ROOT = "SystemStructure.ssd"
"""The description that a package is opened with."""


class Package:
    """The files of a system structure, by their URIs relative to the description.

    `folder`: where files of an archive are written. Raises FmuImportError.
    """

    def __init__(self, path: str | Path, folder: Path, limits: ArchiveLimits) -> None:
        self.path, self.limits, self._folder = Path(path), limits, folder
        if not self.path.is_file():
            raise FmuImportError(f"There is no file {self.path}", "Check the path")
        self._zipped = zipfile.is_zipfile(self.path)
        if not self._zipped and self.path.suffix.lower() != ".ssd":
            raise FmuImportError(
                f"{self.path.name} is neither a zip archive nor an .ssd file", "Give a file .ssp or .ssd"
            )
        if self._zipped:
            with zipfile.ZipFile(self.path) as archive:
                require_within(self.path, archive.infolist(), limits)
        self.root = ROOT if self._zipped else self.path.name
        if self._zipped and ROOT not in self._names():
            raise FmuImportError(f"{self.path.name} has no {ROOT}", "It is a zip archive, but not an SSP")

    def _names(self) -> list[str]:
        with zipfile.ZipFile(self.path) as archive:
            return archive.namelist()

    def read(self, source: str, base: str = "") -> bytes:
        """Content of a file, by its URI relative to the folder of `base`."""
        place = self._place(source, base)
        if isinstance(place, Path):
            return place.read_bytes()
        with zipfile.ZipFile(self.path) as archive:
            return archive.read(place)

    def within(self, component: str, source: str) -> bytes:
        """Content of a file of an FMU, by its path in there."""
        archive = self.local(component)
        if not zipfile.is_zipfile(archive):
            raise FmuImportError(f"{component} is not a zip archive", "Export the SSP again")
        with zipfile.ZipFile(archive) as opened:
            require_within(archive, opened.infolist(), self.limits)
            try:
                return opened.read(unquote(source))
            except KeyError as error:
                raise FmuImportError(f"{component} has no file {source!r}", "Export the SSP again") from error

    def nested(self, source: str, base: str) -> Package:
        """A package inside this one."""
        return Package(self.local(source, base), self._folder, self.limits)

    def local(self, source: str, base: str = "") -> Path:
        """A file on the disk: one of an archive is written into the folder, under a name of its own."""
        place = self._place(source, base)
        if isinstance(place, Path):
            return place
        written = self._folder / f"{len(list(self._folder.iterdir()))}-{PurePosixPath(place).name}"
        with zipfile.ZipFile(self.path) as archive, archive.open(place) as content, written.open("wb") as file:
            shutil.copyfileobj(content, file)
        return written

    def inside(self, source: str, base: str = "") -> str:
        """A URI relative to the description of the package."""
        return str(PurePosixPath(base).parent / unquote(source))

    def _place(self, source: str, base: str) -> Path | str:
        """A file on the disk, or a member of the archive."""
        uri = urlsplit(source)
        if uri.scheme == "file":
            return self._existing(Path(url2pathname(uri.path)), source)
        if uri.scheme or uri.netloc:
            raise FmuImportError(
                f"{self.path.name} refers to {source}, which is not a file", "Put the file into the SSP"
            )
        place = self.inside(uri.path, base)
        if not self._zipped:
            return self._existing(self.path.parent / place, source)
        if place not in self._names():
            raise FmuImportError(f"{self.path.name} has no file {place!r}", f"It has {', '.join(self._names()[:12])}")
        return place

    def _existing(self, path: Path, source: str) -> Path:
        if not path.is_file():
            raise FmuImportError(f"{self.path.name} refers to {source}: there is no file {path}", "Check the path")
        return path
