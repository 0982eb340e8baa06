"""Whole motions in one call: frame by frame with a look at each outcome, or a life repeated with its energy ledger."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..kernels.jit import kernel, seam
from .energy import least_chamber, stored_energy
from .forces import set_rest_lengths
from .integrators import carry, carry_adaptively
from .ladder import MOST_DOUBLINGS, Ladder, again, remember
from .mass import centre_of_mass
from .soundness import SOUND, UNSTABLE, is_sound
from .step_size import ADAPTIVE, MOST_SUBSTEPS, RK4, choose_steps, substeps_in_drag

MOST_STEPS = 100_000  # in a frame, before they are doubled; and in one that is unstable


class Method(NamedTuple):
    """How a motion is integrated."""

    kind: int  # EULER, VERLET, RK4, ADAPTIVE or LAWSON
    steps: int  # see `follow` and `repeat`
    finer: float  # times as many, rounded up
    tolerance: float  # of an adaptive step, m and m/s


class Frames(NamedTuple):
    """A motion as users see it; NaN or anything where it has not come yet."""

    time: np.ndarray  # (T,) s
    position: np.ndarray  # (T, N, 2) m
    velocity: np.ndarray  # (T, N, 2) m/s


@seam
def carry_soundly(system, method, t, seconds, steps, ladder, state, work):
    """`carry`, with a look at each step; where one is not sound, again with twice the steps: see `ladder`.

    Returns: (SOUND or what was wrong with the finest try, steps of that try).
    """
    remember(state.position, state.velocity, state.ledger, work.scratch)
    doubling = 0
    while True:
        outcome = carry(system, method, t, seconds, steps, state, work, True)
        if not again(outcome, doubling, steps, ladder, state.position, state.velocity, state.ledger, work.scratch):
            return outcome, steps
        doubling, steps = doubling + 1, 2 * steps


@kernel
def follow(system, method, bound, h, span, state, work, frames):
    """Carry a state from frame to frame, in place, and keep every frame.

    Args: method: its steps are those in a frame, unrepeated; 0: `finer` times as many as `choose_steps` says by the bound, doubled
        where unsound; more than MOST_STEPS are none; h: first adaptive step to try, 0: as RK4 would; span: (first frame, last);
        state: without a ledger; frames: filled.

    Returns: (outcome; the last sound frame; next adaptive step).
    """
    position, velocity, time = state.position, state.velocity, frames.time
    ladder = Ladder(0, 0) if method.steps else Ladder(MOST_DOUBLINGS, MOST_STEPS)
    for k in range(span[0], span[1]):
        seconds = time[k + 1] - time[k]
        if method.kind == ADAPTIVE:
            if h == 0.0:
                h = seconds / choose_steps(system, RK4, bound, position, velocity, seconds)
            outcome, h, _ = carry_adaptively(system, time[k], seconds, method.tolerance, h, state, work)
            if outcome == SOUND:
                outcome = is_sound(system, method.kind, position, velocity, 0.0, work)
        else:
            count = method.steps
            if not count:
                count = int(np.ceil(method.finer * choose_steps(system, method.kind, bound, position, velocity, seconds)))
            outcome = UNSTABLE
            if count <= MOST_STEPS:
                outcome, _ = carry_soundly(system, method.kind, time[k], seconds, count, ladder, state, work)
        if outcome != SOUND:
            return outcome, k, h
        frames.position[k + 1], frames.velocity[k + 1] = position.T, velocity.T
    return SOUND, span[1], h


@kernel
def repeat(system, method, control_step, activation, state, work, path):
    """Move a body by the muscles of a life, in place.

    Args: method: its steps are those at rest, as evaluations take them; activation (T + 1, N) of e - c, whose row k + 1 holds
        during control step k; path (windows + 1, 2): filled.

    Returns: (outcome; gain of stored energy, J; least S / S0 of any chamber after any control step).
    """
    body, law, ladder = system.body, system.law, Ladder(MOST_DOUBLINGS, MOST_SUBSTEPS)
    position, velocity = state.position, state.velocity
    count = activation.shape[0] - 1
    length = count // (path.shape[0] - 1)
    h, least, outcome = control_step / 16.0, 1.0, SOUND
    set_rest_lengths(body, law, activation[0], system.after)
    begin = stored_energy(body, law, system.after, 0.0, position, velocity)
    path[:, 0], path[:, 1] = centre_of_mass(position, body.inverse_mass)
    for k in range(count):
        system.before[:] = system.after
        set_rest_lengths(body, law, activation[k + 1], system.after)
        if method.kind == ADAPTIVE:
            outcome, h, _ = carry_adaptively(system, 0.0, control_step, method.tolerance, h, state, work)
            if outcome == SOUND:
                outcome = is_sound(system, method.kind, position, velocity, 0.0, work)
        else:
            steps = substeps_in_drag(body, law, position, velocity, control_step, method.steps, work.scratch)
            outcome, _ = carry_soundly(system, method.kind, 0.0, control_step, int(np.ceil(method.finer * steps)), ladder, state, work)
        if outcome != SOUND:
            return outcome, np.nan, least
        least = min(least, least_chamber(body, position)[0])
        if (k + 1) % length == 0:
            window = (k + 1) // length
            path[window:, 0], path[window:, 1] = centre_of_mass(position, body.inverse_mass)
    end = stored_energy(body, law, system.after, 0.0, position, velocity)
    gain = 0.0
    for part in range(4):
        gain += end[part] - begin[part]
    return (outcome if gain == gain else UNSTABLE), gain, least
