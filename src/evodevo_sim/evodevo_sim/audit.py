"""`audit(genome, task)`: whether a fitness stands when its life is repeated in finer steps and by a method of higher order.

Three runs: as evolved; in `FINER` times the steps, genes and all; and with the same muscles by the adaptive pair, of order 5.
Each has its energy ledger: what muscles did must equal what drag and damping took and what is stored in the end.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .evaluation import Evaluation, Performance, perform
from .genome import Genome
from .integrators import make_system, make_work
from .life import OK
from .parameters import Task
from .physics import SOUND, make_law
from .stability import ADAPTIVE, RK4
from .swim import Swim
from .swim_task import score
from .trajectory import repeat

FINER = 8
TOLERANCE = 1e-9  # m and m/s, of a step of the adaptive run
MOST_CHANGE = 0.01  # of the fitness, by which a champion may change and still stand
MOST_GAP = 0.02  # of the energy that went through, that may be missing in the ledger of the run as evolved
MOST_FINE_GAP = 1e-3  # the same in the two better runs


@dataclass(frozen=True)
class Run:
    """name; fitness, m; change of it, relative to the run as evolved; ledger: J by muscles, drag, damping, ground; gap: energy
    that the ledger does not explain, relative to what drag and damping took; chamber: least S / S0; cause: why it failed."""

    name: str
    fitness: float
    change: float
    ledger: tuple[float, ...]
    gap: float
    chamber: float
    cause: str = ""


@dataclass(frozen=True)
class Audit:
    """evaluation: as evolved; runs; faults: why the fitness does not stand, none where it does."""

    evaluation: Evaluation
    runs: tuple[Run, ...]
    faults: tuple[str, ...]

    @property
    def stands(self) -> bool:
        return not self.faults


def audit(genome: Genome, task: Task = Task(), seed: int = 0, most_change: float = MOST_CHANGE) -> Audit:
    """Audit a genome's fitness.  Args: as for `evaluate`; most_change: of the fitness, relative, that still stands."""
    first = perform(genome, task, seed)
    evaluation = first.evaluation
    if evaluation.cause:
        return Audit(evaluation, (), (f"it fails as evolved: {evaluation.cause}",))
    substeps = evaluation.metrics.substeps
    fine = perform(genome, task, seed, finer=FINER)
    runs = [
        _run("as evolved", first, first, task, RK4, substeps),
        _run(f"{FINER} x finer", fine, first, task, RK4, substeps * FINER),
    ]
    if not task.has_target:  # the same muscles do not follow a target on another path
        runs.append(_run("order 5, adaptive", None, first, task, ADAPTIVE, 0))
    return Audit(evaluation, tuple(runs), tuple(_faults(runs, most_change)))


def _faults(runs, most_change):
    for run in runs:
        if run.cause:
            yield f"{run.name}: {run.cause}"
            continue
        if not abs(run.change) <= most_change:
            yield f"{run.name}: fitness changes by {run.change:+.2g} of itself, more than {most_change:g}"
        most_gap = MOST_GAP if run is runs[0] else MOST_FINE_GAP
        if not run.gap <= most_gap:
            yield f"{run.name}: {run.gap:.2%} of the energy is unexplained, more than {most_gap:.1%}"
        if not run.chamber > 0.0:
            yield f"{run.name}: a chamber turned inside out"


def _run(name, performance: Performance | None, first: Performance, task: Task, method, steps) -> Run:
    """The ledger of a run, and its fitness: that of a performance, or of the repeated motion itself."""
    system = make_system(first.body, make_law(task.material.arguments(), task.scene.arguments()))
    position, velocity = first.position[0].T.copy(), np.zeros((2, len(first.position[0])))
    ledger, path = np.zeros(4), np.zeros((task.windows + 1, 2))
    outcome, gain, chamber = repeat(
        system, method, steps, TOLERANCE, task.control_step, first.activation, position, velocity, make_work(first.body),
        ledger, path,
    )
    gap = abs(gain - ledger.sum()) / max(abs(ledger[1:]).sum(), 1e-12)
    cause = "" if outcome == SOUND else "the repeated motion is not sound"
    evaluation = performance.evaluation if performance else _score_path(first.evaluation, first.activation, path, task)
    before = first.evaluation.fitness
    change = (evaluation.fitness - before) / max(abs(before), 1e-12)
    return Run(name, evaluation.fitness, change, tuple(ledger.tolist()), float(gap), float(chamber), evaluation.cause or cause)


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
