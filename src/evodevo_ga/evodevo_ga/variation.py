"""Where children come from: parents drawn by tournaments, the operators by the numbers of `Settings`, given and random genomes.

Each child says who its parents are and which operators changed it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from evodevo_sim import Genome, random_genome

from .individual import Child, Individual
from .operators import crossover, delete, duplicate, flip, mutate_points, mutate_scent, scatter_scent, tournament
from .settings import Settings


class Parents:
    """Individuals of whom tournaments choose parents by their fitness."""

    def __init__(self, individuals: Sequence[Individual]):
        self._individuals = individuals
        self._fitness = np.array([one.evaluation.fitness for one in individuals])

    def draw(self, rng: np.random.Generator, size: int) -> Individual:
        """The winner of a tournament of `size`."""
        return self._individuals[tournament(self._fitness, rng, size)]


def child_of(parents: Parents, settings: Settings, rng: np.random.Generator, layer: int = 0) -> Child:
    """A child of one parent, or of two by crossover; then mutated.  It is as old as the older of them."""
    mother = parents.draw(rng, settings.tournament)
    genome, born = mother.genome, mother.born
    numbers: tuple[int, ...] = (mother.number,)
    made: tuple[str, ...] = ()
    if rng.random() < settings.crossover:
        father = parents.draw(rng, settings.tournament)
        genome, born = crossover(genome, father.genome, rng), min(born, father.born)
        numbers, made = (mother.number, father.number), ("crossover",)
    genome, changed = mutant(genome, settings, rng)
    return Child(genome, born, layer, numbers, made + changed)


def mutant(genome: Genome, settings: Settings, rng: np.random.Generator) -> tuple[Genome, tuple[str, ...]]:
    """Returns: a genome after all operators of mutation; names of those that changed it."""
    s, made = settings, []
    if rng.random() < s.duplication:
        genome = duplicate(genome, rng, s.run_length)
        made.append("duplicate")
    if rng.random() < s.deletion:
        genome = delete(genome, rng, s.run_length)
        made.append("delete")
    scale = s.point_scale * 10.0 ** (-s.point_decades * rng.random()) if s.point_decades else s.point_scale
    moved = mutate_points(genome, rng, s.point_mutation, scale)
    flipped = flip(moved, rng, s.flip)
    made += [name for name, before, after in (("points", genome, moved), ("flip", moved, flipped)) if after is not before]
    if s.scent_mutation and rng.random() < s.scent_mutation:
        return mutate_scent(flipped, rng, s.point_scale, s.scent_extent), (*made, "scent")
    return flipped, tuple(made)


def random_children(count: int, generation: int, settings: Settings, rng: np.random.Generator) -> list[Child]:
    """Random genomes, the beginning of as many lines."""
    return _scattered(_random(count, generation, settings, rng), settings, rng)


def founders(start: Sequence[Genome], settings: Settings, rng: np.random.Generator) -> list[Child]:
    """The first children of a run: what is given, then its mutants in turn, then random genomes."""
    s = settings
    given = start[: s.population]
    others = []
    for k in range(len(given), round(s.start_share * s.population) if given else 0):
        parent = k % len(given)
        genome, made = mutant(given[parent], s, rng)
        others.append(Child(genome, parents=(parent,), operators=made))
    others += _random(max(s.population, s.founders) - len(given) - len(others), 0, s, rng)
    return [Child(genome, operators=("given",)) for genome in given] + _scattered(others, s, rng)


def _random(count: int, generation: int, settings: Settings, rng: np.random.Generator) -> list[Child]:
    return [Child(random_genome(rng, settings.units, settings.extent), generation, operators=("random",)) for _ in range(count)]


def _scattered(children: list[Child], settings: Settings, rng: np.random.Generator) -> list[Child]:
    """The children with the scent's points anywhere in its own square, if it has one."""
    extent = settings.scent_extent
    if not extent:
        return children
    return [replace(one, genome=scatter_scent(one.genome, rng, extent), operators=(*one.operators, "scatter")) for one in children]
