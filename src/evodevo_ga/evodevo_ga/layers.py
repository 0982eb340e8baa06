"""A population in layers of age (ALPS, Hornby 2006), so that the search begins again for ever beside the best that it has.

The age of an individual is that of its oldest line, from the random genome on.  A layer is bred from itself and from the one below;
who is too old for its layer moves up, where the best remain; random genomes fill the youngest layer every `age_gap` generations.  So
what is new competes with its like until it has had its time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from evodevo_sim import Genome

from .individual import Child, Individual
from .panmictic import Panmictic
from .variation import Parents, child_of, random_children


class Layers(Panmictic):
    """Layers of ages, equal parts of the population, each with its elite."""

    def group(self, one: Individual) -> int:
        return one.layer

    def first(self, start: Sequence[Genome], rng: np.random.Generator) -> list[Child]:
        """What is given and its mutants are in the oldest layers, random genomes in the others."""
        s = self.settings
        return [replace(child, layer=max(0, s.layers - 1 - k // s.size)) for k, child in enumerate(super().first(start, rng))]

    def breed(self, population: list[Individual], generation: int, rng: np.random.Generator) -> list[Child]:
        s, children = self.settings, []
        for layer in range(s.layers):
            if layer == 0 and s.layers > 1 and generation % s.age_gap == 0:
                children += random_children(s.size, generation, s, rng)
                continue
            # Where all have just moved up, there may be no parents nearer than the youngest layer, which is never empty.
            near = [one for one in population if layer - 1 <= one.layer <= layer] or [one for one in population if one.layer < layer]
            parents = Parents(near)
            children += [child_of(parents, s, rng, layer) for _ in range(s.size - s.elite)]
        return children

    def survive(self, population: list[Individual], children: list[Individual], generation: int) -> list[Individual]:
        everyone = children + self._best(population, self.settings.elite)
        moved = [replace(one, layer=max(one.layer, self.layer_of(generation - one.born))) for one in everyone]
        return self._best(sorted(moved, key=lambda one: -one.evaluation.fitness), self.settings.size)

    def layer_of(self, age: int) -> int:
        """The lowest layer that is open to an age in generations: those below 1, 2, 4, 9, 16, ... gaps; the last has no limit."""
        layer = 0
        while layer < self.settings.layers - 1 and age >= self.settings.age_gap * max(layer + 1, layer**2):
            layer += 1
        return layer
