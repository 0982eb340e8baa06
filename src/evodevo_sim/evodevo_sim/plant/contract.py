"""What a brain drives: a simulated body, or one of rubber and air behind a driver."""

from __future__ import annotations

from enum import IntEnum
from typing import Protocol

import numpy as np


class Outcome(IntEnum):
    """How a control step went; the first three are the numbers of `physics.soundness`."""

    SOUND = 0
    UNSTABLE = 1  # the physics blew up even with finer steps
    INVERTED = 2  # a chamber turned inside out or a spring collapsed
    LOST = 3  # the plant did not answer in time, or its state is not known


class Plant(Protocol):
    """A body of N cells.

    Attributes: position (N, 2) m, velocity (N, 2) m/s: of every cell now, NaN where it is not known; read-only.
    """

    position: np.ndarray
    velocity: np.ndarray

    def move(self, activation: np.ndarray, seconds: float) -> Outcome:
        """Take the activation (N,) of e - c, each in [-1, 1], for one control step of so many seconds."""
        ...

    def reset(self) -> None:
        """Go back to where it started, at rest."""
        ...

    def rests(self) -> bool:
        """Whether nothing moves, nor will while activation stays as it is.  A plant that cannot tell says False."""
        ...
