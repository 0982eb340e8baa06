"""The swimming task (paper section 4.2): growth, rest with the muscles where the network holds them, then locomotion.

A swimmer starts from rest in the shape that its own network holds at birth, so that neither the first jump of the rest
lengths nor one fold of a tail carries it; what pays is motion that lasts to the end (docs/model.md).
"""

from __future__ import annotations

from collections import namedtuple

import numpy as np

from ._jit import kernel, lean
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
# windows; amplitude: half of max - min of e - c in a window, mean over cells, in the window where it is least; active: the
# share of the most cells that a body may have whose muscles work, one of less than full activity counted in part, likewise
Swim = namedtuple("Swim", "status failed_step path amplitude active substeps cells springs chambers")
# A living animat.  Changed by `live`: position, velocity (2, N), muscle (N,) of e - c, table, past; the rest is scratch
# or stays.  born: regulation steps of growth; start, neighbour: the graph; substeps: 0 where there is no body to move.
Life = namedtuple(
    "Life",
    "body law network units table past delay start neighbour born drive share muscle rest position velocity scratch substeps",
)


@lean
def centre_of_mass(position, inverse_mass):
    """(x, y) of cells at position (2, N)."""
    x, y, total = 0.0, 0.0, 0.0
    for i in range(position.shape[1]):
        m = 1.0 / inverse_mass[i]
        x += m * position[0, i]
        y += m * position[1, i]
        total += m
    return x / total, y / total


@lean
def _rests(body, law, rest, position, velocity, scratch):
    accelerations(body, law, rest, position, velocity, scratch, scratch.k1)
    most = 0.0
    for a in range(2):
        for i in range(position.shape[1]):
            most = max(most, abs(velocity[a, i]), abs(scratch.k1[a, i]))
    return most < _STILL


@kernel
def develop(genome, development, continual, given_inputs, history, activations, graphs):
    """Grow a genome's embryo.  Returns: (weights, units, Embryo); see `regulation.express` and `development.grow`."""
    weights, units = express(*genome)
    network = prune(weights, units, np.array([True, True, True, True]), given_inputs)
    return weights, units, grow(network, development, continual, history, activations, graphs)


@kernel
def birth(genome, development, continual, material, scene, given_inputs, control_step, finer):
    """Grow a genome and bring its body to rest with the muscles where its network holds them.

    Args: finer: times as many substeps as are stable; 1 but for an audit.

    Returns: (OK, NO_GROWTH or NO_CHAMBER; Life, which moves only if OK).
    """
    weights, units, embryo = develop(
        genome, development, continual, given_inputs, np.empty((0, 0, 0)), np.empty((0, 0)), np.empty((0, 0, 0), np.int64)
    )
    cells = embryo.position.shape[0]
    body = build_body(embryo.position, embryo.edges, embryo.start, embryo.neighbour, material.mass)
    status = OK
    if cells < 2:
        status = NO_GROWTH
    elif body.triangle_area.size + body.polygon_area.size == 0:
        status = NO_CHAMBER
    network = prune(weights, units, np.array([False, False, True, True]), given_inputs)
    law = make_law(material, scene)
    past = embryo.past if continual else _keep_read(embryo.past, weights, units, given_inputs, network)
    life = Life(
        body, law, network, units, embryo.table, past, embryo.delay, embryo.start, embryo.neighbour, embryo.steps,
        np.empty((network.nodes.size, cells)), np.empty((cells, 4)), np.empty(cells), np.empty(body.rest_length.size),
        body.position.T.copy(), np.zeros((2, cells)), make_scratch(body),
        finer * choose_substeps(body, law, control_step) if status == OK else 0,
    )
    if status == OK:
        for i in range(cells):
            life.muscle[i] = embryo.table[units + EXPANSION, i] - embryo.table[units + CONTRACTION, i]
        set_rest_lengths(body, life.muscle, life.rest)
        settle(body, law, life.rest, life.position, life.velocity, SETTLE_TOLERANCE, SETTLE_LIMIT, life.scratch)
    return status, life


@lean
def _keep(life, track, traces):
    for i in range(life.muscle.size):
        track[i, 0], track[i, 1] = life.position[0, i], life.position[1, i]
        track[i, 2], track[i, 3] = life.velocity[0, i], life.velocity[1, i]
        traces[i] = life.muscle[i]


