"""Integration of a body's motion by name, with rest lengths held or driven (paper sections 2.3 and 4).

    euler      symplectic Euler, order 1; the only one that meets the ground, by projection of velocities (section 4.1)
    verlet     velocity Verlet, order 2; damping and drag see the predicted velocity v + h a
    rk4        the classical Runge-Kutta method, order 4
    lawson     Lawson's of order 5, with an extended region of stability: that of swimmers (`control_step`), in which audits repeat them
    adaptive   the pair 5(4) of Dormand and Prince, which chooses its own steps.  On a swimmer of 64 cells it beats Bogacki and
               Shampine's 3(2) from 8 force evaluations a control step on: 7e-6 against 4e-6 m after 5 s, at 200 by 8 times

Steps come from `step_size`.  States are (2, N), as in `physics`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..development.body import Body
from ..kernels.jit import lean, seam
from .contact import meet, meet_flat, meet_tips
from .energy import add_muscle_power, add_power, resistances
from .forces import Law, Scratch, accelerations, make_scratch, set_rest_lengths
from .grounded_steps import alike_in, are_alike, go_alike
from .ladder import copy_state
from .soundness import SOUND, UNSTABLE, is_sound
from .step_size import EULER, LAWSON, VERLET
from .terrain import FLAT, Terrain, touches

_SLOWEST = 1e-9  # of an interval: an adaptive step below this has failed
_MOST_TRIES = 100_000  # of adaptive steps in an interval


class System(NamedTuple):
    """What moves a body: its own laws, the world around it, and its muscles: e - c = amplitude sin(2 pi frequency t + phase), or rest
    lengths that are held, or that go evenly from one to another."""

    body: Body
    law: Law
    gravity: float  # m/s^2, downward
    friction: float  # Coulomb's coefficient
    ground: bool  # whether the terrain is solid
    terrain: Terrain
    amplitude: np.ndarray  # (N,), or empty: rest lengths are held
    frequency: np.ndarray  # (N,) Hz, or empty
    phase: np.ndarray  # (N,) rad, or empty
    muscle: np.ndarray  # (N,) of e - c: scratch
    rest: np.ndarray  # (E,) m, rest lengths: held, or scratch
    before: np.ndarray  # (E,) m, rest lengths at t = 0, or empty: they do not go from one to another
    after: np.ndarray  # (E,) m, at t = `seconds`
    seconds: float


class State(NamedTuple):
    """What an integration changes, in place."""

    position: np.ndarray  # (2, N) m
    velocity: np.ndarray  # (2, N) m/s
    ledger: np.ndarray  # (4,) J, added to: see `energy`; or empty


class Work(NamedTuple):
    """Scratch of all methods."""

    scratch: Scratch
    slope_p: np.ndarray  # (7, 2, N) m/s: slopes of position at up to seven stages
    slope_v: np.ndarray  # (7, 2, N) m/s^2: slopes of velocity
    power: np.ndarray  # (4,) J: the ledger of a step that may still be refused


# Butcher's arrays, lower triangles row by row with the weights last: (nodes, coefficients, weights, error weights).
_CLASSICAL = (
    np.array([0.0, 0.5, 0.5, 1.0]),
    np.array([[0.0, 0.0, 0.0], [0.5, 0.0, 0.0], [0.0, 0.5, 0.0], [0.0, 0.0, 1.0]]),
    np.array([1 / 6, 1 / 3, 1 / 3, 1 / 6]),
    np.zeros(4),
)
_LAWSON = (
    np.array([0.0, 0.5, 0.25, 0.5, 0.75, 1.0]),
    np.array([
        [0.0, 0.0, 0.0, 0.0, 0.0], [1 / 2, 0.0, 0.0, 0.0, 0.0], [3 / 16, 1 / 16, 0.0, 0.0, 0.0], [0.0, 0.0, 1 / 2, 0.0, 0.0],
        [0.0, -3 / 16, 6 / 16, 9 / 16, 0.0], [1 / 7, 4 / 7, 6 / 7, -12 / 7, 8 / 7],
    ]),
    np.array([7 / 90, 0.0, 32 / 90, 12 / 90, 32 / 90, 7 / 90]),
    np.zeros(6),
)
_DORMAND_PRINCE = (
    np.array([0.0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0, 1.0]),
    np.array([
        [0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [1 / 5, 0.0, 0.0, 0.0, 0.0, 0.0],
        [3 / 40, 9 / 40, 0.0, 0.0, 0.0, 0.0],
        [44 / 45, -56 / 15, 32 / 9, 0.0, 0.0, 0.0],
        [19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729, 0.0, 0.0],
        [9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656, 0.0],
        [35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84],
    ]),
    np.array([35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84, 0.0]),
    np.array([71 / 57600, 0.0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40]),
)


def make_system(body, law, gravity=0.0, friction=0.0, ground=False, drive=None, terrain=FLAT) -> System:
    """A system at zero activation.  Args: drive: (amplitude, frequency, phase), (N,) each, or None: rest lengths are held."""
    cells = len(body.position)
    drive = tuple(np.zeros(0) for _ in range(3)) if drive is None else tuple(np.array(a, np.float64) for a in drive)
    return System(
        body, law, float(gravity), float(friction), bool(ground), terrain, *drive, np.zeros(cells), body.rest_length.astype(np.float64),
        np.zeros(0), np.zeros(0), 1.0,
    )


def make_work(body) -> Work:
    shape = (7, 2, len(body.position))
    return Work(make_scratch(body), np.zeros(shape), np.zeros(shape), np.zeros(4))


@lean
def set_muscles(system, t):
    """Rest lengths at time t, where they are not held."""
    if system.amplitude.size:
        for i in range(system.amplitude.size):
            turn = 2.0 * np.pi * system.frequency[i] * t + system.phase[i]
            system.muscle[i] = system.amplitude[i] * np.sin(turn)
        set_rest_lengths(system.body, system.law, system.muscle, system.rest)
    elif system.before.size:
        share = t / system.seconds
        for e in range(system.rest.size):
            system.rest[e] = system.before[e] + share * (system.after[e] - system.before[e])


@lean
def _accelerate(system, position, velocity, scratch, out):
    accelerations(system.body, system.law, system.rest, position, velocity, scratch, out)
    if system.gravity != 0.0:
        for i in range(out.shape[1]):
            out[1, i] -= system.gravity


@lean
def _count(mass, h, before, freely, after, drag, damping, ledger):
    """A cell's share of the ledger of a step between two velocities (x, y), of which the later would have been `freely` without contact."""
    mx, my = 0.5 * (before[0] + after[0]), 0.5 * (before[1] + after[1])
    ledger[1] += h * mass * (drag[0] * mx + drag[1] * my)
    ledger[2] += h * mass * (damping[0] * mx + damping[1] * my)
    ledger[3] += mass * ((after[0] - freely[0]) * mx + (after[1] - freely[1]) * my)


