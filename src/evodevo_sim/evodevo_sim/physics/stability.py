"""Steps that are stable, by upper bounds of a body's highest frequency w, rad/s, and strongest damping m, 1/s.

The limits are those of x'' = -w^2 x - m x': h^2 w^2 + 2 h m < 4 for Euler, h^2 w^2 + 4 h m < 4 for Verlet and
h max(w, m) < 2.61 for RK4 (2.83 without damping).  They hold for any body, since each method leads to one polynomial
eigenvalue problem in the stiffness and the damping matrix, both symmetric.
"""

from __future__ import annotations

import numpy as np

from ..kernels.jit import kernel, lean
from .control_step import STABLE_DRAG, UNSTABLE, check
from .rates import damping_bound, drag_rate, frequency_bound

INTEGRATORS = ("euler", "verlet", "rk4", "adaptive")
EULER, VERLET, RK4, ADAPTIVE = range(4)
_SAFETY = 0.8  # of the stability limit
_RK4_LIMIT = 2.61  # the least |z| on the edge of RK4's stability region, in the left half plane
_DRAG_LIMIT = 0.5  # h * rate of drag, far below the 4 at which explicit drag overshoots for good
_MOST_DRAG = 1.0  # the same, that steps of Euler and Verlet may reach which were chosen before a body sped up; RK4: STABLE_DRAG
_PHASE_LIMIT = 0.5  # rad of the fastest muscle in a step
_LEAST = (4, 4, 1)  # steps an interval, for accuracy where the body is soft


@kernel
def bounds(system):
    """Upper bounds of the highest frequency, rad/s, and of the strongest damping by springs, 1/s, at rest."""
    return frequency_bound(system.body, system.law), damping_bound(system.body, system.law)


@lean
def longest_step(method, frequency, damping):
    """The longest stable step of a method, s, by the bounds of frequency and damping."""
    if method == RK4:
        fastest = max(frequency, damping)
        return _RK4_LIMIT / fastest if fastest > 0.0 else np.inf
    weight = 2.0 if method == EULER else 4.0
    fastest = weight * damping + np.sqrt((weight * damping) ** 2 + 16.0 * frequency**2)
    return 8.0 / fastest if fastest > 0.0 else np.inf


@kernel
def choose_steps(system, method, bound, position, velocity, seconds):
    """Steps of a method in an interval that are stable, do not overshoot in drag and resolve the muscles.

    Args: bound: of `bounds`.
    """
    drag = drag_rate(system.body, system.law, position, velocity, np.empty(position.shape[1]))
    need = seconds / (_SAFETY * longest_step(method, bound[0], bound[1] + drag))
    need = max(need, seconds * drag / _DRAG_LIMIT)
    for i in range(system.frequency.size):
        need = max(need, seconds * 2.0 * np.pi * abs(system.frequency[i]) / _PHASE_LIMIT)
    return max(_LEAST[method], int(np.ceil(min(need, 1e9))))


@lean
def is_sound(system, method, position, velocity, h, work):
    """`physics.check` in the frame of the mean velocity, how fast a body travels is no fault; and drag that steps of h can bear."""
    law = system.law
    if law.drag_normal != 0.0 or law.drag_tangential != 0.0:
        most = STABLE_DRAG if method == RK4 else _MOST_DRAG
        if not h * drag_rate(system.body, law, position, velocity, work.scratch.k1[0]) <= most:
            return UNSTABLE
    cells, own = position.shape[1], work.scratch.velocity
    for a in range(2):
        mean = 0.0
        for i in range(cells):
            mean += velocity[a, i] / cells
        for i in range(cells):
            own[a, i] = velocity[a, i] - mean
    return check(system.body, position, own, h)
