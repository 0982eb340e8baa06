"""Random numbers of kernels: they follow from a seed and a count alone, the same bits on every machine."""

from __future__ import annotations

import numpy as np

from ..kernels.jit import lean

_PER_STEP = np.uint64(0x9E3779B97F4A7C15)
_A, _B = np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)
_11, _16, _27, _30, _31 = np.uint64(11), np.uint64(16), np.uint64(27), np.uint64(30), np.uint64(31)
_32, _48 = np.uint64(32), np.uint64(48)
_LOW = np.uint64(0xFFFF)


@lean
def seeded(random, count):
    """Start the numbers of a step over: they depend on the seed and the step alone."""
    random[1] = random[0] + np.uint64(count) * _A
    random[1] = bits(random)


@lean
def bits(random):
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
        z = bits(random)
        part = (z & _LOW) + ((z >> _16) & _LOW) + ((z >> _32) & _LOW) + (z >> _48)
        total += np.float64(part)
    return (total + 6.0) / 65536.0 - 6.0


@lean
def uniform(random):
    """A number from 0 to below 1."""
    return np.float64(bits(random) >> _11) * 2.0**-53
