"""How a body's form changes: areas of chambers, limbs, and how few of its cells do the moving."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...extras import lacking

try:
    from scipy import ndimage
except ModuleNotFoundError as error:
    raise lacking(error) from None

_PIXEL, _MOST_PIXELS = 0.05, 1000  # m, of the raster in which limbs are found; along a side
_REACH = 0.6  # m around a cell's centre that belong to the body
_CORNER = 0.3  # m by which a cell's centre must stick out: those of corners do, too, but less


def chamber_areas(position: np.ndarray, chambers: Sequence[np.ndarray]) -> np.ndarray:
    """(T, C) m^2.  Args: position (T, N, 2) m; chambers: C arrays of cells, counter-clockwise."""
    areas = np.empty((len(position), len(chambers)))
    for k, chamber in enumerate(chambers):
        x, y = np.moveaxis(position[:, chamber] - position[:, chamber[:1]], -1, 0)  # far from the origin, products would hold no area
        areas[:, k] = 0.5 * (x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1)).sum(axis=1)
    return areas


def share_of_cells(power: np.ndarray) -> float:
    """The share of the cells over which a power (N,) is spread: 1 where all have alike, 1 / N where one has all."""
    total = power.sum()
    return float(total**2 / (len(power) * (power**2).sum())) if total > 0 else 0.0


def synchrony(wave: np.ndarray) -> float:
    """1 where all beat together, about 0 where every phase occurs.  Args: wave (K,) complex."""
    total = np.abs(wave).sum()
    return float(abs(wave.sum()) / total) if total > 0 else 0.0


def limbs(shape: np.ndarray, thickness: float) -> np.ndarray:
    """(N,) whether a cell lies in a part that sticks out: one thinner than `thickness`, m, of a body that has thicker parts.

    It is what an opening of the body by a disc takes away.  Args: shape (N, 2) m.
    """
    low = shape.min(axis=0) - thickness
    extent = np.ptp(shape, axis=0) + 2 * thickness
    pixel = max(_PIXEL, extent.max() / _MOST_PIXELS)
    at = tuple(np.rint((shape - low) / pixel).astype(int).T)
    free = np.ones(np.ceil(extent / pixel).astype(int) + 1, bool)
    free[at] = False
    near = ndimage.distance_transform_edt(free) * pixel <= _REACH
    inside = ndimage.distance_transform_edt(ndimage.binary_fill_holes(near)) * pixel
    core = inside >= thickness / 2
    if not core.any():
        return np.zeros(len(shape), bool)
    return ndimage.distance_transform_edt(~core)[at] * pixel > thickness / 2 + _CORNER
