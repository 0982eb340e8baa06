"""Whether a swimmer's fitness stands: its life in finer steps, and its muscles by a method of higher order."""

from __future__ import annotations

import numpy as np

from ...genetics.genome import Genome
from ...parameters import Task
from ...physics.soundness import SOUND
from ...plant.muscles import muscles_had
from ..audit import Audit, held, ways_of
from ..ends import OK
from ..evaluation import Evaluation, Performance, perform
from ..repetition import Run, Way, repeat_motion
from .fitness import motion_of, score
from .kernel import Swim


def audit(genome: Genome, task: Task, seed: int, first: Performance, most_change: float | None, quick: bool) -> Audit:
    """The audit of a swimmer.  Args: first: its life as evolved; the others: see `tasks.audit.audit`."""
    return held(first.evaluation, [_run(genome, task, seed, first, way) for way in ways_of(quick)], most_change)


def _run(genome: Genome, task: Task, seed: int, first: Performance, way: Way) -> Run:
    had = muscles_had(first.activation, task, seed)
    found = repeat_motion(first.body, task, first.evaluation.metrics.substeps, first.position[0], had, way, task.windows)
    if way.anew:
        evaluation = perform(genome, task, seed, finer=way.finer).evaluation
    else:
        evaluation = _score_path(first.evaluation, had, found.path, task)
    before = first.evaluation.fitness
    change = (evaluation.fitness - before) / max(abs(before), 1e-12)
    cause = evaluation.cause or ("" if found.outcome == SOUND else "the repeated motion is not sound")
    sustained = motion_of(evaluation.metrics, task)
    return Run(way.name, evaluation.fitness, change, sustained, found.ledger, found.gap, found.chamber, cause)


def _score_path(evaluation: Evaluation, activation, path, task: Task) -> Evaluation:
    """The evaluation of the same muscles on another path."""
    m = evaluation.metrics
    active = _active(activation, task)
    return score(Swim(OK, -1, path, m.activation_amplitude, active, m.substeps, m.cells, m.springs, m.chambers), task)


def _active(activation, task: Task) -> float:
    """`Swim.active` of activation (T + 1, N), whose row k + 1 holds during control step k."""
    windows = activation[1:].reshape(task.windows, -1, activation.shape[1])
    working = np.minimum(1.0, 0.5 * np.ptp(windows, axis=1) / task.full_activity).sum(1)
    return min(1.0, float(working.min()) / task.development.max_cells)
