"""One population in which every individual competes with every other; a base for populations in groups that do not."""

from __future__ import annotations

from collections import Counter

import numpy as np

from .individual import Child, Individual
from .search import Search
from .variation import Parents, child_of


class Panmictic(Search):
    """The elite lives on unchanged; of it and the children the best stay.  Groups, if a search has any, do so each on its own."""

    def group(self, one: Individual) -> int:
        """Who competes with whom."""
        return 0

    def breed(self, population: list[Individual], generation: int, rng: np.random.Generator) -> list[Child]:
        parents = Parents(population)
        return [child_of(parents, self.settings, rng) for _ in range(self.settings.population - self.settings.elite)]

    def survive(self, population: list[Individual], children: list[Individual], generation: int) -> list[Individual]:
        # The sort is stable and children come first, so of equals the younger lives on: neutral drift.
        everyone = children + self._best(population, self.settings.elite)
        return self._best(sorted(everyone, key=lambda one: -one.evaluation.fitness), self.settings.size)

    def _best(self, ranked: list[Individual], most: int) -> list[Individual]:
        """The first `most` of each group."""
        seen: Counter[int] = Counter()
        best = []
        for one in ranked:
            group = self.group(one)
            seen[group] += 1
            if seen[group] <= most:
                best.append(one)
        return best
