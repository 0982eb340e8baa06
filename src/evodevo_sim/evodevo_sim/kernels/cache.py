"""Compiled kernels on disk: an entry a file, checked before it is used, written whole, and found wherever the sources are.

Numba's own cache trusts what it reads: an entry that was cut ends the process by a traceback, a flipped byte by an abort of LLVM.
It goes by absolute paths and shares an index between processes that write, and where its directory cannot be written, it falls
back to `__pycache__`, which knows nothing of other sources.  Here the name of an entry is a hash of all that tells it
apart; its directory stands for the sources.  An entry that is not as it was written is removed and compiled anew.
Where nothing can be written, kernels are compiled in memory.

An entry: MAGIC, the SHA-256 of its key, the SHA-256 of that and the content, and the content, which is a pickle by numba.
"""

from __future__ import annotations

import hashlib
import os
import pickle
import shutil
import stat
import sys
import uuid
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from numba.core import sigutils, types
from numba.core.caching import _Cache
from numba.core.compiler import CompileResult
from numba.core.dispatcher import Dispatcher
from numba.core.serialize import dumps

from .apart import Callee, Missing, callees, place

MAGIC = b"evodevo kernel 2\n"
SUFFIX = ".nbc"
ROOM = 64 << 20  # bytes; kernels of all tasks together take 36 MB
_HEAD = len(MAGIC) + 64
_told: set[str] = set()


class Damaged(Exception):
    """An entry that is not as it was written; the message says in what."""


class NotKept(Exception):
    """A kernel whose compiled code stands for this process only."""


def tell_once(about: str, line: str = "") -> None:
    """Print a line to standard error, unless something was told about this already.  Without a line: it is told elsewhere."""
    if about not in _told:
        _told.add(about)
        if line:
            with suppress(OSError, ValueError, AttributeError):  # closed, or none
                print(line, file=sys.stderr, flush=True)


def reason(error: OSError) -> str:
    """What kept a directory from being written."""
    return "a file is in its place" if isinstance(error, FileExistsError) else error.strerror or str(error) or type(error).__name__


def unwritable(directory: Path | None, why: str) -> str:
    """The line for a user whose kernels cannot be kept."""
    what = f"{_shown(directory)} cannot be written ({why})" if directory else why
    return f"{what}: kernels are compiled anew at every start; set NUMBA_CACHE_DIR."


def _shown(path: Path) -> str:
    return str(path) if len(str(path)) <= 120 else f"...{str(path)[-117:]}"


