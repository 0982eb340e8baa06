"""Body physics (paper sections 2.3 and 4.2): forces of springs, chambers and drag, and the integration of one control step.

The one interface: `advance` carries a state (position, velocity) over a control step with rest lengths held, and says whether
the outcome is sound.  Worlds add terms to `accelerations`; integrators stand beside `_runge_kutta`.
"""

from __future__ import annotations

from collections import namedtuple

import numpy as np

from ._jit import kernel

SOUND, UNSTABLE, INVERTED = range(3)
# h * (bound of the highest frequency).  RK4 is stable to 2.83 without damping, but damping and drag take their share: at 1.43
# champions that lived on integration errors swam 1.4 times as far as with finer steps, which agree from 1.1 on (docs/model.md).
ACCURATE_RK4 = 1.1
MOST_DOUBLINGS = 3
_FASTEST = 0.5  # of the shortest rest length, that a cell may move in a substep
_SHORTEST = 0.05  # of its rest length, that a spring may shrink to

# stiffness N/m, damping N s/m, pressure N/m, drag_normal and drag_tangential kg/m^2
Law = namedtuple("Law", "stiffness damping pressure drag_normal drag_tangential")
# Scratch of the integrator, (N, 2) each.
Scratch = namedtuple("Scratch", "position velocity k1 k2 k3 k4 start_position start_velocity")


@kernel
def make_law(material, scene):
    return Law(material.stiffness, material.damping, material.pressure, scene.drag_normal, scene.drag_tangential)


@kernel
def make_scratch(cells):
    return Scratch(
        np.empty((cells, 2)), np.empty((cells, 2)), np.empty((cells, 2)), np.empty((cells, 2)), np.empty((cells, 2)),
        np.empty((cells, 2)), np.empty((cells, 2)), np.empty((cells, 2)),
    )


@kernel
def set_rest_lengths(body, activation, rest):
    """Equation (1): L = (1 + 0.2 (a_i + a_j)) L0 with a = e - c.  Fills rest (E,) from activation (N,)."""
    start, end = body.spring_start, body.spring_end
    for i in range(start.size - 1):
        a = activation[i]
        for e in range(start[i], start[i + 1]):
            rest[e] = (1.0 + 0.2 * (a + activation[end[e]])) * body.rest_length[e]


@kernel
def accelerations(body, law, rest, position, velocity, out):
    """Fill out (N, 2) with the acceleration of every cell.  Terms whose coefficient is 0 are not computed."""
    start, end = body.spring_start, body.spring_end
    cells = start.size - 1
    k, damping = law.stiffness, law.damping
    for i in range(cells):
        out[i, 0] = 0.0
        out[i, 1] = 0.0
    for i in range(cells):
        x, y = position[i, 0], position[i, 1]
        u, v = velocity[i, 0], velocity[i, 1]
        fx, fy = 0.0, 0.0
        for e in range(start[i], start[i + 1]):
            j = end[e]
            dx, dy = position[j, 0] - x, position[j, 1] - y
            length = np.sqrt(dx * dx + dy * dy)
            inverse = 1.0 / length
            f = k * (length - rest[e])
            if damping != 0.0:
                f += damping * ((velocity[j, 0] - u) * dx + (velocity[j, 1] - v) * dy) * inverse
            f *= inverse
            fx += f * dx
            fy += f * dy
            out[j, 0] -= f * dx
            out[j, 1] -= f * dy
        out[i, 0] += fx
        out[i, 1] += fy
    if law.pressure != 0.0:
        _add_pressure(body, law.pressure, position, out)
    if law.drag_normal != 0.0 or law.drag_tangential != 0.0:
        _add_drag(body.outline, law.drag_normal, law.drag_tangential, position, velocity, out)
    inverse_mass = body.inverse_mass
    for i in range(cells):
        out[i, 0] *= inverse_mass[i]
        out[i, 1] *= inverse_mass[i]


