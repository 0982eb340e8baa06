"""Audits of new champions beside a run, which neither wait for them nor change by what they find."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace

from evodevo_sim.kernels.jit import is_compiled
from evodevo_sim.ros.own_simulators import end_with_parent
from evodevo_sim.tasks.audit import Audit, audit

from evodevo_sim import Task

from .evolution import Individual

_NICE = 10  # of the thread that audits: simulators go first
_COMPILE = """
import sys
from evodevo_sim.parameters import default_task
from evodevo_sim.tasks.audit import prepare
prepare(default_task(sys.argv[1]))
"""


@dataclass(frozen=True)
class Finding:
    """What the audit of the champion of a generation found."""

    generation: int
    champion: Individual
    audit: Audit


class Auditor:
    """Audits champions in the order given, in one thread of low priority.  A context: at its end, what has not begun is dropped.

    Attributes: done: audits; cpu: s of processor time that they took.
    """

    def __init__(self, task: Task, seed: int):
        self._task, self._seed = task, seed
        self._pool = ThreadPoolExecutor(1, "audit", _step_back)
        self._under_way: list[tuple[int, Individual, Future]] = []
        self.done, self.cpu = 0, 0.0
        self._compiler: subprocess.Popen | None = None
        self._ending = False

    def __enter__(self) -> Auditor:
        kernel = self._task.kind.audit_kernel
        if kernel and not is_compiled(kernel):
            self._pool.submit(self._compile)
        return self

    def __exit__(self, *_: object) -> None:
        self._ending = True
        if self._compiler is not None and not self._under_way:
            self._compiler.terminate()
        self._pool.shutdown(wait=True, cancel_futures=True)

    def _compile(self) -> None:
        """Compile the kernels of audits in another process: in a thread of this one, the run would wait for it again and again."""
        if self._ending:
            return
        command = [sys.executable, "-c", _COMPILE, self._task.name]
        with open(os.devnull, "wb") as nothing, subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=nothing, stderr=nothing, start_new_session=True,
            preexec_fn=end_with_parent,  # noqa: PLW1509  (it takes no lock: a call of the system alone)
        ) as self._compiler:
            self._compiler.wait()  # where it fails, the first audit compiles and says why
        self._compiler = None

    def submit(self, generation: int, champion: Individual) -> None:
        future = self._pool.submit(self._audit, champion)
        self._under_way.append((generation, champion, future))

    def _audit(self, champion: Individual) -> Audit:
        began = time.thread_time()
        found = audit(champion.genome, self._task, self._seed, quick=True)
        recorded, own = champion.evaluation.fitness, found.evaluation.fitness
        if recorded != own:
            fault = f"the recorded fitness of {recorded:.6g} differs from that of its own evaluation, {own:.6g}"
            found = replace(found, faults=(fault, *found.faults))
        self.done, self.cpu = self.done + 1, self.cpu + time.thread_time() - began
        return found

    def drop_all_but_the_last(self) -> None:
        """Forget what has not begun, but for the newest champion."""
        self._under_way = [one for k, one in enumerate(self._under_way) if k == len(self._under_way) - 1 or not one[2].cancel()]

    def __len__(self) -> int:
        """Audits whose findings nobody has taken."""
        return len(self._under_way)

    @property
    def ready(self) -> bool:
        """Whether there is a finding to take."""
        return bool(self._under_way) and self._under_way[0][2].done()

    def next_finding(self) -> Finding:
        """Take the oldest finding, once it is there."""
        generation, champion, future = self._under_way.pop(0)
        return Finding(generation, champion, future.result())


def _step_back() -> None:
    """Lower the priority of this thread alone, as Linux allows."""
    os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), os.getpriority(os.PRIO_PROCESS, 0) + _NICE)
