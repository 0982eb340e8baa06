"""Compilation of kernels: strict floating point, no GIL, cached on disk.

Numba looks only at a function's own file when it decides whether a cached kernel is fresh, so a kernel would go on calling
an old version of a helper in another file.  Here the cache directory is named by a hash of every source file of the package:
any change anywhere compiles anew.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import time
from pathlib import Path

import numba

_ROOT = Path(__file__).resolve().parent
_KEEP_DAYS = 7.0


def _sources_hash() -> str:
    digest = hashlib.sha256(numba.__version__.encode())
    for path in sorted(_ROOT.glob("*.py")):
        digest.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()[:16]


def _caches() -> Path:
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "evodevo"


CACHE_DIRECTORY = Path(os.environ.get("NUMBA_CACHE_DIR") or _caches() / _sources_hash())


def kernel(function):
    """Compile `function`: IEEE-strict, releasing the GIL, cached under `CACHE_DIRECTORY`."""
    before = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = str(CACHE_DIRECTORY)
    try:
        return numba.njit(function, cache=True, nogil=True, error_model="numpy")
    finally:
        numba.config.CACHE_DIR = before


def is_compiled() -> bool:
    """Whether kernels of exactly these sources are on disk already."""
    return any(CACHE_DIRECTORY.rglob("*.nbi"))


def remove_old_caches() -> None:
    """Delete the kernels of other versions of the sources that nobody has used for a week."""
    if not _caches().is_dir():
        return
    for directory in _caches().iterdir():
        if directory != CACHE_DIRECTORY and directory.stat().st_mtime < time.time() - _KEEP_DAYS * 86400:
            shutil.rmtree(directory, ignore_errors=True)
