"""Chemotaxis (paper section 4.3): one growth and birth, a swim without a target, then one towards each of several targets.

Every swim starts from a copy of the state at birth.  Targets are placed by the way that the first swim went.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...brain.controller import Rules
from ...brain.scent import Signals
from ...kernels.jit import kernel, lean
from ...physics.abreast import COPIES
from ...plant.muscles import strike
from ..ends import INVERTED, OK, RESTING, STOPPED, UNSTABLE, surely
from ..life import Kept, birth
from ..swim.abreast import begin, courses, make_copies
from ..swim.kernel import Stakes, course

if TYPE_CHECKING:
    from ...parameters import ChemotaxisArguments

SAMPLES = 10  # of a path, in each window
STRAIGHT = -1  # the swim without a target


class Tests(NamedTuple):
    """The swims towards targets."""

    chemotaxis: ChemotaxisArguments
    placements: np.ndarray  # (K, 2) of targets: rad to the left of the heading, m from the centre of mass at birth
    every: bool  # whether to swim towards all targets, or no further than to the first one that earns nothing: the worst one is paid
    alone: int  # how many of the first swims are one by one; the others are four at a time, unless one of them is kept: no bit depends on it
    shown: int  # which swim is kept in track and activations, STRAIGHT or a row of placements; where there are no targets, STRAIGHT


class Trials(NamedTuple):
    """What the swims came to.  The first nine are those of `swim.Swim`, of the swim without a target, but that any swim can fail."""

    status: int
    failed_step: int
    path: np.ndarray  # (S + 1, 2) m of the centre of mass without a target, S = windows x SAMPLES
    amplitude: float
    active: float
    substeps: int
    cells: int
    springs: int
    chambers: int
    tested: bool  # whether there were swims towards targets
    heading: tuple[float, float]  # unit vector of the first swim from start to end
    targets: np.ndarray  # (K, 2) m
    paths: np.ndarray  # (K, S + 1, 2) m of the swims towards them
    actives: np.ndarray  # (K,) of those swims
    swims: int  # how many of them there were; the others are 0
    bound: float  # see `swim.Swim`


@lean
def nearing(path, target, angle):
    """How a path went towards a target at `angle` from the heading, means over the last window: distance of the target, m; gain:
    how much smaller that is than straight ahead, as far from the start as the path has come, m."""
    first = np.hypot(target[0] - path[0, 0], target[1] - path[0, 1])
    distance, ahead = 0.0, 0.0
    for k in range(path.shape[0] - SAMPLES, path.shape[0]):
        gone = np.hypot(path[k, 0] - path[0, 0], path[k, 1] - path[0, 1])
        distance += np.hypot(path[k, 0] - target[0], path[k, 1] - target[1])
        ahead += np.sqrt(max(0.0, first**2 + gone**2 - 2.0 * first * gone * np.cos(angle)))
    return distance / SAMPLES, (ahead - distance) / SAMPLES


@lean
def earns(path, target, angle, active):
    """Whether a swim is paid at all for its target at `angle` from the heading."""
    return active > 0.0 and nearing(path, target, angle)[1] > 0.0


@lean
def _most_gain(placement):
    """No gain towards a target is more, m, wherever the path ends: seen from a path gone as far as the target is, the way straight ahead
    is 2 D sin(angle / 2) from it.  Args: placement: (angle, distance D), see `Tests`."""
    return 2.0 * placement[1] * abs(np.sin(0.5 * placement[0]))


@lean
def _most_steered(chemotaxis, placements, gains, nearer, swims):
    """What turning and nearing pay at the most, m, after the first `swims` swims.

    Args: gains, nearer (K,): what those have earned by turning and by nearing, m; of pairs the worse one is paid.
    """
    paid = 0.0
    for left in range(0, placements.shape[0] - 1, 2):
        gain, near = np.inf, np.inf
        for k in range(left, left + 2):
            most = _most_gain(placements[k])
            gain = min(gain, gains[k] if k < swims else most)
            near = min(near, nearer[k] if k < swims else min(most, placements[k, 1]))
        paid += chemotaxis.turning_weight * gain + chemotaxis.approach_weight * max(0.0, near)
    return paid / chemotaxis.pairs


@lean
def _forward(path, windows):
    """windows x shortest window x straightness of a path, m, as `swim.fitness.slowest_progress` has it."""
    shortest, whole, last = np.inf, 0.0, path.shape[0] - 1
    for k in range(SAMPLES, path.shape[0], SAMPLES):
        way = np.sqrt((path[k, 0] - path[k - SAMPLES, 0]) ** 2 + (path[k, 1] - path[k - SAMPLES, 1]) ** 2)
        shortest, whole = min(shortest, way), whole + way
    straight = np.sqrt((path[last, 0] - path[0, 0]) ** 2 + (path[last, 1] - path[0, 1]) ** 2)
    return windows * shortest * straight / whole if whole > 0.0 else 0.0


@kernel
def trials(genome, model, finer, tests, signals, track, activations):
    """Evaluate a genome: growth and all swims in one call.

    Args: signals: noise and seed of all swims, they have no target yet; the others: see `swim.swim`.  Returns: Trials.
    """
    chemotaxis, placements = tests.chemotaxis, tests.placements
    count, points = placements.shape[0], model.task.windows * SAMPLES + 1
    path, paths = np.zeros((points, 2)), np.zeros((count, points, 2))
    targets, actives = np.zeros((count, 2)), np.zeros(count)
    status, life = birth(genome, model, finer)
    brain, state = life.brain, life.state
    body, cells = state.body, brain.activation.size
    springs, chambers = body.rest_length.size, body.triangle_area.size + body.polygon_area.size
    if status != OK:
        return Trials(
            status, -1, path, 0.0, 0.0, 0, cells, springs, chambers, False, (1.0, 0.0), targets, paths, actives, 0, np.inf
        )
    position, velocity, table, past = state.position.copy(), state.velocity.copy(), brain.table.copy(), brain.past.copy()
    strike(state.muscles, model.actuators, signals.random[0])
    activation, activation_range = brain.activation.copy(), np.empty((2, cells))
    held, rest = state.muscles.held.copy(), state.rest.copy()
    rules = Rules(model.task.control_step, model.development, model.continual, signals)
    bonus, gains, nearer = model.task.activity_bonus, np.zeros(count), np.zeros(count)
    more = 2.0 * bonus + _most_steered(chemotaxis, placements, gains, nearer, 0)
    stakes = Stakes(model.bar, chemotaxis.scent_reach, more)
    status, step, amplitude, active, bound = course(life, model, rules, path, Kept(activation_range, track, activations), stakes)
    dx, dy = path[-1, 0] - path[0, 0], path[-1, 1] - path[0, 1]
    distance = np.sqrt(dx * dx + dy * dy)
    heading = (dx / distance, dy / distance) if distance > 0.0 else (1.0, 0.0)
    swims, first = 0, 0
    tested = status == OK and distance >= chemotaxis.least_distance
    ended, failed_step = status, step
    if tested:
        forward, worst, no_stakes = min(_forward(path, model.task.windows), chemotaxis.scent_reach), 1.0, Stakes(-np.inf, np.inf, np.inf)
        for k in range(count):
            c, s = placements[k, 1] * np.cos(placements[k, 0]), placements[k, 1] * np.sin(placements[k, 0])
            targets[k, 0] = path[0, 0] + c * heading[0] - s * heading[1]
            targets[k, 1] = path[0, 1] + c * heading[1] + s * heading[0]
        copies = make_copies(life, signals.eyes)
        done = 0
        for k in range(count):
            if model.bar > -np.inf:
                paid = bonus + bonus * worst + _most_steered(chemotaxis, placements, gains, nearer, k)
                most = surely(active * (forward + paid))
                if most < model.bar:
                    status, bound = STOPPED, most
                    break
            if k >= done:
                together = min(count - k, COPIES) if k >= tests.alone and track.size == 0 else 1
                state.position[:], state.velocity[:], brain.table[:], brain.past[:] = position, velocity, table, past
                brain.activation[:], state.muscles.held[:], state.rest[:] = activation, held, rest
                begin(copies, life, together)
                for lane in range(together):
                    x, y = targets[k + lane]
                    copies.target[lane][:] = (x, y, chemotaxis.scent_peak, chemotaxis.scent_reach)
                    copies.random[lane][:] = (signals.random[0] + np.uint64(k + lane + 1), np.uint64(0))
                if together > 1:
                    courses(life, model, rules, copies, paths[k : k + together])
                else:
                    shown = k == tests.shown
                    aimed = Rules(
                        model.task.control_step, model.development, model.continual,
                        Signals(copies.target[0], signals.noise, copies.random[0], signals.eyes),
                    )
                    copies.status[0], copies.step[0], _, copies.active[0], _ = course(
                        life, model, aimed, paths[k],
                        Kept(activation_range, track if shown else track[:0], activations if shown else activations[:0]), no_stakes,
                    )
                first, done = k, k + together
            ended, failed_step, actives[k] = copies.status[k - first], copies.step[k - first], copies.active[k - first]
            swims += 1
            if model.bar > -np.inf:
                last, gain = nearing(paths[k], targets[k], placements[k, 0])
                gains[k], nearer[k] = actives[k] * gain, actives[k] * min(gain, placements[k, 1] - last)
                worst = min(worst, actives[k])
            if (ended != OK and ended != RESTING) or not (tests.every or earns(paths[k], targets[k], placements[k, 0], actives[k])):
                break
        paths[swims:] = 0.0
    failed = ended == UNSTABLE or ended == INVERTED
    return Trials(
        ended if failed else status, failed_step if failed else -1, path, amplitude, active, state.substeps, cells, springs, chambers,
        tested, heading, targets, paths, actives, swims, bound,
    )
