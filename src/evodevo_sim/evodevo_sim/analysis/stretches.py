"""Stretches of frames without a hole between them."""

from __future__ import annotations

import itertools

import numpy as np

LONGEST_GAP = 0.25  # s, of a number that is filled in
_HOLE = 3.5  # usual frames, farther apart than which two frames have a hole between them


def filled(time: np.ndarray, values: np.ndarray) -> np.ndarray:
    """A series (T, ...) with short gaps of numbers that are none filled in along straight lines, each number for itself.

    As of markers that a camera has lost for a moment.  What is longer than `LONGEST_GAP`, or at either end, stays.  Args: time (T,) s.
    """
    if np.isfinite(values).all():
        return values
    found = values.copy()
    for column in found.reshape(len(time), -1).T:
        known = np.flatnonzero(np.isfinite(column))
        if len(known) < 2 or len(known) == len(column):
            continue
        lost = np.flatnonzero(~np.isfinite(column))
        after = np.searchsorted(known, lost)
        within = (after > 0) & (after < len(known))
        lost, after = lost[within], after[within]
        lost = lost[time[known[after]] - time[known[after - 1]] <= LONGEST_GAP + 1e-9]
        column[lost] = np.interp(time[lost], time[known], column[known])
    return found


def speeds(time: np.ndarray, position: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """Velocities (T, ...), those that are no number where the position is one by differences of the positions that are known."""
    lost = ~np.isfinite(velocity) & np.isfinite(position)
    if not lost.any():
        return velocity
    found = velocity.reshape(len(time), -1).copy()
    places, columns = position.reshape(len(time), -1), lost.reshape(len(time), -1)
    for k in np.flatnonzero(columns.any(axis=0)):
        known = np.flatnonzero(np.isfinite(places[:, k]))
        slope = np.gradient(places[known, k], time[known]) if len(known) > 1 else np.zeros(len(known))
        found[columns[:, k], k] = slope[np.searchsorted(known, np.flatnonzero(columns[:, k]))]
    return found.reshape(velocity.shape)


def holes(time: np.ndarray) -> np.ndarray:
    """Indices k of a series' times (T,), ascending, with a hole between k and k + 1."""
    steps = np.diff(time)
    return np.flatnonzero(steps > _HOLE * np.median(steps)) if len(steps) > 1 else np.empty(0, int)


def longest_stretch(time: np.ndarray) -> slice:
    """The frames of the longest stretch without a hole, in time."""
    ends = [-1, *holes(time), len(time) - 1]
    first, last = max(((a + 1, b) for a, b in itertools.pairwise(ends)), key=lambda pair: time[pair[1]] - time[pair[0]])
    return slice(int(first), int(last) + 1)


def words_of_holes(time: np.ndarray) -> str:
    """What is missing in the middle of a series, or nothing.  Args: time (T,) s, from any origin."""
    found = holes(time)
    if not len(found):
        return ""
    begin, length = time[found] - time[0], time[found + 1] - time[found]
    worst = int(length.argmax())
    more = "" if len(found) == 1 else f" in {len(found)} holes"
    return f"{length.sum():.3g} s of states are missing in the middle{more}, {length[worst]:.3g} s of them from {begin[worst]:.3g} s on"