@kernel
def _add_pressure(body, pressure, position, out):
    """Equation (2): c_p l (1 - S/S0) outward on every edge, half to each end; on a corner, half of that across its neighbours."""
    triangle, area = body.triangle, body.triangle_area
    for t in range(area.size):
        a, b, c = triangle[t, 0], triangle[t, 1], triangle[t, 2]
        ax, ay = position[a, 0], position[a, 1]
        bx, by = position[b, 0], position[b, 1]
        cx, cy = position[c, 0], position[c, 1]
        s = 0.5 * ((bx - ax) * (cy - ay) - (cx - ax) * (by - ay))
        q = 0.5 * pressure * (1.0 - s / area[t])
        out[a, 0] += q * (by - cy)
        out[a, 1] += q * (cx - bx)
        out[b, 0] += q * (cy - ay)
        out[b, 1] += q * (ax - cx)
        out[c, 0] += q * (ay - by)
        out[c, 1] += q * (bx - ax)
    start, corner, area = body.polygon_start, body.polygon_cell, body.polygon_area
    for p in range(area.size):
        first, last = start[p], start[p + 1]
        q = 0.5 * pressure * (1.0 - _polygon_area(corner[first:last], position) / area[p])
        before, here = corner[last - 1], corner[first]
        for k in range(first, last):
            after = corner[k + 1] if k + 1 < last else corner[first]
            out[here, 0] += q * (position[after, 1] - position[before, 1])
            out[here, 1] += q * (position[before, 0] - position[after, 0])
            before, here = here, after


@kernel
def _polygon_area(corner, position):
    twice = 0.0
    ox, oy = position[corner[0], 0], position[corner[0], 1]
    bx, by = position[corner[1], 0] - ox, position[corner[1], 1] - oy
    for k in range(2, corner.size):
        cx, cy = position[corner[k], 0] - ox, position[corner[k], 1] - oy
        twice += bx * cy - by * cx
        bx, by = cx, cy
    return 0.5 * twice


@kernel
def _add_drag(outline, normal, tangential, position, velocity, out):
    """F_T = -d_T l v_T |v_T| along and F_N = -d_N l v_N |v_N| across every outline edge, half to each end (section 4.2)."""
    for m in range(outline.shape[0]):
        i, j = outline[m, 0], outline[m, 1]
        dx, dy = position[j, 0] - position[i, 0], position[j, 1] - position[i, 1]
        u, v = 0.5 * (velocity[i, 0] + velocity[j, 0]), 0.5 * (velocity[i, 1] + velocity[j, 1])
        along, across = u * dx + v * dy, v * dx - u * dy  # speeds times length
        half = -0.5 / (dx * dx + dy * dy)
        t = half * tangential * along * abs(along)
        n = half * normal * across * abs(across)
        fx, fy = t * dx - n * dy, t * dy + n * dx
        out[i, 0] += fx
        out[i, 1] += fy
        out[j, 0] += fx
        out[j, 1] += fy


@kernel
def frequency_bound(body, law):
    """An upper bound of the body's highest angular frequency, rad/s, at rest.

    Springs: twice the stiffness times the largest eigenvalue of sum(n n^T) over the springs of a cell, by Gershgorin's
    blocks.  Chambers: |g_i| sum |g_j| of the area gradients g, summed over the chambers of a cell.
    """
    cells = body.position.shape[0]
    outer = np.zeros((cells, 3))
    chamber = np.zeros(cells)
    start, end, p = body.spring_start, body.spring_end, body.position
    for i in range(cells):
        for e in range(start[i], start[i + 1]):
            j = end[e]
            dx, dy = p[j, 0] - p[i, 0], p[j, 1] - p[i, 1]
            inverse = 1.0 / (dx * dx + dy * dy)
            for c in (i, np.int64(j)):
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


@kernel
def _add_chamber_bound(corner, area, position, chamber):
    size = corner.size
    total = 0.0
    for k in range(size):
        total += _gradient(corner, k, size, position)
    for k in range(size):
        chamber[corner[k]] += _gradient(corner, k, size, position) * total / area


@kernel
def _gradient(corner, k, size, position):
    a, b = corner[k - 1 if k else size - 1], corner[k + 1 if k + 1 < size else 0]
    return 0.5 * np.sqrt((position[a, 0] - position[b, 0]) ** 2 + (position[a, 1] - position[b, 1]) ** 2)


@kernel
def choose_substeps(body, law, control_step):
    """Substeps of RK4 in a control step, from the frequency bound of the body."""
    return max(1, int(np.ceil(control_step * frequency_bound(body, law) / ACCURATE_RK4)))


