"""The Gabriel graph of a growing embryo (paper section 2.2): i-j is an edge unless a third cell lies in the circle on ij.

The circle counts as closed, up to rounding: of four cells on a perfect square neither diagonal is an edge.  Otherwise both
would be, and the graph would not be planar.  It still holds the minimum spanning tree, so it is connected.
"""

from __future__ import annotations

import numpy as np

from ..kernels.jit import lean
from .gabriel_tree import TIE, tree_edges

_MANY = 56  # cells, from which on a tree is faster
_FAR = 1e18  # m^2, more than any cell is outside a circle
_DEEP = 0.05  # a witness this deep, in squares of the distance of its pair, is kept: it will do for long
_SHARE = 0.4  # of a distance from a circle, that every cell may move; exact: 1 / (1 + sqrt 2) = 0.414
_ROUNDING = 1e-8  # m, above that of the tests and their slack in bodies of up to 10 km


@lean
def gabriel_edges(position, cells, witness, edges, rounding=0.0):
    """Fill `edges` with the pairs (i, j), i < j, of the graph in ascending order.

    Args:
        position: (>= cells, 2) float64.
        witness: (>= cells, >= cells) int32 scratch kept between calls: the cell last seen inside the circle of a pair, which
            most often still is; any cell index is a valid start.
        edges: (>= 3 cells, 2) int64, filled.
        rounding: m, how much farther than by TIE a cell may be outside a circle and still count as on it.

    Returns: number of edges.
    """
    count = 0
    for i in range(cells):
        xi, yi = position[i, 0], position[i, 1]
        for j in range(i + 1, cells):
            xj, yj = position[j, 0], position[j, 1]
            square = (xi - xj) ** 2 + (yi - yj) ** 2
            slack = TIE * square + rounding * np.sqrt(square)
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
def _nearest(position, cells, i, j, good):
    """(how far outside the circle on ij a third cell is, which): the least of all, or the first below `good`; m^2, < 0 inside."""
    xi, yi = position[i, 0], position[i, 1]
    xj, yj = position[j, 0], position[j, 1]
    least, at = _FAR, 0
    for k in range(cells):
        xk, yk = position[k, 0], position[k, 1]
        outside = (xi - xk) * (xj - xk) + (yi - yk) * (yj - yk)
        if outside < least and k != i and k != j:
            least, at = outside, k
            if outside < good:
                break
    return least, at


@lean
def _follow_row(position, cells, i, witness, edges, count):
    """Write the edges (i, j), i < j, into `edges` from `count` on.

    Returns: (number of edges now; how far from its circle the cell that decides a pair is, m, the least of all pairs).
    """
    xi, yi = position[i, 0], position[i, 1]
    safe = _FAR * _FAR  # m^2
    for j in range(i + 1, cells):
        xj, yj = position[j, 0], position[j, 1]
        square = (xi - xj) ** 2 + (yi - yj) ** 2
        k = witness[i, j]
        xk, yk = position[k, 0], position[k, 1]
        outside = (xi - xk) * (xj - xk) + (yi - yk) * (yj - yk)
        # i and j themselves are 0 outside.  The depth of a cell inside is at least -outside / distance of i and j.
        if not outside < -_DEEP * square:
            outside, k = _nearest(position, cells, i, j, -_DEEP * square)
            witness[i, j] = k
            if outside > TIE * square:
                edges[count, 0] = i
                edges[count, 1] = j
                count += 1
        if outside < 0.0:
            if outside * outside < safe * square:
                safe = outside * outside / square
        else:
            gap = outside / (np.sqrt(outside + 0.25 * square) + np.sqrt(0.25 * square)) if outside > 0.0 else 0.0
            safe = min(safe, gap * gap)
    return count, np.sqrt(safe)


@lean
def follow(position, cells, travelled, holds, witness, edges, count, spare):
    """Bring the edges up to date with cells that have moved, the same as `gabriel_edges`.

    A pair is decided by the cell nearest its circle.  Where no cell moves more than s, the distance of that cell from the circle
    changes by (1 + sqrt 2) s at the most, so a row of pairs is looked at again only when the cells may have moved that far.

    Args:
        travelled: m, how far any cell can have moved since the first call, at the most.
        holds: (>= cells,) m, `travelled` up to which the pairs (i, j), i < j, stay as they are; -1 for a row with a new cell.
        witness: (>= cells, >= cells) int32 kept between calls, see `gabriel_edges`.
        edges, count: (>= 3 cells, 2) and their number at the last call; changed in place.
        spare: scratch like `edges`.

    Returns: (number of edges, whether they changed).
    """
    soonest = holds[0]
    for i in range(1, cells):
        soonest = min(soonest, holds[i])
    if travelled < soonest:
        return count, False
    now, e = 0, 0
    for i in range(cells):
        if travelled < holds[i]:
            while e < count and edges[e, 0] == i:
                spare[now, 0], spare[now, 1] = i, edges[e, 1]
                e += 1
                now += 1
        else:
            while e < count and edges[e, 0] == i:
                e += 1
            now, safe = _follow_row(position, cells, i, witness, spare, now)
            holds[i] = travelled + _SHARE * safe - _ROUNDING
    changed = now != count
    for e in range(now):
        changed = changed or edges[e, 0] != spare[e, 0] or edges[e, 1] != spare[e, 1]
        edges[e, 0], edges[e, 1] = spare[e, 0], spare[e, 1]
    return now, changed


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


def gabriel_graph(position: np.ndarray, rounding: float = 0.0) -> np.ndarray:
    """Edges (E, 2) of the Gabriel graph of (N, 2) positions, i < j, ascending.  Args: rounding: see `gabriel_edges`."""
    cells = position.shape[0]
    edges = np.empty((3 * cells + 1, 2), np.int64)
    if cells > _MANY:
        count = tree_edges(position, edges, rounding)
    else:
        count = gabriel_edges(position, cells, np.zeros((cells, cells), np.int32), edges, rounding)
    return edges[:count].copy()
