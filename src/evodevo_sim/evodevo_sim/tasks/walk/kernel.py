"""The walking task (paper section 4.1): growth, a fall onto the ground with the network asleep, rest, then locomotion.

Falling, rolling and settling earn nothing: the distance counts from where the body has come to rest, and only then does its
network wake.  Motion is symplectic Euler with exact contact (`integrators.euler`).
"""

from __future__ import annotations

from collections import namedtuple

import numpy as np

from ...brain.life import (
    INVERTED_CHAMBER,
    OK,
    RESTING,
    UNSTABLE_PHYSICS,
    activity,
    birth,
    centre_of_mass,
    forget,
    keep,
    think,
    widen,
)
from ...brain.scent import Signals, disturb
from ...development.growth import REST
from ...genetics.regulation import unrest
from ...kernels.jit import kernel, lean
from ...physics.control_step import INVERTED, MOST_DOUBLINGS, SOUND, copy_state, finer_may_help, judge
from ...physics.energy import stored_energy
from ...physics.integrators import System, Work, euler
from ...physics.rates import MOST_SUBSTEPS
from ...physics.stability import EULER, bounds, longest_step
from ...physics.terrain import clearance

UNSETTLED, NO_ROOM = 7, 8
ACCURATE_EULER = 1.6  # h * (bound of the highest frequency)
LEAST_STEPS = 4  # in a control step, for contact
_SAFETY = 0.8  # of the stability limit, where damping sets it
_QUIET = 15  # control steps in a row that count as rest
_TOUCH = 1e-6  # m above the ground, that still counts as contact
_STILL = 1e-7  # m/s below which nothing moves any more
_LOOK = 50  # control steps between looks at whether all rests

# life: see `life.Life`; system, work: see `integrators`; steps: of physics in a control step; born (2, N): place of the cells
# before they are turned and laid down; ledger: see `energy`, or empty
Walker = namedtuple("Walker", "life system work steps born ledger")
# By start, (S,) each: status; failed_step, -1 for none; path (S, windows + 1): x of the centre of mass at the ends of the
# windows; amplitude, active: see `swim.Swim`; settling: control steps until rest; gain: of stored energy while it walked, J, if
# there is a ledger.  steps: of physics in a control step.
Walk = namedtuple("Walk", "status failed_step path amplitude active settling gain steps cells springs chambers")


@kernel
def choose_walk_steps(system, control_step):
    """Steps of physics in a control step: numbers of accuracy, and of stability where damping is strong."""
    frequency, damping = bounds(system)
    need = max(control_step * frequency / ACCURATE_EULER, control_step / (_SAFETY * longest_step(EULER, frequency, damping)))
    return max(LEAST_STEPS, int(np.ceil(need)))


@kernel
def hatch(genome, development, continual, material, scene, terrain, given_inputs, control_step, finer, ledger):
    """Grow a genome.  Args: finer: times as many steps as are chosen.  Returns: (OK, NO_GROWTH or NO_CHAMBER; Walker)."""
    status, life = birth(genome, development, continual, material, scene, given_inputs, control_step, 1)
    none, cells = np.empty(0), life.muscle.size
    system = System(
        life.body, life.law, scene.gravity, scene.friction, True, terrain, none, none, none, life.muscle, life.rest
    )
    work = Work(life.scratch, np.empty((0, 2, cells)), np.empty((1, 2, cells)), np.zeros(4))
    steps = int(np.ceil(finer * choose_walk_steps(system, control_step))) if status == OK else 0
    return status, Walker(life, system, work, steps, life.position.copy(), ledger)


@lean
def lay_down(walker, heading):
    """Turn the newborn body and put it on the ground, by a cell or an edge, its centre at x = 0.

    Args: heading (2,): where its x axis goes.  Returns: OK, or NO_ROOM where it meets the ceiling.
    """
    born, position, velocity = walker.born, walker.life.position, walker.life.velocity
    cx, cy = centre_of_mass(born, walker.life.body.inverse_mass)
    for i in range(born.shape[1]):
        x, y = born[0, i] - cx, born[1, i] - cy
        position[0, i] = heading[0] * x - heading[1] * y
        position[1, i] = heading[1] * x + heading[0] * y
        velocity[0, i] = velocity[1, i] = 0.0
    outline = walker.life.body.outline
    low, _ = clearance(walker.system.terrain, outline, position[0], position[1])
    for i in range(born.shape[1]):
        position[1, i] -= low
    _, high = clearance(walker.system.terrain, outline, position[0], position[1])
    return OK if high > 0.0 else NO_ROOM


