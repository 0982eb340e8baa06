"""The motion of a body (paper sections 2.3 and 4.2): one control step, and rest.

The one interface: `advance` carries a state (position, velocity) over a control step, in which rest lengths go evenly from those
before it to those after it, and says whether the outcome is sound.  Forces stand in `forces`, what is sound in `soundness`, the
choice of steps in `step_size`, other methods and the ground in `integrators`.
"""

from __future__ import annotations

from ..kernels.jit import inlined, kernel, seam
from ..kernels.vectors import four, load4_within, store4_within
from .bounds import find_drag_rate, frequency_bound
from .forces import Ramp, accelerate, accelerations, pack, put, undamped
from .ladder import MOST_DOUBLINGS, Ladder, again, remember
from .soundness import SOUND, STABLE_DRAG, UNSTABLE, check, surely_sound
from .step_size import MOST_SUBSTEPS

# J. D. Lawson, "An order five Runge-Kutta process with extended region of stability", SIAM J. Numer. Anal. 3 (1966): six stages, nodes
# 0, 1/2, 1/4, 1/2, 3/4, 1.  Forces depend on positions at each stage, which are sums of accelerations, too: of the products of its matrix.
NODES = (0.0, 0.5, 0.25, 0.5, 0.75, 1.0)


@inlined
def _pack_stage(position, velocity, h, stage, scratch):
    """Pack the state of a stage from the second on: x + h c v + h^2 sum(p k), v + h sum(a k), of the accelerations k so far."""
    ahead, square = four(h * NODES[stage]), h * h
    if stage == 1:
        none, half = four(0.0), four(h / 2)
        for i in range(0, position.shape[1], 4):
            x, y = _four(scratch.k1, i)
            _pack_four(position, velocity, ahead, i, (none, none), (half * x, half * y), scratch.state)
    elif stage == 2:
        p, a, three = four(square / 32), four(h / 16), four(3.0)
        for i in range(0, position.shape[1], 4):
            (x1, y1), (x2, y2) = _four(scratch.k1, i), _four(scratch.k2, i)
            _pack_four(position, velocity, ahead, i, (p * x1, p * y1), (a * (three * x1 + x2), a * (three * y1 + y2)), scratch.state)
    elif stage == 3:
        p, a, three = four(square / 32), four(h / 2), four(3.0)
        for i in range(0, position.shape[1], 4):
            (x1, y1), (x2, y2), (x3, y3) = _four(scratch.k1, i), _four(scratch.k2, i), _four(scratch.k3, i)
            _pack_four(position, velocity, ahead, i, (p * (three * x1 + x2), p * (three * y1 + y2)), (a * x3, a * y3), scratch.state)
    elif stage == 4:
        for i in range(0, position.shape[1], 4):
            dx, du = _fifth(h, scratch, 0, i)
            dy, dv = _fifth(h, scratch, 1, i)
            _pack_four(position, velocity, ahead, i, (dx, dy), (du, dv), scratch.state)
    else:
        for i in range(0, position.shape[1], 4):
            dx, du = _sixth(h, scratch, 0, i)
            dy, dv = _sixth(h, scratch, 1, i)
            _pack_four(position, velocity, ahead, i, (dx, dy), (du, dv), scratch.state)


@inlined
def _four(array, i):
    return load4_within(array[0], i), load4_within(array[1], i)


@inlined
def _pack_four(position, velocity, ahead, i, moved, faster, state):
    (x, y), (u, v) = _four(position, i), _four(velocity, i)
    put(state, i, x + ahead * u + moved[0], y + ahead * v + moved[1], u + faster[0], v + faster[1])


@inlined
def _fifth(h, scratch, axis, i):
    k1, k2 = load4_within(scratch.k1[axis], i), load4_within(scratch.k2[axis], i)
    k3, k4 = load4_within(scratch.k3[axis], i), load4_within(scratch.k4[axis], i)
    return four(h * h * 3 / 128) * (k2 - k1 + four(12.0) * k3), four(h * 3 / 16) * (four(2.0) * k3 - k2 + four(3.0) * k4)


