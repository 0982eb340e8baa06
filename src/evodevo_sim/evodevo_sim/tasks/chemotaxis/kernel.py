"""Chemotaxis (paper section 4.3): one growth and birth, a swim without a target, then one towards each of several targets.

Every swim starts from a copy of the state at birth.  Targets are placed by the way that the first swim went.
"""

from __future__ import annotations

from collections import namedtuple

import numpy as np

from ...brain.life import INVERTED_CHAMBER, OK, RESTING, UNSTABLE_PHYSICS, birth
from ...brain.scent import Signals
from ...kernels.jit import kernel, lean
from ..swim.kernel import course

SAMPLES = 10  # of a path, in each window
STRAIGHT = -1  # the swim without a target

# status, failed_step, amplitude, active, substeps, cells, springs, chambers: see `swim.Swim`, of the swim without a target, but
# that any swim can fail; tested: whether there were swims towards targets; heading: (x, y), unit vector of the first swim from
# start to end; path (S + 1, 2) m of the centre of mass without a target, S = windows x SAMPLES; targets (K, 2) m; paths
# (K, S + 1, 2) m and actives (K,) of the swims towards them, of which there were `swims`; the others are 0.
Trials = namedtuple(
    "Trials",
    "status failed_step path amplitude active substeps cells springs chambers tested heading targets paths actives swims",
)


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


@kernel
def trials(
    genome, task, development, continual, material, scene, given_inputs, finer, chemotaxis, placements, signals, every, shown, track,
    traces,
):
    """Evaluate a genome: growth and all swims in one call.

    Args:
        placements (K, 2): of targets: rad to the left of the heading, m from the centre of mass at birth.
        signals: noise and seed of all swims; they have no target yet.
        every: whether to swim towards all targets, or no further than to the first one that earns nothing: the worst one is paid.
        shown: which swim is kept in track and traces, STRAIGHT or a row of placements; where there are no targets, STRAIGHT.
        the others: see `swim.swim`.

    Returns: Trials.
    """
    count = placements.shape[0]
    path, paths = np.zeros((task.windows * SAMPLES + 1, 2)), np.zeros((count, task.windows * SAMPLES + 1, 2))
    targets, actives = np.zeros((count, 2)), np.zeros(count)
    status, life = birth(genome, development, continual, material, scene, given_inputs, task.control_step, finer)
    body, cells = life.body, life.muscle.size
    springs, chambers = body.rest_length.size, body.triangle_area.size + body.polygon_area.size
    if status != OK:
        return Trials(
            status, -1, path, 0.0, 0.0, 0, cells, springs, chambers, False, (1.0, 0.0), targets, paths, actives, 0
        )
    position, velocity, table, past = life.position.copy(), life.velocity.copy(), life.table.copy(), life.past.copy()
    muscle = life.muscle.copy()
    range_of_muscle = np.empty((2, cells))
    status, step, amplitude, active = course(
        life, task, development.max_cells, development, continual, signals, path, range_of_muscle, track, traces
    )
    dx, dy = path[-1, 0] - path[0, 0], path[-1, 1] - path[0, 1]
    distance = np.sqrt(dx * dx + dy * dy)
    heading = (dx / distance, dy / distance) if distance > 0.0 else (1.0, 0.0)
    swims = 0
    tested = status == OK and distance >= chemotaxis.least_distance
    ended, failed_step = status, step
    if tested:
        nowhere = track[:0], traces[:0]
        for k in range(count):
            c, s = placements[k, 1] * np.cos(placements[k, 0]), placements[k, 1] * np.sin(placements[k, 0])
            targets[k, 0] = path[0, 0] + c * heading[0] - s * heading[1]
            targets[k, 1] = path[0, 1] + c * heading[1] + s * heading[0]
        for k in range(count):
            life.position[:], life.velocity[:], life.table[:], life.past[:], life.muscle[:] = position, velocity, table, past, muscle
            target = np.array([targets[k, 0], targets[k, 1], chemotaxis.scent_peak, chemotaxis.scent_reach])
            kept = (track, traces) if k == shown else nowhere
            random = np.array([signals.random[0] + np.uint64(k + 1), np.uint64(0)])
            ended, failed_step, _, actives[k] = course(
                life, task, development.max_cells, development, continual, Signals(target, signals.noise, random), paths[k],
                range_of_muscle, kept[0], kept[1],
            )
            swims += 1
            if (ended != OK and ended != RESTING) or not (every or earns(paths[k], target, placements[k, 0], actives[k])):
                break
    failed = ended == UNSTABLE_PHYSICS or ended == INVERTED_CHAMBER
    return Trials(
        ended if failed else status, failed_step if failed else -1, path, amplitude, active, life.substeps, cells, springs, chambers,
        tested, heading, targets, paths, actives, swims,
    )
