"""One look at every answer of a simulator, or of whatever stands in its place, before anything rests on it."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from itertools import repeat
from typing import Any

from evodevo_sim.ros.barrier import brief
from evodevo_sim.ros.messages import evaluation_from_message
from evodevo_sim.tasks.outcome import FAILURE, Metrics, Steering

from evodevo_sim import Evaluation, Status

_NUMBERS = [field.name for field in dataclasses.fields(Metrics) if field.name != "steering"]
_STEERING = [field.name for field in dataclasses.fields(Steering)]


class AnswerError(ValueError):
    """An answer on which nothing can rest; the message says why, in one line."""


def look_at(response: Any, count: int, bars: Sequence[float] = ()) -> list[Evaluation]:
    """The evaluations of an answer to a request of `count` genomes with these bars, or none.  Raises AnswerError."""
    if response.error:
        raise AnswerError(brief(response.error))
    if len(response.evaluations) != count:
        raise AnswerError(f"it answers {len(response.evaluations)} evaluations for {count} genomes")
    return [_evaluation(message, bar) for message, bar in zip(response.evaluations, bars or repeat(-math.inf))]


def _evaluation(message, bar: float) -> Evaluation:
    try:
        evaluation = evaluation_from_message(message)
    except ValueError:
        raise AnswerError(f"it answers a status of {message.status}, which is unknown") from None
    fitness, status, cause, metrics = evaluation.fitness, evaluation.status, evaluation.cause, evaluation.metrics
    if not math.isfinite(fitness):
        raise AnswerError(f"it answers a fitness of {fitness}")
    for part, names in ((metrics, _NUMBERS), (metrics.steering, _STEERING)):
        for name in names:
            if not math.isfinite(getattr(part, name)):
                raise AnswerError(f"it answers a {name} of {getattr(part, name)}")
    failed = status in FAILURE
    if (failed and fitness != FAILURE[status][0]) or failed != bool(cause):
        raise AnswerError(
            f"it answers a fitness of {fitness:g} {'with' if cause else 'without'} a cause of failure for the status {status.name}"
        )
    if status == Status.STOPPED and not fitness < bar:
        what = "without a bar" if bar == -math.inf else f"with a fitness of {fitness:.6g}, not below the bar of {bar:.6g}"
        raise AnswerError(f"it answers that it stopped a life {what}")
    return evaluation if len(cause) <= 300 else dataclasses.replace(evaluation, cause=brief(cause))


def alike(one: Evaluation, other: Evaluation) -> bool:
    """Whether two evaluations are of the same bits; causes are words, in which versions may differ."""
    return one.fitness == other.fitness and one.status == other.status and one.metrics == other.metrics
