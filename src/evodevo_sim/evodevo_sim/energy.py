"""Energies of a body, and a ledger of the work done on it, in J (paper sections 2.3 and 4.2).

Stored: kinetic; elastic, sum of k/2 (l - L)^2; of chambers, sum of c_p (S0 - S)^2 / (2 S0); of gravity, sum of m g y.
The ledger holds work done on the body: by muscles, by drag, by damping and by the ground; the last three never add energy.
Stored energy changes by just their sum, up to the error of the integration.
"""

from __future__ import annotations

import numpy as np

from ._jit import kernel
from .physics import Law, _polygon_area, accelerations

LEDGER = ("muscle", "drag", "damping", "ground")


@kernel
def stored_energy(body, law, rest, gravity, position, velocity):
    """(kinetic, elastic, chamber, gravitational) energy, J.  Args: rest (E,) m; position, velocity (N, 2)."""
    kinetic, elastic, chamber, potential = 0.0, 0.0, 0.0, 0.0
    for i in range(position.shape[0]):
        mass = 1.0 / body.inverse_mass[i]
        kinetic += 0.5 * mass * (velocity[i, 0] ** 2 + velocity[i, 1] ** 2)
        potential += mass * gravity * position[i, 1]
        for e in range(body.spring_start[i], body.spring_start[i + 1]):
            j = body.spring_end[e]
            length = np.sqrt((position[j, 0] - position[i, 0]) ** 2 + (position[j, 1] - position[i, 1]) ** 2)
            elastic += 0.5 * law.stiffness * (length - rest[e]) ** 2
    for t in range(body.triangle_area.size):
        chamber += _chamber_energy(body.triangle[t], body.triangle_area[t], law.pressure, position)
    for f in range(body.polygon_area.size):
        corner = body.polygon_cell[body.polygon_start[f] : body.polygon_start[f + 1]]
        chamber += _chamber_energy(corner, body.polygon_area[f], law.pressure, position)
    return kinetic, elastic, chamber, potential


@kernel
def _chamber_energy(corner, area, pressure, position):
    return 0.5 * pressure * (area - _polygon_area(corner, position)) ** 2 / area


@kernel
def least_chamber(body, position):
    """(least S / S0 of any chamber, its number: triangles first, then polygons); (1.0, -1) where there is none."""
    least, where = np.inf, -1
    for t in range(body.triangle_area.size):
        share = _polygon_area(body.triangle[t], position) / body.triangle_area[t]
        if share < least:
            least, where = share, t
    for f in range(body.polygon_area.size):
        corner = body.polygon_cell[body.polygon_start[f] : body.polygon_start[f + 1]]
        share = _polygon_area(corner, position) / body.polygon_area[f]
        if share < least:
            least, where = share, body.triangle_area.size + f
    return (least, where) if where >= 0 else (1.0, -1)


@kernel
def add_power(system, t, position, velocity, seconds, scratch, ledger):
    """Add `seconds` times the present power of muscles, drag and damping to a ledger (4,).

    Args: system: see `integrators.System`, its rest lengths those of time t; scratch (N, 2).
    """
    body, law = system.body, system.law
    if system.amplitude.size:
        power = 0.0
        for i in range(position.shape[0]):
            own = _muscle_speed(system, i, t)
            for e in range(body.spring_start[i], body.spring_start[i + 1]):
                j = body.spring_end[e]
                length = np.sqrt((position[j, 0] - position[i, 0]) ** 2 + (position[j, 1] - position[i, 1]) ** 2)
                speed = 0.2 * (own + _muscle_speed(system, j, t)) * body.rest_length[e]
                power -= law.stiffness * (length - system.rest[e]) * speed
        ledger[0] += seconds * power
    if law.drag_normal != 0.0 or law.drag_tangential != 0.0:
        drag = Law(0.0, 0.0, 0.0, law.drag_normal, law.drag_tangential)
        ledger[1] += seconds * _power(body, drag, system.rest, position, velocity, scratch)
    if law.damping != 0.0:
        ledger[2] += seconds * _power(body, Law(0.0, law.damping, 0.0, 0.0, 0.0), system.rest, position, velocity, scratch)


@kernel
def _muscle_speed(system, i, t):
    """The rate of e - c of a cell, 1/s."""
    rate = 2.0 * np.pi * system.frequency[i]
    return system.amplitude[i] * rate * np.cos(rate * t + system.phase[i])


@kernel
def _power(body, law, rest, position, velocity, scratch):
    accelerations(body, law, rest, position, velocity, scratch)
    power = 0.0
    for i in range(position.shape[0]):
        power += (scratch[i, 0] * velocity[i, 0] + scratch[i, 1] * velocity[i, 1]) / body.inverse_mass[i]
    return power
