"""Compilation of kernels: strict floating point, no GIL, cached on disk.

Numba looks only at a function's own file when it decides whether a cached kernel is fresh, so a kernel would go on calling
an old version of a helper or constant in another file.  Here the cache directory is named by a hash of every file that
makes kernels and of all that those import (`_kernel_sources`): a change in any of them compiles anew.  So does NUMBA_BOUNDSCHECK=1,
which has every index looked at, slowly, but for those of `lanes`.  Where the package lies plays no part: copies with
equal sources share their kernels.  What is found on disk is checked before it is used (`_kernel_cache`).

Kernels of other packages and files, made with the decorators here, have a directory each for their sources and these.
"""

from __future__ import annotations

import hashlib
import os
import sys
import time
from contextlib import suppress
from functools import lru_cache, partial
from pathlib import Path

import llvmlite
import numba
import numpy as np
from numba.core.dispatcher import Dispatcher

from .apart import call_by_address, without_constants
from .cache import SUFFIX, KernelCache, NotKept, remove, tell_once, unwritable, why_unwritable, write_whole
from .progress import attend
from .sources import hash_of, package_root, sources_of_file, sources_of_package, top_folder

_ROOT = package_root(Path(__file__).resolve(), __name__)
_KEEP_DAYS = 7.0

# Besides sources, what results and speed of compiled code depend on.  Each entry knows its processor.
_CONFIGURED = ("BOUNDSCHECK", "OPT", "LOOP_VECTORIZE", "SLP_VECTORIZE", "USING_SVML", "DEBUGINFO_DEFAULT")
_SETTINGS = (
    numba.__version__, llvmlite.__version__, np.__version__, sys.implementation.cache_tag,
    *(getattr(numba.config, name, None) for name in _CONFIGURED),
)


def kernel_sources() -> list[Path]:
    """The files that compiled kernels depend on, in a fixed order."""
    return sources_of_package(_ROOT, Path(__file__).resolve())


def _caches() -> Path | None:
    """The directory of all caches, None where there is no home."""
    chosen, shared = os.environ.get("NUMBA_CACHE_DIR"), os.environ.get("XDG_CACHE_HOME", "")
    try:
        return Path(chosen or (shared if os.path.isabs(shared) else Path.home() / ".cache")).absolute() / "evodevo"
    except (RuntimeError, OSError):
        return None


def _remembered_sources() -> list[Path]:
    """`kernel_sources()`, from a list on disk where the package has not changed since it was made: to find them takes 0.2 s."""
    everything = sorted(_ROOT.rglob("*.py"))
    caches = _caches()
    if caches is None:
        return kernel_sources()
    place = caches / f"sources-{hash_of(everything, _ROOT, sys.implementation.cache_tag)}.txt"
    with suppress(OSError, UnicodeDecodeError):
        digest, _, names = place.read_text(encoding="utf-8").partition("\n")
        if digest == _digest(names):
            return [_ROOT / name for name in names.splitlines()]
    found = kernel_sources()
    names = "".join(f"{path.relative_to(_ROOT).as_posix()}\n" for path in found)
    with suppress(OSError):
        write_whole(place, f"{_digest(names)}\n{names}".encode())
    return found


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


def _used(directory: Path | None) -> Path | None:
    """The same directory, kept from `remove_old_caches` for another while."""
    if directory:
        with suppress(OSError):
            os.utime(directory)
    return directory


_SOURCES = frozenset(_remembered_sources())
_HASH = hash_of(_SOURCES, _ROOT, *_SETTINGS)
_CACHES = _caches()
CACHE_DIRECTORY = _used(_CACHES / _HASH if _CACHES else None)


@lru_cache(maxsize=1000)
def _resolved(name: str) -> Path:
    return Path(name).resolve()


