"""Forces on a body (paper sections 2.3 and 4.2): springs, chambers, drag.

States are (2, N), a row of x and a row of y, which compilers turn into better code than (N, 2).
"""

from __future__ import annotations

from collections import namedtuple

import numpy as np

from ._jit import kernel, lean

# stiffness N/m, damping N s/m, pressure N/m, drag_normal and drag_tangential kg/m^2
Law = namedtuple("Law", "stiffness damping pressure drag_normal drag_tangential")
# Scratch of the integrator: states and their derivatives, (2, N) each; of the forces: edge (4, E), push (chambers + 1,); and what
# `advance` leaves: rate (1,) 1/s, the rate of drag in its last state.
Scratch = namedtuple("Scratch", "position velocity k1 k2 k3 k4 start_position start_velocity edge push rate")


@kernel
def make_law(material, scene):
    return Law(material.stiffness, material.damping, material.pressure, scene.drag_normal, scene.drag_tangential)


@kernel
def make_scratch(body):
    shape = (2, body.position.shape[0])
    return Scratch(
        np.empty(shape), np.empty(shape), np.empty(shape), np.empty(shape), np.empty(shape), np.empty(shape), np.empty(shape),
        np.empty(shape), np.empty((4, body.rest_length.size)), np.zeros(body.triangle_area.size + body.polygon_area.size + 1),
        np.zeros(1),
    )


@lean
def set_rest_lengths(body, activation, rest):
    """Equation (1): L = (1 + 0.2 (a_i + a_j)) L0 with a = e - c.  Fills rest (E,) from activation (N,)."""
    start, end, rest_length = body.spring_a, body.spring_b, body.rest_length
    for e in range(rest.size):
        rest[e] = (1.0 + 0.2 * (activation[start[e]] + activation[end[e]])) * rest_length[e]


@lean
def face_area(corner, first, last, x, y):
    """Area of the polygon of the cells corner[first:last], counter-clockwise."""
    twice = 0.0
    before = corner[last - 1]
    ox, oy = x[before], y[before]
    for k in range(first, last):
        here = corner[k]
        twice += (x[before] - ox) * (y[here] - oy) - (x[here] - ox) * (y[before] - oy)
        before = here
    return 0.5 * twice


@lean
def accelerations(body, law, rest, position, velocity, scratch, out):
    """Fill out (2, N) with the acceleration of every cell.  Chambers and drag are not computed where their coefficients are 0.

    Every force acts along or across an edge, so it takes one walk over the edges to collect what the forces depend on, one
    without indices for roots and divisions, and one to hand the forces to both ends.
    """
    x, y, u, v, ax, ay = position[0], position[1], velocity[0], velocity[1], out[0], out[1]
    start, end, left, right, inverse_mass = body.spring_a, body.spring_b, body.spring_left, body.spring_right, body.inverse_mass
    triangle, triangle_area, outline = body.triangle, body.triangle_area, body.outline_spring
    polygon, corner, polygon_area = body.polygon_start, body.polygon_cell, body.polygon_area
    dx, dy, inverse_square, pull = scratch.edge[0], scratch.edge[1], scratch.edge[2], scratch.edge[3]

    # Chambers, equation (2): half of c_p (1 - S/S0), times the length across each edge, goes to each end.  Outside is 0.
    push = scratch.push
    if law.pressure != 0.0:
        half = 0.5 * law.pressure
        for t in range(triangle_area.size):
            a, b, c = triangle[t, 0], triangle[t, 1], triangle[t, 2]
            twice = (x[b] - x[a]) * (y[c] - y[a]) - (x[c] - x[a]) * (y[b] - y[a])
            push[t] = half * (1.0 - 0.5 * twice / triangle_area[t])
        for p in range(polygon_area.size):
            s = face_area(corner, polygon[p], polygon[p + 1], x, y)
            push[triangle_area.size + p] = half * (1.0 - s / polygon_area[p])
    else:
        for c in range(push.size):
            push[c] = 0.0

    # Springs and dampers, per length of the spring.
    for e in range(rest.size):
        i, j = start[e], end[e]
        ex, ey = x[j] - x[i], y[j] - y[i]
        dx[e], dy[e] = ex, ey
        inverse_square[e] = ex * ex + ey * ey
        pull[e] = (u[j] - u[i]) * ex + (v[j] - v[i]) * ey
    for e in range(rest.size):
        inverse = 1.0 / np.sqrt(inverse_square[e])
        inverse_square[e] = inverse * inverse
        pull[e] = law.stiffness * (1.0 - rest[e] * inverse) + law.damping * inverse_square[e] * pull[e]

    for i in range(x.size):
        ax[i] = 0.0
        ay[i] = 0.0
    for e in range(rest.size):
        i, j = start[e], end[e]
        across = push[right[e]] - push[left[e]]
        fx, fy = pull[e] * dx[e], pull[e] * dy[e]
        gx, gy = -across * dy[e], across * dx[e]
        ax[i] += gx + fx
        ay[i] += gy + fy
        ax[j] += gx - fx
        ay[j] += gy - fy

    # Drag: F_T = -d_T l v_T |v_T| along and F_N = -d_N l v_N |v_N| across an outline edge, half to each end (section 4.2).
    if law.drag_normal != 0.0 or law.drag_tangential != 0.0:
        for m in range(outline.size):
            e = outline[m]
            i, j = start[e], end[e]
            ue, ve = 0.5 * (u[i] + u[j]), 0.5 * (v[i] + v[j])
            along, across = ue * dx[e] + ve * dy[e], ve * dx[e] - ue * dy[e]  # speeds times length
            t = -0.5 * law.drag_tangential * inverse_square[e] * along * abs(along)
            n = -0.5 * law.drag_normal * inverse_square[e] * across * abs(across)
            fx, fy = t * dx[e] - n * dy[e], t * dy[e] + n * dx[e]
            ax[i] += fx
            ay[i] += fy
            ax[j] += fx
            ay[j] += fy
    for i in range(x.size):
        ax[i] *= inverse_mass[i]
        ay[i] *= inverse_mass[i]
