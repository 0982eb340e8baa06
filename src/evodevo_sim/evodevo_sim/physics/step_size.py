"""How many steps an interval takes: all policies that choose them, from the upper bounds in `bounds`.

    choose_substeps, substeps_at_rate    a swimmer's control step by Lawson's method: at rest, then by the drag that it has come to
    choose_walk_steps                    a walker's control step by symplectic Euler
    choose_steps                         any interval by any method, for bodies of one's own
    ladder                               (a module) twice as many, where an interval came out unsound

Stable steps follow from the highest frequency w, rad/s, and the strongest damping m, 1/s, of x'' = -w^2 x - m x':
h^2 w^2 + 2 h m < 4 for Euler, h^2 w^2 + 4 h m < 4 for Verlet and h max(w, m) < 2.61 for RK4 (2.83 without damping).  They hold
for any body, since each method leads to one polynomial eigenvalue problem in the stiffness and the damping matrix, both symmetric.
"""

from __future__ import annotations

import numpy as np

from ..kernels.jit import kernel, lean
from .bounds import bounds, damping_bound, drag_rate, find_drag_rate, frequency_bound

INTEGRATORS = ("euler", "verlet", "rk4", "adaptive")
EULER, VERLET, RK4, ADAPTIVE, LAWSON = range(5)  # the last is that of swimmers, see `control_step`

# Lawson's method is stable to h * rate = 5.6 in pure damping, and to 3.2 where a damped body turns.  Its errors are small to 1.5 in the
# body's own frequency and damping, at rest, and to 4.8 in the bound of the rate of drag, which grows with speed (docs/reference/model.md).
ACCURATE_REST = 1.5
ACCURATE_DRAG = 4.8
_UNDAMPED = 0.3  # h * frequency up to which what nothing damps does not grow in a life: by 6e-4 (h w)^6 a step
_DAMPED = 100.0  # (h w)^4 h / (damping over stiffness) up to which springs damp more than that, a quarter of the most on springs alone
MOST_SUBSTEPS = 1000  # in a control step; a body that needs more would keep everybody waiting for hours
ACCURATE_EULER = 1.6  # h * (bound of the highest frequency), of a walker
LEAST_EULER = 4  # steps of a walker in a control step, for contact
_SAFETY = 0.8  # of the stability limit
_RK4_LIMIT = 2.61  # the least |z| on the edge of RK4's stability region, in the left half plane
_DRAG_LIMIT = 0.5  # h * rate of drag, far below the 4 at which explicit drag overshoots for good
_PHASE_LIMIT = 0.5  # rad of the fastest muscle in a step
_LEAST = (4, 4, 1)  # steps an interval, for accuracy where the body is soft


@kernel
def choose_substeps(body, law, control_step):
    """Substeps of Lawson's method in a control step that a body takes at rest, by its bounds of frequency and damping."""
    frequency, damping = frequency_bound(body, law), damping_bound(body, law)
    need = control_step * max(frequency, damping) / ACCURATE_REST
    calm = control_step * frequency / _UNDAMPED
    if law.damping > 0.0:
        springs = law.damping / (law.stiffness + law.pressure)
        calm = min(calm, (frequency**4 * control_step**5 / (_DAMPED * springs)) ** 0.2)
    return max(1, int(np.ceil(min(max(need, calm), 1e9))))


@lean
def substeps_in_drag(body, law, position, velocity, control_step, substeps, scratch):
    """Substeps in the next control step, from those at rest and the drag at this velocity."""
    find_drag_rate(body, law, position, velocity, scratch)
    return substeps_at_rate(control_step, substeps, scratch)


@lean
def substeps_at_rate(control_step, substeps, scratch):
    """The same for a rate of drag that scratch holds already."""
    need = control_step * scratch.rate[0] / ACCURATE_DRAG
    if need > substeps:
        return int(np.ceil(min(need, MOST_SUBSTEPS)))
    return substeps


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


@kernel
def choose_walk_steps(system, control_step):
    """Steps of Euler in a control step on the ground: numbers of accuracy, and of stability where damping is strong."""
    frequency, damping = bounds(system)
    need = max(control_step * frequency / ACCURATE_EULER, control_step / (_SAFETY * longest_step(EULER, frequency, damping)))
    return max(LEAST_EULER, int(np.ceil(need)))
