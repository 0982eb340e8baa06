"""Contact of a body with the world in a symplectic step: exact projection, Coulomb friction (paper section 4.1).

A cell that would pass a surface is put on it: the push along the normal is what that takes, and friction takes up to its
coefficient times that push from the speed along the surface.  Impacts are plastic: what bounces is the body.  A sliding cell
moves by its mean velocity, so that a block stops where it should.

Between two cells an edge of the outline can meet a tip of the ground, and of it only tips: where both its cells are above a
profile and it is not, it is deepest at one of them.  The push is shared by the edge's cells by how near the tip is to each.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..kernels.jit import lean
from .terrain import first_from, height, segment

_TRIES = 4  # surfaces of a corner that a cell may meet in one step
_ROUNDING = 1e-12  # m
_SWEEPS = 8  # over the edges in a step; cells of an edge that is in a tip even then are stopped where they were
_DEEP = 1e-10  # m that an edge may be below a tip


class Step(NamedTuple):
    """A step in which outline edges are lifted off tips, in place."""

    friction: float  # Coulomb's coefficient
    h: float  # s
    inverse_mass: np.ndarray  # (N,) 1/kg
    before: np.ndarray  # (2, N) m: position at its start
    position: np.ndarray  # (2, N) m
    velocity: np.ndarray  # (2, N) m/s


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


@lean
def _depth(xi, yi, xj, yj, tip_x, tip_y):
    """How deep a tip is in an edge, m across it; 0 where the edge is above it, or not over it."""
    dx, dy = xj - xi, yj - yi
    if dx == 0.0:
        return 0.0
    share = (tip_x - xi) / dx
    if not 0.0 <= share <= 1.0:
        return 0.0
    return max(0.0, (tip_y - yi - share * dy) * abs(dx) / np.sqrt(dx * dx + dy * dy))


@lean
def _push_off(i, j, tip_x, tip_y, sign, stop, step):
    """Lift an edge off a tip, by what moves its two cells, or stop them where they were.  Returns: whether it was in there."""
    friction, h, inverse_mass, before = step.friction, step.h, step.inverse_mass, step.before
    x, y, u, v = step.position[0], step.position[1], step.velocity[0], step.velocity[1]
    depth = _depth(x[i], sign * y[i], x[j], sign * y[j], tip_x, tip_y)
    if depth <= _DEEP:
        return False
    if stop:
        for k in (i, j):
            x[k], y[k], u[k], v[k] = before[0, k], before[1, k], 0.0, 0.0
        return True
    deep = _depth(before[0, i], sign * before[1, i], before[0, j], sign * before[1, j], tip_x, tip_y)
    dx, dy = x[j] - x[i], sign * (y[j] - y[i])
    square = dx * dx + dy * dy
    b = min(max(((tip_x - x[i]) * dx + (tip_y - sign * y[i]) * dy) / square, 0.0), 1.0)
    a = 1.0 - b
    inverse = (1.0 if dx > 0.0 else -1.0) / np.sqrt(square)
    nx, ny = -dy * inverse, dx * inverse  # away from the solid
    weight = a * a * inverse_mass[i] + b * b * inverse_mass[j]
    push = max(0.0, depth - deep) / (h * weight)
    along = (a * u[i] + b * u[j]) * ny - sign * (a * v[i] + b * v[j]) * nx
    drag, share = along / weight, 1.0
    if abs(drag) > friction * push:
        drag, share = (friction if drag > 0.0 else -friction) * push, 0.5
    lift, slip = depth / weight, share * h * drag
    for k, part in ((i, a * inverse_mass[i]), (j, b * inverse_mass[j])):
        u[k] += part * (push * nx - drag * ny)
        v[k] += part * sign * (push * ny + drag * nx)
        x[k] += part * (lift * nx - slip * ny)
        y[k] += part * sign * (lift * ny + slip * nx)
    return True


@lean
def _put_outside(terrain, i, step):
    """Let a cell that was pushed meet the surfaces that it was pushed into, on its way from where it was before the step."""
    position, velocity, before, h = step.position, step.velocity, step.before, step.h
    x, y = position[0, i], position[1, i]
    ceiling = terrain.ceiling_x
    inside = y < height(terrain.x, terrain.y, x) or (ceiling.size > 0 and -y < height(ceiling, terrain.ceiling_depth, x))
    if inside:
        px, py = before[0, i], before[1, i]
        position[0, i], position[1, i], velocity[0, i], velocity[1, i] = meet(
            terrain, step.friction, h, px, py, (x - px) / h, (y - py) / h
        )


@lean
def _sweep(terrain, ceiling, stop, outline, step):
    """Lift every edge off the tips that it is in, once.  Returns: whether there was one."""
    x, y = step.position[0], step.position[1]
    tip_x, tip_y = terrain.tip_x, terrain.tip_y
    sign, top = 1.0, terrain.top
    if ceiling:
        tip_x, tip_y = terrain.ceiling_tip_x, terrain.ceiling_tip_depth
        sign, top = -1.0, -terrain.bottom
    met = False
    for m in range(outline.shape[0]):
        i, j = outline[m, 0], outline[m, 1]
        if min(sign * y[i], sign * y[j]) >= top:
            continue
        high = max(x[i], x[j])
        for k in range(first_from(tip_x, min(x[i], x[j])), tip_x.size):
            if tip_x[k] > high:
                break
            if _push_off(i, j, tip_x[k], tip_y[k], sign, stop, step):
                _put_outside(terrain, i, step)
                _put_outside(terrain, j, step)
                met = True
    return met


@lean
def meet_tips(terrain, friction, h, body, before, position, velocity):
    """After a step of h in which every cell has met the ground: lift outline edges off tips, in place.

    Args: before (2, N): position at the start of the step.
    """
    step = Step(friction, h, body.inverse_mass, before, position, velocity)
    for k in range(_SWEEPS + body.outline.shape[0]):
        stop = k >= _SWEEPS
        met = _sweep(terrain, False, stop, body.outline, step)
        if terrain.ceiling_tip_x.size:
            met |= _sweep(terrain, True, stop, body.outline, step)
        if not met:
            break
