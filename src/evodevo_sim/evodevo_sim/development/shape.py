"""Shapes of bodies: measures of one, and how far two are apart.  All take the places of cells (N, 2) in diameters of one, called metres.

A shape is its cells' places but for where it stands and how it is turned, mirrored ones with it; no springs, no order of cells.
"""

from __future__ import annotations

import math

import numpy as np

SAME = 0.1  # m, mean distance of the nearest cells below which two shapes are the same one
_OWN = 1.0 / 16.0  # m^2, variance of a disc of diameter 1 along an axis: what a cell adds by its own size
_POSES = np.array([(1.0, 1.0), (-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0)])


def principal(position: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(variances (2,) m^2 along and across, the cells (N, 2) m from their centre along those axes)."""
    own = position - position.mean(axis=0)
    variance, axes = np.linalg.eigh(own.T @ own / len(own))
    return np.maximum(variance[::-1], 0.0), own @ axes[:, ::-1]


def elongation(position: np.ndarray) -> float:
    """Length over width, 1 or more: the ratio of standard deviations along and across, cells taken as discs of diameter 1."""
    variance, _ = principal(position)
    return math.sqrt((variance[0] + _OWN) / (variance[1] + _OWN))


def sprawl(position: np.ndarray) -> float:
    """Radius of gyration over that of a round, closely packed body of as many cells: about 1 where compact, more with limbs or length."""
    variance, _ = principal(position)
    disc = len(position) * math.sqrt(3.0) / (4.0 * math.pi)  # m^2: half the square of its radius
    return math.sqrt((variance.sum() + 2.0 * _OWN) / max(disc, 2.0 * _OWN))


def asymmetry(position: np.ndarray) -> float:
    """How unlike front and back are, m: mean distance of the nearest cells from the body mirrored across its middle; 0 where alike."""
    _, own = principal(position)
    return _apart(own, own[None] * _POSES[3])


def share_of_chambers(cells: int, chambers: int) -> float:
    """Chambers over those of the most compact body of as many cells, 2 n - 5: about 0.5 in a ribbon of two rows, 0.75 in a swarm."""
    return chambers / max(1, 2 * cells - 5)


def shape_distance(one: np.ndarray, other: np.ndarray) -> float:
    """Mean distance of a cell from the nearest one of the other body, both ways, m, in the pose where it is least.

    Poses: centre on centre, as they grew; and turned to principal axes, with each of their four signs.  Infinite against nothing.
    """
    if not len(one) or not len(other):
        return math.inf if len(one) != len(other) else 0.0
    a, b = principal(one)[1], principal(other)[1]
    grown = _apart(one - one.mean(axis=0), (other - other.mean(axis=0))[None])
    return min(grown, _apart(a, b[None] * _POSES[:, None]))


def same_shape(one: np.ndarray, other: np.ndarray, limit: float = SAME) -> bool:
    """Whether two bodies have one shape: as `shape_distance` below `limit`, m."""
    return shape_distance(one, other) < limit


def farthest_cell(one: np.ndarray, other: np.ndarray) -> tuple[int, float]:
    """(cell, m): that which is farthest from where the other body of as many cells has it, centre on centre, as they grew."""
    far = np.hypot(*((one - one.mean(axis=0)) - (other - other.mean(axis=0))).T)
    return int(far.argmax()), float(far.max())


def same_cells(one: np.ndarray, other: np.ndarray, limit: float = SAME) -> bool:
    """Whether two bodies have the same cells in the same order, each less than `limit` m from where the other has it."""
    return len(one) == len(other) > 0 and farthest_cell(one, other)[1] < limit


def _apart(one: np.ndarray, poses: np.ndarray) -> float:
    """The least over poses (P, M, 2) of the mean distance of nearest cells, both ways."""
    square = ((one[None, :, None] - poses[:, None]) ** 2).sum(axis=-1)  # (P, N, M)
    near = np.sqrt(square.min(axis=2)).mean(axis=1) + np.sqrt(square.min(axis=1)).mean(axis=1)
    return float(0.5 * near.min())