@lean
def euler(system, t, h, position, velocity, work, ledger):
    """One symplectic step: velocities first, then what would pass the ground is put on it: see `contact`.

    Any ground, any ledger; `grounded_steps` takes many steps in less time where cells move alike.
    Its ledger counts the work of every force and push by the mean of the velocities before and after the step, so that the gain
    of kinetic energy is its sum exactly, and what rests on the ground takes and gives nothing.
    """
    a, x, y, u, v = work.slope_v[0], position[0], position[1], velocity[0], velocity[1]
    terrain, flat, ground = system.terrain, system.terrain.x.size == 0, system.ground
    drag, damping, before, speed = work.scratch.k1, work.scratch.k2, work.scratch.k3, work.scratch.k4
    tips = ground and (terrain.tip_x.size > 0 or terrain.ceiling_tip_x.size > 0)
    set_muscles(system, t)
    if ledger.size:
        add_muscle_power(system, t, position, 0.5 * h, ledger)
        resistances(system, position, velocity, work.scratch, drag, damping)
    _accelerate(system, position, velocity, work.scratch, a)
    if tips:
        copy_state(position, velocity, before, speed)
    for i in range(x.size):
        vx, vy = u[i] + h * a[0, i], v[i] + h * a[1, i]
        freely_x, freely_y = vx, vy
        there = y[i] + h * vy
        if ground and flat and there < 0.0:
            vx, vy, slip = meet_flat(system.friction, h, y[i], vx, vy)
            x[i] += slip
            x[i] += h * vx
            y[i] = 0.0
        elif ground and not flat and (there < terrain.top or there > terrain.bottom):
            x[i], y[i], vx, vy = meet(terrain, system.friction, h, x[i], y[i], vx, vy)
        else:
            y[i] += h * vy
            x[i] += h * vx
        if ledger.size and not tips:
            mass = 1.0 / system.body.inverse_mass[i]
            _count(mass, h, (u[i], v[i]), (freely_x, freely_y), (vx, vy), drag[:, i], damping[:, i], ledger)
        u[i], v[i] = vx, vy
    if tips:
        meet_tips(terrain, system.friction, h, system.body, before, position, velocity)
        for i in range(x.size if ledger.size else 0):
            mass, ux, uy = 1.0 / system.body.inverse_mass[i], speed[0, i], speed[1, i]
            freely_x, freely_y = ux + h * a[0, i], uy + h * a[1, i]
            _count(mass, h, (ux, uy), (freely_x, freely_y), (u[i], v[i]), drag[:, i], damping[:, i], ledger)
    if ledger.size:
        set_muscles(system, t + h)
        add_muscle_power(system, t + h, position, 0.5 * h, ledger)


