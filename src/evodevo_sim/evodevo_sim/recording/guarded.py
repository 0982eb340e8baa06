"""A recording that is whole even where a signal ends the process in the middle of writing it."""

from __future__ import annotations

import os
import threading
from contextlib import ExitStack

from ..ros.command_process import if_ended
from .writer import Recorder

_WAIT = 2.0  # s for the message that is being written


class GuardedRecorder(Recorder):
    """A `Recorder` that is closed, with its metadata, also by `process.end_now`, which another thread calls."""

    def __init__(self, directory: str | os.PathLike):
        self._lock = threading.RLock()
        self._guard = ExitStack()
        super().__init__(directory)

    def __enter__(self) -> GuardedRecorder:
        self._guard.enter_context(if_ended(self._end))
        return self

    def __exit__(self, *_) -> None:
        with self._guard:
            self.close()

    def write(self, topic: str, message, stamp: int, latched: bool = False) -> None:
        with self._lock:
            super().write(topic, message, stamp, latched)

    def flush(self) -> None:
        with self._lock:
            super().flush()

    def close(self) -> None:
        with self._lock:
            super().close()

    def _end(self) -> None:
        """Close, and let nobody write any more: the lock is kept."""
        if self._lock.acquire(timeout=_WAIT):
            super().close()
