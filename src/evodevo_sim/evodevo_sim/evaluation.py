"""`evaluate(genome, task, seed)`: the one pure function that evolution, nodes and notebooks call."""

from __future__ import annotations

from dataclasses import dataclass, fields
from enum import IntEnum

import numpy as np

from ._jit import is_compiled, remove_old_caches
from .body import build_body
from .genome import INPUT_NAMES, Genome, random_genome
from .parameters import Task
from .swim import develop, swim


class Status(IntEnum):
    """How an evaluation ended; the same numbers as in `evodevo_msgs/Evaluation`."""

    OK = 0
    NO_GROWTH = 1
    NO_CHAMBER = 2
    RESTING = 3
    UNSTABLE = 4
    INVERTED = 5
    INVALID_GENOME = 6


# Fitness of what cannot be scored: all of it below a body that stands still, ordered so that growing comes before failing.
_FAILURE = {
    Status.NO_CHAMBER: (-1.0, "the body has no closed chamber"),
    Status.NO_GROWTH: (-2.0, "the egg never divided"),
    Status.INVERTED: (-3.0, "a chamber turned inside out or a spring collapsed"),
    Status.UNSTABLE: (-4.0, "the physics blew up even with finer steps"),
    Status.INVALID_GENOME: (-5.0, ""),
}


@dataclass(frozen=True)
class Metrics:
    """What was measured; units as in `evodevo_msgs/Metrics`."""

    cells: int = 0
    springs: int = 0
    chambers: int = 0
    substeps: int = 0
    distance: float = 0.0
    distance_second_half: float = 0.0
    slowest_window: float = 0.0
    activation_amplitude: float = 0.0


@dataclass(frozen=True)
class Evaluation:
    """fitness in m; status; cause, empty unless it failed; metrics."""

    fitness: float
    status: Status
    cause: str
    metrics: Metrics


@dataclass(frozen=True, eq=False)
class Performance:
    """A life to look at: growth, body and locomotion.  NaN stands where there is no cell (yet).

    Attributes:
        evaluation: of the same run, bit for bit.
        growth (S + 1, N, 2) m, growth_activation (S + 1, N), growth_edges: list of (E, 2) per step.
        body: see `body.Body`, or None where nothing grew.
        time (T + 1,) s; position, velocity (T + 1, N, 2); activation (T + 1, N) of e - c.
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


def _given_inputs(task: Task) -> np.ndarray:
    """Which input signals the scene of a task has: none has a scent yet."""
    return np.array([name != "scent" for name in INPUT_NAMES])


def _arguments(genome: Genome, task: Task):
    continual = task.development.variant == "continual_graph"
    return (
        genome.arrays(), task.arguments(), task.development.arguments(), continual, task.material.arguments(),
        task.scene.arguments(), _given_inputs(task),
    )


def evaluate(genome: Genome, task: Task = Task(), seed: int = 0) -> Evaluation:
    """Evaluate a genome.  Pure: equal arguments give equal bits.

    Args:
        genome: see `Genome`.
        task: what for.
        seed: of whatever the task draws at random; swimming draws nothing.
    """
    return _score(swim(*_arguments(genome, task), 1, np.empty((0, 0, 0)), np.empty((0, 0))), task)


def _score(result, task: Task) -> Evaluation:
    status = Status(result.status)
    path = result.path
    failed = status in _FAILURE
    metrics = Metrics(
        cells=result.cells,
        springs=result.springs,
        chambers=result.chambers,
        substeps=result.substeps,
        distance=0.0 if failed else float(np.hypot(*(path[-1] - path[0]))),
        distance_second_half=0.0 if failed else float(np.hypot(*(path[-1] - path[task.windows // 2]))),
        slowest_window=0.0 if failed else float(np.hypot(*np.diff(path, axis=0).T).min()),
        activation_amplitude=0.0 if failed else result.amplitude,
    )
    if failed:
        fitness, cause = _FAILURE[status]
        if result.failed_step >= 0:
            cause += f", at control step {result.failed_step}"
        return Evaluation(fitness, status, cause, metrics)
    # Motion counts only as far as muscles move it, to the end: creeping and coasting with a network at rest earn nothing.
    fitness = result.active * (task.windows * metrics.slowest_window + task.activity_bonus)
    return Evaluation(fitness, status, "", metrics)


def prepare(task: Task = Task(), say=print) -> None:
    """Load the kernels that evaluations of a task need, compiled by the first process that asks; `say` is told if that is us."""
    if not is_compiled("swim.swim"):
        say("Compiling the simulation kernels, once: about a minute.")
        remove_old_caches()
    evaluate(random_genome(np.random.default_rng(0)), task)


def invalid(cause: str) -> Evaluation:
    """The evaluation of what is no genome at all."""
    return Evaluation(_FAILURE[Status.INVALID_GENOME][0], Status.INVALID_GENOME, cause, Metrics())


def perform(genome: Genome, task: Task = Task(), seed: int = 0, finer: int = 1) -> Performance:
    """Evaluate a genome with everything kept, to record, draw or analyse.  Args: finer: times as many substeps, for an audit."""
    arguments = _arguments(genome, task)
    development = task.development
    shape = (development.steps + 1, development.max_cells)
    growth, growth_activation = np.full((*shape, 2), np.nan), np.full(shape, np.nan)
    limit = development.max_cells
    most_edges = 3 * limit + 1 if arguments[3] else max(3 * limit, limit * (limit - 1) // 2) + 1
    graphs = np.full((development.steps + 1, most_edges, 2), -1)
    _, _, embryo = develop(arguments[0], arguments[2], arguments[3], arguments[6], growth, growth_activation, graphs)
    cells = embryo.position.shape[0]
    body = None
    if cells > 1:
        body = build_body(embryo.position, embryo.edges, embryo.start, embryo.neighbour, task.material.mass)
    track = np.full((task.control_steps + 1, cells, 4), np.nan)
    traces = np.full((task.control_steps + 1, cells), np.nan)
    evaluation = _score(swim(*arguments, finer, track, traces), task)
    return Performance(
        evaluation=evaluation,
        growth=growth[:, :cells],
        growth_activation=growth_activation[:, :cells],
        growth_edges=[edges[edges[:, 0] >= 0] for edges in graphs],
        body=body,
        time=np.arange(task.control_steps + 1) * task.control_step,
        position=track[..., :2].copy(),
        velocity=track[..., 2:].copy(),
        activation=traces,
    )
