"""Whole motions in one call: frame by frame with a look at each outcome, or a life repeated with its energy ledger."""

from __future__ import annotations

import numpy as np

from ..kernels.jit import kernel, lean
from .control_step import SOUND, UNSTABLE, copy_state, finer_may_help
from .energy import least_chamber, stored_energy
from .forces import set_rest_lengths
from .integrators import carry, carry_adaptively
from .mass import centre_of_mass
from .rates import MOST_SUBSTEPS, substeps_in_drag
from .stability import ADAPTIVE, RK4, choose_steps, is_sound

DOUBLINGS = 3  # of the steps of a frame that came out unsound; of an unstable one more: see `physics.finer_may_help`
MOST_STEPS = 100_000  # in a frame, before they are doubled; and in one that is unstable


@lean
def carry_soundly(system, method, t, seconds, steps, doublings, position, velocity, work, ledger, most=0):
    """`carry`, with a look at each step; where one is not sound, again with twice the steps: see `physics.finer_may_help`.

    Returns: (SOUND or what was wrong with the finest try, steps of that try).
    """
    start_position, start_velocity = work.scratch.start_position, work.scratch.start_velocity
    copy_state(position, velocity, start_position, start_velocity)
    for k in range(ledger.size):
        work.power[k] = ledger[k]
    doubling = 0
    while True:
        outcome = carry(system, method, t, seconds, steps, position, velocity, work, ledger, True)
        if outcome == SOUND or not finer_may_help(outcome, doubling, steps, doublings, most):
            return outcome, steps
        doubling, steps = doubling + 1, 2 * steps
        copy_state(start_position, start_velocity, position, velocity)
        for k in range(ledger.size):
            ledger[k] = work.power[k]


@kernel
def follow(system, method, bound, steps, finer, tolerance, h, time, first, last, position, velocity, work, track_p, track_v):
    """Carry a state from frame to frame, in place, and keep every frame: in track_p and track_v, (T, N, 2) as users see them.

    Args: steps: in a frame, unrepeated; 0: `finer` times as many as `choose_steps` says, doubled where unsound; more than
        MOST_STEPS are none; h: first adaptive step to try, 0: as RK4 would.

    Returns: (outcome; the last sound frame; next adaptive step).
    """
    nothing = np.empty(0)
    for k in range(first, last):
        seconds = time[k + 1] - time[k]
        if method == ADAPTIVE:
            if h == 0.0:
                h = seconds / choose_steps(system, RK4, bound, position, velocity, seconds)
            outcome, h, _ = carry_adaptively(system, time[k], seconds, tolerance, h, position, velocity, work, nothing)
            if outcome == SOUND:
                outcome = is_sound(system, method, position, velocity, 0.0, work)
        else:
            count = steps if steps else finer * choose_steps(system, method, bound, position, velocity, seconds)
            outcome = UNSTABLE
            if count <= MOST_STEPS:
                outcome, _ = carry_soundly(
                    system, method, time[k], seconds, count, 0 if steps else DOUBLINGS, position, velocity, work, nothing,
                    0 if steps else MOST_STEPS,
                )
        if outcome != SOUND:
            return outcome, k, h
        track_p[k + 1], track_v[k + 1] = position.T, velocity.T
    return SOUND, last, h


@kernel
def repeat(system, method, steps, finer, tolerance, control_step, activation, position, velocity, work, ledger, path):
    """Move a body by the muscles of a life, in place.

    Args: steps: at rest, as evaluations take them; finer: times as many; activation (T + 1, N) of e - c, whose row k + 1 holds
        during control step k; ledger: (4,), added to, or empty; path (windows + 1, 2): filled.

    Returns: (outcome; gain of stored energy, J; least S / S0 of any chamber after any control step).
    """
    body, law = system.body, system.law
    count = activation.shape[0] - 1
    length = count // (path.shape[0] - 1)
    h, least, outcome = control_step / 16.0, 1.0, SOUND
    set_rest_lengths(body, activation[0], system.rest)
    begin = stored_energy(body, law, system.rest, 0.0, position, velocity)
    path[:, 0], path[:, 1] = centre_of_mass(position, body.inverse_mass)
    for k in range(count):
        before = stored_energy(body, law, system.rest, 0.0, position, velocity)
        set_rest_lengths(body, activation[k + 1], system.rest)
        after = stored_energy(body, law, system.rest, 0.0, position, velocity)
        if ledger.size:
            ledger[0] += after[1] - before[1]  # muscles do their work at once, at the start of a control step
        if method == ADAPTIVE:
            outcome, h, _ = carry_adaptively(system, 0.0, control_step, tolerance, h, position, velocity, work, ledger)
            if outcome == SOUND:
                outcome = is_sound(system, method, position, velocity, 0.0, work)
        else:
            many = finer * substeps_in_drag(body, law, position, velocity, control_step, steps, work.scratch)
            outcome, _ = carry_soundly(system, method, 0.0, control_step, many, DOUBLINGS, position, velocity, work, ledger, MOST_SUBSTEPS)
        if outcome != SOUND:
            return outcome, np.nan, least
        least = min(least, least_chamber(body, position)[0])
        if (k + 1) % length == 0:
            window = (k + 1) // length
            path[window:, 0], path[window:, 1] = centre_of_mass(position, body.inverse_mass)
    end = stored_energy(body, law, system.rest, 0.0, position, velocity)
    gain = 0.0
    for part in range(4):
        gain += end[part] - begin[part]
    return (outcome if gain == gain else UNSTABLE), gain, least
