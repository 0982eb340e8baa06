"""Where the mass of a body is."""

from __future__ import annotations

from ..kernels.jit import lean


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
