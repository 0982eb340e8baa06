"""The swimming task (paper section 4.2): growth, rest with the muscles where the network holds them, then locomotion.

A swimmer starts from rest in the shape that its own network holds at birth, so that neither the first jump of the rest
lengths nor one fold of a tail carries it; what pays is motion that lasts to the end (docs/reference/swimming.md).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...brain.controller import Rules, brain_rests, brain_step
from ...kernels.jit import kernel, lean, seam
from ...physics.bounds import find_drag_rate
from ...physics.mass import centre_of_mass
from ...physics.soundness import SOUND
from ...plant.muscles import strike
from ...plant.simulated import actuate, move, rests
from ..ends import INVERTED, OK, RESTING, STOPPED, UNSTABLE, end_of, surely
from ..life import Kept, activity, birth, forget, keep, widen

LOOK = 50  # control steps between looks at whether all rests


class Swim(NamedTuple):
    """What a swim came to."""

    status: int
    failed_step: int  # control step at which physics failed, -1 for none
    path: np.ndarray  # (windows + 1, 2) m: the centre of mass at the ends of the windows
    amplitude: float  # half of max - min of e - c in a window, mean over cells, in the window where it is least
    active: float  # share of the most cells that a body may have whose muscles work, one of less than full activity in part, likewise
    substeps: int
    cells: int
    springs: int
    chambers: int
    bound: float = np.inf  # m: what its fitness could have been at the most, where it was STOPPED


class Stakes(NamedTuple):
    """What a swim is about, so that it can be stopped.  At a window's end its fitness is at most
    active x (min(windows x shortest window, most) + more), by what they are so far: no later window raises them, nor is a path more
    than straight."""

    bar: float  # see `Model`
    most: float  # m that motion can earn at the most
    more: float  # m that can be earned beside it at the most


@seam
def locomote(life, step, until, rules, kept):
    """Live from one control step to another, in place: each is one regulation step, then the body for as many seconds.

    Args: kept: see `life.Kept`; its activation_range is widened.

    Returns: (status, step reached): OK; RESTING, seen now and then: nothing will ever change again; or UNSTABLE or INVERTED in
    that step.
    """
    brain, state = life.brain, life.state
    find_drag_rate(state.body, state.law, state.position, state.velocity, state.scratch)
    while step < until:
        if state.halt[0]:
            return OK, until
        if kept.track.size:
            keep(life, kept.track[step], kept.activations[step])
        brain_step(brain, state.position, rules, step)
        actuate(state, brain.activation, rules.signals, step)
        outcome = move(state, rules.control_step)
        if outcome != SOUND:
            return end_of(outcome), step
        step += 1
        if kept.activation_range.size:
            if state.muscles.held.size:
                widen(kept.activation_range, state.muscles.held[0])
            else:
                widen(kept.activation_range, brain.activation)
        if step % LOOK == 0 and brain_rests(brain, rules) and rests(state, brain.activation, step):
            return RESTING, step
    return OK, step


@lean
def course(life, model, rules, path, kept, stakes):
    """Live through all windows, in place; or STOPPED at the end of one, see `Stakes`.

    Args: path (S + 1, 2): filled with the centre of mass; kept: see `life.Kept`.

    Returns: (status, control step reached, amplitude, active, bound), see `Swim`.
    """
    task, position, inverse_mass = model.task, life.state.position, life.state.body.inverse_mass
    samples = (path.shape[0] - 1) // task.windows
    length = task.control_steps // task.windows
    amplitude, active, shortest, bound = 2.0, 1.0, np.inf, np.inf
    status, step = OK, 0
    path[0, 0], path[0, 1] = centre_of_mass(position, inverse_mass)
    for window in range(task.windows):
        forget(kept.activation_range)
        for k in range(samples):
            until = window * length + length * (k + 1) // samples
            status, step = locomote(life, step, until, rules, kept)
            x, y = centre_of_mass(position, inverse_mass)
            last = window * samples + k + 2 if status == OK else path.shape[0]
            for row in range(window * samples + k + 1, last):
                path[row, 0], path[row, 1] = x, y
            if status != OK:
                break
        if status != OK:
            amplitude, active = 0.0, 0.0
            break
        mean, working = activity(kept.activation_range, task.full_activity)
        amplitude = min(amplitude, mean)
        active = min(active, working / model.development.max_cells)
        if stakes.bar > -np.inf and window + 1 < task.windows:
            before, after = path[window * samples], path[(window + 1) * samples]
            shortest = min(shortest, np.sqrt((after[0] - before[0]) ** 2 + (after[1] - before[1]) ** 2))
            most = surely(active * (min(task.windows * shortest, stakes.most) + stakes.more))
            if most < stakes.bar:
                status, bound = STOPPED, most
                break
    if kept.track.size:
        for later in range(step, task.control_steps + 1):
            keep(life, kept.track[later], kept.activations[later])
    return status, step, amplitude, active, bound


@kernel
def swim(genome, model, finer, signals, track, activations):
    """Evaluate a genome: growth and the whole swim in one call.

    Args: genome: (kind, sign, x, y); model: see `life.Model`; finer: see `birth`; signals: see `scent.Signals`; track and activations: see `life.Kept`.

    Returns: Swim.
    """
    path = np.zeros((model.task.windows + 1, 2))
    status, life = birth(genome, model, finer)
    body = life.state.body
    cells, springs = life.brain.activation.size, body.rest_length.size
    chambers = body.triangle_area.size + body.polygon_area.size
    if status != OK:
        return Swim(status, -1, path, 0.0, 0.0, 0, cells, springs, chambers, np.inf)

    strike(life.state.muscles, model.actuators, signals.random[0])
    rules = Rules(model.task.control_step, model.development, model.continual, signals)
    stakes = Stakes(model.bar, np.inf, model.task.activity_bonus)
    status, step, amplitude, active, bound = course(life, model, rules, path, Kept(np.empty((2, cells)), track, activations), stakes)
    failed_step = step if status == UNSTABLE or status == INVERTED else -1
    return Swim(status, failed_step, path, amplitude, active, life.state.substeps, cells, springs, chambers, bound)
