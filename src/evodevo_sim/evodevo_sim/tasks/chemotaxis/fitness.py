"""Chemotaxis around its kernel: where targets stand, and what pays.  docs/reference/chemotaxis.md tells why."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ...brain.eyes import eyes_of
from ...brain.scent import make_signals
from ...genetics.genome import Genome
from ...parameters import Task
from ..outcome import FAILURE, STIFF, Evaluation, Metrics, Status, Steering, by_body, failure, stopped
from ..swim.fitness import kernel_arguments, slowest_progress
from .kernel import SAMPLES, Tests, Trials, earns, nearing, trials

LEFT, RIGHT = range(2)
_NOT_KEPT = np.empty((0, 0, 0)), np.empty((0, 0))
# Four swims abreast take as long as three of them alone.  Those after one that earns nothing are swum for nothing then, so it pays where
# most evaluations go through: seekers that are looked at again and again, not a population that still learns to turn.
WORTH = 0.8  # share of the swims that evaluations needed of late, above which they go abreast
_NEW = 0.25  # weight of the last one


class _Habit:
    """What evaluations of late came to, of all threads, which may overwrite each other: no result depends on it."""

    share = 1.0


_habit = _Habit()


@by_body
def run(
    genome: Genome, task: Task, seed: int, finer: float, track: np.ndarray, activations: np.ndarray, bar: float = -math.inf
) -> Evaluation:
    """Evaluate a seeker.

    Args: see `swim.swim`; the swim that is kept is the one with the target on the left, if there is one; bar: see `Model`.
    """
    placed = placements(task)
    alone = 0 if _habit.share > WORTH else len(placed)
    result = attempt(genome, task, seed, placed, LEFT, finer, (track, activations), every=False, bar=bar, alone=alone)
    if result.tested:
        _habit.share += _NEW * (result.swims / len(placed) - _habit.share)
    return score(result, task)


def placements(task: Task) -> np.ndarray:
    """(2 pairs, 2): angle, rad, and distance, m, of the targets: those of a pair on the left and on the right, pair after pair."""
    c = task.chemotaxis
    lean = c.spread * np.linspace(-1.0, 1.0, c.pairs) if c.pairs > 1 else np.zeros(1)
    angle, distance = c.angle * (1.0 + lean), c.distance * (1.0 - lean)
    return np.column_stack((np.column_stack((angle, -angle)).ravel(), np.repeat(distance, 2)))


def attempt(
    genome: Genome, task: Task, seed: int, placed: np.ndarray, shown: int = LEFT, finer: float = 1.0,
    kept: tuple[np.ndarray, np.ndarray] = _NOT_KEPT, every: bool = True, *, bar: float = -math.inf, alone: int = 0,
) -> Trials:
    """All swims of a genome.

    Args: placed (K, 2), every, alone, shown: see `Tests`; kept: (track, activations), see `life.Kept`; bar: see `Model`, where the
    targets are those of the task.
    """
    signals = make_signals(noise=task.noise.arguments(), seed=seed, eyes=eyes_of(task))
    placed = np.ascontiguousarray(placed, float).reshape(-1, 2)
    tests = Tests(task.chemotaxis.arguments(), placed, every, alone, shown)
    return trials(*kernel_arguments(genome, task, bar), finer, tests, signals, *kept)


def late(path: np.ndarray) -> np.ndarray:
    """The points (SAMPLES, 2) of a path in its last window."""
    return path[-SAMPLES:]


def approach(path: np.ndarray, target: np.ndarray, heading: np.ndarray | tuple[float, float], angle: float) -> tuple[float, float, float]:
    """How a path went towards a target.

    Args: path (S + 1, 2) m; target (2,) m; heading: unit vector of the way without a target; angle: of the target from it, rad.

    Returns, all but the last as means over the last window: distance of the target, m; gain: how much smaller that is than
    straight ahead, as far from the start as the path has come, m; turn from the heading to the way gone, towards the target's
    side, rad.
    """
    distance, gain = nearing(path, target, angle)
    x, y = late(path).mean(axis=0) - path[0]
    turn = np.arctan2(heading[0] * y - heading[1] * x, heading[0] * x + heading[1] * y)
    return distance, gain, float(turn if angle >= 0.0 else -turn)


def score(result: Trials, task: Task) -> Evaluation:
    """What pays: sustained forward motion; then muscles that work in scent, and turning and nearing on both sides."""
    status, path, c = Status(result.status), result.path, task.chemotaxis
    sizes: dict[str, Any] = {"cells": result.cells, "springs": result.springs, "chambers": result.chambers, "substeps": result.substeps}
    if status == Status.STOPPED:
        return stopped(result.bound, Metrics(**sizes))
    if status in FAILURE:
        stiff = status == Status.UNSTABLE and result.failed_step < 0
        return failure(status, Metrics(**sizes), result.failed_step, STIFF if stiff else "")
    ends = path[:: SAMPLES]
    metrics = Metrics(
        **sizes,
        distance=float(np.hypot(*(path[-1] - path[0]))),
        distance_second_half=float(np.hypot(*(path[-1] - ends[task.windows // 2]))),
        slowest_window=slowest_progress(ends),
        activation_amplitude=result.amplitude,
        steering=_steering(result, task),
    )
    paid = min(task.windows * metrics.slowest_window, c.scent_reach) + task.activity_bonus
    if result.swims:
        paid += task.activity_bonus * result.actives[: result.swims].min() + _steered(result, task)
    return Evaluation(float(result.active * paid), status, "", metrics)


def _steered(result: Trials, task: Task) -> float:
    """What turning and nearing pay, m: by the worse side of each pair, mean over pairs; no more after one that earns nothing."""
    c, paid = task.chemotaxis, 0.0
    gains, nearer = [], []
    for k, (angle, distance) in enumerate(placements(task)[: result.swims]):
        if not earns(result.paths[k], result.targets[k], angle, result.actives[k]):
            break
        last, gain, _ = _approach(result, task, k)
        gains.append(result.actives[k] * gain)
        nearer.append(result.actives[k] * min(gain, distance - last))
    for left in range(0, len(gains) - 1, 2):
        paid += c.turning_weight * min(gains[left : left + 2]) + c.approach_weight * max(0.0, min(nearer[left : left + 2]))
    return paid / c.pairs


def _approach(result: Trials, task: Task, k: int) -> tuple[float, float, float]:
    """`approach` to target k; a swim that was not needed counts as one that stayed."""
    angle, distance = placements(task)[k]
    return approach(result.paths[k], result.targets[k], result.heading, angle) if k < result.swims else (float(distance), 0.0, 0.0)


def nearness(result: Trials, task: Task) -> tuple[float, ...]:
    """Distance of each target that was swum to, mean over the last window, m."""
    return tuple(_approach(result, task, k)[0] for k in range(result.swims))


def _steering(result: Trials, task: Task) -> Steering:
    """What is reported, of the first pair."""
    if not result.tested:
        return Steering()
    left, right = (_approach(result, task, k) for k in (LEFT, RIGHT))
    (left_x, left_y), (right_x, right_y) = result.targets[: RIGHT + 1].tolist()
    return Steering(
        distance=float(placements(task)[LEFT, 1]), left_x=left_x, left_y=left_y, right_x=right_x, right_y=right_y,
        left_distance=left[0], right_distance=right[0], left_gain=left[1], right_gain=right[1],
        left_turn=left[2], right_turn=right[2],
        left_active=float(result.actives[LEFT]), right_active=float(result.actives[RIGHT]),
    )
