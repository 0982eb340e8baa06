"""How fast a body can move: upper bounds of its frequency, of its damping by springs and of its damping by drag."""

from __future__ import annotations

import numpy as np

from ..kernels.jit import kernel, lean
from .forces import Law


@kernel
def frequency_bound(body, law):
    """An upper bound of the body's highest angular frequency, rad/s, at rest.

    Springs: twice the stiffness times the largest eigenvalue of sum(n n^T) over the springs of a cell, by Gershgorin's
    blocks.  Chambers: |g_i| sum |g_j| of the area gradients g, summed over the chambers of a cell.
    """
    cells = body.position.shape[0]
    outer = np.zeros((cells, 3))
    chamber = np.zeros(cells)
    p = body.position
    for e in range(body.rest_length.size):
        i, j = body.spring_a[e], body.spring_b[e]
        dx, dy = p[j, 0] - p[i, 0], p[j, 1] - p[i, 1]
        inverse = 1.0 / (dx * dx + dy * dy)
        for c in (i, j):
            outer[c, 0] += dx * dx * inverse
            outer[c, 1] += dx * dy * inverse
            outer[c, 2] += dy * dy * inverse
    for t in range(body.triangle_area.size):
        _add_chamber_bound(body.triangle[t], body.triangle_area[t], p, chamber)
    for f in range(body.polygon_area.size):
        _add_chamber_bound(
            body.polygon_cell[body.polygon_start[f] : body.polygon_start[f + 1]], body.polygon_area[f], p, chamber
        )
    spring_most, chamber_most = 0.0, 0.0
    for i in range(cells):
        a, b, c = outer[i, 0], outer[i, 1], outer[i, 2]
        largest = 0.5 * (a + c) + np.sqrt(0.25 * (a - c) ** 2 + b * b)
        spring_most = max(spring_most, 2.0 * law.stiffness * largest * body.inverse_mass[i])
        chamber_most = max(chamber_most, law.pressure * chamber[i] * body.inverse_mass[i])
    return np.sqrt(spring_most + chamber_most)


@lean
def _add_chamber_bound(corner, area, position, chamber):
    size = corner.size
    total = 0.0
    for k in range(size):
        total += _gradient(corner, k, size, position)
    for k in range(size):
        chamber[corner[k]] += _gradient(corner, k, size, position) * total / area


@lean
def _gradient(corner, k, size, position):
    a, b = corner[k - 1 if k else size - 1], corner[k + 1 if k + 1 < size else 0]
    return 0.5 * np.sqrt((position[a, 0] - position[b, 0]) ** 2 + (position[a, 1] - position[b, 1]) ** 2)


@kernel
def damping_bound(body, law):
    """An upper bound of the strongest damping by springs, 1/s, at rest: that of a frequency whose stiffness is their damping, squared."""
    as_stiffness = Law(
        stiffness=law.damping, damping=0.0, pressure=0.0, drag_normal=0.0, drag_tangential=0.0, muscle_range=law.muscle_range
    )
    return frequency_bound(body, as_stiffness) ** 2


@kernel
def bounds(system):
    """Upper bounds of the highest frequency, rad/s, and of the strongest damping by springs, 1/s, at rest."""
    return frequency_bound(system.body, system.law), damping_bound(system.body, system.law)


@lean
def drag_rate(body, law, position, velocity, rate):
    """An upper bound of the damping by drag at this velocity, 1/s: d l |v|, over the edges of a cell, over its mass.

    Args: rate (N,): scratch.
    """
    outline, start, end = body.outline_spring, body.spring_a, body.spring_b
    x, y, u, v = position[0], position[1], velocity[0], velocity[1]
    for i in range(x.size):
        rate[i] = 0.0
    for m in range(outline.size):
        i, j = start[outline[m]], end[outline[m]]
        dx, dy, ue, ve = x[j] - x[i], y[j] - y[i], 0.5 * (u[i] + u[j]), 0.5 * (v[i] + v[j])
        force = law.drag_tangential * abs(ue * dx + ve * dy) + law.drag_normal * abs(ve * dx - ue * dy)
        rate[i] += force
        rate[j] += force
    most = 0.0
    for i in range(x.size):
        most = max(most, rate[i] * body.inverse_mass[i])
    return most


@lean
def find_drag_rate(body, law, position, velocity, scratch):
    """Leave the rate of drag of this state in scratch, as `advance` does."""
    scratch.rate[0] = 0.0
    if law.drag_normal != 0.0 or law.drag_tangential != 0.0:
        scratch.rate[0] = drag_rate(body, law, position, velocity, scratch.k1[0])
