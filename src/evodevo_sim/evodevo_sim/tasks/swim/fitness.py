"""The swimming task around its kernel: arguments in, evaluation out."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ...brain.controller import Controller
from ...brain.scent import make_signals
from ...genetics.elements import INPUT_NAMES
from ...genetics.genome import Genome
from ...parameters import Task
from ...plant.muscles import actuators_of, strike
from ...plant.simulated import SwimmingBody
from ..halt import flag
from ..life import Model, birth
from ..outcome import FAILURE, STIFF, Evaluation, Metrics, Status, by_body, failure, stopped
from .kernel import swim


def given_inputs(task: Task) -> np.ndarray:
    """Which input signals the scene of a task has: there is a scent where there is a target."""
    return np.array([name != "scent" or task.has_target for name in INPUT_NAMES])


def kernel_arguments(genome: Genome, task: Task, bar: float = -math.inf) -> tuple:
    """(genome, Model) as kernels take them.  Args: bar: see `Model`."""
    model = Model(
        task.arguments(), task.development.arguments(), task.development.variant == "continual_graph", task.material.arguments(),
        task.scene.arguments(), given_inputs(task), float(bar), flag(), actuators_of(task),
    )
    return genome.arrays(), model


def begin(genome: Genome, task: Task, seed: int) -> tuple[int, Controller, SwimmingBody]:
    """A swimmer at its birth, at rest: (status, brain, plant).  Args: seed: of noise, and of what fails."""
    genes, model = kernel_arguments(genome, task)
    status, life = birth(genes, model, 1.0)
    strike(life.state.muscles, model.actuators, np.uint64(seed % 2**64))
    controller = Controller(life.brain, task, seed)
    return status, controller, SwimmingBody(life.state, controller.signals)


@by_body
def run(
    genome: Genome, task: Task, seed: int, finer: float, track: np.ndarray, activations: np.ndarray, bar: float = -math.inf
) -> Evaluation:
    """Evaluate a swimmer.

    Args: finer, track, activations: see `swim.swim`; seed: of noise and of what fails, if there is any; bar: see `Model`: a plain
    distance has no bound.
    """
    signals = make_signals(noise=task.noise.arguments(), seed=seed)
    bar = -math.inf if task.fitness == "distance" else bar
    return score(swim(*kernel_arguments(genome, task, bar), finer, signals, track, activations), task)


def motion_of(metrics: Metrics, task: Task) -> float:
    """m: the part of a fitness that is motion alone, the sustained distance unless the task counts the plain one."""
    return metrics.distance if task.fitness == "distance" else task.windows * metrics.slowest_window


def slowest_progress(path: np.ndarray) -> float:
    """The shortest way in any window times straightness, the share of the whole way that leads from start to end, m.

    Who circles gets nowhere; straightness has a slope everywhere, so that selection can act on it.  Args: path (windows + 1, 2).
    """
    ways = np.hypot(*np.diff(path, axis=0).T)
    whole = float(ways.sum())
    return float(ways.min()) * float(np.hypot(*(path[-1] - path[0]))) / whole if whole > 0.0 else 0.0


def score(result: Any, task: Task) -> Evaluation:
    status = Status(result.status)
    path = result.path
    if status == Status.STOPPED:
        body = Metrics(cells=result.cells, springs=result.springs, chambers=result.chambers, substeps=result.substeps)
        return stopped(result.bound, body)
    failed = status in FAILURE
    metrics = Metrics(
        cells=result.cells,
        springs=result.springs,
        chambers=result.chambers,
        substeps=result.substeps,
        distance=0.0 if failed else float(np.hypot(*(path[-1] - path[0]))),
        distance_second_half=0.0 if failed else float(np.hypot(*(path[-1] - path[task.windows // 2]))),
        slowest_window=0.0 if failed else slowest_progress(path),
        activation_amplitude=0.0 if failed else result.amplitude,
    )
    if failed:
        stiff = status == Status.UNSTABLE and result.failed_step < 0
        return failure(status, metrics, result.failed_step, STIFF if stiff else "")
    if task.fitness == "distance":  # the paper's, whatever carries the body: docs/reference/swimming.md tells what earns it
        return Evaluation(metrics.distance, status, "", metrics)
    # Motion counts only as far as muscles move it, to the end: creeping and coasting with a network at rest earn nothing.
    fitness = result.active * (task.windows * metrics.slowest_window + task.activity_bonus)
    return Evaluation(fitness, status, "", metrics)