def _place(name: str, changed: bool) -> Path | None:
    """The directory for kernels of a file, None where there is no home.

    Args: changed: ask whether the sources are still those that this process has read.
    Raises: NotKept for no file, as in a notebook, and for sources that have changed.
    """
    file = _resolved(name)
    try:
        if changed and hash_of(_SOURCES, _ROOT, *_SETTINGS) != _HASH:
            raise NotKept("its sources have changed")
        if file in _SOURCES:
            return CACHE_DIRECTORY
        if not file.is_file():
            raise NotKept("its sources are not known")
        if CACHE_DIRECTORY is None:
            return None
        sources = sources_of_file(file, besides="" if file.is_relative_to(_ROOT) else _ROOT.name)
        return _used(CACHE_DIRECTORY.parent / f"{file.stem}-{hash_of(sources, top_folder(file), _HASH)}")
    except OSError as error:
        raise NotKept("its sources cannot be read") from error


def kernel(function, **options):
    """Compile `function`: IEEE-strict, releasing the GIL, cached under `CACHE_DIRECTORY`, called by other kernels by address."""
    return _compiled(function, apart=True, **options)


def lean(function):
    """A kernel that allocates nothing, compiled without counting references to arrays.

    Numba counts one for every array of every tuple that a call hands over, atomically, which costs half as much as the forces
    on a small body.  A kernel that allocates is refused by the compiler here.
    """
    return _compiled(function, apart=False, _nrt=False)


def seam(function):
    """A `lean` kernel that others call by address, as they do a `kernel`: for what is large and seldom called."""
    return _compiled(function, apart=True, _nrt=False)


def inlined(function):
    """A `lean` kernel whose code goes into that of each of its callers: a call hands over seven words for every array of a tuple.

    Only kernels can call it."""
    return _compiled(function, apart=False, _nrt=False, forceinline=True, no_cpython_wrapper=True)


def _compiled(function, apart, **options):
    # Nobody calls kernels by a C pointer; to compile those wrappers takes time.
    options = {"nogil": True, "error_model": "numpy", "no_cfunc_wrapper": True} | options
    compiled = numba.njit(function, **options)
    if not isinstance(compiled, Dispatcher):  # so under NUMBA_DISABLE_JIT
        return compiled
    compiled._cache = KernelCache(function, options, partial(_place, function.__code__.co_filename))
    # What takes arguments from Python is compiled where Python calls, not where kernels do.
    options["no_cpython_wrapper"] = True
    called = numba.njit(function, **options)
    called._cache = KernelCache(function, options, partial(_place, function.__code__.co_filename))
    if apart:
        call_by_address(called)
    if not options.get("forceinline"):
        without_constants(called)
    attend(compiled, from_python=True)
    attend(called, from_python=False)
    compiled.for_kernels, compiled.get_call_template, compiled.get_overload = called, called.get_call_template, called.get_overload
    return compiled


def is_compiled(name: str) -> bool:
    """Whether a kernel, given as module.function, of exactly these sources is on disk already."""
    try:
        entries = os.listdir(CACHE_DIRECTORY) if CACHE_DIRECTORY else []
    except OSError:
        return False
    return any(f".{entry}".rpartition("-")[0].endswith(f".{name}") for entry in entries if entry.endswith(SUFFIX))


def compiling(name: str, what: str = "simulation kernels", time: str = "half a minute to a minute") -> str:
    """What to tell a user who waits for a kernel, given as module.function, "" where it is on disk already.

    Args: what: is compiled; time: that it takes.
    """
    if is_compiled(name):
        return ""
    why = why_unwritable(CACHE_DIRECTORY)
    if not why:
        return f"Compiling the {what}, once: {time}."
    tell_once("unwritable")
    return f"Compiling the {what}: {time}.  {unwritable(CACHE_DIRECTORY, why)}"


def remove_old_caches() -> None:
    """Delete the kernels of other versions of the sources that nobody used for more than a week, and what killed processes left."""
    caches, week, day = _caches(), _KEEP_DAYS * 86400, 86400
    for directory, pattern, age in ((caches, "*", week), (caches, "*.tmp", day), (CACHE_DIRECTORY, "*.tmp", day)):
        for path in directory.glob(pattern) if directory else ():
            with suppress(OSError):  # another process does the same
                if path != CACHE_DIRECTORY and path.stat().st_mtime < time.time() - age:
                    remove(path)
