"""The pool: whatever backend brings the workers, it gets a generation evaluated, with results that depend on nobody who evaluates.

    pool = Pool(backend)
    evaluations = pool.evaluate(genomes, task, seed)

Nothing rests on an answer that was not looked at (see `answers`).  Besides, one genome of the first answer of each worker, and each that
would be champion, is evaluated here too: a worker that gives another fitness for it is sent away, and what it answered goes to others.
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import CancelledError, ThreadPoolExecutor
from pathlib import Path

from evodevo_sim.inputs import one_line
from evodevo_sim.tasks.evaluation import invalid

from evodevo_sim import Evaluation, Genome, Task

from ..backends.contract import AnswerError, Backend, BackendError, NotEvaluated, WorkerLost
from .pace import Pace
from .proof import Proofs, prove, whole
from .quarantine import set_apart
from .trial import Judge, Trials, judged
from .vigil import PoolError, Vigil, raise_if_hopeless
from .work import Asked, Work

_LOOK_EVERY = 0.1  # s
_GAP = 2.0  # s between two looks, after which it was us who stood still
_MOST_ENDED = 2  # workers that a genome may end or hang before it is judged
_REST = 0.2  # s until a worker gets anything that gave something back
CONDEMNED = "two simulators ended or hung while they evaluated it"


class Pool:
    """Evaluates genomes on the workers of a backend.

    Args: say: is told what happens, a line each; quarantine: the directory of a run, for genomes that end workers; give_up_after: s to
        wait where there is no worker; judge: what has the last word on such genomes, None where two workers have it; pace: what is known
        of times.
    """

    def __init__(
        self, backend: Backend, say: Callable[[str], object] = lambda line: print(line, file=sys.stderr), quarantine: Path | None = None,
        give_up_after: float = math.inf, judge: Judge | None = judged, pace: Pace | None = None,
    ):
        self.backend = backend
        self._say, self._quarantine, self._judge = say, quarantine, judge
        self._pace = pace or Pace()
        self._open: list[Asked] = []
        self._threads: dict[str, int] = {}  # of workers when they were last there
        self._answered: dict[str, float] = {}  # s, when each worker last did; those that never did are to be proved
        self._rejected: set[str] = set()
        self._rests: dict[str, float] = {}  # s, until when
        self._trials = Trials(judge)
        self._threads_here = ThreadPoolExecutor(1, "proof")  # none is started before there is work
        self._looked = time.monotonic()
        self._vigil = Vigil(say, give_up_after)

    def __len__(self) -> int:
        """Workers that can be given work."""
        return len(self._workers())

    def evaluate(
        self, genomes: Sequence[Genome], task: Task, seed: int, stop: Callable[[], bool] = lambda: False, best: float = -math.inf,
        bars: Sequence[float] = (),
    ) -> list[Evaluation] | None:
        """Evaluate genomes in order; None when `stop()` said to stop.  Raises PoolError where nobody comes any more.

        Args: best: fitness from which on the best of these genomes is evaluated here too; bars: see `Batch`.
        """
        work = Work(genomes, task, seed, bars)
        proofs = None if self.backend.trusted else Proofs(work, best)
        try:
            while self._share(work, stop, proofs):
                if self._best_is_right(work, proofs):
                    return [one for one in work.results if one is not None]  # all, since nothing is left
            return None
        finally:
            self._let_go()

    def wait(self, seconds: float, stop: Callable[[], bool] = lambda: False) -> bool:
        """Wait until there is a worker, or `stop()`.  Returns: whether there is one.  Raises PoolError where none will ever come."""
        deadline = time.monotonic() + seconds
        while not (stop() or self._workers() or time.monotonic() > deadline):
            raise_if_hopeless(self.backend)
            self.backend.wait([], _LOOK_EVERY)
        return bool(self._workers())

    # --- one round after the other ----------------------------------------------------------------------------------------

    def _share(self, work: Work, stop: Callable[[], bool], proofs: Proofs | None) -> bool:
        """Have all that is left evaluated.  Returns: False where `stop()` said to stop."""
        self._looked = time.monotonic()
        while before := work.left:
            if stop():
                return False
            workers = self._workers()
            self._look_at_the_silent(work, workers)
            self._give(work, workers)
            self._vigil.keep(workers, self.backend)
            self.backend.wait([one.future for one in self._open], _LOOK_EVERY)
            for one in [one for one in self._open if one.future.done()]:
                if one in self._open:  # or else its worker was lost with another one
                    self._take(one, work)
            self._take_verdicts(work)
            if proofs and work.left < before:
                proofs.begin(self._threads_here)
        return True

    def _workers(self) -> dict[str, int]:
        try:
            there = {name: threads for name, threads in self.backend.workers.items() if name not in self._rejected}
        except BackendError as error:
            raise PoolError(str(error)) from None
        self._threads |= there
        return there

    def _let_go(self) -> None:
        """A generation is over: what is still asked is of no use, but what hangs goes on to take its worker's thread."""
        for one in self._open:
            one.places = []
            if not one.hung:
                one.future.cancel()
        self._open = [one for one in self._open if one.hung]
        self._trials.forget()

    # --- giving -----------------------------------------------------------------------------------------------------------

    def _give(self, work: Work, workers: Mapping[str, int]) -> None:
        slots, now = sum(workers.values()), time.monotonic()
        asked = {name: [one for one in self._open if one.worker == name] for name in workers}
        for name in sorted(workers, key=lambda name: len(asked[name]) / workers[name]):
            at, threads = asked[name], workers[name]
            if now < self._rests.get(name, 0.0) or any(one.alone for one in at):
                continue
            while len(at) < threads + max(1, threads // 2):  # some wait there, so that it never waits for us
                size = self._pace.size(len(work.waiting), slots, self.backend.cost)
                places = work.next(name, size if name in self._answered else 1, len(workers) > 1)
                if not places:
                    break
                at.append(self._ask(places, name, work))
            if all(one.hung for one in at) and (place := self._next_suspect(work)) is not None:
                self._ask([place], name, work, alone=True)

    def _ask(self, places: list[int], worker: str, work: Work, alone: bool = False) -> Asked:
        one = Asked(places, worker, self.backend.submit(work.batch(places), worker), alone)
        self._open.append(one)
        return one

    def _next_suspect(self, work: Work) -> int | None:
        """Somebody that may be tried again: those whom two workers may have been lost with wait until it is known."""
        for place in sorted(work.again):
            if place in self._trials or any(place in one.places for one in self._open if not (one.away or one.hung)):
                continue
            away = sum(place in one.places for one in self._open if one.away)
            if not away or work.ended[place] + away < _MOST_ENDED:
                return place
        return None

    # --- looking ----------------------------------------------------------------------------------------------------------

    def _look_at_the_silent(self, work: Work, workers: Mapping[str, int]) -> None:
        now = time.monotonic()
        if now - self._looked > _GAP:
            for one in self._open:
                one.begun = None
        self._looked = now
        ranks: dict[str, int] = {}
        for one in self._open:
            rank = ranks[one.worker] = ranks.get(one.worker, 0) + 1
            if one.hung or one.future.done():
                continue
            if one.worker not in workers:
                if not one.away:
                    one.away, one.begun = True, None
                    work.suspect(one.places)
            elif one.away:
                one.away = False
                work.again.difference_update(one.places)
            elif one.begun is None:
                if rank <= workers[one.worker]:
                    one.begun = now
            elif now - one.begun > self._pace.patience([work.genomes[i] for i in one.places], work.task):
                self._hangs(one, work, workers[one.worker])

    def _hangs(self, one: Asked, work: Work, threads: int) -> None:
        """Others get what it was to evaluate; the worker goes too, where none of its threads is of use."""
        one.hung = True
        work.ended.update(one.places)
        self._say(one_line(f"simulator {one.worker} does not answer to {len(one.places)} genomes: others get them"))
        self._suspect(one, work)
        hung = sum(other.hung for other in self._open if other.worker == one.worker)
        if hung >= threads or self._answered.get(one.worker, -math.inf) < (one.begun or math.inf):
            self._go_on_without(one.worker, "it does not answer")
            self._give_back_all(one.worker, work)

    # --- taking -----------------------------------------------------------------------------------------------------------

    def _take(self, one: Asked, work: Work) -> None:
        """A future that is done: its results, or its genomes to others."""
        try:
            answer = one.future.result()
        except WorkerLost as lost:
            self._lose(one.worker, lost.reason, work)
            return
        except BackendError as error:
            raise PoolError(str(error)) from None
        except (NotEvaluated, CancelledError):
            self._open.remove(one)
            self._rests[one.worker] = time.monotonic() + _REST
            work.give_back(one.places)
            return
        except Exception as error:
            self._reject(one.worker, str(error), work)
            return
        self._open.remove(one)
        if not one.places:
            return
        genomes = [work.genomes[i] for i in one.places]
        try:
            evaluations = answer.evaluations
            if not self.backend.trusted:
                evaluations = whole(evaluations, work, one.places)
                if one.worker not in self._answered:
                    prove(one.places[0], evaluations[0], work)
        except AnswerError as error:
            work.give_back(one.places)
            self._reject(one.worker, str(error), work)
            return
        self._answered[one.worker] = time.monotonic()
        self._pace.learn(genomes, work.task, answer.seconds)
        for _, doubter in work.accept(one.places, evaluations, one.worker, sure=self.backend.trusted):
            if doubter not in self._rejected:
                self._reject(doubter, f"it calls a genome invalid that {one.worker} evaluates", work)

    def _best_is_right(self, work: Work, proofs: Proofs | None) -> bool:
        """Whether the best of a generation, where it would be champion, is so by our own evaluation; else who gave it is sent away."""
        wrong = proofs.wrong() if proofs else None
        if wrong is None:
            return True
        place, why = wrong
        self._reject(work.by[place], why, work)
        return False

    # --- losing -----------------------------------------------------------------------------------------------------------

    def _reject(self, worker: str, reason: str, work: Work) -> None:
        """Send a worker away on which nothing can rest; what it has answered in this generation goes to the others."""
        work.forget(worker)
        self._go_on_without(worker, reason)
        self._give_back_all(worker, work)

    def _lose(self, worker: str, reason: str, work: Work) -> None:
        """A worker has ended: what it had in work is suspected, the rest is given to others."""
        self._go_on_without(worker, reason)
        at = [one for one in self._open if one.worker == worker]
        done = [one for one in at if one.future.done() and not (one.future.cancelled() or one.future.exception())]
        lost = [one for one in at if one not in done]
        for rank, one in enumerate(lost):
            self._open.remove(one)
            if rank < self._threads.get(worker, 1) and not one.hung:
                work.ended.update(one.places)
                self._suspect(one, work)
            else:
                work.give_back([i for i in one.places if i not in work.again])
        for one in done:
            self._take(one, work)

    def _suspect(self, one: Asked, work: Work) -> None:
        """After a worker was lost, or hangs: what it evaluated goes on one by one; who ends another one, all alone, is judged."""
        work.suspect(one.places)
        if len(one.places) == 1 and (one.alone or one.hung or self._judge is None):
            [place] = one.places
            if work.ended[place] >= _MOST_ENDED and work.results[place] is None:
                batch = work.batch(one.places)
                self._trials.begin(place, batch, self._pace.patience(batch.genomes, batch.task))

    def _take_verdicts(self, work: Work) -> None:
        for place, verdict in self._trials.ended():
            if work.results[place] is not None:
                continue
            if isinstance(verdict, Evaluation):
                self._say(f"a genome of {len(work.genomes[place])} elements was evaluated here: {CONDEMNED}")
                work.set(place, verdict)
            else:
                work.set(place, invalid(CONDEMNED))
                genome = work.genomes[place]
                where = set_apart(self._quarantine, genome, work.task, work.seed, f"{CONDEMNED}; {verdict}")
                self._say(one_line(f"a genome of {len(genome)} elements counts as failed: {CONDEMNED}{where}"))

    def _go_on_without(self, worker: str, reason: str) -> None:
        if worker in self._rejected:
            return
        self._rejected.add(worker)
        self._vigil.lost(worker, reason)
        self.backend.drop(worker, reason)
        if self._vigil.waits or self._workers():
            self._say(one_line(f"going on without simulator {worker}: {reason}"))

    def _give_back_all(self, worker: str, work: Work) -> None:
        for one in [one for one in self._open if one.worker == worker]:
            self._open.remove(one)
            work.give_back([i for i in one.places if i not in work.again])

