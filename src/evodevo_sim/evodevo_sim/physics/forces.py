"""Forces on a body (paper sections 2.3 and 4.2): springs, chambers, drag.

States are (2, N), a row of x and a row of y, which compilers turn into better code than (N, 2).  The laws are computed for four
edges or chambers at a time (see `vectors`), from a copy of the state with x, y, u, v of a cell side by side.
"""

from __future__ import annotations

from collections import namedtuple

import numpy as np

from ..kernels.jit import inlined, kernel, lean
from ..kernels.vectors import (
    even_pairs,
    evens,
    four,
    halves,
    high,
    index,
    join,
    load2,
    load4,
    load4_within,
    low,
    magnitude,
    number,
    odd_pairs,
    odds,
    padded4,
    root,
    store,
    store4_within,
    transpose,
)

# stiffness N/m, damping N s/m, pressure N/m, drag_normal and drag_tangential kg/m^2
Law = namedtuple("Law", "stiffness damping pressure drag_normal drag_tangential")
# A body in the order in which its forces are computed: springs, triangles and outline filled up to fours with some between three
# cells beyond the last, which lie at the corners of a triangle and never move.  Cells are given by their place in the state, four times
# their number.  start, end, left, right: springs' cells and chambers, the triangles and what fills them up first, then polygons, then
# outside; corner_a, _b, _c, area: triangles; outline, outline_start, outline_end: its springs and their cells.
Plan = namedtuple("Plan", "start end left right corner_a corner_b corner_c area outline outline_start outline_end inverse_mass")
# Scratch of the integrator: states and their derivatives, (2, N) each; of the forces, by place in the plan: state, x, y, u, v of each
# cell; inverse_square, 1/length^2 of each spring; push, half of c_p (1 - S/S0) of each chamber; force, x, y and room for two more;
# and what `advance` leaves: rate (1,) 1/s, the rate of drag in its last state.
Scratch = namedtuple(
    "Scratch", "position velocity k1 k2 k3 k4 start_position start_velocity plan state inverse_square push force rate",
)


@kernel
def make_law(material, scene):
    return Law(material.stiffness, material.damping, material.pressure, scene.drag_normal, scene.drag_tangential)


@kernel
def make_plan(body):
    cells, springs, triangles, outline = body.inverse_mass.size, body.rest_length.size, body.triangle_area.size, body.outline_spring.size
    filler, polygons = padded4(cells), padded4(triangles)
    outside = polygons + body.polygon_area.size
    room = padded4(springs) + 4  # `_pull` looks at a four beyond the last
    first, second, third = 4 * filler, 4 * filler + 4, 4 * filler + 8
    plan = Plan(
        np.full(room, first, np.uint32), np.full(room, second, np.uint32),
        np.full(room, outside, np.uint32), np.full(room, outside, np.uint32),
        np.full(polygons, first, np.uint32), np.full(polygons, second, np.uint32), np.full(polygons, third, np.uint32), np.ones(polygons),
        np.full(padded4(outline), springs, np.uint32), np.full(padded4(outline), first, np.uint32),
        np.full(padded4(outline), second, np.uint32), np.zeros(filler),
    )
    for e in range(springs):
        plan.start[e], plan.end[e] = 4 * body.spring_a[e], 4 * body.spring_b[e]
    for mine, of_body in ((plan.left, body.spring_left), (plan.right, body.spring_right)):
        for e in range(springs):
            mine[e] = of_body[e] if of_body[e] < triangles else of_body[e] - triangles + polygons
    for t in range(triangles):
        corner = body.triangle[t]
        plan.corner_a[t], plan.corner_b[t], plan.corner_c[t] = 4 * corner[0], 4 * corner[1], 4 * corner[2]
        plan.area[t] = body.triangle_area[t]
    for m in range(outline):
        e = body.outline_spring[m]
        plan.outline[m], plan.outline_start[m], plan.outline_end[m] = e, plan.start[e], plan.end[e]
    plan.inverse_mass[:cells] = body.inverse_mass
    return plan


