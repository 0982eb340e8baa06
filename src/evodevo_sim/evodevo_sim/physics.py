"""The motion of a body (paper sections 2.3 and 4.2): one control step, and rest.

The one interface: `advance` carries a state (position, velocity) over a control step with rest lengths held, and says whether
the outcome is sound.  Worlds add terms to `forces.accelerations`; integrators stand beside `_runge_kutta`.
"""

from __future__ import annotations

from ._jit import kernel, lean
from .forces import Law, accelerations, face_area
from .rates import find_drag_rate, frequency_bound

SOUND, UNSTABLE, INVERTED = range(3)
MOST_DOUBLINGS = 3
STABLE_DRAG = 2.6  # h * (rate of drag) after a substep, up to which RK4 does not overshoot
_FASTEST = 0.5  # of the shortest rest length, that a cell may move in a substep
_SHORTEST = 0.05  # of its rest length, that a spring may shrink to
_FARTHEST = 1.0  # of its present length, that its ends may move against each other in a substep: beyond, energy comes from nowhere


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
        if not face_area(corner, polygon[p], polygon[p + 1], x, y) > 0.0:
            return INVERTED
    return SOUND


@lean
def copy_state(position, velocity, to_position, to_velocity):
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
    copy_state(position, velocity, start_position, start_velocity)
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
            copy_state(start_position, start_velocity, position, velocity)
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