@lean
def _shift(system, t, seconds, position, velocity, work):
    """Velocities `seconds` later by present accelerations, but for what the ground holds: contacts across it, and by friction."""
    a, x, y, u, v = work.slope_v[0], position[0], position[1], velocity[0], velocity[1]
    flat = system.terrain.x.size == 0
    set_muscles(system, t)
    _accelerate(system, position, velocity, work.scratch, a)
    for i in range(y.size):
        free = y[i] != 0.0 or v[i] > 0.0 if flat else not touches(system.terrain, x[i], y[i])
        if free or (flat and system.friction == 0.0):
            u[i] += seconds * a[0, i]
        if free:
            v[i] += seconds * a[1, i]


@lean
def _verlet(system, t, h, position, velocity, work, ledger):
    """One step; slope_v[0] holds the acceleration at its start, and at its end that of the next."""
    a, after, predicted = work.slope_v[0], work.slope_v[1], work.scratch.velocity
    if ledger.size:
        set_muscles(system, t)
        add_power(system, t, position, velocity, 0.5 * h, work.scratch, ledger)
    for x in range(2):
        for i in range(position.shape[1]):
            position[x, i] += h * (velocity[x, i] + 0.5 * h * a[x, i])
            predicted[x, i] = velocity[x, i] + h * a[x, i]
    set_muscles(system, t + h)
    _accelerate(system, position, predicted, work.scratch, after)
    for x in range(2):
        for i in range(position.shape[1]):
            velocity[x, i] += 0.5 * h * (a[x, i] + after[x, i])
            a[x, i] = after[x, i]
    if ledger.size:
        add_power(system, t + h, position, velocity, 0.5 * h, work.scratch, ledger)


@lean
def _stages(system, t, h, first, state, work, tableau):
    """Slopes at every stage from `first` on of an explicit Runge-Kutta step, and the stages' share of the ledger."""
    position, velocity, ledger = state.position, state.velocity, state.ledger
    node, coefficient, weight = tableau[0], tableau[1], tableau[2]
    p, v, slope_p, slope_v = work.scratch.position, work.scratch.velocity, work.slope_p, work.slope_v
    for s in range(first, node.size):
        for x in range(2):
            for i in range(position.shape[1]):
                dp, dv = 0.0, 0.0
                for r in range(s):
                    dp += coefficient[s, r] * slope_p[r, x, i]
                    dv += coefficient[s, r] * slope_v[r, x, i]
                p[x, i] = position[x, i] + h * dp
                v[x, i] = velocity[x, i] + h * dv
                slope_p[s, x, i] = v[x, i]
        if s == 0 or node[s] != node[s - 1]:
            set_muscles(system, t + node[s] * h)
        if ledger.size:
            add_power(system, t + node[s] * h, p, v, h * weight[s], work.scratch, ledger)
        _accelerate(system, p, v, work.scratch, slope_v[s])