def why_unwritable(directory: Path | None) -> str:
    """Why the kernels would not be kept in a directory, "" where they would; room for all of them is asked for."""
    if directory is None:
        return "there is no home directory"
    try:
        directory.mkdir(parents=True, exist_ok=True)
        trial = directory / f"{uuid.uuid4().hex}.tmp"
        try:
            with trial.open("xb") as file:
                for _ in range(64):
                    file.write(bytes(ROOM // 64))
        finally:
            trial.unlink(missing_ok=True)
    except OSError as error:
        return reason(error)
    return ""


def read_entry(path: Path, key: bytes) -> bytes | None:
    """The content of an entry, None where there is no such file.

    Args: key: the SHA-256 of what tells the entry apart.
    Raises: Damaged, OSError.
    """
    try:
        number = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    except (FileNotFoundError, NotADirectoryError):
        return None
    with os.fdopen(number, "rb") as file:
        if not stat.S_ISREG(os.fstat(number).st_mode):
            raise Damaged("it is no file")
        head, content = file.read(_HEAD), file.read()
    found, digest = head[len(MAGIC) : -32], head[-32:]
    if len(head) < _HEAD or head[: len(MAGIC)] != MAGIC or hashlib.sha256(found + content).digest() != digest:
        raise Damaged("its checksum differs")
    if found != key:
        raise Damaged("it is another kernel's")
    return content


def write_entry(path: Path, key: bytes, content: bytes) -> None:
    """Write an entry, whole or not at all, whoever else reads or writes it.  Raises: OSError."""
    write_whole(path, MAGIC + key + hashlib.sha256(key + content).digest() + content)


def write_whole(path: Path, data: bytes) -> None:
    """Write a file in a directory that is made where it does not exist, whole or not at all.  Raises: OSError."""
    trial = path.with_name(f"{uuid.uuid4().hex}.tmp")
    for last in (False, True):
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            trial.write_bytes(data)
            os.replace(trial, path)
            return
        except FileNotFoundError:  # somebody removed the directory meanwhile
            if last:
                raise
        except BaseException:
            with suppress(OSError):
                trial.unlink(missing_ok=True)
            raise


def remove(path: Path) -> bool:
    """Remove a file or directory.  Returns: whether it is gone."""
    try:
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path)
        else:
            path.unlink(missing_ok=True)
    except OSError:
        return False
    return True


def described(kind: types.Type) -> str:
    """A text that tells a type of an argument apart, in every process.  Raises: NotKept for one that belongs to this process."""
    if isinstance(kind, (types.NamedTuple, types.NamedUniTuple)):
        made: type = kind.instance_class
        if getattr(sys.modules.get(made.__module__), made.__qualname__, None) is not made or made.__module__ == "__main__":
            raise NotKept(f"{made.__qualname__} cannot be imported")
        inner = ", ".join(f"{name}: {described(part)}" for name, part in zip(kind.fields, kind.types, strict=True))
        return f"{made.__module__}.{made.__qualname__}({inner})"
    if isinstance(kind, (types.Tuple, types.UniTuple)):
        return f"{type(kind).__name__}({', '.join(map(described, kind.types))})"
    text = f"{type(kind).__name__} {kind}"
    if isinstance(kind, (types.Dispatcher, types.FunctionType)) or " at 0x" in text:
        raise NotKept("functions as arguments are known by their place in memory")
    return text


class KernelCache(_Cache):
    """The entries of one kernel, a file for each signature."""

    def __init__(self, function: Callable, options: dict, place: Callable[[bool], Path | None]):
        """Args: options: of its compilation; place: gives the directory of entries, None where there is no place for any.  It raises
        NotKept for a kernel whose sources are not known, and, where its argument says so, for one whose sources have changed since.
        """
        self._function = function
        self._options = repr(sorted(options.items()))
        self._module = str(function.__module__)
        self._name = f"{self._module.partition('.')[2] or self._module}.{function.__qualname__}".replace("<", "").replace(">", "")[-150:]
        self._place = place
        self._enabled = True
        self._directory: Path | None = None
        try:
            self._directory = place(False)
        except NotKept:
            self._enabled = False

    @property
    def cache_path(self) -> str:
        return str(self._directory or "")

    def enable(self) -> None:
        self._enabled = True

    def disable(self) -> None:
        self._enabled = False

    def flush(self) -> None:
        """Remove all entries of this kernel."""
        for path in self._directory.glob(f"{self._name}-*{SUFFIX}") if self._directory else ():
            remove(path)

    def load_overload(self, sig, target_context):
        """The compiled kernel for a signature, None where there is none that can be used."""
        target_context.refresh()
        if not self._enabled or not self._directory:
            return None
        try:
            path, key = self._entry(self._directory, sig, target_context.codegen())
        except NotKept:
            return None
        try:
            content = read_entry(path, key)
            if content is None:
                return None
            called, compiled = pickle.loads(content)
            for callee in called:
                place(callee)
            return CompileResult._rebuild(target_context, *compiled)
        except Missing as error:
            why = str(error)
        except OSError:  # if its directory cannot be written either, that is told when it is compiled
            if not remove(path):
                return None
            why = "it cannot be read"
        except Damaged as error:
            why = str(error)
        except Exception as error:
            why = f"{type(error).__name__} while it was loaded"
        remove(path)
        tell_once("damage", f"{_shown(path)} is damaged ({why}): it is compiled anew, as is any other like it.")
        return None

    def save_overload(self, sig, cres) -> None:
        """Keep a compiled kernel, if it can be kept."""
        if not self._enabled or cres.library.has_dynamic_globals or any(not lifted.can_cache for lifted in cres.lifted):
            return
        if not self._directory:
            tell_once("unwritable", unwritable(None, why_unwritable(None)))
            return
        try:
            described(cres.signature.return_type)
            path, key = self._entry(self._directory, sig, cres.codegen)
            if self._place(True) == self._directory:
                write_entry(path, key, dumps(([self._found_again(callee) for callee in callees(cres)], cres._reduce())))
        except NotKept:
            return
        except OSError as error:
            tell_once("unwritable", unwritable(self._directory, reason(error)))

    @staticmethod
    def _found_again(callee: Callee) -> Callee:
        """The same.  Raises: NotKept for a kernel that another process cannot find."""
        if "<" in callee.name or callee.module == "__main__":
            raise NotKept(f"{callee.name}, which it calls, cannot be imported")
        return callee

    def symbol(self, sig, codegen) -> str:
        """A name that stands for the kernel of a signature in every process that has the same sources, or in this one alone."""
        try:
            return f"{self._directory.name if self._directory else ''}.{hashlib.sha256(self._key(sig, codegen).encode()).hexdigest()}"
        except NotKept:
            return uuid.uuid4().hex

    def _entry(self, directory: Path, sig, codegen) -> tuple[Path, bytes]:
        """The file of a signature, and the hash of its key.  Raises: NotKept."""
        key = hashlib.sha256(self._key(sig, codegen).encode()).digest()
        return directory / f"{self._name}-{key.hex()[:16]}{SUFFIX}", key

    def _key(self, sig, codegen) -> str:
        function = self._function
        closed = tuple(cell.cell_contents for cell in function.__closure__ or ())
        if any(isinstance(item, Dispatcher) for item in closed):
            raise NotKept("another kernel in a closure is known by its place in memory")
        arguments, result = sigutils.normalize_signature(sig)
        return "\n".join((
            self._module, function.__qualname__, str(function.__code__.co_firstlineno), self._options,
            *map(described, arguments), described(result) if result else "", repr(codegen.magic_tuple()),
            hashlib.sha256(function.__code__.co_code).hexdigest(), hashlib.sha256(dumps(closed)).hexdigest() if closed else "",
        ))
