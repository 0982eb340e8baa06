"""The swimming task (paper section 4.2): growth, rest with the muscles where the network holds them, then locomotion.

A swimmer starts from rest in the shape that its own network holds at birth, so that neither the first jump of the rest
lengths nor one fold of a tail carries it; what pays is motion that lasts to the end (docs/model.md).
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
    rests,
    think,
    widen,
)
from ...brain.scent import disturb, sense
from ...development.growth import REST
from ...genetics.regulation import unrest
from ...kernels.jit import kernel, lean
from ...physics.control_step import INVERTED, SOUND, advance
from ...physics.rates import find_drag_rate, substeps_at_rate

_LOOK = 50  # control steps between looks at whether all rests

# failed_step: control step at which physics failed, -1 for none; path (windows + 1, 2): the centre of mass at the ends of the
# windows; amplitude: half of max - min of e - c in a window, mean over cells, in the window where it is least; active: the
# share of the most cells that a body may have whose muscles work, one of less than full activity counted in part, likewise
Swim = namedtuple("Swim", "status failed_step path amplitude active substeps cells springs chambers")


@lean
def live(life, step, until, seconds, development, continual, signals, range_of_muscle, track, traces):
    """Live from one control step to another, in place: each is one regulation step, then the body for as many seconds.

    Args: signals: see `scent.Signals`; range_of_muscle (2, N): least and most e - c, widened, or empty; track and traces as for
        `swim`.

    Returns: (status, step reached): OK; RESTING, seen now and then: nothing will ever change again; or UNSTABLE_PHYSICS or
    INVERTED_CHAMBER in that step.
    """
    body, law, network, table, drive = life.body, life.law, life.network, life.table, life.drive
    muscle, rest, position, velocity, scratch = life.muscle, life.rest, life.position, life.velocity, life.scratch
    cells = muscle.size
    find_drag_rate(body, law, position, velocity, scratch)
    while step < until:
        if track.size:
            keep(life, track[step], traces[step])
        if signals.target.size:
            sense(life, signals, step)
        think(life, step, development, continual)
        if signals.noise.size:
            disturb(life, signals, step)
        substeps = int(np.ceil(life.finer * substeps_at_rate(seconds, life.substeps, scratch)))
        outcome = advance(body, law, rest, position, velocity, seconds, substeps, scratch)
        if outcome != SOUND:
            return (INVERTED_CHAMBER if outcome == INVERTED else UNSTABLE_PHYSICS), step
        step += 1
        if range_of_muscle.size:
            widen(range_of_muscle, muscle)
        if continual and step % _LOOK == 0 and not signals.noise.size and unrest(network, table, drive, cells) < REST:
            if rests(body, law, rest, position, velocity, scratch):
                return RESTING, step
    return OK, step


@lean
def course(life, task, most_cells, development, continual, signals, path, range_of_muscle, track, traces):
    """Live through all windows, in place.

    Args: path (S + 1, 2): filled with the centre of mass; range_of_muscle (2, N): scratch; track, traces: see `swim`.

    Returns: (status, control step reached, amplitude, active), see `Swim`.
    """
    samples = (path.shape[0] - 1) // task.windows
    length = task.control_steps // task.windows
    inverse_mass = life.body.inverse_mass
    amplitude, active = 2.0, 1.0
    status, step = OK, 0
    path[0, 0], path[0, 1] = centre_of_mass(life.position, inverse_mass)
    for window in range(task.windows):
        forget(range_of_muscle)
        for k in range(samples):
            until = window * length + length * (k + 1) // samples
            status, step = live(
                life, step, until, task.control_step, development, continual, signals, range_of_muscle, track, traces
            )
            x, y = centre_of_mass(life.position, inverse_mass)
            last = window * samples + k + 2 if status == OK else path.shape[0]
            for row in range(window * samples + k + 1, last):
                path[row, 0], path[row, 1] = x, y
            if status != OK:
                break
        if status != OK:
            amplitude, active = 0.0, 0.0
            break
        mean, working = activity(range_of_muscle, task.full_activity)
        amplitude = min(amplitude, mean)
        active = min(active, working / most_cells)
    if track.size:
        for later in range(step, task.control_steps + 1):
            keep(life, track[later], traces[later])
    return status, step, amplitude, active


@kernel
def swim(genome, task, development, continual, material, scene, given_inputs, finer, signals, track, traces):
    """Evaluate a genome: growth and the whole swim in one call.

    Args:
        genome: (kind, sign, x, y); finer: see `birth`; signals: see `scent.Signals`; the others: arguments of the parameter
            classes.
        track: (control_steps + 1, max_cells, 4) for x, y, vx, vy of every cell, or empty; traces: the same of e - c.

    Returns: Swim.
    """
    path = np.zeros((task.windows + 1, 2))
    status, life = birth(genome, development, continual, material, scene, given_inputs, task.control_step, finer)
    body = life.body
    cells, springs = life.muscle.size, body.rest_length.size
    chambers = body.triangle_area.size + body.polygon_area.size
    if status != OK:
        return Swim(status, -1, path, 0.0, 0.0, 0, cells, springs, chambers)

    status, step, amplitude, active = course(
        life, task, development.max_cells, development, continual, signals, path, np.empty((2, cells)), track, traces
    )
    failed_step = step if status == UNSTABLE_PHYSICS or status == INVERTED_CHAMBER else -1
    return Swim(status, failed_step, path, amplitude, active, life.substeps, cells, springs, chambers)
