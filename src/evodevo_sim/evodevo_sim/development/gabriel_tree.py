"""The Gabriel graph of many cells in O(N log N), for cells spread in any way: by a tree of boxes.

A cell k rules out all edges from i to cells beyond the line through k across ik: their circles hold k.  So a search from i,
nearest boxes first, leaves out every box beyond such a line, and comes to an end when the cells around i rule out the rest.
What it finds is tested against the cells in the boxes that its circle meets.

Boxes are left out by the very expression that tests cells, at the corner where it is largest or least.  Rounding is
monotone, so no cell of the box would have given another answer: the edges are exactly those of the test of all triples.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..kernels.jit import kernel, lean

TIE = 1e-12  # relative slack of the circle
_LEAF = 6  # cells in a box that is not divided, at the most
_LINES = 24  # cells, at the most, by which a search leaves out boxes


class Tree(NamedTuple):
    """Boxes of cells.  The children of node n are 2n + 1 and 2n + 2; those of leaves would be beyond the last node."""

    order: np.ndarray  # (N,) of the cells
    first: np.ndarray  # (nodes,): ranges of it
    last: np.ndarray  # (nodes,)
    box: np.ndarray  # (nodes, 4) m: least x, y, largest x, y


class Search(NamedTuple):
    """Scratch of a search."""

    stack: np.ndarray  # (128,) of nodes
    kx: np.ndarray  # (_LINES,) m: cells by whose lines boxes are left out
    ky: np.ndarray  # (_LINES,) m


@kernel
def _plant(position):
    """The tree of positions (N, 2).

    Cells are sorted once along either axis; a node halves its range of one order and parts the other alike, which keeps both sorted.
    """
    cells = position.shape[0]
    inner = 1
    while inner * _LEAF < cells:
        inner *= 2
    nodes = 2 * inner - 1
    order, rank = np.empty((2, cells), np.int64), np.empty((2, cells), np.int64)
    for axis in range(2):
        order[axis] = np.argsort(position[:, axis])
        for m in range(cells):
            rank[axis, order[axis, m]] = m
    first, last, box = np.zeros(nodes, np.int64), np.zeros(nodes, np.int64), np.empty((nodes, 4))
    later = np.empty(cells, np.int64)
    last[0] = cells
    for n in range(nodes):
        a, b = first[n], last[n]
        for axis in range(2):
            box[n, axis], box[n, 2 + axis] = position[order[axis, a], axis], position[order[axis, b - 1], axis]
        if 2 * n + 2 < nodes:
            axis = 0 if box[n, 2] - box[n, 0] > box[n, 3] - box[n, 1] else 1
            middle = (a + b) // 2
            least, other, kept = rank[axis, order[axis, middle]], order[1 - axis], a
            for m in range(a, b):
                k = other[m]
                if rank[axis, k] < least:
                    other[kept] = k
                    kept += 1
                else:
                    later[m - kept] = k
            other[middle:b] = later[: b - middle]
            first[2 * n + 1], last[2 * n + 1], first[2 * n + 2], last[2 * n + 2] = a, middle, middle, b
    return Tree(order=order[0], first=first, last=last, box=box)


@lean
def _slack(xi, yi, xj, yj, rounding):
    square = (xi - xj) ** 2 + (yi - yj) ** 2
    return TIE * square + rounding * np.sqrt(square)


@lean
def _inside(xi, yi, xj, yj, xk, yk, slack):
    """Whether k lies in the closed circle on ij."""
    return (xi - xk) * (xj - xk) + (yi - yk) * (yj - yk) <= slack


@lean
def _ruled_out(x, y, kx, ky, lines, box):
    """Whether the whole box lies beyond the line of one of the cells (kx, ky)."""
    for m in range(lines):
        ax, ay = x - kx[m], y - ky[m]
        if max(ax * (box[0] - kx[m]), ax * (box[2] - kx[m])) + max(ay * (box[1] - ky[m]), ay * (box[3] - ky[m])) <= 0.0:
            return True
    return False


@lean
def _distance(x, y, box):
    """Square of the distance of a point from a box, m^2."""
    dx, dy = max(box[0] - x, 0.0, x - box[2]), max(box[1] - y, 0.0, y - box[3])
    return dx * dx + dy * dy


@lean
def _candidates(position, i, rounding, tree, search, found):
    """Fill `found` with cells among which are all Gabriel neighbours of i.  Returns their number."""
    first, last, box, stack, kx, ky = tree.first, tree.last, tree.box, search.stack, search.kx, search.ky
    x, y = position[i, 0], position[i, 1]
    count, lines, top = 0, 0, 1
    stack[0] = 0
    while top:
        top -= 1
        n = stack[top]
        if _ruled_out(x, y, kx, ky, lines, box[n]):
            continue
        left = 2 * n + 1
        if left < box.shape[0]:
            far = 0 if _distance(x, y, box[left]) > _distance(x, y, box[left + 1]) else 1
            stack[top], stack[top + 1] = left + far, left + 1 - far
            top += 2
            continue
        for j in range(first[n], last[n]):
            free = j != i
            slack = _slack(x, y, position[j, 0], position[j, 1], rounding)
            k = 0
            while free and k < lines:
                free = not _inside(x, y, position[j, 0], position[j, 1], kx[k], ky[k], slack)
                k += 1
            if free:
                found[count] = j
                count += 1
                if lines < kx.size:
                    kx[lines], ky[lines] = position[j, 0], position[j, 1]
                    lines += 1
    return count


@lean
def _empty(position, i, j, rounding, tree, stack):
    """Whether no third cell lies in the circle on ij."""
    first, last, box = tree.first, tree.last, tree.box
    xi, yi, xj, yj = position[i, 0], position[i, 1], position[j, 0], position[j, 1]
    slack = _slack(xi, yi, xj, yj, rounding)
    top = 1
    stack[0] = 0
    while top:
        top -= 1
        n = stack[top]
        least = 0.0
        for axis in range(2):
            a, b = position[i, axis], position[j, axis]
            a0, a1, b0, b1 = a - box[n, axis], a - box[n, 2 + axis], b - box[n, axis], b - box[n, 2 + axis]
            least += min(a0 * b0, a0 * b1, a1 * b0, a1 * b1)
        if least > slack:
            continue
        if 2 * n + 2 < box.shape[0]:
            stack[top], stack[top + 1] = 2 * n + 1, 2 * n + 2
            top += 2
            continue
        for k in range(first[n], last[n]):
            if k != i and k != j and _inside(xi, yi, xj, yj, position[k, 0], position[k, 1], slack):
                return False
    return True


@kernel
def tree_edges(position, edges, rounding=0.0):
    """As `gabriel.gabriel_edges`: fill `edges` (>= 3 N, 2) of (N, 2) positions.  Returns their number."""
    cells = position.shape[0]
    tree = _plant(position)
    order = tree.order
    planted = position[order]  # cells of a box side by side
    search, found = Search(np.empty(128, np.int64), np.empty(_LINES), np.empty(_LINES)), np.empty(cells, np.int64)
    pairs, count = np.empty(edges.shape[0], np.int64), 0
    for i in range(cells):
        for m in range(_candidates(planted, i, rounding, tree, search, found)):
            j = found[m]
            if j > i and _empty(planted, i, j, rounding, tree, search.stack):
                a, b = order[i], order[j]
                pairs[count] = min(a, b) * cells + max(a, b)
                count += 1
    pairs[:count].sort()
    for e in range(count):
        edges[e, 0], edges[e, 1] = pairs[e] // cells, pairs[e] % cells
    return count
