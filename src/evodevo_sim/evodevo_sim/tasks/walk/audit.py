"""Whether a walker's fitness stands: from other starts, in finer steps, with its ledger of energy.

Walking is chaotic: a rounding error grows to a body length within seconds, so that one run in finer steps is another run.  What
must agree are means over many starts.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ...genetics.genome import Genome
from ...parameters import Task
from ...physics.energy import least_chamber
from ..audit import Audit
from ..evaluation import Performance
from ..outcome import FAILURE, Status
from ..repetition import Run
from .fitness import headings, kernel_arguments, moved, noise, progress, score, start_fitness
from .kernel import walk

STARTS = 16
FINER, QUICK_FINER = 8.0, 2.0
MOST_CHANGE = 0.25  # of the mean over the starts, by finer steps
LEAST_SHARE = 0.5  # of the distance, and of the fitness, that the median of other starts must reach
MOST_GAP, MOST_FINE_GAP = 0.05, 0.01  # of the energy that went through, that may be missing
_OTHER = 1  # second part of the seed of the other starts


def other_headings(seed: int) -> np.ndarray:
    """(STARTS, 2): orientations that the evaluation did not see, evenly spread: the seed shifts them by less than 23 degrees."""
    return headings((seed, _OTHER), STARTS)


def trial(genome: Genome, task: Task, directions: np.ndarray, finer: float = 1.0, seed: int = 0) -> Any:
    """(Walk, fitness (S,), ledger (S, 4), positions (T + 1, N, 2) from the first) of a walker from these directions.

    Args: seed: of noise.
    """
    ledger = np.zeros((len(directions), 4))
    cells = task.development.max_cells
    track, activations = np.full((task.control_steps + 1, cells, 4), np.nan), np.full((task.control_steps + 1, cells), np.nan)
    arguments = kernel_arguments(genome, task)
    result = walk(*arguments, directions, finer, noise(task, seed), (track, activations), ledger)
    return result, start_fitness(result, task), ledger, track[:, : result.cells, :2]


def audit(genome: Genome, task: Task, seed: int, first: Performance, most_change: float | None, quick: bool) -> Audit:
    """The audit of a walker; it also says how far it walks from other starts.

    Args: first: its life as evolved; the others: see `tasks.audit.audit`.
    """
    body = first.body
    most_change, finer = MOST_CHANGE if most_change is None else most_change, QUICK_FINER if quick else FINER
    result, _, ledger, positions = trial(genome, task, headings(seed, task.starts), seed=seed)
    evaluation = score(result, task)
    runs = [_run("as evolved", evaluation.fitness, evaluation.fitness, result, ledger, positions, task, body)]
    others = other_headings(seed)
    result, fitness, ledger, positions = trial(genome, task, others, seed=seed)
    mean, median = float(fitness.mean()), _median(fitness)
    far, own = _median(progress(result.path, task)[0]), evaluation.metrics.distance
    runs.append(_run(f"mean of {STARTS} other starts", mean, evaluation.fitness, result, ledger, positions, task, body))
    result, fine, ledger, positions = trial(genome, task, others, finer, seed)
    runs.append(_run(f"mean of those, {finer:g} x finer", float(fine.mean()), mean, result, ledger, positions, task, body))
    faults = list(_faults(runs, evaluation.fitness, median, most_change))
    if not far >= LEAST_SHARE * own:
        faults.append(
            f"{STARTS} other starts: it walks {far:.4g} m in their median, less than {LEAST_SHARE:g} of {own:.4g} m: it is the start's luck"
        )
    says = f"It walks {far:.4g} m in the median of {STARTS} other starts, {far / max(own, 1e-12):.2f} of the {own:.4g} m from its own."
    return Audit(evaluation, tuple(runs), tuple(faults), says)


def _median(values) -> float:
    """The lower of the two in the middle: what goes from half of the starts alone does not have half a median."""
    return float(np.quantile(values, 0.5, method="lower"))


def _run(name, fitness, before, result, ledger, positions, task, body):
    """A row of the audit; its energies are means over the starts."""
    gap = np.abs(result.gain - ledger.sum(1)) / np.maximum(np.abs(ledger[:, 1:]).sum(1), 1e-12)
    chamber = min((least_chamber(body, np.ascontiguousarray(p.T))[0] for p in positions if np.isfinite(p).all()), default=np.nan)
    failed = [Status(int(s)) for s in result.status if Status(int(s)) in FAILURE and s != Status.UNSETTLED]  # that earns 0
    cause = "" if not failed else f"{len(failed)} of {len(result.status)} starts: {FAILURE[failed[0]][1]}"
    change = (fitness - before) / max(abs(before), 1e-12)
    sustained = float(moved(result, task).mean())
    return Run(name, fitness, change, sustained, tuple(ledger.mean(0).tolist()), float(gap.max()), float(chamber), cause)


def _faults(runs, fitness, median, most_change):
    fine = runs[-1]
    for run in runs:
        if run.cause:
            yield f"{run.name}: {run.cause}"
        most = MOST_FINE_GAP if run is fine else MOST_GAP
        if not run.gap <= most:
            yield f"{run.name}: {run.gap:.2%} of the energy is unexplained, more than {most:.1%}"
        if not run.chamber > 0.0:
            yield f"{run.name}: a chamber turned inside out"
    if not abs(fine.change) <= most_change:
        yield f"{fine.name}: fitness changes by {fine.change:+.2g} of itself, more than {most_change:g}"
    if not median >= LEAST_SHARE * fitness:
        yield f"{STARTS} other starts: their median is {median:.4g}, less than {LEAST_SHARE:g} of the fitness"
