"""`audit(genome, task)`: whether a fitness stands when its life is repeated in finer steps and by a method of higher order.

Three runs: as evolved; in `FINER` times the steps, genes and all; and with the same muscles by the adaptive pair, of order 5.
Each has its energy ledger: what muscles did must equal what drag and damping took and what is stored in the end.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ._jit import kernel
from .energy import least_chamber, stored_energy
from .evaluation import Evaluation, Performance, _score, perform
from .genome import Genome
from .integrators import carry, carry_adaptively, make_system, make_work
from .parameters import Task
from .physics import SOUND, UNSTABLE, make_law, set_rest_lengths
from .stability import ADAPTIVE, RK4, is_sound
from .swim import OK, Swim, centre_of_mass

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
    runs = [_run("as evolved", first, first, task, RK4, substeps), _run(f"{FINER} x finer", fine, first, task, RK4, substeps * FINER)]
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
    position, velocity = first.position[0].copy(), np.zeros_like(first.position[0])
    ledger, path = np.zeros(4), np.zeros((task.windows + 1, 2))
    outcome, gain, chamber = repeat(
        system, method, steps, TOLERANCE, task.control_step, first.activation, position, velocity, make_work(len(position)), ledger, path
    )
    gap = abs(gain - ledger.sum()) / max(abs(ledger[1:]).sum(), 1e-12)
    cause = "" if outcome == SOUND else "the repeated motion is not sound"
    evaluation = performance.evaluation if performance else _score_path(first.evaluation, path, task)
    before = first.evaluation.fitness
    change = (evaluation.fitness - before) / max(abs(before), 1e-12)
    return Run(name, evaluation.fitness, change, tuple(ledger.tolist()), float(gap), float(chamber), evaluation.cause or cause)


def _score_path(evaluation: Evaluation, path, task: Task) -> Evaluation:
    """The evaluation of the same muscles on another path."""
    m = evaluation.metrics
    return _score(Swim(OK, -1, path, m.activation_amplitude, m.substeps, m.cells, m.springs, m.chambers), task)


@kernel
def repeat(system, method, steps, tolerance, control_step, activation, position, velocity, work, ledger, path):
    """Move a body by the muscles of a life, in place, with its ledger.

    Args: activation (T + 1, N) of e - c, whose row k + 1 holds during control step k; path (windows + 1, 2): filled.

    Returns: (outcome; gain of stored energy, J; least S / S0 of any chamber after any control step).
    """
    body, law = system.body, system.law
    count, windows = activation.shape[0] - 1, path.shape[0] - 1
    h, least, outcome = control_step / 16.0, 1.0, SOUND
    set_rest_lengths(body, activation[0], system.rest)
    begin = stored_energy(body, law, system.rest, 0.0, position, velocity)
    path[:, 0], path[:, 1] = centre_of_mass(position, body.inverse_mass)
    for k in range(count):
        before = stored_energy(body, law, system.rest, 0.0, position, velocity)
        set_rest_lengths(body, activation[k + 1], system.rest)
        after = stored_energy(body, law, system.rest, 0.0, position, velocity)
        ledger[0] += after[1] - before[1]  # muscles do their work at once, at the start of a control step
        if method == ADAPTIVE:
            outcome, h, _ = carry_adaptively(system, 0.0, control_step, tolerance, h, position, velocity, work, ledger)
        else:
            carry(system, method, 0.0, control_step, steps, position, velocity, work, ledger)
        if outcome == SOUND:
            outcome = is_sound(system, position, velocity, 0.0, work)
        if outcome != SOUND:
            return outcome, np.nan, least
        least = min(least, least_chamber(body, position)[0])
        if (k + 1) % (count // windows) == 0:
            path[(k + 1) // (count // windows) :, 0], path[(k + 1) // (count // windows) :, 1] = centre_of_mass(position, body.inverse_mass)
    end = stored_energy(body, law, system.rest, 0.0, position, velocity)
    gain = 0.0
    for part in range(4):
        gain += end[part] - begin[part]
    return (outcome if gain == gain else UNSTABLE), gain, least
