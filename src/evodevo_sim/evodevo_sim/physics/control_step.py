"""The motion of a body (paper sections 2.3 and 4.2): one control step, and rest.

The one interface: `advance` carries a state (position, velocity) over a control step with rest lengths held, and says whether
the outcome is sound.  Forces stand in `forces`, what is sound in `soundness`, the choice of steps in `step_size`, other methods
and the ground in `integrators`.
"""

from __future__ import annotations

from ..kernels.jit import inlined, kernel, seam
from ..kernels.vectors import four, load4_within, store4_within
from .bounds import find_drag_rate, frequency_bound
from .forces import accelerate, accelerations, pack, pack_ahead, undamped
from .ladder import MOST_DOUBLINGS, Ladder, again, remember
from .soundness import SOUND, STABLE_DRAG, UNSTABLE, check, surely_sound
from .step_size import MOST_SUBSTEPS


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


@seam
def advance(body, law, rest, position, velocity, control_step, substeps, scratch):
    """Carry a state over one control step, in place; where that fails, again with twice the substeps: see `ladder`.

    Returns: SOUND, or what was wrong with the finest try; if SOUND, scratch holds the rate of drag that is reached.
    """
    ladder, no_ledger = Ladder(MOST_DOUBLINGS, MOST_SUBSTEPS), scratch.start_ledger[:0]
    remember(position, velocity, no_ledger, scratch)
    outcome, doubling, steps = SOUND, 0, substeps
    pack(position, velocity, scratch.state)
    while True:
        h = control_step / steps
        for _ in range(steps):
            _runge_kutta(body, law, rest, position, velocity, h, scratch)
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
