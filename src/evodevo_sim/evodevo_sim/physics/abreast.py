"""Copies of one body that move abreast: each operation of `forces` and of a control step is done for four copies at once, one in each
lane of a vector.  Nothing has to be gathered or turned around, and each copy has the bits that it has alone.

States, from here on down, are (N, 4, 4) laid out flat: of each cell x of the copies, then y, u, v; accelerations (N, 2, 4).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..kernels.jit import inlined, kernel, lean, seam
from ..kernels.lanes import aligned
from ..kernels.vectors import (
    chosen,
    four,
    index,
    load4,
    load4_within,
    magnitude,
    padded4,
    root,
    store,
    transpose,
)
from .control_step import NODES
from .soundness import FARTHEST, FASTEST, SHORTEST, STABLE_DRAG

COPIES = 4


class Abreast(NamedTuple):
    """Four copies of a body, and scratch."""

    of: np.ndarray  # (4,) int64: the copy that each lane moves: its own; or, where that moves no more, another one, to no purpose
    substeps: np.ndarray  # (4,) int64: of the next control step
    rate: np.ndarray  # (4,) 1/s: of drag, that each has reached
    sound: np.ndarray  # (4,): 1 for a copy that came through a control step; 0 for others, which must do it alone, and for idle lanes
    state: np.ndarray  # (16 N,) of all copies
    start: np.ndarray  # (16 N,) the same at the start of a control step
    stage: np.ndarray  # (16 N,)
    k1: np.ndarray  # (8 N,) m/s^2, as the next five
    k2: np.ndarray
    k3: np.ndarray
    k4: np.ndarray
    k5: np.ndarray
    k6: np.ndarray
    before: np.ndarray  # (4 E,) m: rest lengths at the start of a control step
    rest: np.ndarray  # (4 E,) m: to which they go
    inverse_square: np.ndarray  # (4 E,) 1/m^2
    push: np.ndarray  # (4 chambers + 4,) N/m, see `forces.Scratch`
    activation: np.ndarray  # (4 N,)


@kernel
def make_abreast(body):
    cells, springs = body.position.shape[0], body.rest_length.size
    chambers = body.triangle_area.size + body.polygon_area.size
    return Abreast(
        of=np.arange(COPIES), substeps=np.ones(COPIES, np.int64), rate=np.zeros(COPIES), sound=np.zeros(COPIES),
        state=_room(16 * cells, 0), start=_room(16 * cells, 1), stage=_room(16 * cells, 2), k1=_room(8 * cells, 3),
        k2=_room(8 * cells, 4), k3=_room(8 * cells, 5), k4=_room(8 * cells, 6), k5=_room(8 * cells, 7), k6=_room(8 * cells, 8),
        before=_room(4 * springs, 0), rest=_room(4 * springs, 1), inverse_square=_room(4 * springs, 2), push=_room(4 * chambers + 4, 3),
        activation=_room(4 * padded4(cells), 4),
    )


@kernel
def _room(size, turn):
    """Zeros that begin at a line of the cache, by turns at other places of a page: processors tell loads and stores apart by those."""
    first = 56 * turn
    memory = aligned(1, first + size)
    return memory[0, first : first + size]


@lean
def put_copy(abreast, copy, position, velocity):
    """Set the state of one copy.  Args: position, velocity (2, N)."""
    state = abreast.state
    for i in range(position.shape[1]):
        state[16 * i + copy], state[16 * i + 4 + copy] = position[0, i], position[1, i]
        state[16 * i + 8 + copy], state[16 * i + 12 + copy] = velocity[0, i], velocity[1, i]


@lean
def take_copy(state, copy, position, velocity):
    """Look at one copy in a state of all.  Args: position, velocity (2, N): filled."""
    for i in range(position.shape[1]):
        position[0, i], position[1, i] = state[16 * i + copy], state[16 * i + 4 + copy]
        velocity[0, i], velocity[1, i] = state[16 * i + 8 + copy], state[16 * i + 12 + copy]


@lean
def put_rest(abreast, copy, rest):
    """Set the rest lengths (E,) of one copy."""
    for e in range(rest.size):
        abreast.rest[4 * e + copy] = rest[e]


@lean
def take_rest(lengths, copy, rest):
    """Look at the rest lengths of one copy among those of all.  Args: rest (E,): filled."""
    for e in range(rest.size):
        rest[e] = lengths[4 * e + copy]


@lean
def set_out(abreast):
    """Before rest lengths are set: they go from what they are."""
    for e in range(0, abreast.rest.size, 4):
        store(abreast.before, e, load4(abreast.rest, e))


@lean
def go_along(abreast, lane, copy):
    """Let a lane whose own copy moves no more move another one."""
    abreast.of[lane] = copy
    for values in (abreast.state, abreast.before, abreast.rest):
        for i in range(0, values.size, 4):
            values[i + lane] = values[i + copy]


@lean
def set_rest_abreast(body, law, activation, abreast):
    """`forces.set_rest_lengths` of all copies.  Args: activation (4, N)."""
    of, packed = abreast.of, abreast.activation
    for i in range(0, activation.shape[1], 4):
        a, b, c, d = transpose(
            load4_within(activation[of[0]], i), load4_within(activation[of[1]], i), load4_within(activation[of[2]], i),
            load4_within(activation[of[3]], i),
        )
        store(packed, 4 * i, a)
        store(packed, 4 * i + 4, b)
        store(packed, 4 * i + 8, c)
        store(packed, 4 * i + 12, d)
    one, muscle_range = four(1.0), four(law.muscle_range)
    for e in range(body.rest_length.size):
        a, b = load4(packed, 4 * index(body.spring_a, e)), load4(packed, 4 * index(body.spring_b, e))
        store(abreast.rest, 4 * e, (one + muscle_range * (a + b)) * four(body.rest_length[e]))


@inlined
def _sides(state, triangle, t):
    """Twice the area of a triangle, as two products, of which the second is to be taken off: see `forces.sides`."""
    a, b, c = 16 * index(triangle, 3 * t), 16 * index(triangle, 3 * t + 1), 16 * index(triangle, 3 * t + 2)
    ax, ay = load4(state, a), load4(state, a + 4)
    bx, by, cx, cy = load4(state, b) - ax, load4(state, b + 4) - ay, load4(state, c) - ax, load4(state, c + 4) - ay
    return bx * cy, cx * by


@inlined
def _face(state, corner, first, last):
    """`forces.face_area`"""
    twice, before = four(0.0), 16 * np.int64(corner[last - 1])
    ox, oy = load4(state, before), load4(state, before + 4)
    for k in range(first, last):
        here = 16 * np.int64(corner[k])
        one = (load4(state, before) - ox) * (load4(state, here + 4) - oy)
        twice = twice + (one - (load4(state, here) - ox) * (load4(state, before + 4) - oy))
        before = here
    return four(0.5) * twice


@inlined
def _push(body, law, state, push):
    half, halves, one = four(0.5 * law.pressure), four(0.5), four(1.0)
    triangle, triangles = body.triangle.reshape(-1), body.triangle_area.size
    for t in range(triangles):
        more, less = _sides(state, triangle, t)
        store(push, 4 * t, half * (one - halves * (more - less) / four(body.triangle_area[t])))
    corner, start = body.polygon_cell, body.polygon_start
    for p in range(body.polygon_area.size):
        area = _face(state, corner, start[p], start[p + 1])
        store(push, 4 * (triangles + p), half * (one - area / four(body.polygon_area[p])))


@inlined
def _stretch(body, state, e):
    """Of a spring: dx, dy, length (m), and length times the rate at which it grows (m^2/s)."""
    a, b = 16 * index(body.spring_a, e), 16 * index(body.spring_b, e)
    dx, dy = load4(state, b) - load4(state, a), load4(state, b + 4) - load4(state, a + 4)
    du, dv = load4(state, b + 8) - load4(state, a + 8), load4(state, b + 12) - load4(state, a + 12)
    return dx, dy, root(dx * dx + dy * dy), du * dx + dv * dy


@inlined
def _pull(body, law, state, share, abreast, force):
    push, before, after, squares = abreast.push, abreast.before, abreast.rest, abreast.inverse_square
    stiffness, damping, one, springs = four(law.stiffness), four(law.damping), four(1.0), body.rest_length.size
    dx, dy, length, growth = _stretch(body, state, 0)
    for e in range(springs):
        dx1, dy1, length1, growth1 = _stretch(body, state, min(e + 1, springs - 1))
        inverse = one / length
        square = inverse * inverse
        store(squares, 4 * e, square)
        old = load4(before, 4 * e)
        rest = old + share * (load4(after, 4 * e) - old)
        pull = stiffness * (one - rest * inverse) + damping * square * growth
        across = load4(push, 4 * index(body.spring_right, e)) - load4(push, 4 * index(body.spring_left, e))
        along_x, along_y, across_x, across_y = pull * dx, pull * dy, across * dy, across * dx
        a, b = 8 * index(body.spring_a, e), 8 * index(body.spring_b, e)
        store(force, a, load4(force, a) + (along_x - across_x))
        store(force, a + 4, load4(force, a + 4) + (along_y + across_y))
        store(force, b, load4(force, b) - (along_x + across_x))
        store(force, b + 4, load4(force, b + 4) - (along_y - across_y))
        dx, dy, length, growth = dx1, dy1, length1, growth1


@inlined
def _drag(body, law, state, abreast, force):
    squares, outline = abreast.inverse_square, body.outline_spring
    tangential, normal, half = four(-0.5 * law.drag_tangential), four(-0.5 * law.drag_normal), four(0.5)
    for m in range(outline.size):
        e = np.int64(outline[m])
        i, j = index(body.spring_a, e), index(body.spring_b, e)
        a, b = 16 * i, 16 * j
        dx, dy = load4(state, b) - load4(state, a), load4(state, b + 4) - load4(state, a + 4)
        u, v = load4(state, a + 8) + load4(state, b + 8), load4(state, a + 12) + load4(state, b + 12)
        u, v, square = half * u, half * v, load4(squares, 4 * e)
        along, across = u * dx + v * dy, v * dx - u * dy
        t, n = tangential * square * along * magnitude(along), normal * square * across * magnitude(across)
        x, y = t * dx - n * dy, t * dy + n * dx
        a, b = 8 * i, 8 * j
        store(force, a, load4(force, a) + x)
        store(force, a + 4, load4(force, a + 4) + y)
        store(force, b, load4(force, b) + x)
        store(force, b + 4, load4(force, b + 4) + y)


@inlined
def force_abreast(body, law, state, share, abreast, force):
    """Add the force on every cell of every copy to force (8 N,): see `forces.accelerate`.  Args: share: vector, see `forces.Ramp`."""
    if law.pressure != 0.0:
        _push(body, law, state, abreast.push)
    else:
        for c in range(0, abreast.push.size, 4):
            store(abreast.push, c, four(0.0))
    _pull(body, law, state, share, abreast, force)
    if law.drag_normal != 0.0 or law.drag_tangential != 0.0:
        _drag(body, law, state, abreast, force)


@inlined
def _moved(h, stage, abreast, k, now):
    """What a stage of Lawson's method adds to x + h c v and to v, of the accelerations so far, the last one `now`: see `control_step`."""
    square, three = h * h, four(3.0)
    if stage == 1:
        return four(0.0), h / four(2.0) * now
    first = load4(abreast.k1, k)
    if stage == 2:
        return square / four(32.0) * first, h / four(16.0) * (three * first + now)
    second = load4(abreast.k2, k)
    if stage == 3:
        return square / four(32.0) * (three * first + second), h / four(2.0) * now
    third = load4(abreast.k3, k)
    if stage == 4:
        return (
            square * three / four(128.0) * (second - first + four(12.0) * third),
            h * three / four(16.0) * (four(2.0) * third - second + three * now),
        )
    fourth = load4(abreast.k4, k)
    return (
        square / four(56.0) * (four(25.0) * first - four(9.0) * second - four(24.0) * third + four(36.0) * fourth),
        h / four(7.0) * (first + four(4.0) * second + four(6.0) * third - four(12.0) * fourth + four(8.0) * now),
    )


