"""How long evaluations take, by what was measured: it sizes batches, and tells a worker that is slow from one that hangs."""

from __future__ import annotations

import math
from collections.abc import Sequence

from evodevo_sim import Genome, Task

TARGET = 0.5  # s that a batch takes: long against a message, short against a generation
MOST = 64  # genomes in a batch
FIRST = 4  # genomes in a batch, where nothing was measured
_NEW = 0.2  # weight of a new measurement
_SLOW_STEP = 1e-3  # s, which no control step of a body takes
_SLOW_PAIR = 1e-9  # s for a pair of genetic elements in a cell and a step
_PATIENCE = 20.0  # times as long as the slowest, by the same bound, that was measured


def slowest(genomes: Sequence[Genome], task: Task) -> float:
    """s that the evaluation of genomes does not take, whatever the machine; usually it takes a hundredth of that."""
    steps = task.development.steps + task.starts * (task.settling_limit + task.control_steps)
    return sum(steps * (_SLOW_STEP + _SLOW_PAIR * len(genome) ** 2 * task.development.max_cells) for genome in genomes)


class Pace:
    """What answers have told of times.

    Args: least: s that a worker has for a batch, whatever was measured.
    Attributes: seconds: that a genome takes in the mean of late, or 0.
    """

    def __init__(self, least: float = 60.0) -> None:
        self._least = least
        self.seconds = 0.0
        self._worst = 0.0  # of times by their bounds

    def learn(self, genomes: Sequence[Genome], task: Task, seconds: float) -> None:
        """A batch took so long."""
        if seconds > 0.0 and genomes:
            each = seconds / len(genomes)
            self.seconds = self.seconds + _NEW * (each - self.seconds) if self.seconds else each
            self._worst = max(self._worst, seconds / slowest(genomes, task))

    def size(self, left: int, slots: int, cost: float = 0.0) -> int:
        """Genomes for the next batch: fewer towards the end, so that the last to finish keeps nobody waiting.

        Args: left: genomes that wait; slots: batches that workers take at once; cost: s that it takes us to give a batch.  In batches of
            n we need left / n costs, and wait for n evaluations at the end: both together are least where n^2 = left cost / seconds.
        """
        by_time = int(max(TARGET, cost * slots) / self.seconds) if self.seconds else FIRST  # who gives batches must keep up
        worth_it = int(math.sqrt(left * cost / self.seconds)) if self.seconds else 1
        return max(1, min(max(left // (2 * max(slots, 1)), worth_it), by_time, MOST))

    def patience(self, genomes: Sequence[Genome], task: Task) -> float:
        """s in work after which a batch counts as hanging.

        It decides only when others are asked too, and who judges: no fitness depends on it.
        """
        bound = slowest(genomes, task)
        return self._least + min(1.0, _PATIENCE * self._worst if self._worst else 1.0) * bound
