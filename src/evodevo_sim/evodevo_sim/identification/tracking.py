"""Tracking error: how far apart two motions of one body are."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .observation import ObservationError


@dataclass(frozen=True, eq=False)
class Tracking:
    """How far a motion is from another one that begins in the same pose.

    Attributes: time (T,) s; cells (T,) m: root mean square over cells; centre (T,) m: of their centres; shape (T,) m: root mean square
    over cells, once each moment's pose is made alike; length: m, of the body.
    """

    time: np.ndarray
    cells: np.ndarray
    centre: np.ndarray
    shape: np.ndarray
    length: float

    @property
    def rms(self) -> float:
        """m: root mean square over cells and time."""
        return float(np.sqrt(np.mean(self.cells**2)))

    @property
    def relative(self) -> float:
        """The same as a share of the body's length."""
        return self.rms / self.length


def tracking(time: np.ndarray, position: np.ndarray, other: np.ndarray, length: float, first: float = 0.0) -> Tracking:
    """How far `other` (T, N, 2) m is from `position` (T, N, 2) m, NaN where a cell is not seen, once its first pose is laid on that one.

    Args: time (T,) s; length: m; first: s from the begin over which poses are laid on each other, beyond the first moment.
    Raises ObservationError where they have no moment in common.
    """
    both = np.isfinite(position).all(axis=2) & np.isfinite(other).all(axis=2)
    at = np.flatnonzero(both.sum(axis=1) >= 2)
    if not len(at):
        raise ObservationError("the two motions have no two cells in common at any moment: give two of one body")
    begin = [k for k in at if time[k] - time[at[0]] <= first]
    moved = laid_on(position[begin], other[begin], both[begin])(other)
    off = np.where(both[..., None], moved - position, 0.0)[at]
    count = both[at].sum(axis=1)
    cells = np.sqrt((off**2).sum(axis=(1, 2)) / count)
    centre = np.hypot(*(off.sum(axis=1) / count[:, None]).T)
    shape = np.empty(len(at))
    for row, k in enumerate(at):
        left = (laid_on(position[k : k + 1], moved[k : k + 1], both[k : k + 1])(moved[k : k + 1])[0] - position[k])[both[k]]
        shape[row] = np.sqrt((left**2).sum() / count[row])
    return Tracking(time[at], cells, centre, shape, length)


def laid_on(position: np.ndarray, other: np.ndarray, both: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    """The motion of the plane, as a function of points (..., 2), that brings `other` nearest to `position`, where `both` are known."""
    a, b = position[both], other[both]
    ca, cb = a.mean(axis=0), b.mean(axis=0)
    da, db = a - ca, b - cb
    angle = np.arctan2((db[:, 0] * da[:, 1] - db[:, 1] * da[:, 0]).sum(), (db * da).sum())
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return lambda points: (points - cb) @ turn.T + ca
