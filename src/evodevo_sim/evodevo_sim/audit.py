"""`audit(genome, task)`: whether a fitness stands when its life is repeated in finer steps and by a method of higher order.

Three runs of a swimmer: as evolved; in `FINER` times the steps, genes and all; and with the same muscles by the adaptive pair,
of order 5.  Of a walker: see `walk_audit`; of a seeker, all its swims: see `chemotaxis_audit`.
Each has its energy ledger: what muscles did must equal what drag and damping took and what is stored in the end.

A quick audit, for every new champion of an evolution, takes a quarter of the time: the two better runs move by the same muscles,
less finely, and keep no ledger.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np

from ._jit import is_compiled
from .body import build_body
from .chemotaxis_audit import audit_seeker
from .evaluation import Evaluation, Performance, perform
from .forces import make_law
from .gabriel import adjacency, gabriel_graph
from .genome import Genome
from .integrators import make_system, make_work
from .life import OK
from .parameters import ParameterError, Task
from .physics import SOUND
from .stability import ADAPTIVE, RK4
from .swim import Swim
from .swim_task import score
from .trajectory import repeat
from .walk_audit import audit_walk

TASKS = ("swim", "walk", "chemotaxis")  # that audits can repeat
FINER = 8
TOLERANCE = 1e-9  # m and m/s, of a step of the adaptive run
QUICK_FINER, QUICK_TOLERANCE = 4, 1e-6
MOST_CHANGE = 0.01  # of the fitness, and of the sustained distance, by which a champion may change and still stand
LEAST_CHANGE = 5e-3  # m of sustained distance that is held against nobody: the error that default steps promise
MOST_ASTRAY = 0.1  # m, by which the last distance of a target may change
MOST_GAP = 0.02  # of the energy that went through, that may be missing in the ledger of the run as evolved
MOST_FINE_GAP = 1e-3  # the same in the two better runs


@dataclass(frozen=True)
class Run:
    """name; fitness, m; change of it, relative to the run as evolved; sustained, m: windows x slowest window, the part of fitness
    that is motion; ledger: J by muscles, drag, damping, ground, or empty; gap: energy that the ledger does not explain, relative
    to what drag and damping took; chamber: least S / S0; cause: why it failed; near: last distance of each target, m."""

    name: str
    fitness: float
    change: float
    sustained: float
    ledger: tuple[float, ...]
    gap: float
    chamber: float
    cause: str = ""
    near: tuple[float, ...] = ()


@dataclass(frozen=True)
class Motion:
    """A motion repeated: path (points + 1, 2) m of the centre of mass; ledger, gap, chamber: see `Run`; outcome: SOUND or not."""

    path: np.ndarray
    ledger: tuple[float, ...]
    gap: float
    chamber: float
    outcome: int


@dataclass(frozen=True)
class Audit:
    """evaluation: as evolved; runs; faults: why the fitness does not stand, none where it does; says: what else was found."""

    evaluation: Evaluation
    runs: tuple[Run, ...]
    faults: tuple[str, ...]
    says: str = ""

    @property
    def stands(self) -> bool:
        return not self.faults


def audit(genome: Genome, task: Task = Task(), seed: int = 0, most_change: float | None = None, quick: bool = False) -> Audit:
    """Audit a genome's fitness.

    Args: as for `evaluate`; most_change: of the fitness, relative, that still stands; by default MOST_CHANGE, of a walker
        that of `walk_audit`; quick: see above.
    """
    if task.name not in TASKS:
        raise ParameterError(f"task {task.name!r} has no audit yet: give one of {', '.join(TASKS)}")
    first = perform(genome, task, seed)
    evaluation = first.evaluation
    if evaluation.cause:
        return Audit(evaluation, (), (f"it fails as evolved: {evaluation.cause}",))
    if task.name == "walk":
        evaluation, runs, faults, says = audit_walk(genome, task, seed, most_change, quick, first.body, Run)
        return Audit(evaluation, tuple(runs), tuple(faults), says)
    most_change = MOST_CHANGE if most_change is None else most_change
    finer, tolerance = (QUICK_FINER, QUICK_TOLERANCE) if quick else (FINER, TOLERANCE)
    rows = [
        ("as evolved", RK4, 1, 0.0, True, False),
        (f"{finer} x finer", RK4, finer, 0.0, not quick, not quick),
        ("order 5, adaptive", ADAPTIVE, 1, tolerance, not quick, False),
    ]
    motion = partial(_repeat, first.body, task, evaluation.metrics.substeps)
    if task.name == "chemotaxis":
        runs = audit_seeker(genome, task, seed, rows, motion, Run, evaluation)
    else:
        runs = [_run(genome, task, seed, first, row, motion) for row in rows]
    return Audit(evaluation, tuple(runs), tuple(_faults(runs, most_change)))


def prepare(task: Task = Task(), say=print) -> None:
    """Compile what audits need beyond evaluations, where no process has yet; `say` is told if it is us."""
    if task.name == "walk" or is_compiled("trajectory.repeat"):
        return
    say("Compiling the kernels of audits, once: about half a minute.")
    position = np.array([(0.0, 0.0), (1.0, 0.0), (0.5, 0.9)])
    edges = gabriel_graph(position)
    start, neighbour = np.zeros(4, np.int64), np.empty(6, np.uint32)
    adjacency(edges, 3, 3, start, neighbour)
    body = build_body(position, edges, start, neighbour, task.material.mass)
    system = make_system(body, make_law(task.material.arguments(), task.scene.arguments()))
    repeat(
        system, RK4, 1, 1, 0.0, task.control_step, np.zeros((3, 3)), body.position.T.copy(), np.zeros((2, 3)), make_work(body),
        np.zeros(0), np.zeros((3, 2)),
    )


def _faults(runs, most_change):
    before = runs[0].sustained
    # Of a seeker the way that it swims without a target is a small part of what it earns, and held against all of that.
    most_shift = max(most_change * (runs[0].fitness if runs[0].near else before), LEAST_CHANGE)
    for run in runs:
        if run.cause:
            yield f"{run.name}: {run.cause}"
            continue
        shift = run.sustained - before
        if not abs(run.change) <= most_change:
            yield f"{run.name}: fitness changes by {run.change:+.2g} of itself, more than {most_change:g}"
        elif not abs(shift) <= most_shift:
            yield f"{run.name}: the sustained distance changes by {shift:+.2g} m from {before:.2g} m, more than {most_shift:.2g} m"
        for k, (then, now) in enumerate(zip(runs[0].near, run.near)):
            if not abs(now - then) <= MOST_ASTRAY:
                yield f"{run.name}: it ends {now:.2f} m from target {k + 1}, {then:.2f} m as evolved: over {MOST_ASTRAY:g} m off"
        most_gap = MOST_GAP if run is runs[0] else MOST_FINE_GAP
        if run.ledger and not run.gap <= most_gap:
            yield f"{run.name}: {run.gap:.2%} of the energy is unexplained, more than {most_gap:.1%}"
        if not run.chamber > 0.0:
            yield f"{run.name}: a chamber turned inside out"


def _repeat(body, task: Task, substeps, start, activation, method, finer, tolerance, keep_ledger, points) -> Motion:
    """Repeat a motion from rest.  Args: start (N, 2) m; activation (T + 1, N); points: of the path, after the start."""
    system = make_system(body, make_law(task.material.arguments(), task.scene.arguments()))
    position, velocity = np.ascontiguousarray(start.T), np.zeros((2, len(start)))
    ledger, path = np.zeros(4 if keep_ledger else 0), np.zeros((points + 1, 2))
    outcome, gain, chamber = repeat(
        system, method, substeps, finer, tolerance, task.control_step, activation, position, velocity, make_work(body), ledger, path
    )
    gap = abs(gain - ledger.sum()) / max(abs(ledger[1:]).sum(), 1e-12) if keep_ledger else 0.0
    return Motion(path, tuple(ledger.tolist()), float(gap), float(chamber), outcome)


def _run(genome: Genome, task: Task, seed: int, first: Performance, row, motion) -> Run:
    """A run of a swimmer.  Args: row: see `audit`."""
    name, method, finer, tolerance, with_ledger, anew = row
    found = motion(first.position[0], first.activation, method, finer, tolerance, with_ledger, task.windows)
    if anew:
        evaluation = perform(genome, task, seed, finer=finer).evaluation
    else:
        evaluation = _score_path(first.evaluation, first.activation, found.path, task)
    before = first.evaluation.fitness
    change = (evaluation.fitness - before) / max(abs(before), 1e-12)
    cause = evaluation.cause or ("" if found.outcome == SOUND else "the repeated motion is not sound")
    sustained = task.windows * evaluation.metrics.slowest_window
    return Run(name, evaluation.fitness, change, sustained, found.ledger, found.gap, found.chamber, cause)


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
