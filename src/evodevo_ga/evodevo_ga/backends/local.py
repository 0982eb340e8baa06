"""Threads of this process as the one worker: for notebooks, and wherever no process is to be started.

    pool = Pool(LocalBackend())
    evaluations = pool.evaluate(genomes, task, seed)

Kernels release the interpreter's lock, so threads run side by side.  A genome that ends its process ends this one.
"""

from __future__ import annotations

import os
import queue
import threading
from collections.abc import Mapping
from concurrent.futures import Future, InvalidStateError
from contextlib import suppress

from evodevo_sim.tasks.halt import Halt

from .contract import Answer, Backend, Batch, NotEvaluated
from .evaluating import evaluated

NAME = "this process"


class _Asked(Future):
    """A future that can be cancelled while its batch is in work, which then ends."""

    def __init__(self) -> None:
        super().__init__()
        self.halt = Halt()

    def cancel(self) -> bool:
        cancelled = super().cancel()
        if cancelled:
            self.halt()
            with suppress(InvalidStateError, RuntimeError):
                self.set_running_or_notify_cancel()  # tells those who wait
        return cancelled


class LocalBackend(Backend):
    """Evaluates in threads of this process.  Args: threads: of them; by default one for each core that the process may use."""

    trusted = True

    def __init__(self, threads: int | None = None):
        self._count = threads or len(os.sched_getaffinity(0))
        self._waiting: queue.SimpleQueue[tuple[Batch, _Asked] | None] = queue.SimpleQueue()
        self._threads: list[threading.Thread] = []
        self._open: set[_Asked] = set()

    def __str__(self) -> str:
        return f"{self._count} thread{'s' * (self._count > 1)} of this process"

    @property
    def workers(self) -> Mapping[str, int]:
        return {NAME: self._count}

    def submit(self, batch: Batch, worker: str = NAME) -> Future[Answer]:
        while len(self._threads) < self._count:
            thread = threading.Thread(target=self._work, name=f"evaluations {len(self._threads)}", daemon=True)
            self._threads.append(thread)
            thread.start()
        asked = _Asked()
        self._open.add(asked)
        self._waiting.put((batch, asked))
        return asked

    def drop(self, worker: str, reason: str) -> None:
        for asked in list(self._open):
            asked.cancel()

    def close(self) -> None:
        """End the threads; what they have in work is cancelled."""
        self.drop(NAME, "the backend is closed")
        for _ in self._threads:
            self._waiting.put(None)
        for thread in self._threads:
            thread.join()
        self._threads.clear()

    def _work(self) -> None:
        while (given := self._waiting.get()) is not None:
            batch, asked = given
            try:
                answer = evaluated(batch, NAME, asked.halt)
                with suppress(InvalidStateError):  # cancelled just now
                    asked.set_result(answer) if answer else asked.set_exception(NotEvaluated(NAME, "it was cancelled"))
            except BaseException as error:  # nobody is to wait for ever
                with suppress(InvalidStateError):
                    asked.set_exception(error)
            finally:
                self._open.discard(asked)
