"""Limits of what a body is told: how much, how fast, and for how long when nobody says anything any more."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass
class Report:
    """What limits had to change since they were last asked: channels at the limit of magnitude or of rate, and numbers that are none."""

    magnitude: int = 0
    rate: int = 0
    refused: int = 0


class Limiter:
    """Holds levels within their magnitude and their rate, whoever asks for them: a stream, a brain, a step response.

    Args: least, most (K,): of each channel, in the unit of the calibration; rate (K,): of it a second, infinite where there is none;
    start (K,): levels at the beginning, those of a vented body.
    """

    def __init__(self, least: np.ndarray, most: np.ndarray, rate: np.ndarray, start: np.ndarray):
        self._least, self._most, self._rate = least, most, rate
        self._start = np.clip(start, least, most)
        self.level = self._start.copy()
        self.report = Report()

    def reset(self, level: np.ndarray | None = None) -> None:
        """Begin anew from levels that the body has, or those of a vented one."""
        self.level = np.clip(self._start if level is None else level, self._least, self._most)

    def towards(self, asked: np.ndarray, seconds: float) -> np.ndarray:
        """The levels (K,) to go to within `seconds` since the last call.  A level that is not finite leaves its channel where it is."""
        fine = np.isfinite(asked)
        wanted = np.where(fine, asked, self.level)
        held = np.clip(wanted, self._least, self._most)
        step = self._rate * max(seconds, 0.0)
        moved = np.clip(held, self.level - step, self.level + step)
        self.report.refused += int(np.count_nonzero(~fine))
        self.report.magnitude += int(np.count_nonzero(held != wanted))
        self.report.rate += int(np.count_nonzero(moved != held))
        self.level = moved
        return moved