@lean
def _combine(h, weight, position, velocity, work):
    for x in range(2):
        for i in range(position.shape[1]):
            dp, dv = 0.0, 0.0
            for s in range(weight.size):
                dp += weight[s] * work.slope_p[s, x, i]
                dv += weight[s] * work.slope_v[s, x, i]
            position[x, i] += h * dp
            velocity[x, i] += h * dv


@seam
def carry(system, method, t, seconds, steps, state, work, watched=False):
    """Carry a state from time t over an interval in equal steps, in place.

    Args:
        method: EULER, VERLET, RK4 or LAWSON; only Euler knows the ground.  There its velocities are those of the middles of steps and
            are shifted to the ends of the interval, so that free fall is exact and what rests has no speed.
        watched: whether to look at every step's outcome, and to stop at the first that is not sound.

    Returns: SOUND, or what was wrong.
    """
    position, velocity, ledger = state.position, state.velocity, state.ledger
    h, outcome = seconds / steps, SOUND
    if system.ground:
        _shift(system, t, -0.5 * h, position, velocity, work)
    if method == VERLET:
        set_muscles(system, t)
        _accelerate(system, position, velocity, work.scratch, work.slope_v[0])
    single = watched or system.amplitude.size > 0
    for step in range(steps):
        now = t + step * h
        if method == EULER and are_alike(system, ledger):
            set_muscles(system, now)
            go_alike(alike_in(system, work.scratch), h, 1 if single else steps, position, velocity)
            if not single:
                break
        elif method == EULER:
            euler(system, now, h, position, velocity, work, ledger)
        elif method == VERLET:
            _verlet(system, now, h, position, velocity, work, ledger)
        elif method == LAWSON:
            _stages(system, now, h, 0, state, work, _LAWSON)
            _combine(h, _LAWSON[2], position, velocity, work)
        else:
            _stages(system, now, h, 0, state, work, _CLASSICAL)
            _combine(h, _CLASSICAL[2], position, velocity, work)
        if watched:
            outcome = is_sound(system, method, position, velocity, h, work)
            if outcome != SOUND:
                break
    if system.ground:
        _shift(system, t + seconds, 0.5 * h, position, velocity, work)
    return outcome


@seam
def carry_adaptively(system, t, seconds, tolerance, h, state, work):
    """Carry a state over an interval in steps whose estimated error stays below a tolerance, in place.

    Args: tolerance: most error of a step, in m for every coordinate and in m/s for every speed; h: first step to try, s.

    Returns: (SOUND or UNSTABLE, where steps got too small or too many; next step to try; force evaluations).
    """
    position, velocity, ledger = state.position, state.velocity, state.ledger
    tried = State(position, velocity, work.power[: ledger.size])
    done, used, first, tries = 0.0, 0, 0, 0
    error_weight = _DORMAND_PRINCE[3]
    last = error_weight.size - 1
    while done < seconds:
        step = min(h, seconds - done)
        if seconds - done - step < _SLOWEST * seconds:
            step = seconds - done
        for k in range(ledger.size):
            work.power[k] = 0.0
        _stages(system, t + done, step, first, tried, work, _DORMAND_PRINCE)
        used += last + 1 - first
        first = 0 if ledger.size else 1
        error = 0.0
        for x in range(2):
            for i in range(position.shape[1]):
                dp, dv = 0.0, 0.0
                for s in range(error_weight.size):
                    dp += error_weight[s] * work.slope_p[s, x, i]
                    dv += error_weight[s] * work.slope_v[s, x, i]
                larger = max(abs(dp), abs(dv))
                error = max(error, larger) if larger >= 0.0 else np.inf  # a NaN compares false
        error *= step / tolerance
        if error <= 1.0:
            _combine(step, _DORMAND_PRINCE[2], position, velocity, work)
            done = done + step if step < seconds - done else seconds
            for k in range(ledger.size):
                ledger[k] += work.power[k]
            # The last stage is the first of the next step.
            copy_state(work.slope_p[last], work.slope_v[last], work.slope_p[0], work.slope_v[0])
        factor = 5.0 if error == 0.0 else min(5.0, max(0.2, 0.9 * error**-0.2))
        if error > 1.0 or step == h or factor < 1.0:
            h = step * factor
        tries += 1
        if h < _SLOWEST * seconds or tries > _MOST_TRIES:
            return UNSTABLE, h, used
    return SOUND, h, used
