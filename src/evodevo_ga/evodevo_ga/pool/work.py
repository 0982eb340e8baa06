"""A generation on its way: what waits, what is known, and what is suspected."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Sequence
from concurrent.futures import Future
from dataclasses import dataclass

from evodevo_sim import Evaluation, Genome, Status, Task

from ..backends.contract import Answer, Batch


@dataclass(eq=False)
class Asked:
    """A batch at a worker.

    Attributes: places: in the generation, none once that is over; alone: whether the worker has nothing else, so that what happens to
        it is by this batch; begun: s, since when it is in work as far as one can tell, or None; away: whether the worker is out of
        reach; hung: whether it took longer than anything takes.
    """

    places: list[int]
    worker: str
    future: Future[Answer]
    alone: bool = False
    begun: float | None = None
    away: bool = False
    hung: bool = False


class Work:
    """What is to be evaluated, and what is known of it.

    Attributes, by place: results; by: who gave them; ended: workers that were lost or hung while they evaluated it, alone or beside
        others; doubted: who said that it is no genome, which another one is to confirm.  waiting: places that are given in batches;
        again: those that somebody has had who was lost, hangs or is out of reach, which are given one by one.
    """

    def __init__(self, genomes: Sequence[Genome], task: Task, seed: int, bars: Sequence[float] = ()):
        self.genomes, self.task, self.seed, self.bars = list(genomes), task, seed, tuple(bars)
        self.results: list[Evaluation | None] = [None] * len(self.genomes)
        self.left = len(self.genomes)
        self.by: dict[int, str] = {}
        self.ended: Counter[int] = Counter()
        self.doubted: dict[int, str] = {}
        self.waiting: deque[int] = deque(range(len(self.genomes)))
        self.again: set[int] = set()

    def batch(self, places: Sequence[int]) -> Batch:
        return Batch(tuple(self.genomes[i] for i in places), self.task, self.seed, self.bars_of(places))

    def bars_of(self, places: Sequence[int]) -> tuple[float, ...]:
        """None, or one for each place."""
        return tuple(self.bars[i] for i in places) if self.bars else ()

    def next(self, worker: str, size: int, others: bool) -> list[int]:
        """Places for a worker, from those that wait: none that it has called no genome, where others can say whether that is so."""
        places: list[int] = []
        for _ in range(len(self.waiting)):
            if len(places) == size:
                break
            place = self.waiting.popleft()
            if self.results[place] is not None:
                continue
            if others and self.doubted.get(place) == worker:
                self.waiting.append(place)
            else:
                places.append(place)
        return places

    def give_back(self, places: Sequence[int]) -> None:
        """They go to somebody else, before the others."""
        self.waiting.extendleft(i for i in reversed(places) if self.results[i] is None)

    def suspect(self, places: Sequence[int]) -> None:
        """They go to somebody else one by one, when nothing else waits."""
        self.again.update(i for i in places if self.results[i] is None)

    def accept(self, places: Sequence[int], evaluations: Sequence[Evaluation], worker: str, sure: bool = False) -> list[tuple[int, str]]:
        """Take evaluations; of two for a place the first counts.  Args: sure: whether nobody needs to confirm them.

        Returns: (place, who called it no genome, though it was evaluated) for each such place.
        """
        contradicted = []
        for i, evaluation in zip(places, evaluations):
            if self.results[i] is not None:
                continue
            doubter = self.doubted.get(i)
            if evaluation.status == Status.INVALID_GENOME and doubter is None and not sure:
                self.doubted[i] = worker
                self.waiting.append(i)
                continue
            if evaluation.status != Status.INVALID_GENOME and doubter is not None and doubter != worker:
                contradicted.append((i, doubter))
            self.set(i, evaluation)
            self.by[i] = worker
        return contradicted

    def set(self, place: int, evaluation: Evaluation) -> None:
        """A result that holds, whoever it is from."""
        if self.results[place] is None:
            self.left -= 1
        self.results[place] = evaluation
        self.again.discard(place)

    def forget(self, worker: str) -> None:
        """Nothing that a worker has answered counts."""
        places = [i for i, by in self.by.items() if by == worker]
        for i in places:
            self.results[i] = None
            del self.by[i]
        self.left += len(places)
        self.waiting.extend(places)
        for i in [i for i, doubter in self.doubted.items() if doubter == worker]:
            del self.doubted[i]
