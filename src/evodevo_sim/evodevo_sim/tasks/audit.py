"""`audit(genome, task)`: whether a fitness stands when its life is repeated in finer steps and by a method of higher order.

Three runs of a swimmer: as evolved; in `FINER` times the steps, genes and all; and with the same muscles by the adaptive pair,
of order 5.  Of a walker: see `walk_audit`; of a seeker, all its swims: see `chemotaxis_audit`.
Each has its energy ledger: what muscles did must equal what drag and damping took and what is stored in the end.

A quick audit, for every new champion of an evolution, takes a quarter of the time: the two better runs move by the same muscles,
less finely, and keep no ledger.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ..development.body import build_body
from ..development.gabriel import adjacency, gabriel_graph
from ..genetics.genome import Genome
from ..kernels.jit import compiling
from ..parameters import ParameterError, Task, known_kind
from ..physics.forces import make_law
from ..physics.integrators import State, make_system, make_work
from ..physics.replayed_motion import Method, repeat
from ..physics.step_size import ADAPTIVE, LAWSON
from ..task_kinds import names
from .evaluation import Evaluation, perform
from .repetition import Run, Way

FINER = 8.0
TOLERANCE = 1e-9  # m and m/s, of a step of the adaptive run
QUICK_FINER, QUICK_TOLERANCE = 4.0, 1e-6
MOST_CHANGE = 0.01  # of the fitness, and of the sustained distance, by which a champion may change and still stand
LEAST_CHANGE = 5e-3  # m of sustained distance that is held against nobody: the error that default steps promise
MOST_ASTRAY = 0.1  # m, by which the last distance of a target may change
MOST_GAP = 0.02  # of the energy that went through, that may be missing in the ledger of the run as evolved
MOST_FINE_GAP = 1e-3  # the same in the two better runs


@dataclass(frozen=True, eq=False)
class Audit:
    """evaluation: as evolved; runs; faults: why the fitness does not stand, none where it does; says: what else was found."""

    evaluation: Evaluation
    runs: tuple[Run, ...]
    faults: tuple[str, ...]
    says: str = ""

    @property
    def stands(self) -> bool:
        return not self.faults


def verdict_of(found: Audit) -> str:
    """An audit in a line: whether the fitness stands, and what each way of repeating the life came to, by its name."""
    if not found.stands:
        return "FAILED: " + "; ".join(found.faults)
    return f"the fitness stands ({'; '.join(f'{run.fitness:.6g} m {run.name}' for run in found.runs[1:])})"


def audit(genome: Genome, task: Task = Task(), seed: int = 0, most_change: float | None = None, quick: bool = False) -> Audit:
    """Audit a genome's fitness.

    Args: as for `evaluate`; most_change: of the fitness, relative, that still stands; by default MOST_CHANGE, of a walker
        that of `walk_audit`; quick: see above.
    """
    if task.kind.audit is None:
        able = ", ".join(name for name in names() if known_kind(name).audit is not None)
        raise ParameterError(f"task {task.name!r} has no audit yet: give one of {able}")
    first = perform(genome, task, seed)
    evaluation = first.evaluation
    if evaluation.cause:
        return Audit(evaluation, (), (f"it fails as evolved: {evaluation.cause}",))
    return task.kind.function("audit")(genome, task, seed, first, most_change, quick)


def ways_of(quick: bool) -> tuple[Way, ...]:
    """How the life of a swimmer is repeated."""
    finer, tolerance = (QUICK_FINER, QUICK_TOLERANCE) if quick else (FINER, TOLERANCE)
    return (
        Way("as evolved", LAWSON, 1.0, 0.0, True, False),
        Way(f"{finer:g} x finer", LAWSON, finer, 0.0, not quick, not quick),
        Way("order 5, adaptive", ADAPTIVE, 1.0, tolerance, not quick, False),
    )


def held(evaluation: Evaluation, runs: Sequence[Run], most_change: float | None) -> Audit:
    """The audit that follows from the runs of `ways_of`."""
    return Audit(evaluation, tuple(runs), tuple(_faults(runs, MOST_CHANGE if most_change is None else most_change)))


def prepare(task: Task = Task(), say: Callable[[str], None] = print) -> None:
    """Compile what audits need beyond evaluations, where no process has yet; `say` is told if it is us."""
    kernel = task.kind.audit_kernel
    notice = compiling(kernel, "kernels of audits", "about half a minute") if kernel else ""
    if not notice:
        return
    say(notice)
    position = np.array([(0.0, 0.0), (1.0, 0.0), (0.5, 0.9)])
    edges = gabriel_graph(position)
    start, neighbour = np.zeros(4, np.int64), np.empty(6, np.uint32)
    adjacency(edges, 3, 3, start, neighbour)
    body = build_body(position, edges, start, neighbour, task.material.mass)
    system = make_system(body, make_law(task.material.arguments(), task.scene.arguments()))
    state = State(body.position.T.copy(), np.zeros((2, 3)), np.zeros(0))
    repeat(system, Method(LAWSON, 1, 1.0, 0.0), task.control_step, np.zeros((3, 3)), state, make_work(body), np.zeros((3, 2)))


def _faults(runs: Sequence[Run], most_change: float):
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
