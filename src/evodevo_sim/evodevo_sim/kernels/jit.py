"""Compilation of kernels: strict floating point, no GIL, cached on disk.

Numba looks only at a function's own file when it decides whether a cached kernel is fresh, so a kernel would go on calling
an old version of a helper or constant in another file.  Here the cache directory is named by a hash of every file that
holds a kernel and of all that those import: a change in any of them compiles anew.  So does NUMBA_BOUNDSCHECK=1, which has every
index looked at, slowly, but for those of `lanes`.
"""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import time
from pathlib import Path

import numba

_ROOT = Path(__file__).resolve().parent
_KEEP_DAYS = 7.0


def kernel_sources() -> list[Path]:
    """The files that compiled kernels depend on, in a fixed order; `parameters.py` among them, which makes argument types."""
    text = {path.stem: path.read_text(encoding="utf-8") for path in _ROOT.glob("*.py")}
    wanted = {name for name in text if re.search(r"^@(kernel|lean|inlined)$", text[name], re.MULTILINE)} | {"parameters"}
    queue = list(wanted)
    while queue:
        for name in re.findall(r"^from \.(\w+) import", text[queue.pop()], re.MULTILINE):
            if name in text and name not in wanted:
                wanted.add(name)
                queue.append(name)
    return [_ROOT / f"{name}.py" for name in sorted(wanted)]


def _sources_hash() -> str:
    digest = hashlib.sha256(f"{numba.__version__} {numba.config.BOUNDSCHECK}".encode())
    for path in kernel_sources():
        digest.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()[:16]


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
