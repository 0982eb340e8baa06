"""One look at every answer of a worker, or of whatever stands in its place, before anything rests on it."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from itertools import repeat

from evodevo_sim.inputs import one_line, shown
from evodevo_sim.tasks.outcome import FAILURE, Metrics, Steering

from evodevo_sim import Evaluation, Status

from .backends.contract import AnswerError

_NUMBERS = [field.name for field in dataclasses.fields(Metrics) if field.name != "steering"]
_STEERING = [field.name for field in dataclasses.fields(Steering)]


def looked_at(evaluations: Sequence[Evaluation], count: int, bars: Sequence[float] = ()) -> list[Evaluation]:
    """The evaluations of an answer to `count` genomes with these bars, or none; causes of any length made brief.  Raises AnswerError."""
    if len(evaluations) != count:
        raise AnswerError(f"it answers {len(evaluations)} evaluations for {count} genomes")
    return [_sound(evaluation, bar) for evaluation, bar in zip(evaluations, bars or repeat(-math.inf))]


def _sound(evaluation: Evaluation, bar: float) -> Evaluation:
    if not isinstance(evaluation, Evaluation):
        raise AnswerError(f"it answers {shown(evaluation)} for an evaluation")
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
    return evaluation if len(cause) <= 300 else dataclasses.replace(evaluation, cause=one_line(cause))


def alike(one: Evaluation, other: Evaluation) -> bool:
    """Whether two evaluations are of the same bits; causes are words, in which versions may differ."""
    return one.fitness == other.fitness and one.status == other.status and one.metrics == other.metrics
