"""Actuators and sensors of a rig as laws, one control step at a time.  Equal rigs and seeds give equal bits."""

from __future__ import annotations

from collections import deque

import numpy as np

from ..plant.muscles import drawn
from .rig import Actuators, Sensors

_FINEST = 1e-9  # a resolution below it is none


def steps_of(seconds: float, control_step: float) -> int:
    """A delay in whole control steps, the nearest."""
    return round(seconds / control_step)


class ActuatorChain:
    """From the activation asked for to the one that muscles have: resolution, dead time, lag, rate, cells that do nothing.

    a += clip((1 - exp(-h / lag)) (u - a), -rate h, rate h), with u what was asked for, rounded to the resolution, the dead time ago.

    Args: actuators: of the rig; cells: N; control_step: h, s.
    """

    def __init__(self, actuators: Actuators, cells: int, control_step: float):
        self._law = actuators
        self.activation = np.zeros(cells)
        self._share = -np.expm1(-control_step / actuators.lag) if actuators.lag > 0.0 else 1.0
        self._most = actuators.rate * control_step if actuators.rate > 0.0 else np.inf
        self._waiting = deque([np.zeros(cells)] * steps_of(actuators.dead_time, control_step))
        self._works = np.ones(cells, bool)
        self.fail(actuators.dead)

    def fail(self, cells: tuple[int, ...]) -> None:
        """From the next step on, these cells do nothing: what pressure they have leaks away by the lag."""
        self._works[list(cells)] = False

    def hold(self, activation: np.ndarray) -> None:
        """Begin as if this activation (N,) had been asked for since long ago."""
        self.activation[:] = np.where(self._works, activation, 0.0)
        self._waiting = deque([np.array(activation, float)] * len(self._waiting))

    def fail_by_lot(self, count: int, seed: int) -> tuple[int, ...]:
        """The same of so many cells that still work, drawn by a seed.  Returns them."""
        found = drawn(len(self._works), tuple(np.flatnonzero(~self._works).tolist()), count, seed)
        self.fail(found)
        return found

    def step(self, asked: np.ndarray) -> np.ndarray:
        """Take the activation asked for (N,), in [-1, 1].  Returns: the one that muscles have in this step; the same array each time."""
        law = self._law
        wanted = np.rint(asked / law.resolution) * law.resolution if law.resolution > _FINEST else np.array(asked, float)
        self._waiting.append(np.clip(wanted, -1.0, 1.0))
        towards = np.where(self._works, self._waiting.popleft(), 0.0)
        change = self._share * (towards - self.activation)
        there = (self._share == 1.0) & (np.abs(change) <= self._most)  # the same bits, where neither lag nor rate hold it back
        self.activation[...] = np.where(there, towards, self.activation + np.clip(change, -self._most, self._most))
        return self.activation


class SensorChain:
    """From where cells are to where their markers are seen: delay, noise, resolution, markers that are lost.

    Args: sensors: of the rig; start (N, 2) m: where cells are at the beginning; control_step: s; seed: of noise.
    """

    def __init__(self, sensors: Sensors, start: np.ndarray, control_step: float, seed: int):
        self._law = sensors
        self._rng = np.random.default_rng((seed, 1))
        self._waiting = deque([np.array(start, float)] * steps_of(sensors.delay, control_step))

    def see(self, position: np.ndarray) -> np.ndarray:
        """Where markers are seen (N, 2) m, NaN where they are lost, of the cells at `position` (N, 2) m."""
        law = self._law
        self._waiting.append(np.array(position, float))
        seen = self._waiting.popleft()
        if law.noise > 0.0:
            seen = seen + law.noise * self._rng.standard_normal(seen.shape)
        if law.resolution > _FINEST:
            seen = np.rint(seen / law.resolution) * law.resolution
        if law.lost > 0.0:
            seen = np.where(self._rng.random(len(seen))[:, None] < law.lost, np.nan, seen)
        return seen