@inlined
def _ahead(body, h, stage, abreast, slope, following):
    """Lay out the state of a stage.  Args: slope: forces of the one before, which become accelerations; following: emptied for its own."""
    ahead, state, out, zero = h * four(NODES[stage]), abreast.state, abreast.stage, four(0.0)
    for i in range(body.inverse_mass.size):
        inverse = four(body.inverse_mass[i])
        for axis in range(0, 8, 4):
            place, k = 16 * i + axis, 8 * i + axis
            now = load4(slope, k) * inverse
            v, (moved, faster) = load4(state, place + 8), _moved(h, stage, abreast, k, now)
            store(slope, k, now)
            store(following, k, zero)
            store(out, place, load4(state, place) + ahead * v + moved)
            store(out, place + 8, v + faster)


@inlined
def _substep(body, law, abreast, h, steps, step):
    """One step of Lawson's method, as `control_step` has it, of copies that have some left.  Args: h, s, and steps: vectors."""
    state, share, now, zero = abreast.state, four(step), four(step) / steps, four(0.0)
    k1, k2, k3, k4, k5, k6 = abreast.k1, abreast.k2, abreast.k3, abreast.k4, abreast.k5, abreast.k6
    for k in range(0, k1.size, 4):
        store(k1, k, zero)
    for n in range(6):
        slope, at = k1, state
        if n == 1:
            slope = k2
            _ahead(body, h, 1, abreast, k1, k2)
        elif n == 2:
            slope = k3
            _ahead(body, h, 2, abreast, k2, k3)
        elif n == 3:
            slope = k4
            _ahead(body, h, 3, abreast, k3, k4)
        elif n == 4:
            slope = k5
            _ahead(body, h, 4, abreast, k4, k5)
        elif n == 5:
            slope = k6
            _ahead(body, h, 5, abreast, k5, k6)
        if n > 0:
            at = abreast.stage
        force_abreast(body, law, at, now + four(NODES[n]) / steps, abreast, slope)
    square, part = h * h / four(90.0), h / four(90.0)
    for i in range(body.inverse_mass.size):
        inverse = four(body.inverse_mass[i])
        for axis in range(0, 8, 4):
            place, k = 16 * i + axis, 8 * i + axis
            x, v, seven, third, fourth = load4(state, place), load4(state, place + 8), four(7.0) * load4(k1, k), load4(k3, k), load4(k4, k)
            fifth, last = load4(k5, k), four(7.0) * (load4(k6, k) * inverse)
            after = x + h * v + square * (seven + four(24.0) * third + four(6.0) * fourth + four(8.0) * fifth)
            faster = v + part * (seven + four(32.0) * third + four(12.0) * fourth + four(32.0) * fifth + last)
            store(state, place, chosen(steps, share, after, x))
            store(state, place + 8, chosen(steps, share, faster, v))


