"""Forces on a body (paper sections 2.3 and 4.2): springs, chambers, drag.

States are (2, N), a row of x and a row of y, which compilers turn into better code than (N, 2).  The laws are computed for four
edges or chambers at a time (see `vectors`), from a copy of the state with x, y, u, v of a cell side by side.
"""

from __future__ import annotations

from collections import namedtuple

import numpy as np

from ._jit import inlined, kernel, lean
from .vectors import (
    evens, four, index, join, load2, load4, load4_within, low, magnitude, number, odds, padded4, root, store, store4_within, swapped,
    transpose, two, zip_high, zip_low,
)

# stiffness N/m, damping N s/m, pressure N/m, drag_normal and drag_tangential kg/m^2
Law = namedtuple("Law", "stiffness damping pressure drag_normal drag_tangential")
# A body in the order in which its forces are computed: springs, triangles and outline filled up to fours with some between three
# cells beyond the last, which lie at the corners of a triangle and never move.  start, end, left, right: springs' cells and chambers, the
# triangles and what fills them up first, then polygons, then outside; corner_a, _b, _c, area: triangles; outline: springs.
Plan = namedtuple("Plan", "start end left right corner_a corner_b corner_c area outline inverse_mass")
# Scratch of the integrator: states and their derivatives, (2, N) each; of the forces, by place in the plan: state, x, y, u, v of each
# cell; edge, dx, dy; inverse_square, 1/length^2; pull, tension per length; push, half of c_p (1 - S/S0); drag and force, x and y; and
# what `advance` leaves: rate (1,) 1/s, the rate of drag in its last state.
Scratch = namedtuple(
    "Scratch",
    "position velocity k1 k2 k3 k4 start_position start_velocity plan state edge inverse_square pull push drag force rate",
)


@kernel
def make_law(material, scene):
    return Law(material.stiffness, material.damping, material.pressure, scene.drag_normal, scene.drag_tangential)


@kernel
def make_plan(body):
    cells, springs, triangles, outline = body.inverse_mass.size, body.rest_length.size, body.triangle_area.size, body.outline_spring.size
    filler, polygons = padded4(cells), padded4(triangles)
    outside = polygons + body.polygon_area.size
    plan = Plan(
        np.full(padded4(springs + 1), filler, np.uint32), np.full(padded4(springs + 1), filler + 1, np.uint32),
        np.full(padded4(springs + 1), outside, np.uint32), np.full(padded4(springs + 1), outside, np.uint32),
        np.full(polygons, filler, np.uint32), np.full(polygons, filler + 1, np.uint32), np.full(polygons, filler + 2, np.uint32),
        np.ones(polygons), np.full(padded4(outline), springs, np.uint32), np.zeros(filler),
    )
    plan.start[:springs], plan.end[:springs] = body.spring_a, body.spring_b
    for mine, of_body in ((plan.left, body.spring_left), (plan.right, body.spring_right)):
        for e in range(springs):
            mine[e] = of_body[e] if of_body[e] < triangles else of_body[e] - triangles + polygons
    plan.corner_a[:triangles], plan.corner_b[:triangles] = body.triangle[:, 0], body.triangle[:, 1]
    plan.corner_c[:triangles], plan.area[:triangles] = body.triangle[:, 2], body.triangle_area
    plan.outline[:outline], plan.inverse_mass[:cells] = body.outline_spring, body.inverse_mass
    return plan