@kernel
def make_scratch(body):
    plan, shape = make_plan(body), (2, body.position.shape[0])
    filler, outside = plan.inverse_mass.size, plan.area.size + body.polygon_area.size
    state = np.zeros(4 * (filler + 3))
    state[4 * (filler + 1)], state[4 * (filler + 2) + 1] = 1.0, 1.0  # x of the second cell that fills up, y of the third
    return Scratch(
        np.empty(shape), np.empty(shape), np.empty(shape), np.empty(shape), np.empty(shape), np.empty(shape), np.empty(shape),
        np.empty(shape), plan, state, np.zeros(plan.start.size), np.zeros(outside + 1), np.empty(state.size), np.zeros(1),
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
    zero, force = four(0.0), scratch.force
    for i in range(0, force.size, 4):
        store(force, i, zero)
    _pull(law, rest, scratch)
    if law.drag_normal != 0.0 or law.drag_tangential != 0.0:
        _drag(law, scratch)
    for i in range(0, out.shape[1], 4):
        one, other = join(load2(force, 4 * i), load2(force, 4 * i + 4)), join(load2(force, 4 * i + 8), load2(force, 4 * i + 12))
        inverse = load4(scratch.plan.inverse_mass, i)
        store4_within(out[0], i, evens(one, other) * inverse)
        store4_within(out[1], i, odds(one, other) * inverse)


@inlined
def _at(state, cell, k):
    """x and y of a cell of a list."""
    return load2(state, index(cell, k))


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
    return load4(state, index(end, e)) - load4(state, index(start, e))


@inlined
def _numbers(values, places, e):
    """The values at four places of a list."""
    return four(
        number(values, index(places, e)), number(values, index(places, e + 1)),
        number(values, index(places, e + 2)), number(values, index(places, e + 3)),
    )


@inlined
def _add(force, cell, e, vector):
    place = index(cell, e)
    store(force, place, load2(force, place) + vector)


@inlined
def _take(force, cell, e, vector):
    place = index(cell, e)
    store(force, place, load2(force, place) - vector)


@inlined
def _stretch(state, start, end, e):
    """Of four edges from the e-th on: dx, dy, length (m), and length times the rate at which it grows (m^2/s)."""
    a, b = span(state, start, end, e), span(state, start, end, e + 1)
    c, d = span(state, start, end, e + 2), span(state, start, end, e + 3)
    dx, dy, du, dv = transpose(a, b, c, d)
    return dx, dy, root(dx * dx + dy * dy), du * dx + dv * dy


@inlined
def _pull(law, rest, scratch):
    """Springs, dampers and chambers: force along and across every edge, to both its ends; and 1/length^2, which drag needs.

    Each four is measured a turn before it is handed out: the processor takes its roots meanwhile.
    """
    plan, push, force, state = scratch.plan, scratch.push, scratch.force, scratch.state
    start, end = plan.start, plan.end
    stiffness, damping, one = four(law.stiffness), four(law.damping), four(1.0)
    dx0, dy0, length0, growth0 = _stretch(state, start, end, 0)
    for e in range(0, rest.size, 4):
        dx1, dy1, length1, growth1 = _stretch(state, start, end, e + 4)
        inverse = one / length0
        square = inverse * inverse
        store(scratch.inverse_square, e, square)
        pull = stiffness * (one - load4_within(rest, e) * inverse) + damping * square * growth0
        across = _numbers(push, plan.right, e) - _numbers(push, plan.left, e)
        along_x, along_y, across_x, across_y = pull * dx0, pull * dy0, across * dy0, across * dx0
        x, y = along_x - across_x, along_y + across_y
        even, odd = even_pairs(x, y), odd_pairs(x, y)
        x, y = along_x + across_x, along_y - across_y
        even_end, odd_end = even_pairs(x, y), odd_pairs(x, y)
        _add(force, start, e, low(even))
        _take(force, end, e, low(even_end))
        _add(force, start, e + 1, low(odd))
        _take(force, end, e + 1, low(odd_end))
        _add(force, start, e + 2, high(even))
        _take(force, end, e + 2, high(even_end))
        _add(force, start, e + 3, high(odd))
        _take(force, end, e + 3, high(odd_end))
        dx0, dy0, length0, growth0 = dx1, dy1, length1, growth1


@inlined
def _flow(state, start, end, m):
    """dx, dy of an edge and the sum of its ends' u, v."""
    one, other = load4(state, index(start, m)), load4(state, index(end, m))
    return halves(other - one, one + other)


@inlined
def _drag(law, scratch):
    """F_T = -d_T l v_T |v_T| along and F_N = -d_N l v_N |v_N| across an outline edge, half to each end (section 4.2)."""
    plan, state, force = scratch.plan, scratch.state, scratch.force
    start, end = plan.outline_start, plan.outline_end
    tangential, normal, half = four(-0.5 * law.drag_tangential), four(-0.5 * law.drag_normal), four(0.5)
    for m in range(0, plan.outline.size, 4):
        a, b = _flow(state, start, end, m), _flow(state, start, end, m + 1)
        c, d = _flow(state, start, end, m + 2), _flow(state, start, end, m + 3)
        dx, dy, u, v = transpose(a, b, c, d)
        u, v, square = half * u, half * v, _numbers(scratch.inverse_square, plan.outline, m)
        along, across = u * dx + v * dy, v * dx - u * dy  # speeds times length
        t, n = tangential * square * along * magnitude(along), normal * square * across * magnitude(across)
        x, y = t * dx - n * dy, t * dy + n * dx
        even, odd = even_pairs(x, y), odd_pairs(x, y)
        _add(force, start, m, low(even))
        _add(force, end, m, low(even))
        _add(force, start, m + 1, low(odd))
        _add(force, end, m + 1, low(odd))
        _add(force, start, m + 2, high(even))
        _add(force, end, m + 2, high(even))
        _add(force, start, m + 3, high(odd))
        _add(force, end, m + 3, high(odd))
