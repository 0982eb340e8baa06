"""What copies of one animat smell that move abreast: see `physics.abreast`."""

from __future__ import annotations

from ..kernels.jit import inlined, lean
from ..kernels.vectors import chosen, four, load4, root, store4_within, transpose


@inlined
def _scents(state, i, target, cells):
    """`scent.scent` of the copies of one cell, nothing beyond the last."""
    nothing, one, cell = four(0.0), four(1.0), 16 * min(i, cells - 1)
    dx, dy = load4(state, cell) - target[0], load4(state, cell + 4) - target[1]
    left = one - root(dx * dx + dy * dy) / target[3]
    return chosen(left, nothing, target[2] * left, nothing)


@lean
def sense_abreast(table, row, abreast, target, cells):
    """Clamp the scent input of every cell of every copy: see `scent.sense`, without noise and eyes.

    Args: table (4, rows, W); row: of the input; abreast: see `Abreast`; target (4, 4): see `Signals`, of each copy.
    """
    where = transpose(load4(target[0], 0), load4(target[1], 0), load4(target[2], 0), load4(target[3], 0))
    state = abreast.state
    for i in range(0, cells, 4):
        a, b, c, d = transpose(
            _scents(state, i, where, cells), _scents(state, i + 1, where, cells), _scents(state, i + 2, where, cells),
            _scents(state, i + 3, where, cells),
        )
        store4_within(table[0, row, :cells], i, a)
        store4_within(table[1, row, :cells], i, b)
        store4_within(table[2, row, :cells], i, c)
        store4_within(table[3, row, :cells], i, d)
