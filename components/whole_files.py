"""Files are written completely or not at all."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from uuid import uuid4

from ropeway.components.errors import WriteError


@contextmanager
def whole(path: str | Path) -> Iterator[Path]:
    """A path to write a file to, which replaces `path` when the block ends without an error.

    The file is written in the same folder and moved in one step: readers see the old or the new file. After an error it
    is removed, and the file at `path` is unchanged. A pipe or device is written directly.

    Parameters
    ----------
    path : str or Path
        The file to write. A symbolic link is kept: its target is replaced.

    Yields
    ------
    Path
        The temporary file.

    Raises
    ------
    WriteError
        The file could not be written: no folder, no permission, a full disk.
    """
    target = beside = Path(path)
    if target.is_file() or not target.exists():
        target = target.resolve()
        # Some writers choose their format by the suffix.
        beside = target.with_name(f".{uuid4().hex[:8]}-{target.name}")
    try:
        yield beside
        if beside is not target:
            if target.exists():
                shutil.copymode(target, beside)
            os.replace(beside, target)
    except WriteError:
        raise
    except OSError as error:
        reason = error.strerror or str(error)
        raise WriteError(
            f"{path} cannot be written: {reason}", "Choose a folder with write permission and free space"
        ) from error
    finally:
        if beside is not target:
            beside.unlink(missing_ok=True)
