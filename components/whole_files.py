"""Files are written whole or not at all."""

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
    """A path to write a file to, which takes the place of `path` when the block ends without an error.

    The file is made in the same folder and moved in one step: readers see the old file or the new one. After an
    error nothing of it is left, and what was at `path` before is unchanged. What is no ordinary file, as a pipe, is
    written to as it is.

    Parameters
    ----------
    path : str or Path
        The file to write. A link stays a link: what it points to is replaced.

    Raises
    ------
    WriteError
        The file could not be written: no folder, no permission, a full disk.
    """
    target = beside = Path(path)
    if target.is_file() or not target.exists():
        target = target.resolve()
        # The end of the name says in what format some writers write.
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
            f"{path} cannot be written: {reason}", "Choose a folder that can be written to and has room"
        ) from error
    finally:
        if beside is not target:
            beside.unlink(missing_ok=True)