@inlined
def _surely_sound(body, h, state):
    """1 for copies that pass `soundness.check`, and 0 for those that do not or nearly do not."""
    ok, no, over, under = four(1.0), four(0.0), four(FASTEST * body.shortest) / h, h / four(FARTHEST)
    fastest, farthest, shortest = over * over, under * under, four(SHORTEST)
    for i in range(body.inverse_mass.size):
        u, v = load4(state, 16 * i + 8), load4(state, 16 * i + 12)
        ok = chosen(fastest, u * u + v * v, ok, no)
    for e in range(body.rest_length.size):
        a, b = 16 * index(body.spring_a, e), 16 * index(body.spring_b, e)
        dx, dy = load4(state, b) - load4(state, a), load4(state, b + 4) - load4(state, a + 4)
        du, dv = load4(state, b + 8) - load4(state, a + 8), load4(state, b + 12) - load4(state, a + 12)
        least, square = shortest * four(body.rest_length[e]), dx * dx + dy * dy
        ok = chosen(square, least * least, ok, no)
        ok = chosen(square, (du * du + dv * dv) * farthest, ok, no)
    triangle = body.triangle.reshape(-1)
    for t in range(body.triangle_area.size):
        more, less = _sides(state, triangle, t)
        ok = chosen(more, less, ok, no)
    corner, start = body.polygon_cell, body.polygon_start
    for p in range(start.size - 1):
        ok = chosen(_face(state, corner, start[p], start[p + 1]), no, ok, no)
    return ok


