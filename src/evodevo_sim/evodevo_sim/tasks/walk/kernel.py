"""The walking task (paper section 4.1): growth, a fall onto the ground with the network asleep, rest, then locomotion.

Falling, rolling and settling earn nothing: the distance counts from where the body has come to rest, and only then does its
network wake.  Motion is symplectic Euler with exact contact (`integrators.euler`).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...brain.controller import Rules, brain_rests, brain_step
from ...brain.scent import Signals
from ...kernels.jit import kernel, lean, seam
from ...physics.energy import stored_energy
from ...physics.mass import centre_of_mass
from ...physics.soundness import SOUND
from ...physics.terrain import clearance
from ...plant.grounded import GroundedState, fastest, lies_still, make_grounded_state, move
from ...plant.muscles import strike
from ...plant.simulated import actuate
from ..ends import INVERTED, NO_ROOM, OK, RESTING, UNSETTLED, UNSTABLE, end_of, surely
from ..life import Kept, Life, activity, birth, forget, keep, widen
from ..swim.kernel import LOOK

_QUIET = 15  # control steps in a row that count as rest
_TOUCH = 1e-6  # m above the ground, that still counts as contact
_MOST_KEPT = 2**24  # numbers, of all starts while they wait for each other; where it takes more, no bar stops them


class Walker(NamedTuple):
    """A living animat on the ground."""

    life: Life
    grounded: GroundedState


class Walk(NamedTuple):
    """What the walks from all starts came to, (S,) each unless said otherwise."""

    status: np.ndarray
    failed_step: np.ndarray  # -1 for none
    path: np.ndarray  # (S, windows + 1) m: x of the centre of mass at the ends of the windows
    amplitude: np.ndarray  # see `swim.Swim`
    active: np.ndarray
    settling: np.ndarray  # control steps until rest
    gain: np.ndarray  # J, of stored energy while it walked, if there is a ledger
    steps: int  # of physics in a control step
    cells: int
    springs: int
    chambers: int
    bound: float = np.inf  # m: what the fitness could have been at the most, where the walks were stopped; inf where they were not


class Moment(NamedTuple):
    """All that a walk goes on from, of each start (S, ...)."""

    table: np.ndarray
    past: np.ndarray
    activation: np.ndarray
    rest: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    held: np.ndarray


@kernel
def _make_moments(life, starts):
    brain, state = life.brain, life.state
    return Moment(
        np.empty((starts, *brain.table.shape)), np.empty((starts, *brain.past.shape)), np.empty((starts, brain.activation.size)),
        np.empty((starts, state.rest.size)), np.empty((starts, *state.position.shape)), np.empty((starts, *state.position.shape)),
        np.empty((starts, *state.muscles.held.shape)),
    )


@kernel
def _leave(life, moments, k):
    """Keep where start k is."""
    brain, state = life.brain, life.state
    moments.table[k], moments.past[k], moments.activation[k] = brain.table, brain.past, brain.activation
    moments.rest[k], moments.position[k], moments.velocity[k] = state.rest, state.position, state.velocity
    moments.held[k] = state.muscles.held


@kernel
def _return(life, moments, k):
    """Go back to where start k was left."""
    brain, state = life.brain, life.state
    brain.table[:], brain.past[:], brain.activation[:] = moments.table[k], moments.past[k], moments.activation[k]
    state.rest[:], state.position[:], state.velocity[:] = moments.rest[k], moments.position[k], moments.velocity[k]
    state.muscles.held[:] = moments.held[k]


@lean
def _most_of_start(path, done, active, task):
    """What a start earns at the most, m, by its first `done` windows: no later one raises the slowest, whichever way it goes.

    Args: path (windows + 1,).
    """
    forth, back = np.inf, np.inf
    for window in range(done):
        way = path[window + 1] - path[window]
        forth, back = min(forth, way), min(back, -way)
    return active * (task.windows * max(0.0, forth, back) + task.activity_bonus)


@kernel
def _most(earned):
    """The mean of the worse half, as `walk.fitness.worse_half` has it, of what starts (S,) earn at the most."""
    half = (earned.size + 1) // 2
    return np.sort(earned)[:half].sum() / half


@kernel
def hatch(genome, model, terrain, finer, ledger):
    """Grow a genome, to be laid on the ground.  Args: see `walk`; ledger: see `GroundedState`.  Returns: (status of `birth`, Walker)."""
    status, life = birth(genome, model, 1.0)
    grounded = make_grounded_state(life.state, model.scene, terrain, model.task.control_step, finer, status == OK, ledger)
    return status, Walker(life, grounded)


@lean
def lay_down(grounded, heading):
    """Turn the newborn body and put it on the ground, by a cell or an edge, its centre at x = 0.

    Args: heading (2,): where its x axis goes.  Returns: OK, or NO_ROOM where it meets the ceiling.
    """
    state, terrain = grounded.state, grounded.system.terrain
    born, position, velocity = grounded.born, state.position, state.velocity
    cx, cy = centre_of_mass(born, state.body.inverse_mass)
    for i in range(born.shape[1]):
        x, y = born[0, i] - cx, born[1, i] - cy
        position[0, i] = heading[0] * x - heading[1] * y
        position[1, i] = heading[1] * x + heading[0] * y
        velocity[0, i] = velocity[1, i] = 0.0
    outline = state.body.outline
    low, _ = clearance(terrain, outline, position[0], position[1])
    for i in range(born.shape[1]):
        position[1, i] -= low
    _, high = clearance(terrain, outline, position[0], position[1])
    return OK if high > 0.0 else NO_ROOM


@seam
def come_to_rest(grounded, task):
    """Let the body fall with its muscles held, in a thin fluid, until no cell has moved for a while and one is on the ground.

    Returns: (OK, UNSETTLED or a failure of physics; control steps taken).
    """
    position, velocity, quiet = grounded.state.position, grounded.state.velocity, 0
    slower = max(0.0, 1.0 - task.settling_drag * task.control_step)
    for step in range(task.settling_limit):
        if grounded.state.halt[0]:
            break
        outcome = move(grounded, task.control_step)
        if outcome != SOUND:
            return end_of(outcome), step
        quiet = quiet + 1 if fastest(velocity) <= task.settled_speed * task.settled_speed else 0
        if quiet >= _QUIET:
            low, _ = clearance(grounded.system.terrain, grounded.state.body.outline, position[0], position[1])
            if low <= _TOUCH:
                return OK, step + 1
        for i in range(velocity.shape[1]):
            velocity[0, i] *= slower
            velocity[1, i] *= slower
    return UNSETTLED, task.settling_limit


@seam
def locomote(walker, step, until, rules, kept):
    """Live from one control step to another, in place.  Args and result: as for `swim.locomote`; there is no scent."""
    life, grounded = walker.life, walker.grounded
    brain, state, ledger = life.brain, life.state, grounded.ledger
    body, position, velocity = state.body, state.position, state.velocity
    gravity, half = grounded.system.gravity, 0.5 * rules.control_step / grounded.steps
    while step < until:
        if state.halt[0]:
            return OK, until
        if kept.track.size:
            keep(life, kept.track[step], kept.activations[step])
        # Muscles do their work at once, half a step ago: the velocities are those of then.
        if ledger.size:
            then = state.scratch.position
            for i in range(brain.activation.size):
                then[0, i] = position[0, i] - half * velocity[0, i]
                then[1, i] = position[1, i] - half * velocity[1, i]
            ledger[0] -= stored_energy(body, state.law, state.rest, gravity, then, velocity)[1]
        brain_step(brain, position, rules, step)
        actuate(state, brain.activation, rules.signals, step)
        if ledger.size:
            ledger[0] += stored_energy(body, state.law, state.rest, gravity, state.scratch.position, velocity)[1]
        outcome = move(grounded, rules.control_step)
        if outcome != SOUND:
            return end_of(outcome), step
        step += 1
        if kept.activation_range.size:
            if state.muscles.held.size:
                widen(kept.activation_range, state.muscles.held[0])
            else:
                widen(kept.activation_range, brain.activation)
        if step % LOOK == 0 and brain_rests(brain, rules) and lies_still(grounded, brain.activation, step):
            return RESTING, step
    return OK, step


@kernel
def _total(grounded):
    state = grounded.state
    parts = stored_energy(state.body, state.law, state.rest, grounded.system.gravity, state.position, state.velocity)
    return parts[0] + parts[1] + parts[2] + parts[3]


@kernel
def _walk_windows(walker, model, rules, path, kept, windows, amplitude, active):
    """Locomotion in some windows.  Fills path.  Returns: (status, step reached, amplitude, active).

    Args: windows: (first, the one behind the last); amplitude, active: in those before.
    """
    task, state = model.task, walker.life.state
    length = task.control_steps // task.windows
    status, step = OK, windows[0] * length
    if windows[0] == 0:
        path[:] = centre_of_mass(state.position, state.body.inverse_mass)[0]
    for window in range(windows[0], windows[1]):
        forget(kept.activation_range)
        status, step = locomote(walker, step, step + length, rules, kept)
        path[window + 1 :] = centre_of_mass(state.position, state.body.inverse_mass)[0]
        if status != OK:
            return status, step, 0.0, 0.0
        mean, working = activity(kept.activation_range, task.full_activity)
        amplitude = min(amplitude, mean)
        active = min(active, working / model.development.max_cells)
    return status, step, amplitude, active


@kernel
def walk(genome, model, terrain, headings, finer, signals, shown, ledger):
    """Evaluate a genome: growth once, then a fall, rest and walk from each start, in one call.

    Args:
        genome, model: as for `swim.swim`; terrain: see `terrain.Terrain`.
        headings (S, 2): unit vectors, the orientations at birth; finer: times as many steps of physics; signals: noise, and its
            seed in the first start, which is that of what fails, too.
        shown: (track, activations), see `life.Kept`, of the first start; ledger: (S, 4), added to while it walks, or (S, 0).

    Returns: Walk.
    """
    starts, task, track, activations = headings.shape[0], model.task, shown[0], shown[1]
    status, failed, settling = np.zeros(starts, np.int64), np.full(starts, -1), np.zeros(starts, np.int64)
    path, gain = np.zeros((starts, task.windows + 1)), np.zeros(starts)
    amplitude, active, earned, bound = np.full(starts, 2.0), np.ones(starts), np.full(starts, np.inf), np.inf
    grown, first = hatch(genome, model, terrain, finer, ledger[0])
    life, ground = first.life, first.grounded
    brain, state = life.brain, life.state
    cells, springs = brain.activation.size, state.body.rest_length.size
    chambers = state.body.triangle_area.size + state.body.polygon_area.size
    stops = model.bar > -np.inf and starts * (brain.table.size + brain.past.size) <= _MOST_KEPT
    # Where a bar can stop them, all starts walk a window each, then the next one; else one after the other, to the end.
    rounds = task.windows if stops else 1
    strike(state.muscles, model.actuators, signals.random[0])
    moments, newborn = _make_moments(life, starts if stops else 0), _make_moments(life, 1)
    _leave(life, newborn, 0)
    activation_range = np.empty((2, cells))
    for turn in range(rounds):
        for k in range(starts):
            grounded = GroundedState(state, ground.system, ground.work, ground.steps, ground.born, ledger[k])
            if turn == 0:
                asleep = GroundedState(state, ground.system, ground.work, ground.steps, ground.born, np.empty(0))
                status[k] = grown
                if grown == OK:
                    _return(life, newborn, 0)
                    status[k] = lay_down(grounded, headings[k])
                if status[k] == OK:
                    status[k], settling[k] = come_to_rest(asleep, task)
                if status[k] == OK:
                    gain[k] = -_total(grounded) if ledger.size else 0.0
                else:
                    amplitude[k], active[k] = 0.0, 0.0
            elif status[k] == OK:
                _return(life, moments, k)
            if status[k] == OK:
                kept = Kept(activation_range, track if k == 0 else track[:0], activations if k == 0 else activations[:0])
                noise = Signals(signals.target, signals.noise, np.array([signals.random[0] + np.uint64(k), np.uint64(0)]), signals.eyes)
                rules = Rules(task.control_step, model.development, model.continual, noise)
                windows = turn * task.windows // rounds, (turn + 1) * task.windows // rounds
                status[k], step, amplitude[k], active[k] = _walk_windows(
                    Walker(life, grounded), model, rules, path[k], kept, windows, amplitude[k], active[k]
                )
                if turn + 1 == rounds or status[k] != OK:
                    gain[k] += _total(grounded) if ledger.size else 0.0
                    if kept.track.size:
                        for later in range(step, task.control_steps + 1):
                            keep(life, kept.track[later], kept.activations[later])
                if status[k] == UNSTABLE or status[k] == INVERTED:
                    failed[k] = step
                if stops:
                    _leave(life, moments, k)
            if stops and not (turn + 1 == rounds and k + 1 == starts):
                earned[k] = _most_of_start(path[k], turn + 1, active[k], task) if status[k] == OK else 0.0
                most = surely(_most(earned))
                if most < model.bar:
                    return Walk(
                        status, failed, path, amplitude, active, settling, gain, ground.steps, cells, springs, chambers, most
                    )
    return Walk(status, failed, path, amplitude, active, settling, gain, ground.steps, cells, springs, chambers, bound)
