"""The frozen body (paper section 2.3): springs on the edges of a planar graph, chambers in its faces, an outline around it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..kernels.jit import kernel, lean


class Body(NamedTuple):
    """A body at rest.  Chambers are numbered triangles first.

    Indices are unsigned 32-bit: the force loop runs a fifth faster than with signed ones.
    """

    position: np.ndarray  # (N, 2) m
    inverse_mass: np.ndarray  # (N,) 1/kg
    spring_a: np.ndarray  # (E,): cells of every spring, a < b, in the order of `_in_turn`
    spring_b: np.ndarray  # (E,)
    rest_length: np.ndarray  # (E,) m, at zero activation
    shortest: float  # m, of them
    spring_left: np.ndarray  # (E,): the chamber on the left of a spring on its way from a to b, or the number of chambers
    spring_right: np.ndarray  # (E,): likewise on the right
    triangle: np.ndarray  # (T, 3): cells of chambers of three corners, counter-clockwise
    triangle_area: np.ndarray  # (T,) m^2
    polygon_start: np.ndarray  # (P + 1,): where each chamber of more corners begins in polygon_cell
    polygon_cell: np.ndarray  # (corners,): their cells, counter-clockwise
    polygon_area: np.ndarray  # (P,) m^2
    outline: np.ndarray  # (M, 2): cells of edges that touch the outside, each once, in the order of a walk around it
    outline_spring: np.ndarray  # (M,): their springs


@kernel
def _sort_around(position, start, neighbour):
    """Sort each adjacency list counter-clockwise by direction, in place."""
    angle = np.empty(neighbour.size)
    for i in range(start.size - 1):
        first = start[i]
        for k in range(first, start[i + 1]):
            j = neighbour[k]
            turned = np.arctan2(position[j, 1] - position[i, 1], position[j, 0] - position[i, 0])
            place = k
            while place > first and turned < angle[place - 1]:
                angle[place], neighbour[place] = angle[place - 1], neighbour[place - 1]
                place -= 1
            angle[place], neighbour[place] = turned, j


@kernel
def _walk_faces(position, start, neighbour):
    """Walk every face with the face on the left.

    Returns: (face_start (F + 1,), corner (2E,), area (F,)); the outer face is the one of least (negative or zero) area.
    """
    halves = neighbour.size
    origin = np.empty(halves, np.int64)
    for i in range(start.size - 1):
        origin[start[i] : start[i + 1]] = i
    seen = np.zeros(halves, np.bool_)
    face_start = np.zeros(halves + 1, np.int64)
    corner = np.empty(halves, np.int64)
    area = np.empty(halves)
    faces, count = 0, 0
    for first in range(halves):
        if seen[first]:
            continue
        half, twice = first, 0.0
        base = position[origin[first]]
        while not seen[half]:
            seen[half] = True
            a, b = origin[half], neighbour[half]
            corner[count] = a
            count += 1
            pa, pb = position[a] - base, position[b] - base
            twice += pa[0] * pb[1] - pa[1] * pb[0]
            # Leave b by the edge clockwise next to the one we came by.
            k = start[b]
            while neighbour[k] != a:
                k += 1
            half = k - 1 if k > start[b] else start[b + 1] - 1
        area[faces] = 0.5 * twice
        faces += 1
        face_start[faces] = count
    return face_start[: faces + 1], corner, area[:faces]


@lean
def _find(edges, i, j):
    """Index of the edge (i, j) among ascending ones."""
    low, high = 0, edges.shape[0]
    while low < high:
        middle = (low + high) // 2
        if edges[middle, 0] < i or (edges[middle, 0] == i and edges[middle, 1] < j):
            low = middle + 1
        else:
            high = middle
    return low


@kernel
def _in_turn(edges, cells):
    """An order of edges (E, 2), given in ascending order, in which those that follow each other seldom share a cell.

    Each adds to the forces on its cells what must wait for the sum so far: in ascending order, most of them would wait for the
    one before.  The edges of one cell keep their order, so no sum changes by one bit.  Returns: (E,), from places to edges.
    """
    turns, turn, most = np.zeros(cells, np.int64), np.empty(edges.shape[0], np.int64), 0
    for e in range(turn.size):
        i, j = edges[e, 0], edges[e, 1]
        turn[e] = max(turns[i], turns[j])
        turns[i] = turns[j] = turn[e] + 1
        most = max(most, turn[e])
    order, place = np.empty(turn.size, np.int64), 0
    for now in range(most + 1):
        for e in range(turn.size):
            if turn[e] == now:
                order[place] = e
                place += 1
    return order


@kernel
def build_body(position, edges, start, neighbour, mass):
    """Make the body of a connected planar graph.

    Args: position (N, 2); edges (E, 2), i < j, ascending; start, neighbour: adjacency lists; mass of a cell, kg.
    """
    cells, springs = position.shape[0], edges.shape[0]
    spring_a, spring_b = np.empty(springs, np.uint32), np.empty(springs, np.uint32)
    rest_length = np.empty(springs)
    shortest = np.inf
    for e in range(springs):
        i, j = edges[e, 0], edges[e, 1]
        spring_a[e], spring_b[e] = i, j
        rest_length[e] = np.sqrt((position[i, 0] - position[j, 0]) ** 2 + (position[i, 1] - position[j, 1]) ** 2)
        shortest = min(shortest, rest_length[e])

    around = neighbour.copy()
    _sort_around(position, start, around)
    face_start, corner, area = _walk_faces(position, start, around)
    faces = area.size
    outer = 0
    for f in range(faces):
        if area[f] < area[outer]:
            outer = f

    triangles, polygons, corners = 0, 0, 0
    for f in range(faces):
        size = face_start[f + 1] - face_start[f]
        if f != outer:
            if size == 3:
                triangles += 1
            else:
                polygons += 1
                corners += size
    triangle = np.empty((triangles, 3), np.uint32)
    triangle_area = np.empty(triangles)
    polygon_start = np.zeros(polygons + 1, np.uint32)
    polygon_cell = np.empty(corners, np.uint32)
    polygon_area = np.empty(polygons)
    triangles, polygons, corners = 0, 0, 0
    for f in range(faces):
        walk = corner[face_start[f] : face_start[f + 1]]
        if f == outer:
            continue
        if walk.size == 3:
            for k in range(3):
                triangle[triangles, k] = walk[k]
            triangle_area[triangles] = area[f]
            triangles += 1
        else:
            for k in range(walk.size):
                polygon_cell[corners] = walk[k]
                corners += 1
            polygon_area[polygons] = area[f]
            polygons += 1
            polygon_start[polygons] = corners

    spring_left, spring_right = np.full(springs, triangles + polygons, np.uint32), np.full(springs, triangles + polygons, np.uint32)
    outline, outline_spring = np.empty((springs, 2), np.uint32), np.empty(springs, np.uint32)
    drawn = np.zeros(springs, np.bool_)
    count, triangles, polygons = 0, 0, triangle_area.size
    for f in range(faces):
        first, last = face_start[f], face_start[f + 1]
        chamber = triangles if last - first == 3 else polygons
        for k in range(first, last):
            a, b = corner[k], corner[k + 1 if k + 1 < last else first]
            e = _find(edges, min(a, b), max(a, b))
            if f != outer:
                if a < b:
                    spring_left[e] = chamber
                else:
                    spring_right[e] = chamber
            elif not drawn[e]:  # a dangling edge is walked twice
                drawn[e] = True
                outline[count, 0], outline[count, 1], outline_spring[count] = a, b, e
                count += 1
        if f != outer:
            if last - first == 3:
                triangles += 1
            else:
                polygons += 1
    order = _in_turn(edges, cells)
    place = np.empty(springs, np.uint32)
    for k in range(springs):
        place[order[k]] = k
    return Body(
        position=position.copy(), inverse_mass=np.full(cells, 1.0 / mass), spring_a=spring_a[order], spring_b=spring_b[order],
        rest_length=rest_length[order], shortest=shortest, spring_left=spring_left[order], spring_right=spring_right[order],
        triangle=triangle, triangle_area=triangle_area, polygon_start=polygon_start, polygon_cell=polygon_cell,
        polygon_area=polygon_area, outline=outline[:count].copy(), outline_spring=place[outline_spring[:count]],
    )
