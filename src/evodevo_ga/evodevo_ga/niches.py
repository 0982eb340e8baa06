"""Niches of body shapes: slender bodies start slowly and swim farthest, so they need a while without compact ones as rivals.

A niche is a range of the chambers that a body has, as a share of those of the most compact one: 2 n - 5 for n cells, whose
outline is a triangle.  A ribbon two cells wide has a half of them, grown swarms three quarters.  A niche is bred from itself, a child
belongs to where its own body does, and each niche keeps its best.
"""

from __future__ import annotations

import math

import numpy as np

from evodevo_sim import Metrics

from .individual import Child, Individual
from .panmictic import Panmictic
from .variation import Parents, child_of

_SLENDER, _COMPACT = 0.5, 0.78  # shares of chambers between which the niches but the first are spread evenly


def niche_of(metrics: Metrics, niches: int) -> int:
    """The niche of a body: 0 for the most slender, with branches and holes, and for what has no chamber; niches - 1 for compact."""
    if niches == 1 or metrics.chambers == 0:
        return 0
    share = metrics.chambers / max(1, 2 * metrics.cells - 5)
    return min(max(math.floor(1 + (share - _SLENDER) / ((_COMPACT - _SLENDER) / (niches - 1))), 0), niches - 1)


class Niches(Panmictic):
    """Niches of body shapes, equal parts of the population, each with its elite."""

    def group(self, one: Individual) -> int:
        return niche_of(one.evaluation.metrics, self.settings.niches)

    def breed(self, population: list[Individual], generation: int, rng: np.random.Generator) -> list[Child]:
        """Children of parents of one niche each, which is drawn evenly from those that are settled."""
        s = self.settings
        niches: dict[int, list[Individual]] = {}
        for one in population:
            niches.setdefault(self.group(one), []).append(one)
        settled = [Parents(individuals) for individuals in niches.values()]
        return [child_of(settled[rng.integers(len(settled))], s, rng) for _ in range(s.population - s.elite)]
