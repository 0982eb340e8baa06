"""What reaches a body from outside step by step: the target's scent (paper section 4.3), and noise."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..genetics.elements import INPUTS, OUTPUTS
from ..kernels.jit import lean
from .brain import find_activation

_SCENT = INPUTS - 1  # of the input signals: the last one, so that a scent of 0 changes no bit of the others' sum
_PER_STEP = np.uint64(0x9E3779B97F4A7C15)
_A, _B = np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)
_16, _27, _30, _31, _32, _48 = np.uint64(16), np.uint64(27), np.uint64(30), np.uint64(31), np.uint64(32), np.uint64(48)
_LOW = np.uint64(0xFFFF)


class Signals(NamedTuple):
    """What reaches a body from outside."""

    target: np.ndarray  # (x, y) m, scent at the target, and m beyond which there is none; or empty where the scene has no target
    noise: np.ndarray  # standard deviations of sensing, concentrations and actuation; or empty
    random: np.ndarray  # uint64 (2,): seed and state of the generator


def make_signals(target=None, peak: float = 0.0, reach: float = 1.0, noise=None, seed: int = 0) -> Signals:
    """Signals.  Args: target: (x, y) m or None; noise: three standard deviations or None; seed: of the noise."""
    where = np.empty(0) if target is None else np.array([*target, peak, reach], float)
    deviations = np.empty(0) if noise is None or not any(noise) else np.array(noise, float)
    return Signals(where, deviations, np.array([seed % 2**64, 0], np.uint64))


@lean
def scent(dx, dy, peak, reach):
    """The scent at (dx, dy) from the target: `peak` there, falling linearly to 0 at a distance of `reach`."""
    left = 1.0 - np.sqrt(dx * dx + dy * dy) / reach
    return peak * left if left > 0.0 else 0.0


@lean
def scent_row(units):
    """The row of a network's table that is every cell's scent input."""
    return 2 * units + OUTPUTS + _SCENT


@lean
def sense(brain, position, signals, step):
    """Clamp every cell's scent input to the scent at its own place.  Args: position (2, N) m."""
    target, row = signals.target, brain.table[scent_row(brain.units)]
    x, y = position[0], position[1]
    for i in range(x.size):
        row[i] = scent(x[i] - target[0], y[i] - target[1], target[2], target[3])
    if signals.noise.size and signals.noise[0] > 0.0:
        seeded(signals.random, 2 * step)
        for i in range(x.size):
            row[i] = min(max(row[i] + signals.noise[0] * normal(signals.random), 0.0), target[2])


@lean
def disturb(brain, signals, step):
    """After a regulation step: noise on concentrations, which stay in [0, 1]; noise of actuation goes on with the same random numbers."""
    random = signals.random
    seeded(random, 2 * step + 1)
    if signals.noise[1] > 0.0:
        table, nodes, cells = brain.table, brain.network.nodes, brain.activation.size
        for row in range(nodes.size):
            c = table[nodes[row]]
            for i in range(cells):
                c[i] = min(max(c[i] + signals.noise[1] * normal(random), 0.0), 1.0)
        find_activation(brain)


@lean
def seeded(random, count):
    """Start the numbers of a step over: they depend on the seed and the step alone."""
    random[1] = random[0] + np.uint64(count) * _A
    random[1] = _next(random)


@lean
def _next(random):
    """64 random bits (splitmix64, Steele, Lea and Flood 2014)."""
    random[1] += _PER_STEP
    z = random[1]
    z = (z ^ (z >> _30)) * _A
    z = (z ^ (z >> _27)) * _B
    return z ^ (z >> _31)


@lean
def normal(random):
    """A number of mean 0 and variance 1, the sum of twelve uniform ones: normal up to 3 deviations, never beyond 6.

    The same bits on every machine, without a maths library.
    """
    total = 0.0
    for _ in range(3):
        z = _next(random)
        part = (z & _LOW) + ((z >> _16) & _LOW) + ((z >> _32) & _LOW) + (z >> _48)
        total += np.float64(part)
    return (total + 6.0) / 65536.0 - 6.0
