"""The Gabriel graph of a growing embryo (paper section 2.2): i-j is an edge unless a third cell lies in the circle on ij.

The circle counts as closed, up to rounding: of four cells on a perfect square neither diagonal is an edge.  Otherwise both
would be, and the graph would not be planar.  It still holds the minimum spanning tree, so it is connected.
"""

from __future__ import annotations

import numpy as np

from ._jit import kernel, lean

_TIE = 1e-12  # relative slack of the circle


@lean
def gabriel_edges(position, cells, witness, edges):
    """Fill `edges` with the pairs (i, j), i < j, of the graph in ascending order.

    Args:
        position: (>= cells, 2) float64.
        witness: (>= cells, >= cells) int32 scratch kept between calls: the cell last seen inside the circle of a pair, which
            most often still is; any cell index is a valid start.
        edges: (>= 3 cells, 2) int64, filled.

    Returns: number of edges.
    """
    count = 0
    for i in range(cells):
        xi, yi = position[i, 0], position[i, 1]
        for j in range(i + 1, cells):
            xj, yj = position[j, 0], position[j, 1]
            slack = _TIE * ((xi - xj) ** 2 + (yi - yj) ** 2)
            k = witness[i, j]
            if k != i and k != j and k < cells:
                xk, yk = position[k, 0], position[k, 1]
                if (xi - xk) * (xj - xk) + (yi - yk) * (yj - yk) <= slack:
                    continue
            free = True
            for k in range(cells):
                xk, yk = position[k, 0], position[k, 1]
                if (xi - xk) * (xj - xk) + (yi - yk) * (yj - yk) <= slack and k != i and k != j:
                    witness[i, j] = k
                    free = False
                    break
            if free:
                edges[count, 0] = i
                edges[count, 1] = j
                count += 1
    return count


@lean
def adjacency(edges, count, cells, start, neighbour):
    """Fill adjacency lists (CSR) of an undirected graph: start (>= cells + 1,), neighbour (>= 2 count,)."""
    for i in range(cells + 1):
        start[i] = 0
    for e in range(count):
        start[edges[e, 0] + 1] += 1
        start[edges[e, 1] + 1] += 1
    for i in range(cells):
        start[i + 1] += start[i]
    # Filling from the back leaves start[i] at the first entry of i again.
    for i in range(cells, 0, -1):
        start[i] = start[i - 1]
    for e in range(count):
        i, j = edges[e, 0], edges[e, 1]
        neighbour[start[i + 1]] = j
        start[i + 1] += 1
        neighbour[start[j + 1]] = i
        start[j + 1] += 1


@kernel
def gabriel_graph(position):
    """Edges (E, 2) of the Gabriel graph of (N, 2) positions, i < j, ascending."""
    cells = position.shape[0]
    witness = np.zeros((cells, cells), np.int32)
    edges = np.empty((3 * cells + 1, 2), np.int64)
    return edges[: gabriel_edges(position, cells, witness, edges)].copy()
