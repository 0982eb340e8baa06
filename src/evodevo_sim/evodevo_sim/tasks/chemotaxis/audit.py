"""Whether a seeker's fitness stands: all its swims in finer steps, and by the method of higher order with the muscles of each.

In finer steps cells smell where those steps have brought them; with the muscles as they were they no longer steer.
"""

from __future__ import annotations

import numpy as np

from ...genetics.genome import Genome
from ...parameters import Task
from ...physics.soundness import SOUND
from ...plant.muscles import muscles_had
from ..audit import Audit, held, ways_of
from ..evaluation import Performance
from ..repetition import Run, repeat_motion
from .fitness import attempt, nearness, placements, score
from .kernel import SAMPLES, STRAIGHT


def audit(genome: Genome, task: Task, seed: int, first: Performance, most_change: float | None, quick: bool) -> Audit:
    """The audit of a seeker.  Args: first: its life as evolved; the others: see `tasks.audit.audit`."""
    result = attempt(genome, task, seed, placements(task), every=False)
    swims = [STRAIGHT, *range(result.swims)]
    kept = [_kept(genome, task, seed, shown) for shown in swims]
    return held(first.evaluation, [_run(genome, task, seed, first, result, kept, way) for way in ways_of(quick)], most_change)


def _kept(genome, task, seed, shown):
    """Track (T + 1, N, 4) and activation that muscles had (T + 1, N) of one swim."""
    shape = (task.control_steps + 1, task.development.max_cells)
    track, activations = np.full((*shape, 4), np.nan), np.full(shape, np.nan)
    result = attempt(genome, task, seed, placements(task)[: shown + 1], shown, 1.0, (track, activations))
    return track[:, : result.cells], muscles_had(activations[:, : result.cells].copy(), task, seed)


def _run(genome, task, seed, first, result, kept, way):
    before, points = first.evaluation, task.windows * SAMPLES
    motions = [
        repeat_motion(first.body, task, before.metrics.substeps, track[0, :, :2], activation, way, points) for track, activation in kept
    ]
    if way.anew:
        found = attempt(genome, task, seed, placements(task), finer=way.finer, every=False)
    else:
        paths = result.paths.copy()
        for k, motion in enumerate(motions[1:]):
            paths[k] = motion.path
        found = result._replace(path=motions[0].path, paths=paths)
    evaluation = score(found, task)
    ledger = tuple(np.sum([motion.ledger for motion in motions], axis=0).tolist())
    cause = evaluation.cause or ("" if all(m.outcome == SOUND for m in motions) else "the repeated motion is not sound")
    change = (evaluation.fitness - before.fitness) / max(abs(before.fitness), 1e-12)
    return Run(
        way.name, evaluation.fitness, change, task.windows * evaluation.metrics.slowest_window, ledger,
        max(motion.gap for motion in motions), min(motion.chamber for motion in motions), cause, nearness(found, task),
    )
