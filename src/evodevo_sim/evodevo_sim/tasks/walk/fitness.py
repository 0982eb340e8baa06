"""The walking task around its kernel: arguments in, evaluation out."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ...brain.controller import Controller
from ...brain.scent import make_signals
from ...genetics.genome import Genome
from ...parameters import Task
from ...physics.terrain import make_terrain
from ...plant.grounded import WalkingBody
from ...plant.muscles import strike
from ..ends import OK
from ..outcome import FAILURE, Evaluation, Metrics, Status, by_body, failure, stopped
from ..swim.fitness import kernel_arguments as swim_arguments
from .kernel import come_to_rest, hatch, lay_down, walk

NOT_KEPT = np.empty((0, 0, 0)), np.empty((0, 0))


def kernel_arguments(genome: Genome, task: Task, bar: float = -math.inf) -> tuple:
    """(genome, Model, Terrain) as `walk` takes them.  Args: bar: see `life.Model`."""
    return *swim_arguments(genome, task, bar), make_terrain(task.scene)


def headings(seed: int | tuple[int, ...], starts: int) -> np.ndarray:
    """(starts, 2): unit vectors spread over the circle, the first one at random; those of fewer starts come first among those of more.

    Turns go by van der Corput's sequence, 0, 1/2, 1/4, 3/4, 1/8, ...: 2^k starts are evenly spread.
    """
    count, turns = np.arange(starts), np.zeros(starts)
    for bit in range(int(starts).bit_length()):
        turns += (count >> bit & 1) * 0.5 ** (bit + 1)
    angle = math.tau * (np.random.default_rng(seed).random() + turns)
    return np.column_stack((np.cos(angle), np.sin(angle)))


@by_body
def run(
    genome: Genome, task: Task, seed: int, finer: float, track: np.ndarray, activations: np.ndarray, bar: float = -math.inf
) -> Evaluation:
    """Evaluate a walker.

    Args: seed: of its orientations at birth, of noise and of what fails; finer, track, activations: see `walk.walk`; bar: see
    `life.Model`: a plain distance has no bound.
    """
    bar = -math.inf if task.fitness == "distance" else bar
    given, ledger = kernel_arguments(genome, task, bar), np.zeros((task.starts, 0))
    return score(walk(*given, headings(seed, task.starts), finer, noise(task, seed), (track, activations), ledger), task)


def noise(task: Task, seed: int = 0) -> Any:
    """The `scent.Signals` of a walker: noise alone."""
    return make_signals(noise=task.noise.arguments(), seed=seed)


def begin(genome: Genome, task: Task, seed: int) -> tuple[int, Controller, WalkingBody]:
    """A walker at rest on the ground, as in the first start of an evaluation: (status, brain, plant)."""
    genes, model, terrain = kernel_arguments(genome, task)
    status, walker = hatch(genes, model, terrain, 1.0, np.zeros(0))
    strike(walker.life.state.muscles, model.actuators, np.uint64(seed % 2**64))
    if status == OK:
        status = lay_down(walker.grounded, headings(seed, 1)[0])
    if status == OK:
        status, _ = come_to_rest(walker.grounded, task.arguments())
    controller = Controller(walker.life.brain, task, seed)
    return status, controller, WalkingBody(walker.grounded, controller.signals)


def progress(path: np.ndarray, task: Task) -> Any:
    """(m in all, in the second half, in the slowest window) of every start, counted along the way from start to end.

    Args: path (S, windows + 1) m.  The last two are negative where it went back: shaking about a place earns nothing.
    """
    way = path[:, -1] - path[:, 0]
    along = np.where(way < 0.0, -1.0, 1.0)
    late = along * (path[:, -1] - path[:, task.windows // 2])
    return np.abs(way), late, (along[:, None] * np.diff(path, axis=1)).min(1)


def moved(result: Any, task: Task) -> np.ndarray:
    """(S,) m: the part of a fitness that is motion alone, the sustained distance unless the task counts the plain one."""
    distance, _, slowest = progress(result.path, task)
    return distance if task.fitness == "distance" else task.windows * np.maximum(slowest, 0.0)


def start_fitness(result: Any, task: Task) -> np.ndarray:
    """(S,) m: what every start earns; nothing where the body did not come to rest, or failed."""
    earned = moved(result, task)
    if task.fitness != "distance":
        earned = result.active * (earned + task.activity_bonus)
    return np.where(np.isin(result.status, list(FAILURE)), 0.0, earned)


def worse_half(earned: np.ndarray) -> float:
    """The mean of the worse half of what starts (S,) earn, the middle one of an odd number with it: their median is as much or more."""
    return float(np.sort(earned)[: (len(earned) + 1) // 2].mean())


def fitness_by_start(genome: Genome, task: Task, directions: np.ndarray) -> np.ndarray:
    """(S,) m: what a walker earns from each of these orientations (S, 2); nothing where it fails."""
    result = walk(*kernel_arguments(genome, task), directions, 1.0, noise(task), NOT_KEPT, np.zeros((len(directions), 0)))
    return start_fitness(result, task)


def score(result: Any, task: Task) -> Evaluation:
    """The mean of the worse half of the starts; a failure where physics or growth failed in one, or no start came to rest."""
    fatal = [k for k, s in enumerate(result.status) if Status(int(s)) in FAILURE and s != Status.UNSETTLED]
    unsettled = result.status == Status.UNSETTLED
    body = {"cells": result.cells, "springs": result.springs, "chambers": result.chambers, "substeps": result.steps}
    if result.bound < math.inf and result.steps:  # without a step of physics, nothing has grown that could live
        return stopped(result.bound, Metrics(**body))
    if fatal or unsettled.all():
        k = fatal[0] if fatal else 0
        return failure(Status(int(result.status[k])), Metrics(**body), int(result.failed_step[k]))
    distance, late, slowest = progress(result.path, task)
    earned = start_fitness(result, task)
    metrics = Metrics(
        **body,
        distance=float(distance.mean()),
        distance_second_half=float(late.mean()),
        slowest_window=float(slowest.mean()),
        activation_amplitude=float(result.amplitude.mean()),
        settling_steps=int(result.settling.max()),
        worst_start=float(earned.min()),
    )
    resting = (result.status == Status.RESTING).all()
    return Evaluation(worse_half(earned), Status.RESTING if resting else Status.OK, "", metrics)