@inlined
def _sixth(h, scratch, axis, i):
    k1, k2, k3 = load4_within(scratch.k1[axis], i), load4_within(scratch.k2[axis], i), load4_within(scratch.k3[axis], i)
    k4, k5 = load4_within(scratch.k4[axis], i), load4_within(scratch.k5[axis], i)
    return (
        four(h * h / 56) * (four(25.0) * k1 - four(9.0) * k2 - four(24.0) * k3 + four(36.0) * k4),
        four(h / 7) * (k1 + four(4.0) * k2 + four(6.0) * k3 - four(12.0) * k4 + four(8.0) * k5),
    )


@inlined
def _substep(body, law, ramp, position, velocity, h, steps, scratch):
    """One of so many steps of Lawson's fifth-order method, in place, of a state that is packed before and after."""
    for stage in range(6):
        slope = scratch.k1
        if stage == 1:
            slope = scratch.k2
        elif stage == 2:
            slope = scratch.k3
        elif stage == 3:
            slope = scratch.k4
        elif stage == 4:
            slope = scratch.k5
        elif stage == 5:
            slope = scratch.k6
        if stage > 0:
            _pack_stage(position, velocity, h, stage, scratch)
        accelerate(body, law, Ramp(ramp.before, ramp.after, ramp.share + NODES[stage] / steps), scratch, slope)
    whole, square, share = four(h), four(h * h / 90), four(h / 90)
    for a in range(2):
        x, v = position[a], velocity[a]
        for i in range(0, x.size, 4):
            k1, k3, k4 = load4_within(scratch.k1[a], i), load4_within(scratch.k3[a], i), load4_within(scratch.k4[a], i)
            k5, k6, before = load4_within(scratch.k5[a], i), load4_within(scratch.k6[a], i), load4_within(v, i)
            seven, eight = four(7.0) * k1, four(8.0) * k5
            after = load4_within(x, i) + whole * before + square * (seven + four(24.0) * k3 + four(6.0) * k4 + eight)
            store4_within(x, i, after)
            store4_within(v, i, before + share * (seven + four(32.0) * k3 + four(12.0) * k4 + four(32.0) * k5 + four(7.0) * k6))
    pack(position, velocity, scratch.state)


@seam
def advance(body, law, ramp, position, velocity, control_step, substeps, scratch):
    """Carry a state over one control step, in place; where that fails, again with twice the substeps: see `ladder`.

    Args: ramp: rest lengths (E,) before and after it, m, and a share of 0.

    Returns: SOUND, or what was wrong with the finest try; if SOUND, scratch holds the rate of drag that is reached.
    """
    ladder, no_ledger = Ladder(MOST_DOUBLINGS, MOST_SUBSTEPS), scratch.start_ledger[:0]
    remember(position, velocity, no_ledger, scratch)
    outcome, doubling, steps = SOUND, 0, substeps
    pack(position, velocity, scratch.state)
    while True:
        h = control_step / steps
        for step in range(steps):
            _substep(body, law, Ramp(ramp.before, ramp.after, step / steps), position, velocity, h, steps, scratch)
            outcome = SOUND if surely_sound(body, position, velocity, h, scratch) else check(body, position, velocity, h)
            if outcome != SOUND:
                break
        if outcome == SOUND:
            find_drag_rate(body, law, position, velocity, scratch)
            if h * scratch.rate[0] > STABLE_DRAG:
                outcome = UNSTABLE  # it sped up so much that drag may have overshot
        if not again(outcome, doubling, steps, ladder, position, velocity, no_ledger, scratch):
            return outcome
        doubling, steps = doubling + 1, 2 * steps
        pack(position, velocity, scratch.state)


@kernel
def relax(body, law, rest, position, velocity, tolerance, limit, scratch):
    """Bring a body to rest under its own springs and chambers with rest lengths held, in place, without a world around it.

    Kinetic damping: all speeds are set to 0 whenever the kinetic energy has passed a peak.  Only internal forces act, so the
    centre of mass stays where it is.

    Args: tolerance: largest acceleration, m/s^2, that counts as rest; limit: most steps.  Returns: steps taken.
    """
    alone = undamped(law)
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
