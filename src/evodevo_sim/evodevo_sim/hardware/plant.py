"""A body on a serial line as a plant: what a brain drives in the place of the simulated one."""

from __future__ import annotations

from collections import deque

import numpy as np

from ..plant.contract import Outcome
from ..plant.simulated import read_only
from .protocol import Mode
from .serial_body import SerialBody, Sight

_SETTLED = 0.05  # m/s, mean over cells: slower than that, a body that is held counts as at rest
_SETTLE_WITHIN = 5.0  # s
_LOOK = 15  # sights that are averaged, so that the noise of a camera is no motion


class HardwarePlant:
    """A body of N cells behind a line: a `Plant`.

    A control step is one state of the firmware: its clock paces the brain, and `seconds` are its control step, which the firmware keeps.

    Args: born (N,): activation that its muscles hold at birth, to which `reset` goes; by default none.

    Attributes: position (N, 2) m, velocity (N, 2) m/s: of the last state, NaN where a marker was lost; sight: that state; idle: control
    steps so far in which it was not armed, so that its muscles did not do what they were told.
    """

    def __init__(self, body: SerialBody, born: np.ndarray | None = None):
        cells = body.calibration.cells
        self._body, self._number = body, -1
        self.born = np.zeros(cells) if born is None else np.array(born, float)
        self._position, self._velocity = np.array(body.calibration.position), np.zeros((cells, 2))
        self.position, self.velocity = read_only(self._position), read_only(self._velocity)
        self.sight: Sight | None = None
        self.idle = 0
        self._start = 0.0  # s of the firmware's clock
        self._take(body.look())
        self._start = self.sight.time if self.sight else 0.0

    def _take(self, sight: Sight | None) -> bool:
        if sight is None:
            return False
        self.sight, self._number = sight, sight.number
        self._position[...], self._velocity[...] = sight.position, sight.velocity
        return True

    @property
    def time(self) -> float:
        """s of the firmware's clock, since this life began, at which the cells were where `position` has them."""
        return self.sight.time - self._start if self.sight else 0.0

    def move(self, activation: np.ndarray, seconds: float) -> Outcome:
        self._body.command(activation, self._number)
        if not self._take(self._body.look(self._number)):
            self.idle += max(1, round(self._body.calibration.state_within / seconds))
            return Outcome.LOST
        self.idle += self.sight is not None and self.sight.state.mode != Mode.ARMED
        return Outcome.SOUND

    def reset(self) -> None:
        """Muscles as at birth until the body hardly moves, where it is: nobody carries it back to where it started."""
        self.idle = 0
        if self.sight is None and not self._take(self._body.look()):
            return
        began = self._start = self.sight.time if self.sight else 0.0
        seen: deque[np.ndarray] = deque(maxlen=2 * _LOOK)
        times: deque[float] = deque(maxlen=2 * _LOOK)
        while self._take(self._body.look(self._number)) and self.sight is not None:
            self._body.command(self.born)
            self._start = self.sight.time
            seen.append(self.sight.position)
            times.append(self.sight.time)
            if self.sight.time - began > _SETTLE_WITHIN or (len(seen) == seen.maxlen and _speed(seen, times) < _SETTLED):
                return

    def rests(self) -> bool:
        return False  # a camera's noise hides whether it does


def _speed(seen: deque[np.ndarray], times: deque[float]) -> float:
    """m/s, mean over the cells that are seen, from the first half of some positions to the second; infinite where none is."""
    first, second = (_mean(np.array([seen[k] for k in half])) for half in (range(_LOOK), range(_LOOK, 2 * _LOOK)))
    moved = np.hypot(*(second - first).T)
    known = np.isfinite(moved)
    apart = (times[-1] - times[0]) * _LOOK / (2 * _LOOK - 1)
    return float(moved[known].mean()) / apart if known.any() and apart > 0.0 else np.inf


def _mean(position: np.ndarray) -> np.ndarray:
    """(N, 2): the mean of (K, N, 2) over what is seen; NaN where nothing is."""
    seen = np.isfinite(position)
    count = seen.sum(axis=0)
    return np.where(count > 0, np.where(seen, position, 0.0).sum(axis=0) / np.maximum(count, 1), np.nan)