@lean
def move(walker, seconds):
    """Carry the body over one control step; where that is not sound, again with twice the steps: see `physics.finer_may_help`."""
    life, system, work, ledger = walker.life, walker.system, walker.work, walker.ledger
    position, velocity, scratch = life.position, life.velocity, life.scratch
    copy_state(position, velocity, scratch.start_position, scratch.start_velocity)
    for k in range(ledger.size):
        work.power[k] = ledger[k]
    doubling, steps = 0, walker.steps
    while True:
        h = seconds / steps
        for _ in range(steps):
            euler(system, 0.0, h, position, velocity, work, ledger)
        outcome = judge(life.body, position, velocity, h, scratch)
        if outcome == SOUND or not finer_may_help(outcome, doubling, steps, MOST_DOUBLINGS, MOST_SUBSTEPS):
            return outcome
        doubling, steps = doubling + 1, 2 * steps
        copy_state(scratch.start_position, scratch.start_velocity, position, velocity)
        for k in range(ledger.size):
            ledger[k] = work.power[k]


@lean
def _fastest(velocity):
    """The square of the largest speed of any cell."""
    most = 0.0
    for i in range(velocity.shape[1]):
        most = max(most, velocity[0, i] * velocity[0, i] + velocity[1, i] * velocity[1, i])
    return most


@lean
def come_to_rest(walker, task):
    """Let the body fall with its muscles held, in a thin fluid, until no cell has moved for a while and one is on the ground.

    Returns: (OK, UNSETTLED or a failure of physics; control steps taken).
    """
    position, velocity, quiet = walker.life.position, walker.life.velocity, 0
    slower = max(0.0, 1.0 - task.settling_drag * task.control_step)
    for step in range(task.settling_limit):
        outcome = move(walker, task.control_step)
        if outcome != SOUND:
            return (INVERTED_CHAMBER if outcome == INVERTED else UNSTABLE_PHYSICS), step
        quiet = quiet + 1 if _fastest(velocity) <= task.settled_speed * task.settled_speed else 0
        if quiet >= _QUIET:
            low, _ = clearance(walker.system.terrain, walker.life.body.outline, position[0], position[1])
            if low <= _TOUCH:
                return OK, step + 1
        for i in range(velocity.shape[1]):
            velocity[0, i] *= slower
            velocity[1, i] *= slower
    return UNSETTLED, task.settling_limit


@lean
def live(walker, step, until, seconds, development, continual, signals, range_of_muscle, track, traces):
    """Live from one control step to another, in place.  Args and result: as for `swim.live`; there is no scent."""
    life, ledger = walker.life, walker.ledger
    body, muscle, position, velocity = life.body, life.muscle, life.position, life.velocity
    gravity, half = walker.system.gravity, 0.5 * seconds / walker.steps
    while step < until:
        if track.size:
            keep(life, track[step], traces[step])
        # Muscles do their work at once, half a step ago: the velocities are those of then.
        if ledger.size:
            then = life.scratch.position
            for i in range(muscle.size):
                then[0, i] = position[0, i] - half * velocity[0, i]
                then[1, i] = position[1, i] - half * velocity[1, i]
            ledger[0] -= stored_energy(body, life.law, life.rest, gravity, then, velocity)[1]
        think(life, step, development, continual)
        if signals.noise.size:
            disturb(life, signals, step)
        if ledger.size:
            ledger[0] += stored_energy(body, life.law, life.rest, gravity, life.scratch.position, velocity)[1]
        outcome = move(walker, seconds)
        if outcome != SOUND:
            return (INVERTED_CHAMBER if outcome == INVERTED else UNSTABLE_PHYSICS), step
        step += 1
        if range_of_muscle.size:
            widen(range_of_muscle, muscle)
        if continual and step % _LOOK == 0 and not signals.noise.size and unrest(life.network, life.table, life.drive, muscle.size) < REST:
            if _fastest(velocity) < _STILL * _STILL:
                return RESTING, step
    return OK, step


