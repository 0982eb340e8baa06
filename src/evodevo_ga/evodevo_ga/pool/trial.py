"""The last word on a genome that two workers were lost with: one evaluation in a process of its own, which may end or hang.

Workers are also lost by what is no genome's fault, and a search that had other results then would not be the same search.
So nobody is condemned but by a process that evaluated the genome alone.
"""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from evodevo_sim.ros.own_simulators import end_with_parent

from evodevo_sim import Evaluation, Genome, Task, evaluate

from ..backends.contract import Batch

Judge = Callable[[Batch, float], Evaluation | str]  # see `judged`

COMMAND = [sys.executable, "-m", __spec__.name]
START = 300.0  # s for the process to start, also on a host that is busy: nobody is condemned for that


class Trials:
    """Trials beside a generation, each in a thread of its own, by the genome's place in it."""

    def __init__(self, judge: Judge | None):
        self._judge = judge
        self._verdicts: dict[int, list[Evaluation | str]] = {}

    def begin(self, place: int, batch: Batch, patience: float) -> None:
        """Where there is no judge, the verdict is there at once."""
        if self._judge is None:
            self._verdicts[place] = ["no process of its own was asked"]
        elif place not in self._verdicts:
            verdict = self._verdicts[place] = []
            threading.Thread(target=self._try, args=(batch, patience, verdict), name="trial", daemon=True).start()

    def _try(self, batch: Batch, patience: float, verdict: list[Evaluation | str]) -> None:
        assert self._judge is not None
        try:
            verdict.append(self._judge(batch, patience))
        except Exception as error:  # as where there is no memory for a process
            verdict.append(f"no process could be asked: {type(error).__name__}: {error}")

    def __contains__(self, place: int) -> bool:
        return place in self._verdicts

    def ended(self) -> list[tuple[int, Evaluation | str]]:
        """Verdicts that nobody has taken."""
        found = [(place, verdict[0]) for place, verdict in self._verdicts.items() if verdict]
        for place, _ in found:
            del self._verdicts[place]
        return found

    def forget(self) -> None:
        """What is under way is of no use any more."""
        self._verdicts = {}


def judged(batch: Batch, patience: float) -> Evaluation | str:
    """The evaluation of the one genome of a batch, or how the process ended.  Args: patience: s."""
    with subprocess.Popen(
        COMMAND, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
        start_new_session=True, preexec_fn=end_with_parent,  # noqa: PLW1509  (it takes no lock: a call of the system alone)
    ) as process:
        try:
            given = pickle.dumps((batch.genomes[0], batch.task, batch.seed, batch.bars))
            answer, _ = process.communicate(given, START + patience)
        except subprocess.TimeoutExpired:
            return f"it did not end in {START + patience:.0f} s"
        finally:
            process.kill()
    if process.returncode:
        ended = f"by signal {-process.returncode}" if process.returncode < 0 else f"with exit code {process.returncode}"
        return f"the process ended {ended}"
    return pickle.loads(answer)


def _evaluated(genome: Genome, task: Task, seed: int, bars: tuple[float, ...]) -> Evaluation:
    return evaluate(genome, task, seed, *bars)


def _main() -> None:
    with suppress(OSError):  # where memory runs out, it is this process that goes
        Path("/proc/self/oom_score_adj").write_text("1000")
    given = pickle.load(sys.stdin.buffer)
    answer, sys.stdout = os.fdopen(os.dup(1), "wb"), sys.stderr
    with answer:
        answer.write(pickle.dumps(_evaluated(*given)))


if __name__ == "__main__":
    _main()