@lean
def live(life, step, until, seconds, development, continual, range_of_muscle, track, traces):
    """Live from one control step to another, in place: each is one regulation step, then the body for as many seconds.

    Args: range_of_muscle (2, N): least and most e - c, widened, or empty; track and traces as for `swim`.

    Returns: (status, step reached): OK; RESTING, seen now and then: nothing will ever change again; or UNSTABLE_PHYSICS or
    INVERTED_CHAMBER in that step.
    """
    body, law, network, table, past, drive = life.body, life.law, life.network, life.table, life.past, life.drive
    muscle, rest, position, velocity, scratch = life.muscle, life.rest, life.position, life.velocity, life.scratch
    start, neighbour, share, delay = life.start, life.neighbour, life.share, life.delay
    cells = muscle.size
    e, c = table[life.units + EXPANSION], table[life.units + CONTRACTION]
    while step < until:
        if track.size:
            _keep(life, track[step], traces[step])
        if continual:
            exchange(network, table, start, neighbour, cells, share)
        else:
            now = life.born + step
            remember(network, table, past, now, cells)
            diffuse(network, table, past, now, delay, cells, development.morphogen_range)
        regulate(network, table, drive, cells, development.regulation_rate)
        for i in range(cells):
            muscle[i] = e[i] - c[i]
        set_rest_lengths(body, muscle, rest)
        outcome = advance(body, law, rest, position, velocity, seconds, life.substeps, scratch)
        if outcome != SOUND:
            return (INVERTED_CHAMBER if outcome == INVERTED else UNSTABLE_PHYSICS), step
        step += 1
        if range_of_muscle.size:
            least, most = range_of_muscle[0], range_of_muscle[1]
            for i in range(cells):
                least[i] = muscle[i] if muscle[i] < least[i] else least[i]
                most[i] = muscle[i] if muscle[i] > most[i] else most[i]
        if continual and step % _LOOK == 0 and unrest(network, table, drive, cells) < REST:
            if _rests(body, law, rest, position, velocity, scratch):
                return RESTING, step
    return OK, step


@kernel
def swim(genome, task, development, continual, material, scene, given_inputs, finer, track, traces):
    """Evaluate a genome: growth and the whole swim in one call.

    Args:
        genome: (kind, sign, x, y); finer: see `birth`; the others: arguments of the parameter classes.
        track: (control_steps + 1, max_cells, 4) for x, y, vx, vy of every cell, or empty; traces: the same of e - c.

    Returns: Swim.
    """
    path = np.zeros((task.windows + 1, 2))
    status, life = birth(genome, development, continual, material, scene, given_inputs, task.control_step, finer)
    body, position, muscle = life.body, life.position, life.muscle
    cells, springs = muscle.size, body.rest_length.size
    chambers = body.triangle_area.size + body.polygon_area.size
    if status != OK:
        return Swim(status, -1, path, 0.0, 0.0, 0, cells, springs, chambers)

    length = task.control_steps // task.windows
    range_of_muscle = np.empty((2, cells))
    amplitude, active = 2.0, 1.0
    path[:, 0], path[:, 1] = centre_of_mass(position, body.inverse_mass)
    step = 0
    for window in range(task.windows):
        range_of_muscle[0], range_of_muscle[1] = np.inf, -np.inf
        status, step = live(
            life, step, step + length, task.control_step, development, continual, range_of_muscle, track, traces
        )
        path[window + 1 :, 0], path[window + 1 :, 1] = centre_of_mass(position, body.inverse_mass)
        if status != OK:
            amplitude, active = 0.0, 0.0
            break
        total, working = 0.0, 0.0
        for i in range(cells):
            a = 0.5 * (range_of_muscle[1, i] - range_of_muscle[0, i])
            total += a
            working += min(1.0, a / task.full_activity)
        amplitude = min(amplitude, total / cells)
        active = min(active, working / development.max_cells)
    if track.size:
        for later in range(step, task.control_steps + 1):
            _keep(life, track[later], traces[later])
    failed_step = step if status == UNSTABLE_PHYSICS or status == INVERTED_CHAMBER else -1
    return Swim(status, failed_step, path, amplitude, active, life.substeps, cells, springs, chambers)


@kernel
def _keep_read(past, weights, units, given_inputs, network):
    """Variant A: of the history of growth, the morphogens that locomotion still reads."""
    grown = prune(weights, units, np.array([True, True, True, True]), given_inputs)
    kept = np.empty((past.shape[0], network.morphogens.size, past.shape[2]))
    for row, morphogen in enumerate(network.morphogens):
        kept[:, row] = past[:, np.searchsorted(grown.morphogens, morphogen)]
    return kept
