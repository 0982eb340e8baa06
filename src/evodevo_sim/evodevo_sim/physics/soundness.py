"""Whether a state is sound after a step, or what is wrong with it."""

from __future__ import annotations

from ..kernels.jit import inlined, lean
from ..kernels.vectors import all_at_most, all_below, four, load4_within, transpose
from .bounds import drag_rate
from .forces import face_area, pack, sides, span
from .step_size import EULER, LAWSON, RK4

SOUND, UNSTABLE, INVERTED = range(3)
STABLE_DRAG = 5.6  # h * (rate of drag) after a substep, up to which Lawson's method does not overshoot
_MOST_DRAG_RK4 = 2.6  # the same of RK4
_MOST_DRAG = 1.0  # the same, that steps of Euler and Verlet may reach which were chosen before a body sped up
FASTEST = 0.5  # of the shortest rest length, that a cell may move in a substep
SHORTEST = 0.05  # of its rest length, that a spring may shrink to
FARTHEST = 1.0  # of its present length, that its ends may move against each other in a substep: beyond, energy comes from nowhere


@inlined
def surely_sound(body, position, velocity, h, scratch):
    """Whether a packed state passes `check`, in fewer steps.  Where this says no, `check` tells why."""
    state, plan, rest_length = scratch.state, scratch.plan, body.rest_length
    fastest, farthest = four((FASTEST * body.shortest / h) ** 2), four((h / FARTHEST) ** 2)
    for i in range(0, velocity.shape[1], 4):
        u, v = load4_within(velocity[0], i), load4_within(velocity[1], i)
        if not all_at_most(u * u + v * v, fastest):
            return False
    start, end, shortest = plan.start, plan.end, four(SHORTEST)
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
    fastest, farthest = (FASTEST * body.shortest / h) ** 2, (h / FARTHEST) ** 2
    for i in range(x.size):
        if not u[i] * u[i] + v[i] * v[i] <= fastest:
            return UNSTABLE
    for e in range(rest_length.size):
        i, j = start[e], end[e]
        dx, dy, du, dv = x[j] - x[i], y[j] - y[i], u[j] - u[i], v[j] - v[i]
        shortest, square = SHORTEST * rest_length[e], dx * dx + dy * dy
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
    return SOUND if surely_sound(body, position, velocity, h, scratch) else check(body, position, velocity, h)


@lean
def is_sound(system, method, position, velocity, h, work):
    """`check` in the frame of the mean velocity, how fast a body travels is no fault; and drag that steps of h can bear."""
    law = system.law
    if law.drag_normal != 0.0 or law.drag_tangential != 0.0:
        most = STABLE_DRAG if method == LAWSON else _MOST_DRAG_RK4 if method == RK4 else _MOST_DRAG
        if not h * drag_rate(system.body, law, position, velocity, work.scratch.k1[0]) <= most:
            return UNSTABLE
    cells, own = position.shape[1], work.scratch.velocity
    for a in range(2):
        mean = 0.0
        for i in range(cells):
            mean += velocity[a, i] / cells
        for i in range(cells):
            own[a, i] = velocity[a, i] - mean
    if method == EULER:  # whose steps keep nothing in scratch
        return judge(system.body, position, own, h, work.scratch)
    return check(system.body, position, own, h)
