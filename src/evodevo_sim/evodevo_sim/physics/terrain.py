"""The solid world around a walker: ground and ceiling as height profiles, in kernels and out of them.

A profile is a polyline, single-valued: points (x, y) m with x ascending, level beyond both ends.  No points of ground: flat at
y = 0; none of ceiling: open sky.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..kernels.jit import lean
from ..profiles import profile

_FAR = 1e9  # m, where a profile's level ends end
_CLOSE = 1e-9  # m, and of a height: as near as rounding leaves what touches


class Terrain(NamedTuple):
    """Ground and ceiling, as kernels take them.  Tips: the vertices that an edge of a body can meet between its cells."""

    x: np.ndarray  # (K,) m, ascending: the ground, padded with its level ends; or empty: flat at 0
    y: np.ndarray  # (K,) m
    top: float  # m: its highest point
    ceiling_x: np.ndarray  # (C,) m: likewise the ceiling; or empty: none
    ceiling_depth: np.ndarray  # (C,) m: -y of it, upside down
    bottom: float  # m: its lowest point, or infinity
    tip_x: np.ndarray  # (T,) m: tips of the ground, those that point up
    tip_y: np.ndarray  # (T,) m
    ceiling_tip_x: np.ndarray  # (D,) m: tips of the ceiling
    ceiling_tip_depth: np.ndarray  # (D,) m: -y of them


_NONE = np.zeros(0)
FLAT = Terrain(
    x=_NONE, y=_NONE, top=0.0, ceiling_x=_NONE, ceiling_depth=_NONE, bottom=np.inf, tip_x=_NONE, tip_y=_NONE, ceiling_tip_x=_NONE,
    ceiling_tip_depth=_NONE,
)


def make_terrain(scene) -> Terrain:
    """The terrain of a `parameters.Scene`, as kernels take it."""
    if not scene.ground_x and not scene.ceiling_x:
        return FLAT
    ground = _padded(scene.ground_x or (0.0, 1.0), scene.ground_y or (0.0, 0.0))
    ceiling = _padded(scene.ceiling_x, scene.ceiling_y) if scene.ceiling_x else (np.zeros(0), np.zeros(0))
    bottom = float(ceiling[1].min()) if scene.ceiling_x else np.inf
    depth = -ceiling[1]
    return Terrain(
        *ground, float(ground[1].max()), ceiling[0], depth, bottom, *_tips(*ground), *_tips(ceiling[0], depth)
    )


def _padded(x, y):
    return np.array([-_FAR, *x, _FAR]), np.array([y[0], *y, y[-1]], float)


def _tips(x, y):
    """(x, y) of the vertices of a profile that stick out of it."""
    slope = np.diff(y) / np.diff(x)
    tips = np.flatnonzero(slope[1:] < slope[:-1]) + 1 if len(x) else np.zeros(0, int)
    return x[tips], y[tips]


@dataclass(frozen=True)
class Ground:
    """The ground under a motion, by its points; none: flat.  Called with x of any shape it gives the height there, m."""

    x: tuple[float, ...] = ()
    y: tuple[float, ...] = ()

    def __call__(self, x) -> np.ndarray:
        return profile(self.x, self.y, x)

    def touching(self, outline, position, tolerance: float) -> np.ndarray:
        """Whether cells touch, themselves or by an edge that lies on a tip.

        Args: outline (M, 2): edges; position (T, N, 2) m; tolerance: m above the ground, that still touch.  Returns: (T, N) bool.
        """
        touch = position[..., 1] - self(position[..., 0]) <= tolerance
        return touch | (_on_tips(*_tips(*_padded(self.x, self.y)), outline, position, tolerance) if len(self.x) else False)


def _on_tips(tip_x, tip_y, outline, position, tolerance):
    """(T, N): whether a cell is an end of an outline edge that lies on a tip."""
    x, y = position[..., 0], position[..., 1]
    on = np.zeros(x.shape, bool)
    for i, j in outline:
        low, high = np.minimum(x[:, i], x[:, j]), np.maximum(x[:, i], x[:, j])
        for k in range(*np.searchsorted(tip_x, (low.min(), high.max()))):
            over = np.flatnonzero((low < tip_x[k]) & (tip_x[k] < high))
            share = (tip_x[k] - x[over, i]) / (x[over, j] - x[over, i])
            rests = over[y[over, i] + share * (y[over, j] - y[over, i]) - tip_y[k] <= tolerance]
            on[rests, i] = on[rests, j] = True
    return on


def touching(scene, position) -> np.ndarray:
    """Whether cells at position (..., 2) are themselves at ground or ceiling: (...) bool."""
    x, y = position[..., 0], position[..., 1]
    close = _CLOSE * (1.0 + np.abs(y))
    touch = np.abs(y - profile(scene.ground_x, scene.ground_y, x)) <= close
    if len(scene.ceiling_x):
        touch |= np.abs(y - profile(scene.ceiling_x, scene.ceiling_y, x)) <= close
    return touch


def contacts(scene, outline, position) -> np.ndarray:
    """Whether cells touch ground or ceiling, themselves or by an edge that lies on a tip: (T, N) bool.

    Args: outline (M, 2): edges; position (T, N, 2) m.
    """
    down = position * (1.0, -1.0)
    below = Ground(tuple(scene.ground_x), tuple(scene.ground_y))
    above = Ground(tuple(scene.ceiling_x), tuple(-y for y in scene.ceiling_y))
    touch = touching(scene, position)
    for side, ways in ((below, position), (above, down)):
        if side.x:
            touch |= _on_tips(*_tips(*_padded(side.x, side.y)), outline, ways, _CLOSE * (1.0 + np.abs(side.y).max()))
    return touch


@lean
def segment(xs, x):
    """The number of the segment over x, by bisection."""
    low, high = 0, xs.size - 1
    while high - low > 1:
        middle = (low + high) // 2
        if xs[middle] <= x:
            low = middle
        else:
            high = middle
    return low


@lean
def height(xs, ys, x):
    """Height of a padded profile at x."""
    k = segment(xs, x)
    return ys[k] + (x - xs[k]) * ((ys[k + 1] - ys[k]) / (xs[k + 1] - xs[k]))


@lean
def touches(terrain, x, y):
    """Whether a point is on the ground, or at the ceiling."""
    close = _CLOSE * (1.0 + abs(y))
    if abs(y - (height(terrain.x, terrain.y, x) if terrain.x.size else 0.0)) <= close:
        return True
    xs = terrain.ceiling_x
    return xs.size > 0 and abs(y + height(xs, terrain.ceiling_depth, x)) <= close


@lean
def first_from(xs, x):
    """The number of the first of ascending xs that is not below x."""
    low, high = 0, xs.size
    while low < high:
        middle = (low + high) // 2
        if xs[middle] < x:
            low = middle + 1
        else:
            high = middle
    return low


@lean
def _above_tips(tip_x, tip_y, outline, x, y, sign):
    """Least height of outline edges above tips; y of both profile and body times sign."""
    least = np.inf
    for m in range(outline.shape[0] if tip_x.size else 0):
        i, j = outline[m, 0], outline[m, 1]
        if x[i] > x[j]:
            i, j = j, i
        for k in range(first_from(tip_x, x[i]), tip_x.size):
            if tip_x[k] > x[j] or x[i] == x[j]:
                break
            share = (tip_x[k] - x[i]) / (x[j] - x[i])
            least = min(least, sign * (y[i] + share * (y[j] - y[i])) - tip_y[k])
    return least


@lean
def clearance(terrain, outline, x, y):
    """Least height of a body above the ground (how far it has to rise if it is negative), and below the ceiling.

    Args: outline (M, 2): its edges; x, y (N,): its cells.
    """
    low = _above_tips(terrain.tip_x, terrain.tip_y, outline, x, y, 1.0)
    high = _above_tips(terrain.ceiling_tip_x, terrain.ceiling_tip_depth, outline, x, y, -1.0)
    for i in range(x.size):
        low = min(low, y[i] - (height(terrain.x, terrain.y, x[i]) if terrain.x.size else 0.0))
        if terrain.ceiling_x.size:
            high = min(high, -height(terrain.ceiling_x, terrain.ceiling_depth, x[i]) - y[i])
    return low, high
