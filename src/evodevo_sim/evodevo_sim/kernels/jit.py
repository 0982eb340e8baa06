"""Compilation of kernels: strict floating point, no GIL, cached on disk.

Numba looks only at a function's own file when it decides whether a cached kernel is fresh, so a kernel would go on calling
an old version of a helper or constant in another file.  Here the cache directory is named by a hash of every file that
makes kernels and of all that those import (`_kernel_sources`): a change in any of them compiles anew.  So does NUMBA_BOUNDSCHECK=1, which has every
index looked at, slowly, but for those of `lanes`.
"""

from __future__ import annotations

import os
import shutil
import sys
import time
from pathlib import Path

import llvmlite
import numba
import numpy as np

from .sources import hash_of, package_root, sources_of_package

_ROOT = package_root(Path(__file__).resolve(), __name__)
_ARGUMENT_TYPES = ("parameters.py",)
_KEEP_DAYS = 7.0

# Besides sources, what results and speed of compiled code depend on.  Numba itself tells processors apart.
_SETTINGS = (
    numba.__version__, llvmlite.__version__, np.__version__, sys.implementation.cache_tag, numba.config.BOUNDSCHECK, numba.config.OPT,
    numba.config.LOOP_VECTORIZE, numba.config.SLP_VECTORIZE, numba.config.USING_SVML, numba.config.DEBUGINFO_DEFAULT,
)


def kernel_sources() -> list[Path]:
    """The files that compiled kernels depend on, in a fixed order."""
    return sources_of_package(_ROOT, Path(__file__).resolve(), _ARGUMENT_TYPES)


def _sources_hash() -> str:
    return hash_of(kernel_sources(), _ROOT, *_SETTINGS)


def _caches() -> Path:
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    return Path(chosen or os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "evodevo"


CACHE_DIRECTORY = _caches() / _sources_hash()


def kernel(function, **options):
    """Compile `function`: IEEE-strict, releasing the GIL, cached under `CACHE_DIRECTORY`."""
    before = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = str(CACHE_DIRECTORY)
    try:
        # Nobody calls kernels by a C pointer; to compile those wrappers takes time.
        return numba.njit(function, cache=True, nogil=True, error_model="numpy", no_cfunc_wrapper=True, **options)
    finally:
        numba.config.CACHE_DIR = before


def lean(function):
    """A kernel that allocates nothing, compiled without counting references to arrays.

    Numba counts one for every array of every tuple that a call hands over, atomically, which costs half as much as the forces
    on a small body.  A kernel that allocates is refused by the compiler here.
    """
    return kernel(function, _nrt=False)


def inlined(function):
    """A `lean` kernel whose code goes into that of each of its callers: a call hands over seven words for every array of a tuple.

    Only kernels can call it."""
    return kernel(function, _nrt=False, forceinline=True, no_cpython_wrapper=True)


def is_compiled(name: str) -> bool:
    """Whether a kernel, given as module.function, of exactly these sources is on disk already."""
    return any(CACHE_DIRECTORY.rglob(f"{name}-*.nbi"))


def remove_old_caches() -> None:
    """Delete the kernels of other versions of the sources that are more than a week old."""
    if not _caches().is_dir():
        return
    for directory in _caches().iterdir():
        if directory != CACHE_DIRECTORY and directory.stat().st_mtime < time.time() - _KEEP_DAYS * 86400:
            shutil.rmtree(directory, ignore_errors=True)
