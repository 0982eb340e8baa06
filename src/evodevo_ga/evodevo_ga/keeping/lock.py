"""The lock of a run's directory: whoever writes in it holds it, and the kernel frees it whatever ends the process."""

from __future__ import annotations

import fcntl
import json
import os
import socket
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path
from types import TracebackType

from .errors import ResumeError

NAME = "lock"
_own: set[str] = set()  # directories whose locks this process holds


class Lock:
    """The lock of a directory that exists, as a context.  Raises ResumeError that says who holds it.

    The file stays: it tells who held it last.
    """

    def __init__(self, directory: Path):
        self._directory = directory
        self._descriptor = -1

    def __enter__(self) -> Lock:
        path = self._directory / NAME
        try:
            self._descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o666)
        except OSError as error:
            raise ResumeError(f"{path} cannot be written ({error.strerror}): make {self._directory} writable") from None
        try:
            fcntl.flock(self._descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            os.close(self._descriptor)
            if not isinstance(error, BlockingIOError):
                raise ResumeError(f"{path} cannot be locked ({error.strerror}): move the run to a file system with locks") from None
            raise ResumeError(_told(self._directory)) from None
        _own.add(os.path.realpath(self._directory))
        about = {"pid": os.getpid(), "host": socket.gethostname(), "since": datetime.now(UTC).isoformat(timespec="seconds")}
        with suppress(OSError):  # a full disk: the lock holds without it
            os.ftruncate(self._descriptor, 0)
            os.pwrite(self._descriptor, (json.dumps(about) + "\n").encode(), 0)
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        _own.discard(os.path.realpath(self._directory))
        os.close(self._descriptor)


def refuse_if_held(directory: Path) -> None:
    """Raises ResumeError where a run of another process goes on in a directory; touches nothing."""
    if os.path.realpath(directory) in _own:
        return
    try:
        descriptor = os.open(directory / NAME, os.O_RDONLY | os.O_CLOEXEC)
    except OSError:
        return
    try:
        fcntl.flock(descriptor, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        raise ResumeError(_told(directory)) from None
    except OSError:  # no locks there: nobody holds one
        return
    finally:
        os.close(descriptor)


def _told(directory: Path) -> str:
    who = "another process"
    with suppress(OSError, ValueError, TypeError, KeyError):
        about = json.loads((directory / NAME).read_text(encoding="utf-8")[:1000])
        who = f"process {int(about['pid'])} on {str(about['host'])[:64]} since {str(about['since'])[:32]}"
    return f"{directory} is in use by {who}: wait until that run has ended, or end it"
