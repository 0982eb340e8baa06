"""Answers against our own evaluation, which is pure: whoever gives other bits is not to be trusted."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor, Future

from evodevo_sim.inputs import one_line

from evodevo_sim import Evaluation, Status, evaluate

from ..answers import alike, looked_at
from ..backends.contract import AnswerError
from .work import Work


def whole(evaluations: Sequence[Evaluation], work: Work, places: Sequence[int]) -> list[Evaluation]:
    """The evaluations of an answer for some places, looked at.  Raises AnswerError, whatever is wrong with them."""
    try:
        return looked_at(evaluations, len(places), work.bars_of(places))
    except AnswerError:
        raise
    except Exception as error:
        raise AnswerError(f"its answer cannot be read: {one_line(f'{type(error).__name__}: {error}')}") from None


def prove(place: int, evaluation: Evaluation, work: Work) -> None:
    """Raises AnswerError where our own evaluation of a genome is another one."""
    _compare(_own(place, work), evaluation)


def _own(place: int, work: Work) -> Evaluation:
    return evaluate(work.genomes[place], work.task, work.seed, *work.bars_of([place]))


def _compare(own: Evaluation, evaluation: Evaluation) -> None:
    if not alike(own, evaluation):
        raise AnswerError(f"it gives a genome a fitness of {evaluation.fitness:.6g} that has {own.fitness:.6g} by our own evaluation")


class Proofs:
    """Our own evaluations of those of a generation that would be champion, begun while others are still evaluated.

    Args: best: fitness from which on that is worth it.
    """

    def __init__(self, work: Work, best: float):
        self._work, self._best = work, best
        self._begun: dict[int, Future[Evaluation]] = {}

    def begin(self, threads: Executor) -> None:
        """Begin that of the best so far, where there is none yet."""
        place = self._wanted()
        if place is not None and place not in self._begun:
            self._begun[place] = threads.submit(_own, place, self._work)

    def wrong(self) -> tuple[int, str] | None:
        """(place of the best, what is wrong with its evaluation), where it would be champion and is not as our own; waits for that."""
        place = self._wanted()
        found = None if place is None else self._work.results[place]
        if place is None or found is None:
            return None
        try:
            _compare(self._begun[place].result() if place in self._begun else _own(place, self._work), found)
        except AnswerError as error:
            return place, str(error)
        return None

    def _wanted(self) -> int | None:
        found = best_of(self._work)
        return found[0] if found and found[1].fitness > self._best and found[0] in self._work.by else None


def best_of(work: Work) -> tuple[int, Evaluation] | None:
    """(place, evaluation) of the best of a generation, of equals the first one; None where every life was stopped."""
    found = [(one.fitness, -place, one) for place, one in enumerate(work.results) if one and one.status != Status.STOPPED]
    if not found:
        return None
    _, place, evaluation = max(found, key=lambda of: of[:2])
    return -place, evaluation