@kernel
def _total(walker):
    life = walker.life
    parts = stored_energy(life.body, life.law, life.rest, walker.system.gravity, life.position, life.velocity)
    return parts[0] + parts[1] + parts[2] + parts[3]


@kernel
def _walk_windows(walker, task, development, continual, signals, path, track, traces):
    """Locomotion.  Fills path.  Returns: (status, step reached, amplitude, active)."""
    life = walker.life
    cells, length = life.muscle.size, task.control_steps // task.windows
    range_of_muscle = np.empty((2, cells))
    amplitude, active, status, step = 2.0, 1.0, OK, 0
    path[:] = centre_of_mass(life.position, life.body.inverse_mass)[0]
    for window in range(task.windows):
        forget(range_of_muscle)
        status, step = live(
            walker, step, step + length, task.control_step, development, continual, signals, range_of_muscle, track, traces
        )
        path[window + 1 :] = centre_of_mass(life.position, life.body.inverse_mass)[0]
        if status != OK:
            return status, step, 0.0, 0.0
        mean, working = activity(range_of_muscle, task.full_activity)
        amplitude = min(amplitude, mean)
        active = min(active, working / development.max_cells)
    return status, step, amplitude, active


@kernel
def walk(
    genome, task, development, continual, material, scene, terrain, given_inputs, headings, finer, signals, track, traces, ledger
):
    """Evaluate a genome: growth once, then a fall, rest and walk from each start, in one call.

    Args:
        genome to given_inputs: as for `swim.swim`; terrain: see `terrain.Terrain`.
        headings (S, 2): unit vectors, the orientations at birth; finer: times as many steps of physics; signals: noise, and its
            seed in the first start.
        track, traces: as for `swim.swim`, of the first start; ledger: (S, 4), added to while it walks, or (S, 0).

    Returns: Walk.
    """
    starts = headings.shape[0]
    status, failed, settling = np.zeros(starts, np.int64), np.full(starts, -1), np.zeros(starts, np.int64)
    path, amplitude, active, gain = np.zeros((starts, task.windows + 1)), np.zeros(starts), np.zeros(starts), np.zeros(starts)
    grown, first = hatch(
        genome, development, continual, material, scene, terrain, given_inputs, task.control_step, finer, ledger[0]
    )
    life = first.life
    cells, springs = life.muscle.size, life.body.rest_length.size
    chambers = life.body.triangle_area.size + life.body.polygon_area.size
    table, past, muscle, rest = life.table.copy(), life.past.copy(), life.muscle.copy(), life.rest.copy()
    for k in range(starts):
        walker = Walker(life, first.system, first.work, first.steps, first.born, ledger[k])
        asleep = Walker(life, first.system, first.work, first.steps, first.born, np.empty(0))
        status[k], step = grown, 0
        if grown == OK:
            life.table[:], life.past[:], life.muscle[:], life.rest[:] = table, past, muscle, rest
            status[k] = lay_down(walker, headings[k])
        if status[k] == OK:
            status[k], settling[k] = come_to_rest(asleep, task)
        if status[k] != OK:
            continue
        gain[k] = -_total(walker) if ledger.size else 0.0
        kept, shown = (track, traces) if k == 0 else (track[:0], traces[:0])
        noise = Signals(signals.target, signals.noise, np.array([signals.random[0] + np.uint64(k), np.uint64(0)]))
        status[k], step, amplitude[k], active[k] = _walk_windows(
            walker, task, development, continual, noise, path[k], kept, shown
        )
        gain[k] += _total(walker) if ledger.size else 0.0
        if kept.size:
            for later in range(step, task.control_steps + 1):
                keep(life, track[later], traces[later])
        if status[k] == UNSTABLE_PHYSICS or status[k] == INVERTED_CHAMBER:
            failed[k] = step
    return Walk(status, failed, path, amplitude, active, settling, gain, first.steps, cells, springs, chambers)
