"""`evaluate(genome, task, seed)`: the one pure function that evolution, nodes and notebooks call."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np

from ..development.body import build_body
from ..genetics.genome import Genome, random_genome
from ..kernels.jit import compiling, remove_old_caches
from ..parameters import Task
from .life import develop
from .memory import over_limit
from .outcome import Evaluation, Metrics, Status, failure
from .swim.fitness import kernel_arguments

_NOT_KEPT = np.empty((0, 0, 0)), np.empty((0, 0))


@dataclass(frozen=True, eq=False)
class Performance:
    """A life to look at: growth, body and locomotion.  NaN stands where there is no cell (yet).

    Attributes:
        evaluation: of the same run, bit for bit.
        growth (S + 1, N, 2) m, growth_activation (S + 1, N), growth_edges: list of (E, 2) per step.
        body: see `body.Body`, or None where nothing grew.
        time (T + 1,) s; position, velocity (T + 1, N, 2); activation (T + 1, N) of e - c.
        target: (x, y) m of the target that it swims towards, on the left of its way without one; None where there is none.
    """

    evaluation: Evaluation
    growth: np.ndarray
    growth_activation: np.ndarray
    growth_edges: list
    body: object
    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    activation: np.ndarray
    target: tuple[float, float] | None = None


def evaluate(genome: Genome, task: Task = Task(), seed: int = 0, bar: float = -math.inf) -> Evaluation:
    """Evaluate a genome.  Pure: equal arguments give equal bits.

    Args:
        genome: see `Genome`.
        task: what for.
        seed: of whatever the task draws at random: noise, where there is any, and of walking the orientations at birth.
        bar: m; a life is stopped as soon as it is certain that its fitness, as it would be without a bar, is below this.  Its evaluation
            then is `outcome.stopped`: of status STOPPED, with a bound of that fitness, below the bar.  All others have the same bits as
            without a bar.  A task whose `run` takes no bar has no bound, nor has a plain distance: they live on.
    """
    too_much = over_limit(genome, task)
    if too_much:
        return invalid(too_much)
    run = task.kind.function("run")
    return run(genome, task, seed, 1.0, *_NOT_KEPT, **({"bar": bar} if bar > -math.inf and _takes_bar(run) else {}))


@cache
def _takes_bar(run: Callable[..., Evaluation]) -> bool:
    return "bar" in inspect.signature(run).parameters


def prepare(task: Task = Task(), say: Callable[[str], None] = print) -> None:
    """Load the kernels that evaluations of a task need, compiled by the first process that asks; `say` is told if that is us."""
    if notice := compiling(task.kind.kernel):
        say(notice)
        remove_old_caches()
    evaluate(random_genome(np.random.default_rng(0)), task)


def invalid(cause: str) -> Evaluation:
    """The evaluation of what is no genome at all."""
    return failure(Status.INVALID_GENOME, Metrics(), cause=cause)


def perform(genome: Genome, task: Task = Task(), seed: int = 0, finer: float = 1.0) -> Performance:
    """Evaluate a genome with everything kept, to record, draw or analyse.  Args: finer: times as many substeps, rounded up."""
    genes, model = kernel_arguments(genome, task)
    development = task.development
    shape = (development.steps + 1, development.max_cells)
    growth, growth_activation = np.full((*shape, 2), np.nan), np.full(shape, np.nan)
    limit = development.max_cells
    most_edges = 3 * limit + 1 if model.continual else max(3 * limit, limit * (limit - 1) // 2) + 1
    graphs = np.full((development.steps + 1, most_edges, 2), -1)
    _, _, embryo = develop(genes, model, growth, growth_activation, graphs)
    cells = embryo.position.shape[0]
    body = None
    if cells > 1:
        body = build_body(embryo.position, embryo.edges, embryo.start, embryo.neighbour, task.material.mass)
    track = np.full((task.control_steps + 1, cells, 4), np.nan)
    activations = np.full((task.control_steps + 1, cells), np.nan)
    evaluation = task.kind.function("run")(genome, task, seed, float(finer), track, activations)
    steering = evaluation.metrics.steering
    return Performance(
        evaluation=evaluation,
        growth=growth[:, :cells],
        growth_activation=growth_activation[:, :cells],
        growth_edges=[edges[edges[:, 0] >= 0] for edges in graphs],
        body=body,
        time=np.arange(task.control_steps + 1) * task.control_step,
        position=track[..., :2].copy(),
        velocity=track[..., 2:].copy(),
        activation=activations,
        target=(steering.left_x, steering.left_y) if steering.distance else None,
    )
