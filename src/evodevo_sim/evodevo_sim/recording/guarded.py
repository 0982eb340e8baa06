"""A recording that is whole even where a signal ends the process in the middle of writing it."""

from __future__ import annotations

import os
from contextlib import ExitStack

from ..command_process import if_ended
from .writer import Recorder


class GuardedRecorder(Recorder):
    """A `Recorder` that is closed, with its metadata, also by `command_process.end_now`, which another thread calls."""

    def __init__(self, directory: str | os.PathLike, go_on: bool = False):
        self._guard = ExitStack()
        super().__init__(directory, go_on)

    def __enter__(self) -> GuardedRecorder:
        self._guard.enter_context(if_ended(self.close_for_good))
        return self

    def __exit__(self, *_) -> None:
        with self._guard:
            self.close()
