"""The swimming task (paper section 4.2): growth, rest with the muscles where the network holds them, then locomotion.

A swimmer starts from rest in the shape that its own network holds at birth, so that neither the first jump of the rest
lengths nor one fold of a tail carries it; what pays is motion that lasts to the end (docs/model.md).
"""

from __future__ import annotations

from collections import namedtuple

import numpy as np

from ._jit import kernel
from .body import build_body
from .development import REST, diffuse, grow, remember
from .physics import INVERTED, SOUND, accelerations, advance, choose_substeps, make_law, make_scratch, set_rest_lengths, settle
from .regulation import CONTRACTION, EXPANSION, exchange, express, prune, regulate, unrest

OK, NO_GROWTH, NO_CHAMBER, RESTING, UNSTABLE_PHYSICS, INVERTED_CHAMBER = range(6)
SETTLE_TOLERANCE = 1e-3  # m/s^2
SETTLE_LIMIT = 2000
_STILL = 1e-7  # m/s and m/s^2 below which a body rests
_LOOK = 50  # control steps between looks at whether all rests

# failed_step: control step at which physics failed, -1 for none; path (windows + 1, 2): the centre of mass at the ends of the
# windows; middle (2,): and halfway; amplitude: half of max - min of e - c in the last half, mean over cells
Swim = namedtuple("Swim", "status failed_step path middle amplitude substeps cells springs chambers")



@kernel
def centre_of_mass(position, inverse_mass):
    x, y, total = 0.0, 0.0, 0.0
    for i in range(position.shape[0]):
        m = 1.0 / inverse_mass[i]
        x += m * position[i, 0]
        y += m * position[i, 1]
        total += m
    return x / total, y / total


@kernel
def _rests(body, law, rest, position, velocity, scratch):
    accelerations(body, law, rest, position, velocity, scratch.k1)
    most = 0.0
    for i in range(position.shape[0]):
        for a in range(2):
            most = max(most, abs(velocity[i, a]), abs(scratch.k1[i, a]))
    return most < _STILL


@kernel
def develop(genome, development, continual, given_inputs, history, activations, graphs):
    """Grow a genome's embryo.  Returns: (weights, units, Embryo); see `regulation.express` and `development.grow`."""
    weights, units = express(*genome)
    network = prune(weights, units, np.array([True, True, True, True]), given_inputs)
    return weights, units, grow(network, development, continual, history, activations, graphs)


@kernel
def swim(genome, task, development, continual, material, scene, given_inputs, track, traces):
    """Evaluate a genome: growth and the whole swim in one call.

    Args:
        genome: (kind, sign, x, y); the others: arguments of the parameter classes.
        track: (control_steps + 1, max_cells, 4) for x, y, vx, vy of every cell, or empty; traces: the same of e - c.

    Returns: Swim.
    """
    none = np.empty((0, 0, 0))
    path = np.zeros((task.windows + 1, 2))
    middle = np.zeros(2)
    weights, units, embryo = develop(
        genome, development, continual, given_inputs, none, np.empty((0, 0)), np.empty((0, 0, 0), np.int64)
    )
    cells, springs = embryo.position.shape[0], embryo.edges.shape[0]
    if cells < 2:
        return Swim(NO_GROWTH, -1, path, middle, 0.0, 0, cells, springs, 0)
    body = build_body(embryo.position, embryo.edges, embryo.start, embryo.neighbour, material.mass)
    chambers = body.triangle_area.size + body.polygon_area.size
    if chambers == 0:
        return Swim(NO_CHAMBER, -1, path, middle, 0.0, 0, cells, springs, 0)

    network = prune(weights, units, np.array([False, False, True, True]), given_inputs)
    law = make_law(material, scene)
    substeps = choose_substeps(body, law, task.control_step)
    scratch = make_scratch(cells)
    table, past, delay = embryo.table, embryo.past, embryo.delay
    drive = np.empty((network.nodes.size, cells))
    position, velocity, rest = body.position.copy(), np.zeros((cells, 2)), np.empty(springs)
    muscle, share = np.empty(cells), np.empty(cells)
    low, high = np.full(cells, np.inf), np.full(cells, -np.inf)
    e, c = table[units + EXPANSION], table[units + CONTRACTION]
    if not continual:
        past = _keep_read(past, weights, units, given_inputs, network)

    for i in range(cells):
        muscle[i] = e[i] - c[i]
    set_rest_lengths(body, muscle, rest)
    settle(body, law, rest, position, velocity, SETTLE_TOLERANCE, SETTLE_LIMIT, scratch)

    status, failed_step = OK, -1
    window, half = task.control_steps // task.windows, task.control_steps // 2
    path[0] = centre_of_mass(position, body.inverse_mass)
    step = 0
    while step < task.control_steps:
        if track.size:
            track[step, :cells, :2] = position
            track[step, :cells, 2:] = velocity
            traces[step, :cells] = muscle
        if continual:
            exchange(network, table, embryo.start, embryo.neighbour, cells, share)
        else:
            now = embryo.steps + step
            remember(network, table, past, now, cells)
            diffuse(network, table, past, now, delay, cells, development.morphogen_range)
        regulate(network, table, drive, cells, development.regulation_rate)
        for i in range(cells):
            muscle[i] = e[i] - c[i]
        set_rest_lengths(body, muscle, rest)
        outcome = advance(body, law, rest, position, velocity, task.control_step, substeps, scratch)
        if outcome != SOUND:
            status = INVERTED_CHAMBER if outcome == INVERTED else UNSTABLE_PHYSICS
            failed_step = step
            break
        step += 1
        if step > half:
            for i in range(cells):
                low[i] = min(low[i], muscle[i])
                high[i] = max(high[i], muscle[i])
        if step % window == 0:
            path[step // window] = centre_of_mass(position, body.inverse_mass)
        if step == half:
            middle[0], middle[1] = centre_of_mass(position, body.inverse_mass)
        if continual and step % _LOOK == 0 and unrest(network, table, drive, cells) < REST:
            if _rests(body, law, rest, position, velocity, scratch):
                status = RESTING
                break
    if status == RESTING:
        for w in range(step // window + 1, task.windows + 1):
            path[w] = centre_of_mass(position, body.inverse_mass)
        if step < half:
            middle[0], middle[1] = centre_of_mass(position, body.inverse_mass)
    if track.size:
        for later in range(step, task.control_steps + 1):
            track[later, :cells, :2] = position
            track[later, :cells, 2:] = velocity
            traces[later, :cells] = muscle
    amplitude = 0.0
    if step > half:
        for i in range(cells):
            amplitude += 0.5 * (high[i] - low[i]) / cells
    return Swim(status, failed_step, path, middle, amplitude, substeps, cells, springs, chambers)


@kernel
def _keep_read(past, weights, units, given_inputs, network):
    """Variant A: of the history of growth, the morphogens that locomotion still reads."""
    grown = prune(weights, units, np.array([True, True, True, True]), given_inputs)
    kept = np.empty((past.shape[0], network.morphogens.size, past.shape[2]))
    for row, morphogen in enumerate(network.morphogens):
        kept[:, row] = past[:, np.searchsorted(grown.morphogens, morphogen)]
    return kept
