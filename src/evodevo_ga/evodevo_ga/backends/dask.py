"""Workers of a Dask cluster: on this host, or wherever a scheduler is at home: SLURM, Kubernetes, machines reached by SSH.

    pool = Pool(DaskBackend("tcp://127.0.0.1:8786"))
    evaluations = pool.evaluate(genomes, task, seed)

Dask itself sends functions as pickles: whoever reaches the scheduler's port can run anything on its workers, and a scheduler anything on
us.  So a cluster belongs into a net that is trusted, or behind Dask's TLS (docs/guide/cluster.md).  What we send and take are plain data.
"""

from __future__ import annotations

import asyncio
import dataclasses
import itertools
import pydoc
import sys
import time
import uuid
import warnings
from collections.abc import Callable, Mapping
from concurrent.futures import Future, InvalidStateError
from contextlib import suppress
from typing import Any

from evodevo_sim.inputs import one_line
from evodevo_sim.tasks.code import code_hash

from evodevo_sim import Task, __version__

from . import remote
from .contract import Answer, AnswerError, Backend, Batch, NotEvaluated, WorkerLost
from .dask_scheduler import CONNECT, connected, imported
from .plain import answer_of_plain, plain_batch

_FETCH = 30.0  # s for an answer that is there
_IDENTITY = f"{remote.__name__}.IDENTITY"
_LOOK_EVERY = 0.5  # s, at the scheduler's list of workers
_SILENT = 15.0  # s without a sign of a worker after which it counts as out of reach


def _to_standard_error(line: str) -> None:
    print(f"evolve: {line}", file=sys.stderr, flush=True)


class _Asked(Future):
    """A batch at a worker.  cancel: tells the worker too, which leaves what it has in work."""

    def __init__(self, worker: _Worker, give_up: Callable[[_Asked], None]):
        super().__init__()
        self.worker, self.name = worker, ""
        self.task: Any = None  # of Dask's
        self._give_up = give_up

    def cancel(self) -> bool:
        cancelled = super().cancel()
        if cancelled:
            with suppress(InvalidStateError, RuntimeError):
                self.set_running_or_notify_cancel()
            self._give_up(self)
        return cancelled

    def end(self, outcome: Answer | BaseException) -> None:
        """With an answer, or an exception; unless it has ended before."""
        with suppress(InvalidStateError):
            self.set_exception(outcome) if isinstance(outcome, BaseException) else self.set_result(outcome)


@dataclasses.dataclass(eq=False)
class _Worker:
    """One life of a worker.  seen: its last sign, by the scheduler's clock, and when we heard of it, by ours; refused: why it is not used;
    ready: whether it was found to run our code."""

    name: str
    address: str
    threads: int
    asked: set[_Asked] = dataclasses.field(default_factory=set)
    sign: float = 0.0
    seen: float = dataclasses.field(default_factory=time.monotonic)
    questions: list[Any] = dataclasses.field(default_factory=list)
    ready: bool = False
    refused: str = ""


