"""Contact of one cell with the world in a symplectic step: exact projection, Coulomb friction (paper section 4.1).

A cell that would pass a surface is put on it: the push along the normal is what that takes, and friction takes up to its
coefficient times that push from the speed along the surface.  Impacts are plastic: what bounces is the body.  A sliding cell
moves by its mean velocity, so that a block stops where it should.
"""

from __future__ import annotations

import numpy as np

from ._jit import lean
from .terrain import height, segment

_TRIES = 4  # surfaces of a corner that a cell may meet in one step
_ROUNDING = 1e-12  # m


@lean
def meet_flat(friction, h, y, vx, vy):
    """Of a cell that would pass y = 0: (vx, vy, what friction moves it along x), y being 0 then."""
    landing = -y / h
    most = friction * (landing - vy)
    if abs(vx) <= most:
        return 0.0, landing, 0.0
    most = most if vx > 0.0 else -most
    return vx - most, landing, 0.5 * h * most


@lean
def _meet(xs, ys, friction, h, px, py, vx, vy):
    """Of a cell above a profile at p with velocity v: (place, velocity) after h.

    It is stopped where it is if a corner cannot be met otherwise.
    """
    qx, qy = px + h * vx, py + h * vy
    if qy >= height(xs, ys, qx):
        return qx, qy, vx, vy
    for _ in range(_TRIES):
        k = segment(xs, qx)
        for _ in range(2):
            tx, ty = xs[k + 1] - xs[k], ys[k + 1] - ys[k]
            inverse = 1.0 / np.sqrt(tx * tx + ty * ty)
            tx, ty = tx * inverse, ty * inverse
            above = (py - ys[k]) * tx - (px - xs[k]) * ty
            if above >= -_ROUNDING:
                break
            k = segment(xs, px)  # it left its own side of an edge: it meets that
        normal, along = vy * tx - vx * ty, vx * tx + vy * ty
        landing = -max(above, 0.0) / h
        push = landing - normal
        if push <= 0.0:
            break
        most = friction * push
        slip = 0.0
        if abs(along) <= most:
            along = 0.0
        else:
            most = most if along > 0.0 else -most
            along -= most
            slip = 0.5 * h * most
        vx, vy = along * tx - landing * ty, along * ty + landing * tx
        qx, qy = px + h * vx + slip * tx, py + h * vy + slip * ty
        ground = height(xs, ys, qx)
        if qy >= ground - _ROUNDING * (1.0 + abs(ground)):
            return qx, max(qy, ground), vx, vy
    return px, py, 0.0, 0.0


@lean
def meet(terrain, friction, h, px, py, vx, vy):
    """Of a cell outside all solids at p with velocity v: (place, velocity) after h, outside them."""
    qx, qy, u, v = _meet(terrain.x, terrain.y, friction, h, px, py, vx, vy)
    xs, depth = terrain.ceiling_x, terrain.ceiling_depth
    if xs.size and qy > terrain.bottom and -qy < height(xs, depth, qx):
        qx, qy, u, v = _meet(xs, depth, friction, h, px, -py, u, -v)
        qy, v = -qy, -v
        if qy < height(terrain.x, terrain.y, qx):
            return px, py, 0.0, 0.0
    return qx, qy, u, v
