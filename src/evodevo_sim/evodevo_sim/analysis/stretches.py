"""Stretches of frames without a hole between them."""

from __future__ import annotations

import itertools

import numpy as np

_HOLE = 3.5  # usual frames, farther apart than which two frames have a hole between them


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