class DaskBackend(Backend):
    """Evaluates on the workers of a Dask scheduler.

    Args: scheduler: its address, e.g. tcp://HOST:8786, or empty: a cluster of our own on this host; task: whose kernels workers load
        before they get work; threads: of a cluster of our own, by default one a core; say: is told what people must know.
    Raises BackendError where no scheduler answers, or one of another version.
    """

    cost = 3e-3  # of the scheduler: docs/results/scaling.md

    def __init__(
        self, scheduler: str = "", task: Task = Task(), threads: int | None = None, say: Callable[[str], object] = _to_standard_error
    ):
        distributed = imported()
        self._say, self._task = say, dataclasses.asdict(task)
        self._workers: dict[str, _Worker] = {}  # by the id of their life
        self._dropped: set[str] = set()
        self._listed: dict[str, Any] | None = None
        self._looking, self._looked = False, 0.0
        self._numbers, self._own_name = itertools.count(), uuid.uuid4().hex
        self._cluster: Any = None
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            if not scheduler:
                self._cluster = distributed.LocalCluster(
                    n_workers=1, threads_per_worker=threads, processes=True, host="127.0.0.1", memory_limit=0,
                    dashboard_address="127.0.0.1:0", worker_dashboard_address="127.0.0.1:0",  # else they listen everywhere
                )
                scheduler = self._cluster.scheduler_address
            self.scheduler = scheduler
            try:
                self._client = connected(distributed, scheduler)
            except BaseException:
                self._end_cluster()
                raise

    def __str__(self) -> str:
        return f"a Dask worker of our own, {self.scheduler}" if self._cluster else f"the workers of the Dask scheduler at {self.scheduler}"

    @property
    def workers(self) -> Mapping[str, int]:
        self._look()
        now = time.monotonic()
        return {one.name: one.threads for one in self._workers.values() if one.ready and now - one.seen < _SILENT}

    def hopeless(self) -> str:
        if self._client.status in ("running", "connecting"):
            return ""
        return f"the Dask scheduler at {self.scheduler} is gone: start it again, then go on by evolve --resume"

    @property
    def mend(self) -> str:
        return f"start one by `dask worker {self.scheduler}`"

    def submit(self, batch: Batch, worker: str) -> Future[Answer]:
        one = next((one for one in self._workers.values() if one.name == worker and one.ready), None)
        asked = _Asked(one or _Worker(worker, "", 0), self._give_up)
        if one is None or self._client.status != "running":
            asked.end(NotEvaluated(worker, "it is out of reach"))
            return asked
        asked.name = f"evodevo-{self._own_name}-{next(self._numbers)}"
        one.asked.add(asked)
        try:
            asked.task = self._submit(remote.answer, asked.name, plain_batch(batch), at=one.address, key=asked.name)
            asked.task.add_done_callback(lambda task: self._take(asked, task))
        except Exception as error:  # the client has lost its scheduler just now
            one.asked.discard(asked)
            asked.end(NotEvaluated(worker, one_line(f"{type(error).__name__}: {error}")))
        return asked

    def _submit(self, function: Callable, *given: Any, at: str, key: str) -> Any:
        return self._client.submit(function, *given, workers=[at], allow_other_workers=False, pure=False, retries=0, key=key)

    def _take(self, asked: _Asked, task: Any) -> None:
        """In a thread of Dask's: a task is done."""
        worker = asked.worker
        worker.asked.discard(asked)
        if asked.done():
            return
        try:
            found = _result(task)
            outcome: Any = NotEvaluated(worker.name, "it was cancelled") if found is None else answer_of_plain(found, worker.name)
        except AnswerError as error:
            outcome = error
        except Exception as error:
            outcome = self._meaning(worker, task.status, error)
        asked.end(outcome)

    def _meaning(self, worker: _Worker, status: str, error: Exception) -> Exception:
        """What an exception means in the contract."""
        from distributed.scheduler import KilledWorker

        if isinstance(error, KilledWorker):
            return WorkerLost(worker.name, "it has ended")
        if status in ("cancelled", "lost") or self._client.status != "running":
            return NotEvaluated(worker.name, "the scheduler has given it back")
        return AnswerError(one_line(f"{type(error).__name__}: {error}"))

    def _give_up(self, asked: _Asked) -> None:
        """Nobody waits for it: out of the scheduler's queue, and out of work."""
        if asked.task is None or self._client.status != "running":
            return
        asked.worker.asked.discard(asked)
        asked.task.release()
        self._client.loop.add_callback(self._tell_given_up, asked.worker.address, [asked.name])

    async def _tell_given_up(self, address: str, names: list[str]) -> None:
        with suppress(Exception):  # it is gone
            await self._client._run(remote.give_up, names, workers=[address], on_error="ignore")

    def drop(self, worker: str, reason: str) -> None:
        for life, one in list(self._workers.items()):
            if one.name == worker:
                self._dropped.add(life)
                del self._workers[life]
                for asked in list(one.asked):
                    asked.cancel()

    # --- who is there -----------------------------------------------------------------------------------------------------

    def _look(self) -> None:
        """Take what the scheduler has told, and ask it again; without waiting."""
        now = time.monotonic()
        if self._listed is not None:
            listed, self._listed = self._listed, None
            self._compare(listed)
        if not self._looking and now > self._looked + _LOOK_EVERY and self._client.status == "running":
            self._looking, self._looked = True, now
            self._client.loop.add_callback(self._ask_who_is_there)

    async def _ask_who_is_there(self) -> None:
        try:
            self._listed = (await asyncio.wait_for(self._client.scheduler.identity(n_workers=-1), CONNECT))["workers"]
        except Exception:  # no answer: what is known holds
            self._listed = None
        finally:
            self._looking = False

    def _compare(self, listed: Mapping[str, Any]) -> None:
        # The scratch directory is that of one process; address and name may come again.
        lives = {f"{address} {about.get('local_directory')}": (address, about) for address, about in listed.items()}
        for life in [life for life in self._workers if life not in lives]:
            one = self._workers.pop(life)
            for asked in list(one.asked):
                one.asked.discard(asked)
                asked.end(WorkerLost(one.name, "it has ended"))
                if asked.task is not None:
                    asked.task.release()  # or it waits for a worker at that address
        for life, (address, about) in lives.items():
            if life in self._dropped:
                continue
            if life not in self._workers:
                name = address if all(other.address != address for other in self._workers.values()) else f"{address} {life[-6:]}"
                self._workers[life] = one = _Worker(name, address, int(about["nthreads"]))
                self._begin_check(one)
            one = self._workers[life]
            if about["last_seen"] != one.sign:
                one.sign, one.seen = about["last_seen"], time.monotonic()

    def _begin_check(self, one: _Worker) -> None:
        """Who it is.  A function of Python's own finds that out: one of ours would end a worker that has none of our code."""
        self._question(one, self._end_check, pydoc.locate, _IDENTITY)

    def _question(self, one: _Worker, then: Callable[[_Worker, Any], None], function: Callable, *given: Any) -> None:
        task = self._submit(function, *given, at=one.address, key=f"evodevo-{self._own_name}-who-{next(self._numbers)}")
        one.questions.append(task)  # or it is forgotten
        task.add_done_callback(lambda task: then(one, task))

    def _end_check(self, one: _Worker, task: Any) -> None:
        """In a thread of Dask's: a worker has told who it is, or cannot."""
        try:
            one.refused = _unlike(_result(task))
            if not one.refused:
                self._question(one, self._is_ready, remote.get_ready, self._task)
        except Exception as error:
            self._cannot_begin(one, task, error)
        if one.refused:
            self._say(one_line(f"worker {one.name} is not used: {one.refused}"))

    def _is_ready(self, one: _Worker, task: Any) -> None:
        try:
            _result(task)
            one.ready = True
        except Exception as error:
            self._cannot_begin(one, task, error)
            if one.refused:
                self._say(one_line(f"worker {one.name} is not used: {one.refused}"))

    def _cannot_begin(self, one: _Worker, task: Any, error: Exception) -> None:
        if task.status not in ("cancelled", "lost"):
            one.refused = one_line(f"it cannot begin: {type(error).__name__}: {error}")

    def close(self) -> None:
        for one in list(self._workers.values()):
            for asked in list(one.asked):
                asked.cancel()
        with suppress(Exception):  # a scheduler that is gone is no reason to fail at the end
            self._client.close(timeout=2)
        self._end_cluster()

    def _end_cluster(self) -> None:
        if self._cluster is not None:
            with suppress(Exception):
                self._cluster.close(timeout=5)


def _result(task: Any) -> Any:
    if task.status not in ("finished", "error"):
        raise LookupError(f"the task is {task.status}")
    return task.result(timeout=_FETCH)


def _unlike(about: Any) -> str:
    """Why a worker's evaluations may have other bits than ours, and the mend; nothing where they have the same."""
    if not isinstance(about, dict):
        return "it lacks evodevo_ga: install it there, in the version that runs here"
    if about.get("code") != code_hash():
        version = f"evodevo {one_line(str(about.get('evodevo')), 20)} there, {__version__} here"
        return f"it runs other code ({version}, hash {one_line(str(about.get('code')), 16)}, not {code_hash()}): install the same there"
    return ""
