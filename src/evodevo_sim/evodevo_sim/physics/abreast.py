"""Copies of one body that move abreast: each operation of `forces` and of a control step is done for four copies at once, one in each
lane of a vector.  Nothing has to be gathered or turned around, and each copy has the bits that it has alone.

States, from here on down, are (N, 4, 4) laid out flat: of each cell x of the copies, then y, u, v; accelerations (N, 2, 4).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..kernels.jit import inlined, kernel, lean, seam
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
    k1: np.ndarray  # (8 N,) m/s^2, as the next three
    k2: np.ndarray
    k3: np.ndarray
    k4: np.ndarray
    rest: np.ndarray  # (4 E,) m: rest lengths
    inverse_square: np.ndarray  # (4 E,) 1/m^2
    push: np.ndarray  # (4 chambers + 4,) N/m, see `forces.Scratch`
    activation: np.ndarray  # (4 N,)


@kernel
def make_abreast(body):
    cells, springs = padded4(body.position.shape[0]), body.rest_length.size
    chambers = body.triangle_area.size + body.polygon_area.size
    return Abreast(
        of=np.arange(COPIES), substeps=np.ones(COPIES, np.int64), rate=np.zeros(COPIES), sound=np.zeros(COPIES),
        state=np.zeros(16 * cells), start=np.zeros(16 * cells), stage=np.zeros(16 * cells), k1=np.zeros(8 * cells), k2=np.zeros(8 * cells),
        k3=np.zeros(8 * cells), k4=np.zeros(8 * cells), rest=np.zeros(4 * springs), inverse_square=np.zeros(4 * springs),
        push=np.zeros(4 * chambers + 4), activation=np.zeros(4 * cells),
    )


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
def take_rest(abreast, copy, rest):
    """Look at the rest lengths of one copy.  Args: rest (E,): filled."""
    for e in range(rest.size):
        rest[e] = abreast.rest[4 * e + copy]


@lean
def go_along(abreast, lane, copy):
    """Let a lane whose own copy moves no more move another one."""
    abreast.of[lane] = copy
    for values in (abreast.state, abreast.rest):
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
def _pull(body, law, state, abreast, force):
    push, rest, squares = abreast.push, abreast.rest, abreast.inverse_square
    stiffness, damping, one, springs = four(law.stiffness), four(law.damping), four(1.0), body.rest_length.size
    dx, dy, length, growth = _stretch(body, state, 0)
    for e in range(springs):
        dx1, dy1, length1, growth1 = _stretch(body, state, min(e + 1, springs - 1))
        inverse = one / length
        square = inverse * inverse
        store(squares, 4 * e, square)
        pull = stiffness * (one - load4(rest, 4 * e) * inverse) + damping * square * growth
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
def accelerate_abreast(body, law, state, abreast, out):
    """Fill out (8 N,) with the acceleration of every cell of every copy: see `forces.accelerate`."""
    zero, cells = four(0.0), body.inverse_mass.size
    if law.pressure != 0.0:
        _push(body, law, state, abreast.push)
    else:
        for c in range(0, abreast.push.size, 4):
            store(abreast.push, c, zero)
    for i in range(0, 8 * cells, 4):
        store(out, i, zero)
    _pull(body, law, state, abreast, out)
    if law.drag_normal != 0.0 or law.drag_tangential != 0.0:
        _drag(body, law, state, abreast, out)
    for i in range(cells):
        inverse = four(body.inverse_mass[i])
        store(out, 8 * i, load4(out, 8 * i) * inverse)
        store(out, 8 * i + 4, load4(out, 8 * i + 4) * inverse)


@inlined
def _ahead(state, ahead, before, slower, faster, stage):
    """A stage of a Runge-Kutta step: x + ahead (v + before slower), v + ahead faster.  Args: ahead, before: vectors, s."""
    for i in range(0, slower.size // 8):
        for axis in range(0, 8, 4):
            place, k = 16 * i + axis, 8 * i + axis
            v = load4(state, place + 8)
            store(stage, place, load4(state, place) + ahead * (v + before * load4(slower, k)))
            store(stage, place + 8, v + ahead * load4(faster, k))


@inlined
def _runge_kutta(body, law, abreast, h, left):
    """One step of the classical fourth-order Runge-Kutta method, as `control_step` has it, of copies that have steps left.

    Args: h: vector, s; left: vector, more than 0 for such copies."""
    k1, k2, k3, k4, state = abreast.k1, abreast.k2, abreast.k3, abreast.k4, abreast.state
    half, nothing = four(0.5) * h, four(0.0)
    for stage in range(4):
        slope, slower, faster, ahead, before, at = k1, k1, k1, half, nothing, state
        if stage == 1:
            slope = k2
        elif stage == 2:
            slope, faster, before = k3, k2, half
        elif stage == 3:
            slope, slower, faster, ahead, before = k4, k2, k3, h, half
        if stage > 0:
            at = abreast.stage
            _ahead(state, ahead, before, slower, faster, at)
        accelerate_abreast(body, law, at, abreast, slope)
    sixth, double = h / four(6.0), four(2.0)
    for i in range(body.inverse_mass.size):
        for axis in range(0, 8, 4):
            place, k = 16 * i + axis, 8 * i + axis
            first, second, third, last = load4(k1, k), load4(k2, k), load4(k3, k), load4(k4, k)
            x, v = load4(state, place), load4(state, place + 8)
            store(state, place, chosen(left, nothing, x + h * (v + sixth * (first + second + third)), x))
            store(state, place + 8, chosen(left, nothing, v + sixth * (first + double * (second + third) + last), v))


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
        _runge_kutta(body, law, abreast, h, steps - four(float(k)))
        sound = chosen(_surely_sound(body, h, state), zero, sound, zero)
    rate = zero
    if law.drag_normal != 0.0 or law.drag_tangential != 0.0:
        rate = _drag_rate(body, law, state, abreast.k1)
    store(abreast.sound, 0, chosen(h * rate, four(STABLE_DRAG), zero, sound))
    store(abreast.rate, 0, rate)
    for lane in range(COPIES):
        if abreast.of[lane] != lane:
            abreast.sound[lane] = 0.0
