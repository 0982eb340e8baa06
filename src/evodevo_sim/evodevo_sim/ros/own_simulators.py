"""Simulator nodes of a command's own."""

from __future__ import annotations

import ctypes
import os
import signal
import subprocess
import sys
import time


class OwnSimulators:
    """Simulator nodes of this process's own, as a context: started together, ended by their ids, and with us if we are killed.

    Args: owner: the command's name, for their namespace, which is hidden from others; task: whose kernels they load at once.
    """

    def __init__(self, count: int, log_path: str | os.PathLike | None = None, owner: str = "evolve", task: str = "swim"):
        self.namespace = f"/_{owner}_{os.getpid()}"
        self._task = task
        self._count = count
        self._log_path = log_path
        self._processes: list[subprocess.Popen] = []

    @property
    def namespaces(self) -> list[str]:
        return [f"{self.namespace}/sim_{i}" for i in range(self._count)]

    @property
    def services(self) -> list[str]:
        return [f"{namespace}/evaluate" for namespace in self.namespaces]

    def alive(self) -> bool:
        return all(process.poll() is None for process in self._processes)

    def __enter__(self):
        log = open(self._log_path or os.devnull, "ab")
        with log:
            for namespace in self.namespaces:
                command = [sys.executable, "-m", "evodevo_sim.commands.simulator", "--ros-args", "-r", f"__ns:={namespace}"]
                command += ["-p", f"task:={self._task}"]
                # A session of their own: Ctrl-C reaches us alone, and we end them in good order.
                self._processes.append(
                    subprocess.Popen(
                        command, stdin=subprocess.DEVNULL, stdout=log, stderr=log, start_new_session=True, preexec_fn=_end_with_parent
                    )
                )
        return self

    def __exit__(self, *_):
        self.end()

    def end(self) -> None:
        for process in self._processes:
            process.terminate()
        deadline = time.monotonic() + 5.0
        for process in self._processes:
            try:
                process.wait(max(0.0, deadline - time.monotonic()))
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        self._processes.clear()


def _end_with_parent():
    PR_SET_PDEATHSIG = 1
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGTERM)
