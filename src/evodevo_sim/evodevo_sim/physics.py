"""Body physics (paper sections 2.3 and 4.2): forces of springs, chambers and drag, and the integration of one control step.

The one interface: `advance` carries a state (position, velocity) over a control step with rest lengths held, and says whether
the outcome is sound.  States are (2, N) here, a row of x and a row of y, which compilers turn into better code than (N, 2).
Worlds add terms to `accelerations`; integrators stand beside `_runge_kutta`.
"""

from __future__ import annotations

from collections import namedtuple

import numpy as np

from ._jit import kernel, lean

SOUND, UNSTABLE, INVERTED = range(3)
# RK4 is stable to h * rate = 2.6 and more.  Its errors are small to 1.5 in the body's own frequency and damping, at rest, and to 1.6
# in the rate of drag, which grows with speed and would be most of the error of fast swimmers (docs/model.md).
ACCURATE_RK4 = 1.5
ACCURATE_DRAG = 1.6
MOST_SUBSTEPS = 1000  # in a control step; a body that needs more would keep everybody waiting for hours
MOST_DOUBLINGS = 3
STABLE_DRAG = 2.6  # h * (rate of drag) after a substep, up to which RK4 does not overshoot
_FASTEST = 0.5  # of the shortest rest length, that a cell may move in a substep
_SHORTEST = 0.05  # of its rest length, that a spring may shrink to
_FARTHEST = 1.0  # of its present length, that its ends may move against each other in a substep: beyond, energy comes from nowhere

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
def _polygon_area(corner, first, last, x, y):
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
            s = _polygon_area(corner, polygon[p], polygon[p + 1], x, y)
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
    """An upper bound of the strongest damping by springs, 1/s, at rest."""
    return frequency_bound(body, Law(law.damping, 0.0, 0.0, 0.0, 0.0)) ** 2


@kernel
def choose_substeps(body, law, control_step):
    """Substeps of RK4 in a control step that a body takes at rest, by its bounds of frequency and damping."""
    fastest = max(frequency_bound(body, law), damping_bound(body, law))
    return max(1, int(np.ceil(min(control_step * fastest / ACCURATE_RK4, 1e9))))


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


@lean
def substeps_in_drag(body, law, position, velocity, control_step, substeps, scratch):
    """Substeps in the next control step, from those at rest and the drag at this velocity."""
    find_drag_rate(body, law, position, velocity, scratch)
    return substeps_at_rate(control_step, substeps, scratch)


@lean
def substeps_at_rate(control_step, substeps, scratch):
    """The same for a rate of drag that scratch holds already."""
    need = control_step * scratch.rate[0] / ACCURATE_DRAG
    if need > substeps:
        return int(np.ceil(min(need, MOST_SUBSTEPS)))
    return substeps


@lean
def _runge_kutta(body, law, rest, position, velocity, h, scratch):
    """One step of the classical fourth-order Runge-Kutta method, in place."""
    p, v, k1, k2, k3, k4 = scratch.position, scratch.velocity, scratch.k1, scratch.k2, scratch.k3, scratch.k4
    cells = position.shape[1]
    accelerations(body, law, rest, position, velocity, scratch, k1)
    for a in range(2):
        for i in range(cells):
            p[a, i] = position[a, i] + 0.5 * h * velocity[a, i]
            v[a, i] = velocity[a, i] + 0.5 * h * k1[a, i]
    accelerations(body, law, rest, p, v, scratch, k2)
    for a in range(2):
        for i in range(cells):
            p[a, i] = position[a, i] + 0.5 * h * (velocity[a, i] + 0.5 * h * k1[a, i])
            v[a, i] = velocity[a, i] + 0.5 * h * k2[a, i]
    accelerations(body, law, rest, p, v, scratch, k3)
    for a in range(2):
        for i in range(cells):
            p[a, i] = position[a, i] + h * (velocity[a, i] + 0.5 * h * k2[a, i])
            v[a, i] = velocity[a, i] + h * k3[a, i]
    accelerations(body, law, rest, p, v, scratch, k4)
    for a in range(2):
        for i in range(cells):
            position[a, i] += h * (velocity[a, i] + h / 6.0 * (k1[a, i] + k2[a, i] + k3[a, i]))
            velocity[a, i] += h / 6.0 * (k1[a, i] + 2.0 * (k2[a, i] + k3[a, i]) + k4[a, i])


