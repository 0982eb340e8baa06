"""What reaches a body from outside step by step: the target's scent (paper section 4.3), and noise."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..genetics.elements import INPUTS, OUTPUTS
from ..kernels.jit import lean
from .brain import find_activation
from .chance import normal, seeded
from .eyes import Eyes, open_eyes, see

_SCENT = INPUTS - 1  # of the input signals: the last one, so that a scent of 0 changes no bit of the others' sum


class Signals(NamedTuple):
    """What reaches a body from outside."""

    target: np.ndarray  # (x, y) m, scent at the target, and m beyond which there is none; or empty where the scene has no target
    noise: np.ndarray  # standard deviations of sensing, concentrations and actuation; or empty
    random: np.ndarray  # uint64 (2,): seed and state of the generator
    eyes: Eyes  # by which cells are seen, where their place decides what they sense


def make_signals(target=None, peak: float = 0.0, reach: float = 1.0, noise=None, seed: int = 0, eyes: Eyes | None = None) -> Signals:
    """Signals.  Args: target: (x, y) m or None; noise: three standard deviations or None; seed: of the noise; eyes: or perfect ones."""
    where = np.empty(0) if target is None else np.array([*target, peak, reach], float)
    deviations = np.empty(0) if noise is None or not any(noise) else np.array(noise, float)
    return Signals(where, deviations, np.array([seed % 2**64, 0], np.uint64), open_eyes() if eyes is None else eyes)


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
    """Clamp every cell's scent input to the scent at its own place, as it is seen.  Args: position (2, N) m."""
    target, row, eyes, cells = signals.target, brain.table[scent_row(brain.units)], signals.eyes, brain.activation.size
    x, y = position[0], position[1]
    if eyes.seen.size:
        seeded(signals.random, 2 * step)
        see(eyes, position, signals.random, step)
        x, y = eyes.seen[0], eyes.seen[1]
    for i in range(cells):
        row[i] = scent(x[i] - target[0], y[i] - target[1], target[2], target[3])
    if signals.noise.size and signals.noise[0] > 0.0:
        if not eyes.seen.size:
            seeded(signals.random, 2 * step)
        for i in range(cells):
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
