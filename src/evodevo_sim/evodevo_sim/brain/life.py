"""What every task's animats share: growth, birth, one control step's regulation, rest.

An animat is born at rest in the shape that its own network holds, so that neither the first jump of the rest lengths nor one
fold of a tail carries it (docs/model.md).
"""

from __future__ import annotations

from collections import namedtuple

import numpy as np

from ..development.body import build_body
from ..development.growth import diffuse, grow, remember
from ..genetics.regulation import CONTRACTION, EXPANSION, exchange, express, make_spread, prune, regulate, share_out
from ..kernels.jit import kernel, lean
from ..kernels.lanes import aligned
from ..physics.control_step import settle
from ..physics.forces import accelerations, make_law, make_scratch, set_rest_lengths
from ..physics.rates import MOST_SUBSTEPS, choose_substeps

OK, NO_GROWTH, NO_CHAMBER, RESTING, UNSTABLE_PHYSICS, INVERTED_CHAMBER = range(6)
SETTLE_TOLERANCE = 1e-3  # m/s^2
SETTLE_LIMIT = 2000
_STILL = 1e-7  # m/s and m/s^2 below which a body rests

# A living animat.  Changed by `live`: position, velocity (2, N), muscle (N,) of e - c, table, past; the rest is scratch
# or stays.  born: regulation steps of growth; start, neighbour: the graph; substeps: at rest, 0 where there is no body to move;
# finer: times as many, for an audit.
Life = namedtuple(
    "Life",
    "body law network units table past delay start neighbour born drive spread muscle rest position velocity scratch substeps finer",
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
def rests(body, law, rest, position, velocity, scratch):
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
    network = prune(weights, units, np.array([True, True, True, True]), given_inputs, development.max_cells)
    return weights, units, grow(network, development, continual, history, activations, graphs)


@kernel
def birth(genome, development, continual, material, scene, given_inputs, control_step, finer):
    """Grow a genome and bring its body to rest with the muscles where its network holds them.

    Args: finer: times as many substeps as are chosen, rounded up; 1 but for an audit.

    Returns: (OK, NO_GROWTH, NO_CHAMBER, or UNSTABLE_PHYSICS where it needs more than MOST_SUBSTEPS; Life, which moves only if OK).
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
    network = prune(weights, units, np.array([False, False, True, True]), given_inputs, cells)
    law = make_law(material, scene)
    substeps = choose_substeps(body, law, control_step) if status == OK else 0
    if substeps > MOST_SUBSTEPS:
        status, substeps = UNSTABLE_PHYSICS, 0
    past = embryo.past if continual else _keep_read(embryo.past, weights, units, given_inputs, network)
    spread = make_spread(network, cells)
    share_out(embryo.start, cells, spread)
    life = Life(
        body, law, network, units, embryo.table, past, embryo.delay, embryo.start, embryo.neighbour, embryo.steps,
        aligned(network.nodes.size, cells), spread, np.empty(cells), np.empty(body.rest_length.size),
        body.position.T.copy(), np.zeros((2, cells)), make_scratch(body),
        substeps, float(finer),
    )
    if status == OK:
        for i in range(cells):
            life.muscle[i] = embryo.table[units + EXPANSION, i] - embryo.table[units + CONTRACTION, i]
        set_rest_lengths(body, life.muscle, life.rest)
        settle(body, law, life.rest, life.position, life.velocity, SETTLE_TOLERANCE, SETTLE_LIMIT, life.scratch)
    return status, life


@lean
def keep(life, track, traces):
    for i in range(life.muscle.size):
        track[i, 0], track[i, 1] = life.position[0, i], life.position[1, i]
        track[i, 2], track[i, 3] = life.velocity[0, i], life.velocity[1, i]
        traces[i] = life.muscle[i]


@kernel
def _keep_read(past, weights, units, given_inputs, network):
    """Variant A: of the history of growth, the morphogens that locomotion still reads."""
    grown = prune(weights, units, np.array([True, True, True, True]), given_inputs, past.shape[2])
    kept = np.empty((past.shape[0], network.morphogens.size, past.shape[2]))
    for row, morphogen in enumerate(network.morphogens):
        kept[:, row] = past[:, np.searchsorted(grown.morphogens, morphogen)]
    return kept


@lean
def think(life, step, development, continual):
    """One regulation step of every cell, in place: morphogens spread, concentrations and with them muscles and rest lengths move."""
    network, table, drive, muscle = life.network, life.table, life.drive, life.muscle
    cells = muscle.size
    e, c = table[life.units + EXPANSION], table[life.units + CONTRACTION]
    if continual:
        exchange(network, table, life.start, life.neighbour, cells, life.spread)
    else:
        now = life.born + step
        remember(network, table, life.past, now, cells)
        diffuse(network, table, life.past, now, life.delay, cells, development.morphogen_range)
    regulate(network, table, drive, cells, development.regulation_rate)
    for i in range(cells):
        muscle[i] = e[i] - c[i]
    set_rest_lengths(life.body, muscle, life.rest)


@lean
def forget(range_of_muscle):
    """Make a range (2, N) of least and most e - c empty."""
    for i in range(range_of_muscle.shape[1]):
        range_of_muscle[0, i], range_of_muscle[1, i] = np.inf, -np.inf


@lean
def widen(range_of_muscle, muscle):
    """Let a range of least and most e - c hold what muscles (N,) do now."""
    least, most = range_of_muscle[0], range_of_muscle[1]
    for i in range(muscle.size):
        least[i] = muscle[i] if muscle[i] < least[i] else least[i]
        most[i] = muscle[i] if muscle[i] > most[i] else most[i]


@lean
def activity(range_of_muscle, full_activity):
    """(mean amplitude over the cells, number of cells that work, those of less than full activity in part) of a range."""
    total, working, cells = 0.0, 0.0, range_of_muscle.shape[1]
    for i in range(cells):
        a = 0.5 * (range_of_muscle[1, i] - range_of_muscle[0, i])
        total += a
        working += min(1.0, a / full_activity)
    return total / cells, working
