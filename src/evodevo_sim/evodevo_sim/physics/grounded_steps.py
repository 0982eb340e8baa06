"""Steps of symplectic Euler where all cells move alike: on flat ground or none, with rest lengths held and no ledger.

They have the bits of `integrators.euler`.  A state stays packed from step to step, and cells move and land four at a time.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..kernels.jit import inlined, seam
from ..kernels.vectors import all_at_most, chosen, chosen_at_least, four, magnitude, negative
from .forces import Law, Plan, exert, pack, pushed, put, taken, unpack
from .ladder import copy_state
from .soundness import surely_sound


class Alike(NamedTuple):
    """What of a system, its body and scratch such steps look at, under the names that those have: a call hands over every array."""

    law: Law
    gravity: float
    friction: float
    ground: bool
    rest: np.ndarray
    rest_length: np.ndarray
    shortest: float
    polygon_cell: np.ndarray
    polygon_start: np.ndarray
    polygon_area: np.ndarray
    plan: Plan
    state: np.ndarray
    inverse_square: np.ndarray
    push: np.ndarray
    force: np.ndarray
    start_position: np.ndarray
    start_velocity: np.ndarray


@inlined
def are_alike(system, ledger):
    """Whether `go_alike` can take the place of `euler`."""
    return not ledger.size and not (system.ground and system.terrain.x.size)


@inlined
def alike_in(system, scratch):
    body = system.body
    return Alike(
        system.law, system.gravity, system.friction, system.ground, system.rest, body.rest_length, body.shortest, body.polygon_cell,
        body.polygon_start, body.polygon_area, scratch.plan, scratch.state, scratch.inverse_square, scratch.push, scratch.force,
        scratch.start_position, scratch.start_velocity,
    )


@inlined
def _land(friction, h, y, u, v):
    """`contact.meet_flat` of four cells: (u, v, what friction moves them along x)."""
    zero, landing = four(0.0), negative(y) / h
    most = friction * (landing - v)
    along, speed = chosen(u, zero, most, negative(most)), magnitude(u)
    return (
        chosen_at_least(most, speed, zero, u - along), landing, chosen_at_least(most, speed, zero, four(0.5) * h * along),
    )


@inlined
def _move(alike, h, cells):
    """Every cell by the forces on it."""
    state, step, zero = alike.state, four(h), four(0.0)
    gravity, friction = four(alike.gravity), four(alike.friction)
    for i in range(0, cells, 4):
        x, y, u, v = taken(state, i)
        ax, ay = pushed(alike, i)
        u, v = u + step * ax, v + step * (ay - gravity)
        there = y + step * v
        if alike.ground and not all_at_most(zero, there):
            landed_u, landed_v, slip = _land(friction, step, y, u, v)
            x, u = chosen(zero, there, x + slip, x), chosen(zero, there, landed_u, u)
            v, there = chosen(zero, there, landed_v, v), chosen(zero, there, zero, there)
        put(state, i, x + step * u, there, u, v)


@seam
def go_alike(alike, h, steps, position, velocity):
    """So many steps of h seconds, in place.  See `are_alike`."""
    pack(position, velocity, alike.state)
    for _ in range(steps):
        exert(alike, alike.law, alike.rest, alike)
        _move(alike, h, position.shape[1])
    unpack(alike.state, position, velocity)


@seam
def go_soundly_alike(alike, h, steps, position, velocity):
    """The same if the outcome is surely sound.  Returns: whether it is; if not, nothing has moved."""
    copy_state(position, velocity, alike.start_position, alike.start_velocity)
    go_alike(alike, h, steps, position, velocity)
    if surely_sound(alike, position, velocity, h, alike):
        return True
    copy_state(alike.start_position, alike.start_velocity, position, velocity)
    return False