@inlined
def _drag_rate(body, law, state, rate):
    """`bounds.drag_rate`.  Args: rate (4 N,): scratch."""
    outline, zero, half = body.outline_spring, four(0.0), four(0.5)
    tangential, normal, cells = four(law.drag_tangential), four(law.drag_normal), body.inverse_mass.size
    for i in range(cells):
        store(rate, 4 * i, zero)
    for m in range(outline.size):
        e = np.int64(outline[m])
        i, j = index(body.spring_a, e), index(body.spring_b, e)
        a, b = 16 * i, 16 * j
        dx, dy = load4(state, b) - load4(state, a), load4(state, b + 4) - load4(state, a + 4)
        u, v = half * (load4(state, a + 8) + load4(state, b + 8)), half * (load4(state, a + 12) + load4(state, b + 12))
        force = tangential * magnitude(u * dx + v * dy) + normal * magnitude(v * dx - u * dy)
        store(rate, 4 * i, load4(rate, 4 * i) + force)
        store(rate, 4 * j, load4(rate, 4 * j) + force)
    most = zero
    for i in range(cells):
        now = load4(rate, 4 * i) * four(body.inverse_mass[i])
        most = chosen(now, most, now, most)
    return most


@lean
def keep_start(abreast):
    """Before a control step: no copy has come through it."""
    store(abreast.sound, 0, four(0.0))
    for i in range(0, abreast.state.size, 4):
        store(abreast.start, i, load4(abreast.state, i))


@seam
def advance_abreast(body, law, abreast, control_step):
    """Carry four copies over a control step, in place, each in its number of substeps: see `control_step.advance`.

    Leaves in `abreast.sound` which of them came through: the bits of those, and their rates of drag, are what `advance` gives; how the
    others were is left in `abreast.start`."""
    state, substeps = abreast.state, abreast.substeps
    keep_start(abreast)
    n0, n1, n2, n3 = substeps[0], substeps[1], substeps[2], substeps[3]
    steps = four(float(n0), float(n1), float(n2), float(n3))
    h, zero, sound = four(control_step) / steps, four(0.0), four(1.0)
    for k in range(max(n0, n1, n2, n3)):
        _substep(body, law, abreast, h, steps, float(k))
        sound = chosen(_surely_sound(body, h, state), zero, sound, zero)
    rate = zero
    if law.drag_normal != 0.0 or law.drag_tangential != 0.0:
        rate = _drag_rate(body, law, state, abreast.k1)
    store(abreast.sound, 0, chosen(h * rate, four(STABLE_DRAG), zero, sound))
    store(abreast.rate, 0, rate)
    for lane in range(COPIES):
        if abreast.of[lane] != lane:
            abreast.sound[lane] = 0.0