@lean
def check(body, position, velocity, h):
    """SOUND, or what is wrong with a state after a substep of h seconds.  A NaN anywhere is UNSTABLE."""
    x, y, u, v = position[0], position[1], velocity[0], velocity[1]
    start, end, rest_length, triangle = body.spring_a, body.spring_b, body.rest_length, body.triangle
    polygon, corner = body.polygon_start, body.polygon_cell
    fastest, farthest = (_FASTEST * body.shortest / h) ** 2, (h / _FARTHEST) ** 2
    for i in range(x.size):
        if not u[i] * u[i] + v[i] * v[i] <= fastest:
            return UNSTABLE
    for e in range(rest_length.size):
        i, j = start[e], end[e]
        dx, dy, du, dv = x[j] - x[i], y[j] - y[i], u[j] - u[i], v[j] - v[i]
        shortest, square = _SHORTEST * rest_length[e], dx * dx + dy * dy
        if not square > shortest * shortest:
            return INVERTED
        if not (du * du + dv * dv) * farthest <= square:
            return UNSTABLE
    for t in range(triangle.shape[0]):
        a, b, c = triangle[t, 0], triangle[t, 1], triangle[t, 2]
        if not (x[b] - x[a]) * (y[c] - y[a]) > (x[c] - x[a]) * (y[b] - y[a]):
            return INVERTED
    for p in range(polygon.size - 1):
        if not _polygon_area(corner, polygon[p], polygon[p + 1], x, y) > 0.0:
            return INVERTED
    return SOUND


@lean
def _copy(position, velocity, to_position, to_velocity):
    for a in range(2):
        for i in range(position.shape[1]):
            to_position[a, i] = position[a, i]
            to_velocity[a, i] = velocity[a, i]


@lean
def advance(body, law, rest, position, velocity, control_step, substeps, scratch):
    """Carry a state over one control step, in place; where that fails, again with twice the substeps, at most three times.

    Returns: SOUND, or what was wrong with the finest try; if SOUND, scratch holds the rate of drag that is reached.
    """
    start_position, start_velocity = scratch.start_position, scratch.start_velocity
    _copy(position, velocity, start_position, start_velocity)
    outcome = SOUND
    for doubling in range(MOST_DOUBLINGS + 1):
        steps = substeps << doubling
        h = control_step / steps
        for _ in range(steps):
            _runge_kutta(body, law, rest, position, velocity, h, scratch)
            outcome = check(body, position, velocity, h)
            if outcome != SOUND:
                break
        if outcome == SOUND:
            find_drag_rate(body, law, position, velocity, scratch)
            if h * scratch.rate[0] > STABLE_DRAG:
                outcome = UNSTABLE  # it sped up so much that drag may have overshot
        if outcome == SOUND:
            break
        if doubling < MOST_DOUBLINGS:
            _copy(start_position, start_velocity, position, velocity)
    return outcome


@kernel
def settle(body, law, rest, position, velocity, tolerance, limit, scratch):
    """Bring a body to rest under its own springs and chambers with rest lengths held, in place, without a world around it.

    Kinetic damping: all speeds are set to 0 whenever the kinetic energy has passed a peak.  Only internal forces act, so the
    centre of mass stays where it is.

    Args: tolerance: largest acceleration, m/s^2, that counts as rest; limit: most steps.  Returns: steps taken.
    """
    alone = Law(law.stiffness, 0.0, law.pressure, 0.0, 0.0)
    h = 1.0 / frequency_bound(body, alone)
    acceleration = scratch.k1
    velocity[:] = 0.0
    before = 0.0
    for step in range(limit):
        accelerations(body, alone, rest, position, velocity, scratch, acceleration)
        largest = 0.0
        for a in range(2):
            for i in range(position.shape[1]):
                largest = max(largest, abs(acceleration[a, i]))
        if not largest > tolerance:
            velocity[:] = 0.0
            return step
        energy = 0.0
        for a in range(2):
            for i in range(position.shape[1]):
                velocity[a, i] += h * acceleration[a, i]
                energy += velocity[a, i] * velocity[a, i] / body.inverse_mass[i]
        if energy < before:
            velocity[:] = 0.0
            energy = 0.0
        before = energy
        for a in range(2):
            for i in range(position.shape[1]):
                position[a, i] += h * velocity[a, i]
    velocity[:] = 0.0
    return limit
