"""How an animat turns towards targets (paper section 4.3, Fig. 6): which cells change, on which side, and by what memory.

    turning(genome, task, seed) -> Turning
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..brain.brain import think
from ..brain.scent import scent_row
from ..genetics.genome import Genome
from ..live.animat import Animat
from ..parameters import ParameterError, Task
from ..tasks.chemotaxis.fitness import LEFT, RIGHT, attempt, placements
from ..tasks.chemotaxis.kernel import STRAIGHT
from ..tasks.outcome import FAILURE, Status

ARRIVED = 0.25  # of the distance at birth: nearer than that, a turn is over
TURNS = 0.1  # rad, of the way, towards the target on both sides, that count as turning
REACTIVE = 0.25  # of the effect of scent, that its history may have on an animat that counts as reactive
_SETTLED = 60  # regulation steps after which a reaction to the present scent is over: ten time constants at h = 0.3, twice
_COMPARED = 120  # regulation steps of actuation that are compared
_SHUFFLES = 4


@dataclass(frozen=True, eq=False)
class Turning:
    """What was found; sides are in order left, right.

    Attributes:
        heading: unit vector of the way without a target; start (2,) m; place (N, 2) m: cells at birth.
        targets (2, 2) m; paths (3, S + 1, 2) m: to the left, to the right, without a target.
        turn (2,) rad, towards the target; ratio (2,): last distance of the target over the first.
        change (2, N): mean activation while turning, minus that without a target in the same time (Fig. 6).
        swing (2, N): the same of the amplitude, half of max - min.
        near (2,): mean change of the half of the cells nearer to the target, minus that of the other half.
        memory: how much of the effect of scent on muscles depends on its history (see `memory_of`); NaN where it has no effect.
    """

    heading: np.ndarray
    start: np.ndarray
    place: np.ndarray
    targets: np.ndarray
    paths: np.ndarray
    turn: np.ndarray
    ratio: np.ndarray
    change: np.ndarray
    swing: np.ndarray
    near: np.ndarray
    memory: float

    @property
    def turns(self) -> str:
        """To which sides it turns: both, left, right or neither."""
        left, right = self.turn >= TURNS
        return "both" if left and right else "left" if left else "right" if right else "neither"

    @property
    def side(self) -> str:
        """Which side contracts in a turn: nearer, farther, or left or right whatever the target."""
        left, right = self.near
        if left * right > 0.0:
            return "nearer" if left < 0.0 else "farther"
        return "left" if left < 0.0 else "right"

    @property
    def strategy(self) -> str:
        """What changes most in a turn: posture (mean activation) or stroke (its amplitude)."""
        return "posture" if np.abs(self.change).mean() >= np.abs(self.swing).mean() else "stroke"

    @property
    def control(self) -> str:
        return "indifferent" if not np.isfinite(self.memory) else "reactive" if self.memory < REACTIVE else "internal state"


def turning(genome: Genome, task: Task, seed: int = 0) -> Turning:
    """Analyse how a genome turns.  Raises ParameterError where it cannot: no target in the task, or an animat that goes nowhere."""
    if not task.has_target:
        raise ParameterError(f"task {task.name!r} has no targets: give a genome or a run of chemotaxis")
    task = _tested(task)
    runs = [_kept(genome, task, seed, shown) for shown in (LEFT, RIGHT, STRAIGHT)]
    result = runs[0][0]
    if Status(result.status) in FAILURE:
        raise ParameterError(f"there is nothing to analyse: {FAILURE[Status(result.status)][1]}")
    if not result.tested:
        raise ParameterError("there is nothing to analyse: it does not swim")
    place = runs[2][1][0, :, :2]
    heading, start = np.array(result.heading), result.path[0]
    across = (place - start) @ np.array([-heading[1], heading[0]])  # to the left
    change, swing, near, turn, ratio = (np.empty((2, len(place))), np.empty((2, len(place))), np.empty(2), np.empty(2), np.empty(2))
    for side, sign in ((LEFT, 1.0), (RIGHT, -1.0)):
        track, activation = runs[side][1], runs[side][2]
        centre, target = track[..., :2].mean(axis=1), result.targets[side]
        away = np.hypot(*(centre - target).T) / np.hypot(*(start - target))
        last = int(np.flatnonzero(away < ARRIVED)[0]) if (away < ARRIVED).any() else len(away) - 1
        last = max(last, min(_COMPARED, len(away) - 1))
        ahead = runs[2][2][1 : last + 1]
        change[side] = activation[1 : last + 1].mean(axis=0) - ahead.mean(axis=0)
        swing[side] = 0.5 * (np.ptp(activation[1 : last + 1], axis=0) - np.ptp(ahead, axis=0))
        nearer = sign * across > np.median(sign * across)
        near[side] = change[side, nearer].mean() - change[side, ~nearer].mean()
        gone = centre[last] - start
        turn[side] = sign * np.arctan2(heading[0] * gone[1] - heading[1] * gone[0], heading @ gone)
        ratio[side] = away[-1]
    memory = float(np.mean([memory_of(genome, task, runs[side][1], result.targets[side]) for side in (LEFT, RIGHT)]))
    return Turning(
        heading, start, place, result.targets, np.concatenate((result.paths, result.path[None])), turn, ratio, change, swing, near, memory
    )


def _tested(task: Task) -> Task:
    """The task, but that whoever moves at all is tested, with one pair of targets."""
    return replace(task, chemotaxis=replace(task.chemotaxis, least_distance=0.0, pairs=1))


def _kept(genome, task, seed, shown):
    shape = (task.control_steps + 1, task.development.max_cells)
    track, activations = np.full((*shape, 4), np.nan), np.full(shape, np.nan)
    result = attempt(genome, task, seed, placements(task), shown, 1.0, (track, activations))
    return result, track[:, : result.cells], activations[:, : result.cells]


def memory_of(genome: Genome, task: Task, track: Any, target: Any) -> float:
    """How much of what scent does to muscles depends on its history at equal concentration: 0 is purely reactive.

    The networks run without the body, on a tape of the scents that each cell met.  Up to a moment the tape is shuffled in time,
    or held at its mean; from then on it is the true one.  When reactions to the present scent have settled, actuation is
    compared with that on the true tape, relative to its difference from actuation without any scent.

    Args: track (T + 1, N, >= 2): x, y m of each cell; target (2,) m.
    Returns: RMS of the differences over the RMS of those without scent, mean over moments and histories; NaN where scent does
    nothing.
    """
    c = task.chemotaxis
    distance = np.hypot(track[:-1, :, 0] - target[0], track[:-1, :, 1] - target[1])
    tape = c.scent_peak * np.maximum(0.0, 1.0 - distance / c.scent_reach)
    true, without = actuation(genome, task, tape), actuation(genome, task, np.zeros_like(tape))
    rng = np.random.default_rng(0)
    shares = []
    for moment in (np.array([0.25, 0.5, 0.75]) * len(tape)).astype(int):
        seen = slice(moment + _SETTLED, moment + _SETTLED + _COMPARED)
        effect = _rms(true[seen] - without[seen])
        if not effect > 1e-6:
            continue
        histories = [tape[rng.permutation(moment)] for _ in range(_SHUFFLES - 1)] + [
            np.broadcast_to(tape[:moment].mean(0), tape[:moment].shape)
        ]
        for history in histories:
            other = actuation(genome, task, np.concatenate((history, tape[moment:]))[: seen.stop])
            shares.append(_rms(other[seen] - true[seen]) / effect)
    return float(np.mean(shares)) if shares else float("nan")


def actuation(genome: Genome, task: Task, tape: np.ndarray) -> np.ndarray:
    """Muscles (T, N) of e - c that a genome's networks make of a tape of scents (T, N), whatever the body does."""
    brain = Animat(genome, task).brain.brain
    arguments, continual = task.development.arguments(), task.development.variant == "continual_graph"
    row = scent_row(brain.units)
    made = np.empty_like(tape)
    for step, scents in enumerate(tape):
        brain.table[row, : len(scents)] = scents
        think(brain, step, arguments, continual)
        made[step] = brain.activation
    return made


def _rms(values) -> float:
    return float(np.sqrt(np.mean(values**2)))
