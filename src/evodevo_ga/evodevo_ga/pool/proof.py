"""Answers against our own evaluation, which is pure: whoever gives other bits is not to be trusted."""

from __future__ import annotations

from collections.abc import Sequence

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
    own = evaluate(work.genomes[place], work.task, work.seed, *work.bars_of([place]))
    if not alike(own, evaluation):
        raise AnswerError(f"it gives a genome a fitness of {evaluation.fitness:.6g} that has {own.fitness:.6g} by our own evaluation")


def best_of(work: Work) -> tuple[int, Evaluation] | None:
    """(place, evaluation) of the best of a generation, of equals the first one; None where every life was stopped."""
    found = [(one.fitness, -place, one) for place, one in enumerate(work.results) if one and one.status != Status.STOPPED]
    if not found:
        return None
    _, place, evaluation = max(found, key=lambda of: of[:2])
    return -place, evaluation
