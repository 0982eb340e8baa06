"""Simulator nodes of a command's own: processes that are started together, watched, started anew where they end, and ended with us."""

from __future__ import annotations

import ctypes
import os
import signal
import subprocess
import sys
import time
from dataclasses import dataclass, field

# Parameters of simulators that answer to who started them alone: the most that `nodes.limits` has.
UNLIMITED = ("max_cells:=4096", "max_steps:=1000000000000", "max_seconds:=1000000000000")
_OFTEN = 12  # ends of one simulator within `_OF_LATE` after which it is not started again
_OF_LATE = 120.0  # s
_FIRST_PAUSE, _LONGEST_PAUSE = 0.2, 5.0  # s before it is started again, doubled with each end of late
_END_WITHIN = 5.0  # s


@dataclass
class _Own:
    """One simulator: a process after the other.  lives: how many; ends: s, when each ended, of late."""

    number: int
    lives: int = 0
    process: subprocess.Popen | None = None
    ends: list[float] = field(default_factory=list)
    due: float = 0.0  # s, when it may be started


class OwnSimulators:
    """Simulator nodes of this process's own, as a context: started together, ended by their ids, and with us if we are killed.

    Args: count: processes; owner: the command's name, for their namespace, which is hidden from others; task: whose kernels they load at
        once; threads: of each process.
    """

    def __init__(
        self, count: int, log_path: str | os.PathLike | None = None, owner: str = "evolve", task: str = "swim", threads: int = 1
    ):
        self.namespace = f"/_{owner}_{os.getpid()}"
        self._task, self._threads, self._log_path = task, threads, log_path
        self._own = [_Own(number) for number in range(count)]

    @property
    def namespaces(self) -> list[str]:
        """Of those that were started and have not been seen to end.  Each life has a namespace of its own, so that nobody waits for an
        answer of the one before."""
        return [self._namespace(one) for one in self._own if one.process]

    @property
    def services(self) -> list[str]:
        return [f"{namespace}/evaluate" for namespace in self.namespaces]

    def _namespace(self, one: _Own) -> str:
        return f"{self.namespace}/sim_{one.number}" + (f"_{one.lives}" if one.lives > 1 else "")

    def alive(self) -> bool:
        """Whether none has ended."""
        return all(one.process and one.process.poll() is None for one in self._own)

    def process_of(self, service: str) -> int | None:
        """The number of the process that has a service."""
        return next((one.process.pid for one in self._own if one.process and f"{self._namespace(one)}/evaluate" == service), None)

    def __enter__(self) -> OwnSimulators:
        for one in self._own:
            self._start(one)
        return self

    def __exit__(self, *_: object) -> None:
        self.end()

    def _start(self, one: _Own) -> None:
        one.lives += 1
        command = [sys.executable, "-m", "evodevo_sim.commands.simulator", "--ros-args", "-r", f"__ns:={self._namespace(one)}"]
        command += ["-p", f"task:={self._task}", "-p", f"threads:={self._threads}"]
        for limit in UNLIMITED:  # they answer to us alone, who know what we ask
            command += ["-p", limit]
        with open(self._log_path or os.devnull, "ab") as log:
            # A session of their own: Ctrl-C reaches us alone, and we end them in good order.
            one.process = subprocess.Popen(
                command, stdin=subprocess.DEVNULL, stdout=log, stderr=log, start_new_session=True,
                preexec_fn=end_with_parent,  # noqa: PLW1509  (it takes no lock: a call of the system alone)
            )

    def watch(self) -> list[str]:
        """Start those anew that have ended, after a pause, each a few times.  Returns: services that ended since the last look."""
        now, ended = time.monotonic(), []
        for one in self._own:
            if one.process and one.process.poll() is not None:
                ended.append(f"{self._namespace(one)}/evaluate")
                one.process = None
                one.ends = [*(when for when in one.ends if when > now - _OF_LATE), now]
                one.due = now + min(_FIRST_PAUSE * 2.0 ** (len(one.ends) - 1), _LONGEST_PAUSE)
            elif not one.process and now >= one.due and not self._spent(one):
                self._start(one)
        return ended

    def _spent(self, one: _Own) -> bool:
        return len(one.ends) >= _OFTEN

    def spent(self) -> bool:
        """Whether all have ended, so often that none is started again."""
        return all(not one.process and self._spent(one) for one in self._own)

    def restart(self, service: str) -> None:
        """Kill one that hangs; `watch` starts it anew."""
        for one in self._own:
            if one.process and f"{self._namespace(one)}/evaluate" == service:
                one.process.kill()

    def end(self) -> None:
        processes = [one.process for one in self._own if one.process]
        for process in processes:
            process.terminate()
            process.send_signal(signal.SIGCONT)  # one that was stopped would not hear it
        deadline = time.monotonic() + _END_WITHIN
        for process in processes:
            try:
                process.wait(max(0.0, deadline - time.monotonic()))
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        self._own = []


_PR_SET_PDEATHSIG = 1  # of prctl(2)


def end_with_parent() -> None:
    """To be called in a new process: it ends when the thread does that started it."""
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
