"""When the frames of a film are shown: growth quickly, then life as it was, holes in it cut short.  The player of pages does the same."""

from __future__ import annotations

import numpy as np

from ...recording.life import Life

_GROWTH = 6.0  # s, at the most, that growth takes
_STEP = 1 / 60  # s, at the most, of a step of growth
_PAUSE = 0.3  # s between growth and birth
_HOLE = 1.0  # s, at the most, between two frames of a life


def clock_of(life: Life) -> np.ndarray:
    """(S + T,) s, ascending: when each step of growth and then each one of life is shown at speed 1."""
    grown, lived = len(life.growth), len(life.time)
    growth = np.arange(grown) * min(_STEP, _GROWTH / max(grown, 1))
    birth = grown * min(_STEP, _GROWTH / max(grown, 1)) + _PAUSE if grown else 0.0
    steps = np.minimum(np.diff(life.time, prepend=life.time[:1]), _HOLE)
    return np.concatenate((growth, birth + np.cumsum(steps) if lived else []))


def frames_of(life: Life, rate: float, speed: float) -> np.ndarray:
    """Numbers of the steps, growth first, that a video of `rate` frames a second shows at a speed; the last one for a second."""
    clock = clock_of(life)
    moments = np.arange(0.0, clock[-1] + speed / rate, speed / rate)
    steps = np.searchsorted(clock, moments, side="right") - 1
    return np.concatenate((steps, np.full(int(rate), len(clock) - 1)))
