"""The motion of a body (paper sections 2.3 and 4.2): one control step, and rest.

The one interface: `advance` carries a state (position, velocity) over a control step with rest lengths held, and says whether
the outcome is sound.  Worlds add terms to `forces.accelerations`; integrators stand beside `_runge_kutta`.
"""

from __future__ import annotations

from ..kernels.jit import inlined, kernel, lean
from ..kernels.vectors import all_at_most, all_below, four, load4_within, store4_within, transpose
from .forces import Law, accelerate, accelerations, face_area, pack, pack_ahead, sides, span
from .rates import MOST_SUBSTEPS, find_drag_rate, frequency_bound

SOUND, UNSTABLE, INVERTED = range(3)
MOST_DOUBLINGS = 3  # of the steps of a control step that came out unsound; of an unstable one more: see `finer_may_help`
STABLE_DRAG = 2.6  # h * (rate of drag) after a substep, up to which RK4 does not overshoot
_FASTEST = 0.5  # of the shortest rest length, that a cell may move in a substep
_SHORTEST = 0.05  # of its rest length, that a spring may shrink to
_FARTHEST = 1.0  # of its present length, that its ends may move against each other in a substep: beyond, energy comes from nowhere


@inlined
def _runge_kutta(body, law, rest, position, velocity, h, scratch):
    """One step of the classical fourth-order Runge-Kutta method, in place, of a state that is packed before and after."""
    k1, k2, k3, k4, state = scratch.k1, scratch.k2, scratch.k3, scratch.k4, scratch.state
    for stage in range(4):
        slope, slower, faster, ahead, before = k1, k1, k1, 0.5 * h, 0.0
        if stage == 1:
            slope = k2
        elif stage == 2:
            slope, faster, before = k3, k2, 0.5 * h
        elif stage == 3:
            slope, slower, faster, ahead, before = k4, k2, k3, h, 0.5 * h
        if stage > 0:
            pack_ahead(position, velocity, ahead, before, slower, faster, state)
        accelerate(body, law, rest, scratch, slope)
    whole, sixth, double = four(h), four(h / 6.0), four(2.0)
    for a in range(2):
        x, v = position[a], velocity[a]
        for i in range(0, x.size, 4):
            first, second, third, last = load4_within(k1[a], i), load4_within(k2[a], i), load4_within(k3[a], i), load4_within(k4[a], i)
            before = load4_within(v, i)
            store4_within(x, i, load4_within(x, i) + whole * (before + sixth * (first + second + third)))
            store4_within(v, i, before + sixth * (first + double * (second + third) + last))
    pack(position, velocity, state)


@inlined
def _surely_sound(body, position, velocity, h, scratch):
    """Whether a packed state passes `check`, in fewer steps.  Where this says no, `check` tells why."""
    state, plan, rest_length = scratch.state, scratch.plan, body.rest_length
    fastest, farthest = four((_FASTEST * body.shortest / h) ** 2), four((h / _FARTHEST) ** 2)
    for i in range(0, velocity.shape[1], 4):
        u, v = load4_within(velocity[0], i), load4_within(velocity[1], i)
        if not all_at_most(u * u + v * v, fastest):
            return False
    start, end, shortest = plan.start, plan.end, four(_SHORTEST)
    for e in range(0, rest_length.size, 4):
        a, b = span(state, start, end, e), span(state, start, end, e + 1)
        c, d = span(state, start, end, e + 2), span(state, start, end, e + 3)
        dx, dy, du, dv = transpose(a, b, c, d)
        least, square = shortest * load4_within(rest_length, e), dx * dx + dy * dy
        if not (all_below(least * least, square) and all_at_most((du * du + dv * dv) * farthest, square)):
            return False
    for t in range(0, plan.area.size, 4):
        more, less = sides(state, plan, t)
        if not all_below(less, more):
            return False
    polygon, corner = body.polygon_start, body.polygon_cell
    for p in range(polygon.size - 1):
        if not face_area(corner, polygon[p], polygon[p + 1], position[0], position[1]) > 0.0:
            return False
    return True


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
def judge(body, position, velocity, h, scratch):
    """`check` of a state that is not packed, in less time where it is sound."""
    pack(position, velocity, scratch.state)
    return SOUND if _surely_sound(body, position, velocity, h, scratch) else check(body, position, velocity, h)


@lean
def copy_state(position, velocity, to_position, to_velocity):
    for a in range(2):
        for i in range(position.shape[1]):
            to_position[a, i] = position[a, i]
            to_velocity[a, i] = velocity[a, i]


@inlined
def finer_may_help(outcome, doubling, steps, doublings, most):
    """Whether an unsound interval is to be tried again in twice as many steps.

    Chambers turn inside out in fine steps, too: three doublings settle that.  Where a body blew up, its steps may be far too long:
    they follow from the drag that it begins with, which is 0 at rest.

    Args: doubling, steps: of the last try; doublings: in any case; most: steps up to which what is unstable is tried.
    """
    return doubling < doublings or (outcome == UNSTABLE and 2 * steps <= most)


@lean
def advance(body, law, rest, position, velocity, control_step, substeps, scratch):
    """Carry a state over one control step, in place; where that fails, again with twice the substeps: see `finer_may_help`.

    Returns: SOUND, or what was wrong with the finest try; if SOUND, scratch holds the rate of drag that is reached.
    """
    start_position, start_velocity = scratch.start_position, scratch.start_velocity
    copy_state(position, velocity, start_position, start_velocity)
    outcome, doubling, steps = SOUND, 0, substeps
    pack(position, velocity, scratch.state)
    while True:
        h = control_step / steps
        for _ in range(steps):
            _runge_kutta(body, law, rest, position, velocity, h, scratch)
            outcome = SOUND if _surely_sound(body, position, velocity, h, scratch) else check(body, position, velocity, h)
            if outcome != SOUND:
                break
        if outcome == SOUND:
            find_drag_rate(body, law, position, velocity, scratch)
            if h * scratch.rate[0] > STABLE_DRAG:
                outcome = UNSTABLE  # it sped up so much that drag may have overshot
        if outcome == SOUND or not finer_may_help(outcome, doubling, steps, MOST_DOUBLINGS, MOST_SUBSTEPS):
            return outcome
        doubling, steps = doubling + 1, 2 * steps
        copy_state(start_position, start_velocity, position, velocity)
        pack(position, velocity, scratch.state)


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