@kernel
def make_scratch(body):
    plan, shape = make_plan(body), (2, body.position.shape[0])
    filler, springs, outside = plan.inverse_mass.size, plan.start.size, plan.area.size + body.polygon_area.size
    state = np.zeros(4 * (filler + 3))
    state[4 * (filler + 1)], state[4 * (filler + 2) + 1] = 1.0, 1.0  # x of the second cell that fills up, y of the third
    return Scratch(
        np.empty(shape), np.empty(shape), np.empty(shape), np.empty(shape), np.empty(shape), np.empty(shape), np.empty(shape),
        np.empty(shape), plan, state, np.zeros(2 * springs), np.zeros(springs), np.zeros(springs), np.zeros(outside + 1),
        np.empty(2 * plan.outline.size), np.empty(2 * filler + 8), np.zeros(1),
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


@inlined
def pack(position, velocity, state):
    """Lay the state of each cell side by side, for `accelerate`."""
    x, y, u, v = position[0], position[1], velocity[0], velocity[1]
    for i in range(0, x.size, 4):
        _put(state, i, load4_within(x, i), load4_within(y, i), load4_within(u, i), load4_within(v, i))


@inlined
def pack_ahead(position, velocity, ahead, before, slower, faster, state):
    """The same for a stage of a Runge-Kutta step: x + ahead (v + before slower), v + ahead faster.

    Args: ahead, before: s; slower, faster (2, N): accelerations.
    """
    h, b = four(ahead), four(before)
    for i in range(0, position.shape[1], 4):
        x, u = _ahead(position[0], velocity[0], h, b, slower[0], faster[0], i)
        y, v = _ahead(position[1], velocity[1], h, b, slower[1], faster[1], i)
        _put(state, i, x, y, u, v)


@inlined
def _ahead(position, velocity, h, b, slower, faster, i):
    v = load4_within(velocity, i)
    return load4_within(position, i) + h * (v + b * load4_within(slower, i)), v + h * load4_within(faster, i)


@inlined
def _put(state, i, x, y, u, v):
    a, b, c, d = transpose(x, y, u, v)
    store(state, 4 * i, a)
    store(state, 4 * i + 4, b)
    store(state, 4 * i + 8, c)
    store(state, 4 * i + 12, d)


@lean
def accelerations(body, law, rest, position, velocity, scratch, out):
    """Fill out (2, N) with the acceleration of every cell.  Chambers and drag are not computed where their coefficients are 0."""
    pack(position, velocity, scratch.state)
    accelerate(body, law, rest, scratch, out)


@inlined
def accelerate(body, law, rest, scratch, out):
    """The same for a state that is packed already."""
    if law.pressure != 0.0:
        _push(body, law, scratch)
    else:
        for c in range(scratch.push.size):
            scratch.push[c] = 0.0
    _pull(law, rest, scratch)
    zero, force = four(0.0), scratch.force
    for i in range(0, force.size, 4):
        store(force, i, zero)
    _hand_out(scratch)
    if law.drag_normal != 0.0 or law.drag_tangential != 0.0:
        _drag(law, scratch)
    for i in range(0, out.shape[1], 4):
        one, other, inverse = load4(force, 2 * i), load4(force, 2 * i + 4), load4(scratch.plan.inverse_mass, i)
        store4_within(out[0], i, evens(one, other) * inverse)
        store4_within(out[1], i, odds(one, other) * inverse)


@inlined
def _at(state, cell, k):
    """x and y of a cell of a list."""
    return load2(state, 4 * index(cell, k))


@inlined
def sides(state, plan, t):
    """Twice the areas of four triangles from the t-th on, as two products, of which the second is to be taken off."""
    a, b, c = plan.corner_a, plan.corner_b, plan.corner_c
    a_low, a_high = join(_at(state, a, t), _at(state, a, t + 1)), join(_at(state, a, t + 2), _at(state, a, t + 3))
    b_low, b_high = join(_at(state, b, t), _at(state, b, t + 1)), join(_at(state, b, t + 2), _at(state, b, t + 3))
    c_low, c_high = join(_at(state, c, t), _at(state, c, t + 1)), join(_at(state, c, t + 2), _at(state, c, t + 3))
    b_low, b_high, c_low, c_high = b_low - a_low, b_high - a_high, c_low - a_low, c_high - a_high
    return evens(b_low, b_high) * odds(c_low, c_high), evens(c_low, c_high) * odds(b_low, b_high)


@inlined
def _push(body, law, scratch):
    """Chambers, equation (2): half of c_p (1 - S/S0), which times the length across each edge goes to each end.  Outside is 0."""
    state, push, area = scratch.state, scratch.push, scratch.plan.area
    half, halves, one = four(0.5 * law.pressure), four(0.5), four(1.0)
    for t in range(0, area.size, 4):
        more, less = sides(state, scratch.plan, t)
        twice = more - less
        store(push, t, half * (one - halves * twice / load4(area, t)))
    corner, start, polygon_area = body.polygon_cell, body.polygon_start, body.polygon_area
    for p in range(polygon_area.size):
        push[area.size + p] = 0.5 * law.pressure * (1.0 - _polygon(corner, start[p], start[p + 1], state) / polygon_area[p])


@inlined
def _polygon(corner, first, last, state):
    """`face_area` of a packed state."""
    twice, before = 0.0, 4 * np.int64(corner[last - 1])
    ox, oy = state[before], state[before + 1]
    for k in range(first, last):
        here = 4 * np.int64(corner[k])
        twice += (state[before] - ox) * (state[here + 1] - oy) - (state[here] - ox) * (state[before + 1] - oy)
        before = here
    return 0.5 * twice


@inlined
def span(state, start, end, e):
    """dx, dy, du, dv of an edge."""
    return load4(state, 4 * index(end, e)) - load4(state, 4 * index(start, e))


@inlined
def _pull(law, rest, scratch):
    """Springs and dampers, per length of the spring, and what the other laws need of every edge."""
    state, start, end = scratch.state, scratch.plan.start, scratch.plan.end
    edge, inverse_square, pull = scratch.edge, scratch.inverse_square, scratch.pull
    stiffness, damping, one = four(law.stiffness), four(law.damping), four(1.0)
    for e in range(0, rest.size, 4):
        a, b, c, d = span(state, start, end, e), span(state, start, end, e + 1), span(state, start, end, e + 2), span(state, start, end, e + 3)
        store(edge, 2 * e, join(low(a), low(b)))
        store(edge, 2 * e + 4, join(low(c), low(d)))
        dx, dy, du, dv = transpose(a, b, c, d)
        inverse = one / root(dx * dx + dy * dy)
        square = inverse * inverse
        store(inverse_square, e, square)
        store(pull, e, stiffness * (one - load4_within(rest, e) * inverse) + damping * square * (du * dx + dv * dy))


@inlined
def _hand_out(scratch):
    """Hand springs' and chambers' forces to both ends of every edge."""
    plan, edge, pull, push, force = scratch.plan, scratch.edge, scratch.pull, scratch.push, scratch.force
    start, end, left, right = plan.start, plan.end, plan.left, plan.right
    for e in range(start.size):
        i, j = 2 * index(start, e), 2 * index(end, e)
        across = number(push, index(right, e)) - number(push, index(left, e))
        d = load2(edge, 2 * e)
        along, pushed = two(number(pull, e)) * d, two(-across, across) * swapped(d)
        store(force, i, load2(force, i) + (pushed + along))
        store(force, j, load2(force, j) + (pushed - along))


@inlined
def _flow(state, start, end, e):
    """Twice the mean velocity of an edge's ends."""
    return load2(state, 4 * index(start, e) + 2) + load2(state, 4 * index(end, e) + 2)


@inlined
def _drag(law, scratch):
    """F_T = -d_T l v_T |v_T| along and F_N = -d_N l v_N |v_N| across an outline edge, half to each end (section 4.2)."""
    plan, state, edge, inverse_square, drag, force = (
        scratch.plan, scratch.state, scratch.edge, scratch.inverse_square, scratch.drag, scratch.force
    )
    start, end, outline = plan.start, plan.end, plan.outline
    tangential, normal, half = four(-0.5 * law.drag_tangential), four(-0.5 * law.drag_normal), four(0.5)
    for m in range(0, outline.size, 4):
        a, b, c, d = index(outline, m), index(outline, m + 1), index(outline, m + 2), index(outline, m + 3)
        one, other = join(_flow(state, start, end, a), _flow(state, start, end, b)), join(_flow(state, start, end, c), _flow(state, start, end, d))
        u, v = half * evens(one, other), half * odds(one, other)
        one, other = join(load2(edge, 2 * a), load2(edge, 2 * b)), join(load2(edge, 2 * c), load2(edge, 2 * d))
        dx, dy = evens(one, other), odds(one, other)
        square = four(number(inverse_square, a), number(inverse_square, b), number(inverse_square, c), number(inverse_square, d))
        along, across = u * dx + v * dy, v * dx - u * dy  # speeds times length
        t, n = tangential * square * along * magnitude(along), normal * square * across * magnitude(across)
        fx, fy = t * dx - n * dy, t * dy + n * dx
        store(drag, 2 * m, zip_low(fx, fy))
        store(drag, 2 * m + 4, zip_high(fx, fy))
    for m in range(outline.size):
        e = index(outline, m)
        i, j, f = 2 * index(start, e), 2 * index(end, e), load2(drag, 2 * m)
        store(force, i, load2(force, i) + f)
        store(force, j, load2(force, j) + f)