@kernel
def _runge_kutta(body, law, rest, position, velocity, h, scratch):
    """One step of the classical fourth-order Runge-Kutta method, in place."""
    p, v, k1, k2, k3, k4 = scratch.position, scratch.velocity, scratch.k1, scratch.k2, scratch.k3, scratch.k4
    cells = position.shape[0]
    accelerations(body, law, rest, position, velocity, k1)
    for i in range(cells):
        for a in range(2):
            p[i, a] = position[i, a] + 0.5 * h * velocity[i, a]
            v[i, a] = velocity[i, a] + 0.5 * h * k1[i, a]
    accelerations(body, law, rest, p, v, k2)
    for i in range(cells):
        for a in range(2):
            p[i, a] = position[i, a] + 0.5 * h * (velocity[i, a] + 0.5 * h * k1[i, a])
            v[i, a] = velocity[i, a] + 0.5 * h * k2[i, a]
    accelerations(body, law, rest, p, v, k3)
    for i in range(cells):
        for a in range(2):
            p[i, a] = position[i, a] + h * (velocity[i, a] + 0.5 * h * k2[i, a])
            v[i, a] = velocity[i, a] + h * k3[i, a]
    accelerations(body, law, rest, p, v, k4)
    for i in range(cells):
        for a in range(2):
            position[i, a] += h * (velocity[i, a] + h / 6.0 * (k1[i, a] + k2[i, a] + k3[i, a]))
            velocity[i, a] += h / 6.0 * (k1[i, a] + 2.0 * (k2[i, a] + k3[i, a]) + k4[i, a])


@kernel
def check(body, position, velocity, h):
    """SOUND, or what is wrong with a state after a substep of h seconds.  A NaN anywhere is UNSTABLE."""
    start, end = body.spring_start, body.spring_end
    shortest = np.inf
    collapsed = False
    for i in range(start.size - 1):
        for e in range(start[i], start[i + 1]):
            dx, dy = position[end[e], 0] - position[i, 0], position[end[e], 1] - position[i, 1]
            rest = body.rest_length[e]
            collapsed = collapsed or not dx * dx + dy * dy > (_SHORTEST * rest) ** 2
            shortest = min(shortest, rest)
    fastest = 0.0
    for i in range(start.size - 1):
        speed = velocity[i, 0] * velocity[i, 0] + velocity[i, 1] * velocity[i, 1]
        if not speed * h * h <= (_FASTEST * shortest) ** 2:
            return UNSTABLE
    if collapsed:
        return INVERTED
    triangle = body.triangle
    for t in range(triangle.shape[0]):
        a, b, c = triangle[t, 0], triangle[t, 1], triangle[t, 2]
        ax, ay = position[a, 0], position[a, 1]
        if not (position[b, 0] - ax) * (position[c, 1] - ay) > (position[c, 0] - ax) * (position[b, 1] - ay):
            return INVERTED
    for f in range(body.polygon_area.size):
        if not _polygon_area(body.polygon_cell[body.polygon_start[f] : body.polygon_start[f + 1]], position) > 0.0:
            return INVERTED
    return SOUND


@kernel
def advance(body, law, rest, position, velocity, control_step, substeps, scratch):
    """Carry a state over one control step, in place; where that fails, again with twice the substeps, at most three times.

    Returns: SOUND, or what was wrong with the finest try.
    """
    before_p, before_v = scratch.start_position, scratch.start_velocity
    cells = position.shape[0]
    for i in range(cells):
        for a in range(2):
            before_p[i, a] = position[i, a]
            before_v[i, a] = velocity[i, a]
    outcome = SOUND
    for doubling in range(MOST_DOUBLINGS + 1):
        steps = substeps << doubling
        h = control_step / steps
        for _ in range(steps):
            _runge_kutta(body, law, rest, position, velocity, h, scratch)
        outcome = check(body, position, velocity, h)
        if outcome == SOUND:
            break
        if doubling < MOST_DOUBLINGS:
            for i in range(cells):
                for a in range(2):
                    position[i, a] = before_p[i, a]
                    velocity[i, a] = before_v[i, a]
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
    a = scratch.k1
    cells = position.shape[0]
    velocity[:] = 0.0
    before = 0.0
    for step in range(limit):
        accelerations(body, alone, rest, position, velocity, a)
        largest = 0.0
        for i in range(cells):
            largest = max(largest, abs(a[i, 0]), abs(a[i, 1]))
        if not largest > tolerance:
            velocity[:] = 0.0
            return step
        energy = 0.0
        for i in range(cells):
            for axis in range(2):
                velocity[i, axis] += h * a[i, axis]
                energy += velocity[i, axis] * velocity[i, axis] / body.inverse_mass[i]
        if energy < before:
            velocity[:] = 0.0
            energy = 0.0
        before = energy
        for i in range(cells):
            position[i, 0] += h * velocity[i, 0]
            position[i, 1] += h * velocity[i, 1]
    velocity[:] = 0.0
    return limit
