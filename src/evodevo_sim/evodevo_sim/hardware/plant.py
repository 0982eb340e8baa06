"""A body on a serial line as a plant: what a brain drives in the place of the simulated one."""

from __future__ import annotations

import numpy as np

from ..plant.contract import Outcome
from ..plant.simulated import read_only
from .serial_body import SerialBody, Sight

_SETTLED = 0.05  # m/s, mean over cells: slower than that, a body that is held counts as at rest
_SETTLE_WITHIN = 5.0  # s


class HardwarePlant:
    """A body of N cells behind a line: a `Plant`.

    A control step is one state of the firmware: its clock paces the brain, and `seconds` are its control step, which the firmware keeps.

    Attributes: position (N, 2) m, velocity (N, 2) m/s: of the last state, NaN where a marker was lost; sight: that state.
    """

    def __init__(self, body: SerialBody):
        cells = body.calibration.cells
        self._body, self._number = body, -1
        self._position, self._velocity = np.array(body.calibration.position), np.zeros((cells, 2))
        self.position, self.velocity = read_only(self._position), read_only(self._velocity)
        self.sight: Sight | None = None
        self._born = 0.0  # s of the firmware's clock
        self._take(body.look())
        self._born = self.sight.time if self.sight else 0.0

    def _take(self, sight: Sight | None) -> bool:
        if sight is None:
            return False
        self.sight, self._number = sight, sight.number
        self._position[...], self._velocity[...] = sight.position, sight.velocity
        return True

    @property
    def time(self) -> float:
        """s of the firmware's clock, since this life began, at which the cells were where `position` has them."""
        return self.sight.time - self._born if self.sight else 0.0

    def move(self, activation: np.ndarray, seconds: float) -> Outcome:
        self._body.command(activation, self._number)
        return Outcome.SOUND if self._take(self._body.look(self._number)) else Outcome.LOST

    def reset(self) -> None:
        """Muscles at rest until the body hardly moves, where it is: nobody carries it back to where it started."""
        if self.sight is None and not self._take(self._body.look()):
            return
        start = self._born = self.sight.time if self.sight else 0.0
        while self._take(self._body.look(self._number)) and self.sight is not None:
            self._body.command(np.zeros(len(self.position)))
            elapsed = self.sight.time - start
            self._born = self.sight.time
            if elapsed > _SETTLE_WITHIN or (elapsed > 0.5 and float(np.nanmean(np.hypot(*self.velocity.T))) < _SETTLED):
                return

    def rests(self) -> bool:
        return False  # a camera's noise hides whether it does
