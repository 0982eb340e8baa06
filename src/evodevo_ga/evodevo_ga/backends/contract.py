"""The contract between the pool, which shares a generation's genomes among workers, and the backends that bring the workers.

A backend hands batches to workers and answers to the pool, as futures of `concurrent.futures`.  The pool does the rest, the same for
all backends: it sizes batches by measured times, asks again, proves answers by its own evaluation, sends away who answers wrongly,
finds the genomes that end their worker, and waits where nobody is left.  So a backend is thin:

    submit       one batch to one worker; its future ends with an `Answer`, or with one of the exceptions below
    workers      who can be given work just now; the pool asks often, and whoever is new gets work at once
    drop         a worker of no more use

What is evaluated is pure: a batch may be given to two workers, and to one worker twice, and the first answer counts.
"""

from __future__ import annotations

import concurrent.futures
import time
from abc import ABC, abstractmethod
from collections.abc import Collection, Mapping
from concurrent.futures import Future
from dataclasses import dataclass

from evodevo_sim import Evaluation, Genome, Task


@dataclass(frozen=True)
class Batch:
    """Genomes to evaluate for a task and a seed.

    Attributes: bars: one for each genome, or none at all: a fitness in m below which a genome is of no use, so that its evaluation may
        end early; the pool passes them on unread.
    """

    genomes: tuple[Genome, ...]
    task: Task
    seed: int
    bars: tuple[float, ...] = ()


@dataclass(frozen=True)
class Answer:
    """What a worker answers to a batch.

    Attributes: evaluations: one for each genome, in order; worker: its name; seconds: that the evaluations took, without waiting for
        their turn, or 0 where that is not known.
    """

    evaluations: list[Evaluation]
    worker: str
    seconds: float = 0.0


class BackendError(RuntimeError):
    """The backend cannot go on or begin, with whatever workers; the message says why and what to do, in one line."""


class WorkerLost(Exception):
    """The worker has ended, for certain, before it answered: what it evaluated just then is suspected of that.

    A worker that is only out of reach is not lost: the backend takes it out of `workers`, asks it again when it is back, and raises this
    where it does not come back in a time that no stop of a process or net lasts.

    Args: outside: whether a signal from outside ended it, as far as one knows, so that its genomes are suspected less.
    """

    def __init__(self, worker: str, reason: str, outside: bool = False):
        super().__init__(f"{worker}: {reason}")
        self.worker, self.reason, self.outside = worker, reason, outside


class NotEvaluated(Exception):
    """The batch was given back as it was, by no fault of its genomes or of the worker's answers: it was cancelled, the worker ends in
    good order, or went before it began.  The pool gives it to somebody else."""

    def __init__(self, worker: str, reason: str):
        super().__init__(f"{worker}: {reason}")
        self.worker, self.reason = worker, reason


class AnswerError(ValueError):
    """An answer on which nothing can rest; the message says why, in one line.  The pool sends the worker away."""


class Backend(ABC):
    """Workers behind one contract.  All methods are called in the pool's thread; futures may end in any.

    Attributes: trusted: whether workers run the code of this very process, so that their answers need no proof; cost: s that it takes
        this process, or one other that all batches go through, to give a batch.
    """

    trusted = False
    cost = 0.0

    @property
    def mend(self) -> str:
        """How somebody brings a worker, where there is none."""
        return "start it by ros2 run evodevo_sim simulator"

    @property
    @abstractmethod
    def workers(self) -> Mapping[str, int]:
        """Who can be given work just now, and how many batches each works on at once (threads).

        A name stands for one life of a worker: one that is started anew has another name.  It is shown to people, in one line.
        """

    @abstractmethod
    def submit(self, batch: Batch, worker: str) -> Future[Answer]:
        """Give a batch to one of `workers`, behind what it has.  It never waits for an answer.

        The future ends with an Answer, which was looked at or will be by the pool, or with WorkerLost, NotEvaluated, AnswerError or
        BackendError.  Cancelling it means that nobody waits any more: stop the work where that is possible.
        """

    @abstractmethod
    def drop(self, worker: str, reason: str) -> None:
        """A worker that answers wrongly, or hangs: use this life of it no more.  Its futures end with NotEvaluated, or never."""

    def wait(self, futures: Collection[Future], seconds: float) -> None:
        """Let things happen for so long, s, or until one of the futures is done or there is another worker."""
        if futures:
            concurrent.futures.wait(futures, seconds, concurrent.futures.FIRST_COMPLETED)
        else:
            time.sleep(seconds)

    def hopeless(self) -> str:
        """Why no worker will ever come, in one line with the mend; empty where one may come."""
        return ""

    def close(self) -> None:  # noqa: B027  (a backend that holds nothing has nothing to give back)
        """End what is the backend's own: processes, threads, connections."""
