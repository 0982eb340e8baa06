"""Energies of a body, and a ledger of the work done on it, in J (paper sections 2.3 and 4.2).

Stored: kinetic; elastic, sum of k/2 (l - L)^2; of chambers, sum of c_p (S0 - S)^2 / (2 S0); of gravity, sum of m g y.
The ledger holds work done on the body: by muscles, by drag, by damping and by the ground; the last three never add energy.
Stored energy changes by just their sum, up to the error of the integration.  States are (2, N), as in `physics`.
"""

from __future__ import annotations

import numpy as np

from ..kernels.jit import lean
from .forces import accelerations, damping_alone, drag_alone, face_area

LEDGER = ("muscle", "drag", "damping", "ground")


@lean
def stored_energy(body, law, rest, gravity, position, velocity):
    """(kinetic, elastic, chamber, gravitational) energy, J.  Args: rest (E,) m; position, velocity (2, N)."""
    x, y, u, v = position[0], position[1], velocity[0], velocity[1]
    start, end, corner = body.spring_a, body.spring_b, body.polygon_cell
    kinetic, elastic, chamber, potential = 0.0, 0.0, 0.0, 0.0
    for i in range(x.size):
        mass = 1.0 / body.inverse_mass[i]
        kinetic += 0.5 * mass * (u[i] ** 2 + v[i] ** 2)
        potential += mass * gravity * y[i]
    for e in range(rest.size):
        i, j = start[e], end[e]
        elastic += 0.5 * law.stiffness * (np.sqrt((x[j] - x[i]) ** 2 + (y[j] - y[i]) ** 2) - rest[e]) ** 2
    for t in range(body.triangle_area.size):
        area = body.triangle_area[t]
        chamber += 0.5 * law.pressure * (area - face_area(body.triangle[t], 0, 3, x, y)) ** 2 / area
    for p in range(body.polygon_area.size):
        area = body.polygon_area[p]
        now = face_area(corner, body.polygon_start[p], body.polygon_start[p + 1], x, y)
        chamber += 0.5 * law.pressure * (area - now) ** 2 / area
    return kinetic, elastic, chamber, potential


@lean
def least_chamber(body, position):
    """(least S / S0 of any chamber, its number: triangles first, then polygons); (1.0, -1) where there is none."""
    x, y, corner = position[0], position[1], body.polygon_cell
    least, where = np.inf, -1
    for t in range(body.triangle_area.size):
        share = face_area(body.triangle[t], 0, 3, x, y) / body.triangle_area[t]
        if share < least:
            least, where = share, t
    for p in range(body.polygon_area.size):
        now = face_area(corner, body.polygon_start[p], body.polygon_start[p + 1], x, y)
        share = now / body.polygon_area[p]
        if share < least:
            least, where = share, body.triangle_area.size + p
    return (least, where) if where >= 0 else (1.0, -1)


@lean
def add_muscle_power(system, t, position, seconds, ledger):
    """Add `seconds` times the present power of muscles that move to a ledger (4,).  Args: as for `add_power`."""
    body, law = system.body, system.law
    driven, going = system.amplitude.size > 0, system.before.size > 0
    if driven or going:
        x, y, power = position[0], position[1], 0.0
        for e in range(system.rest.size):
            i, j = body.spring_a[e], body.spring_b[e]
            length = np.sqrt((x[j] - x[i]) ** 2 + (y[j] - y[i]) ** 2)
            if driven:
                speed = law.muscle_range * (_muscle_speed(system, i, t) + _muscle_speed(system, j, t)) * body.rest_length[e]
            else:
                speed = (system.after[e] - system.before[e]) / system.seconds
            power -= law.stiffness * (length - system.rest[e]) * speed
        ledger[0] += seconds * power


@lean
def add_power(system, t, position, velocity, seconds, scratch, ledger):
    """Add `seconds` times the present power of muscles, drag and damping to a ledger (4,).

    Args: system: see `integrators.System`, its rest lengths those of time t; scratch: see `forces.Scratch`, whose k1 is used.
    """
    body, law = system.body, system.law
    add_muscle_power(system, t, position, seconds, ledger)
    if law.drag_normal != 0.0 or law.drag_tangential != 0.0:
        ledger[1] += seconds * _power(body, drag_alone(law), system.rest, position, velocity, scratch)
    if law.damping != 0.0:
        ledger[2] += seconds * _power(body, damping_alone(law), system.rest, position, velocity, scratch)


@lean
def resistances(system, position, velocity, scratch, drag, damping):
    """Fill drag and damping (2, N) with the accelerations by each alone."""
    law = system.law
    accelerations(system.body, drag_alone(law), system.rest, position, velocity, scratch, drag)
    accelerations(system.body, damping_alone(law), system.rest, position, velocity, scratch, damping)


@lean
def _muscle_speed(system, i, t):
    """The rate of e - c of a cell, 1/s."""
    rate = 2.0 * np.pi * system.frequency[i]
    return system.amplitude[i] * rate * np.cos(rate * t + system.phase[i])


@lean
def _power(body, law, rest, position, velocity, scratch):
    out = scratch.k1
    accelerations(body, law, rest, position, velocity, scratch, out)
    power = 0.0
    for i in range(position.shape[1]):
        power += (out[0, i] * velocity[0, i] + out[1, i] * velocity[1, i]) / body.inverse_mass[i]
    return power
