"""Files that are written whole or not at all."""

from __future__ import annotations

import os
import tempfile
from contextlib import contextmanager
from pathlib import Path

from .command_process import if_ended


@contextmanager
def written_whole(path: str | os.PathLike, ending: str = ""):
    """The name of a temporary file that takes the place of `path` when all went well, and vanishes when not.  Raises OSError."""
    path = Path(path)
    handle, name = tempfile.mkstemp(ending, f".{path.stem}-", path.parent)
    os.close(handle)
    try:
        with if_ended(Path(name).unlink):
            yield name
        os.chmod(name, 0o666 & ~_mask())
        os.replace(name, path)
    finally:
        Path(name).unlink(missing_ok=True)


def _mask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
