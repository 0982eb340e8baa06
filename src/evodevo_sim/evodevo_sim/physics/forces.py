"""Forces on a body (paper sections 2.3 and 4.2): springs, chambers, drag.

States are (2, N), a row of x and a row of y, which compilers turn into better code than (N, 2).  The laws are computed for four
edges or chambers at a time (see `vectors`), from a copy of the state with x, y, u, v of a cell side by side.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import types
from numba.extending import overload

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


class Law(NamedTuple):
    """The coefficients of all forces.  Where chambers or drag have 0, their terms are not computed."""

    stiffness: float  # N/m, of springs
    damping: float  # N s/m, of springs
    pressure: float  # N/m, of chambers, c_p
    drag_normal: float  # kg/m^2, across an outline edge
    drag_tangential: float  # kg/m^2, along it
    muscle_range: float  # of its rest length, that a spring grows by for each e - c of 1 at either end: see `set_rest_lengths`


class Ramp(NamedTuple):
    """Rest lengths on their way: they go evenly from one length to another over a control step."""

    before: np.ndarray  # (E,) m, at its start
    after: np.ndarray  # (E,) m, at its end
    share: float  # of the step that is over


class Plan(NamedTuple):
    """A body in the order in which its forces are computed: springs, triangles and outline filled up to fours with some between three
    cells beyond the last, which lie at the corners of a triangle and never move.

    Cells are given by their place in the state, four times their number; chambers by their number, the triangles and what fills them
    up first, then polygons, then outside.  E, T, M, N: filled up.
    """

    start: np.ndarray  # (E,) uint32: cells of springs
    end: np.ndarray  # (E,)
    left: np.ndarray  # (E,) uint32: chambers of springs
    right: np.ndarray  # (E,)
    corner_a: np.ndarray  # (T,) uint32: cells of triangles
    corner_b: np.ndarray  # (T,)
    corner_c: np.ndarray  # (T,)
    area: np.ndarray  # (T,) m^2 at rest, of triangles
    outline: np.ndarray  # (M,) uint32: springs of the outline
    outline_start: np.ndarray  # (M,) uint32: their cells
    outline_end: np.ndarray  # (M,)
    inverse_mass: np.ndarray  # (N,) 1/kg


class Scratch(NamedTuple):
    """Scratch of an integrator: states and their derivatives; of the forces, by place in the plan; and what `advance` leaves."""

    position: np.ndarray  # (2, N) m
    velocity: np.ndarray  # (2, N) m/s
    k1: np.ndarray  # (2, N) m/s^2, as the next five
    k2: np.ndarray
    k3: np.ndarray
    k4: np.ndarray
    k5: np.ndarray
    k6: np.ndarray
    start_position: np.ndarray  # (2, N) m: at the start of an interval, see `ladder`
    start_velocity: np.ndarray  # (2, N) m/s
    start_ledger: np.ndarray  # (4,) J
    plan: Plan
    state: np.ndarray  # (4 N,): x, y, u, v of each cell
    inverse_square: np.ndarray  # (E,) 1/m^2: 1 / length^2 of springs
    push: np.ndarray  # (chambers + 1,) N/m: half of c_p (1 - S/S0); outside, the last, has 0
    force: np.ndarray  # (4 N,) N: x, y and room for two more
    rate: np.ndarray  # (1,) 1/s: the rate of drag in the last state


@kernel
def make_law(material, scene):
    return Law(
        stiffness=material.stiffness, damping=material.damping, pressure=material.pressure, drag_normal=scene.drag_normal,
        drag_tangential=scene.drag_tangential, muscle_range=material.muscle_range,
    )


@lean
def undamped(law):
    """Springs and chambers alone."""
    return Law(
        stiffness=law.stiffness, damping=0.0, pressure=law.pressure, drag_normal=0.0, drag_tangential=0.0, muscle_range=law.muscle_range
    )


@lean
def damping_alone(law):
    """The damping of springs alone."""
    return Law(stiffness=0.0, damping=law.damping, pressure=0.0, drag_normal=0.0, drag_tangential=0.0, muscle_range=law.muscle_range)


@lean
def drag_alone(law):
    """The drag of the fluid alone."""
    return Law(
        stiffness=0.0, damping=0.0, pressure=0.0, drag_normal=law.drag_normal, drag_tangential=law.drag_tangential,
        muscle_range=law.muscle_range,
    )


@kernel
def make_plan(body):
    cells, springs, triangles, outline = body.inverse_mass.size, body.rest_length.size, body.triangle_area.size, body.outline_spring.size
    filler, polygons = padded4(cells), padded4(triangles)
    outside = polygons + body.polygon_area.size
    room = padded4(springs) + 4  # `_pull` looks at a four beyond the last
    first, second, third = 4 * filler, 4 * filler + 4, 4 * filler + 8
    plan = Plan(
        start=np.full(room, first, np.uint32), end=np.full(room, second, np.uint32),
        left=np.full(room, outside, np.uint32), right=np.full(room, outside, np.uint32),
        corner_a=np.full(polygons, first, np.uint32), corner_b=np.full(polygons, second, np.uint32),
        corner_c=np.full(polygons, third, np.uint32), area=np.ones(polygons),
        outline=np.full(padded4(outline), springs, np.uint32), outline_start=np.full(padded4(outline), first, np.uint32),
        outline_end=np.full(padded4(outline), second, np.uint32), inverse_mass=np.zeros(filler),
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
    for i in range(cells):
        plan.inverse_mass[i] = body.inverse_mass[i]
    return plan


@kernel
def make_scratch(body):
    plan, shape = make_plan(body), (2, body.position.shape[0])
    filler, outside = plan.inverse_mass.size, plan.area.size + body.polygon_area.size
    state = np.zeros(4 * (filler + 3))
    state[4 * (filler + 1)], state[4 * (filler + 2) + 1] = 1.0, 1.0  # x of the second cell that fills up, y of the third
    return Scratch(
        position=np.empty(shape), velocity=np.empty(shape), k1=np.empty(shape), k2=np.empty(shape), k3=np.empty(shape), k4=np.empty(shape),
        k5=np.empty(shape), k6=np.empty(shape), start_position=np.empty(shape), start_velocity=np.empty(shape),
        start_ledger=np.zeros(4), plan=plan, state=state, inverse_square=np.zeros(plan.start.size),
        push=np.zeros(outside + 1), force=np.empty(state.size), rate=np.zeros(1),
    )


@lean
def set_rest_lengths(body, law, activation, rest):
    """Equation (1): L = (1 + r (a_i + a_j)) L0 with a = e - c and the muscle range r.  Fills rest (E,) from activation (N,)."""
    start, end, rest_length, muscle_range = body.spring_a, body.spring_b, body.rest_length, law.muscle_range
    for e in range(rest.size):
        rest[e] = (1.0 + muscle_range * (activation[start[e]] + activation[end[e]])) * rest_length[e]


def _rest4(_rest, _e):
    """Rest lengths of four springs, m, from the e-th on: of an array, or on a `Ramp`."""


@overload(_rest4)
def _rest4_of(_rest, _e):
    return _held if isinstance(_rest, types.Array) else _on_the_way


def _held(_rest, _e):
    return load4_within(_rest, _e)


def _on_the_way(_rest, _e):
    before = load4_within(_rest.before, _e)
    return before + four(_rest.share) * (load4_within(_rest.after, _e) - before)


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
        put(state, i, load4_within(x, i), load4_within(y, i), load4_within(u, i), load4_within(v, i))


@inlined
def put(state, i, x, y, u, v):
    """Lay down four cells, from the i-th on."""
    a, b, c, d = transpose(x, y, u, v)
    store(state, 4 * i, a)
    store(state, 4 * i + 4, b)
    store(state, 4 * i + 8, c)
    store(state, 4 * i + 12, d)


@inlined
def taken(state, i):
    """x, y, u, v of four cells from the i-th on."""
    return transpose(load4(state, 4 * i), load4(state, 4 * i + 4), load4(state, 4 * i + 8), load4(state, 4 * i + 12))


@inlined
def unpack(state, position, velocity):
    """The way back."""
    for i in range(0, position.shape[1], 4):
        x, y, u, v = taken(state, i)
        store4_within(position[0], i, x)
        store4_within(position[1], i, y)
        store4_within(velocity[0], i, u)
        store4_within(velocity[1], i, v)


@lean
def accelerations(body, law, rest, position, velocity, scratch, out):
    """Fill out (2, N) with the acceleration of every cell.  Chambers and drag are not computed where their coefficients are 0."""
    pack(position, velocity, scratch.state)
    accelerate(body, law, rest, scratch, out)


@inlined
def accelerate(body, law, rest, scratch, out):
    """The same for a state that is packed already.  Args: rest: (E,) m, or a `Ramp`."""
    exert(body, law, rest, scratch)
    for i in range(0, out.shape[1], 4):
        x, y = pushed(scratch, i)
        store4_within(out[0], i, x)
        store4_within(out[1], i, y)


@inlined
def exert(body, law, rest, scratch):
    """Fill scratch.force from a packed state."""
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


@inlined
def pushed(scratch, i):
    """Accelerations of four cells from the i-th on, by the forces on them: x, y."""
    force = scratch.force
    one, other = join(load2(force, 4 * i), load2(force, 4 * i + 4)), join(load2(force, 4 * i + 8), load2(force, 4 * i + 12))
    inverse = load4(scratch.plan.inverse_mass, i)
    return evens(one, other) * inverse, odds(one, other) * inverse


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
    for e in range(0, start.size - 4, 4):
        dx1, dy1, length1, growth1 = _stretch(state, start, end, e + 4)
        inverse = one / length0
        square = inverse * inverse
        store(scratch.inverse_square, e, square)
        pull = stiffness * (one - _rest4(rest, e) * inverse) + damping * square * growth0
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
