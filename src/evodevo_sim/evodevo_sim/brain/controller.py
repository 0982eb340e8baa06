"""The brain as something that drives a plant: positions in, activation of every cell out, one control step after the other."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..development.growth import REST
from ..kernels.jit import lean, seam
from .brain import Brain, brain_unrest, think
from .eyes import eyes_of
from .scent import Signals, disturb, make_signals, scent_row, sense

if TYPE_CHECKING:
    from ..parameters import DevelopmentArguments, Task


class Rules(NamedTuple):
    """What a control step needs to know."""

    control_step: float  # s
    development: DevelopmentArguments
    continual: bool  # variant B, whose graph is that of growth; in variant A morphogens reach cells by distance and delay
    signals: Signals


@seam
def brain_step(brain, position, rules, step):
    """One control step of every cell, in place: it smells, its network moves, noise disturbs it.  Args: position (2, N) m."""
    signals = rules.signals
    if signals.target.size:
        sense(brain, position, signals, step)
    think(brain, step, rules.development, rules.continual)
    if signals.noise.size:
        disturb(brain, signals, step)


@lean
def brain_rests(brain, rules):
    """Whether no concentration will ever change again, as far as can be told: never in variant A, whose past still arrives, or with noise.

    Nor where cells are seen late."""
    signals = rules.signals
    return rules.continual and not signals.noise.size and not signals.eyes.seen.size and brain_unrest(brain) < REST


class Controller:
    """A brain at work.

    Args: brain: as growth left it; task: whose control step, development and scent hold; seed: of noise.

    Attributes: steps: control steps done; activation (N,): of the last one, a read-only view; signals: for whoever shares its noise.
    """

    def __init__(self, brain: Brain, task: Task, seed: int = 0):
        self.brain, self.steps = brain, 0
        self._scent = task.chemotaxis.scent_peak, task.chemotaxis.scent_reach
        self.signals = make_signals(noise=task.noise.arguments(), seed=seed, eyes=eyes_of(task))
        continual = task.development.variant == "continual_graph"
        self._blind = Rules(task.control_step, task.development.arguments(), continual, self.signals)
        self._target = np.array([0.0, 0.0, *self._scent])
        self._aimed = self._blind._replace(signals=self.signals._replace(target=self._target)) if task.has_target else self._blind
        self.activation = self.brain.activation.view()
        self.activation.flags.writeable = False
        self._born = [(array, array.copy()) for array in (brain.table, brain.past, brain.activation)]

    def reset(self) -> None:
        """Back to birth, at once however long growth took."""
        for array, at_birth in self._born:
            array[...] = at_birth
        self.steps = 0

    def step(self, position: np.ndarray, target: tuple[float, float] | None = None) -> np.ndarray:
        """One control step.  Args: position (N, 2) m: of every cell, as the plant senses it; target: whose scent it smells, or none.

        Returns: activation (N,) of e - c, -1 contracting to 1 expanding; the same array at each step.
        """
        rules = self._aimed
        if target is None and rules is not self._blind:
            self.brain.table[scent_row(self.brain.units)] = 0.0
            self.signals.eyes.seen[...] = np.nan
            rules = self._blind
        elif target is not None:
            self._target[:2] = target
        brain_step(self.brain, np.ascontiguousarray(position.T), rules, self.steps)
        self.steps += 1
        return self.activation

    def rests(self) -> bool:
        """Whether the networks will never change again, as long as nothing reaches them."""
        return bool(brain_rests(self.brain, self._blind))
