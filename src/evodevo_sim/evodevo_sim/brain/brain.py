"""The brain: what the cells' networks do in one control step.  Senses in, activation of every cell out; it knows no body.

Every cell runs the same network, with concentrations of its own, and exchanges morphogens with its neighbours (paper sections 2.1, 2.2).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..development.growth import diffuse, remember
from ..genetics.regulation import CONTRACTION, EXPANSION, Network, Spread, exchange, make_spread, prune, regulate, share_out, unrest
from ..kernels.jit import kernel, lean
from ..kernels.lanes import aligned


class Brain(NamedTuple):
    """The networks of all cells.  `think` changes table, past and activation; the rest is scratch or stays."""

    network: Network  # what locomotion needs of the genome's network
    units: int  # regulatory units of the genome
    table: np.ndarray  # (rows, N) concentrations, see `genetics.regulation`
    past: np.ndarray  # variant A: morphogens of every cell in the regulation steps before
    delay: np.ndarray  # variant A: (N, N) regulation steps from cell to cell
    start: np.ndarray  # (N + 1,) of each cell's neighbours in `neighbour`
    neighbour: np.ndarray
    born: int  # regulation steps of growth
    drive: np.ndarray  # scratch
    spread: Spread  # scratch
    activation: np.ndarray  # (N,) of e - c, -1 contracting to 1 expanding


@kernel
def make_brain(weights, units, embryo, given_inputs, continual):
    """The brain of an embryo's body: its network without what only growth needs, its concentrations as growth left them."""
    cells = embryo.position.shape[0]
    network = prune(weights, units, (False, False, True, True), given_inputs, cells)
    past = embryo.past if continual else _keep_read(embryo.past, weights, units, given_inputs, network)
    spread = make_spread(network, cells)
    share_out(embryo.start, cells, spread)
    brain = Brain(
        network, units, embryo.table, past, embryo.delay, embryo.start, embryo.neighbour, embryo.steps,
        aligned(network.nodes.size, cells), spread, np.empty(cells),
    )
    find_activation(brain)
    return brain


@kernel
def _keep_read(past, weights, units, given_inputs, network):
    """Variant A: of the history of growth, the morphogens that locomotion still reads."""
    grown = prune(weights, units, (True, True, True, True), given_inputs, past.shape[2])
    kept = np.empty((past.shape[0], network.morphogens.size, past.shape[2]))
    for row, morphogen in enumerate(network.morphogens):
        was = 0
        while grown.morphogens[was] != morphogen:
            was += 1
        for step in range(past.shape[0]):
            for i in range(past.shape[2]):
                kept[step, row, i] = past[step, was, i]
    return kept


@lean
def find_activation(brain):
    """Set every cell's activation to what its network holds."""
    e, c = brain.table[brain.units + EXPANSION], brain.table[brain.units + CONTRACTION]
    for i in range(brain.activation.size):
        brain.activation[i] = e[i] - c[i]


@lean
def think(brain, step, development, continual):
    """One control step of every cell, in place: morphogens spread, concentrations move, and with them activation."""
    network, table, cells = brain.network, brain.table, brain.activation.size
    if continual:
        exchange(network, table, brain.start, brain.neighbour, cells, brain.spread)
    else:
        now = brain.born + step
        remember(network, table, brain.past, now, cells)
        diffuse(network, table, brain.past, now, brain.delay, cells, development.morphogen_range)
    regulate(network, table, brain.drive, cells, development.regulation_rate)
    find_activation(brain)


@lean
def brain_unrest(brain):
    """How far any concentration is from where it is going."""
    return unrest(brain.network, brain.table, brain.drive, brain.activation.size)
