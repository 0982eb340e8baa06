"""The genetic algorithm (paper section 3), ask/tell shaped: evaluation belongs to the caller.

    evolution = Evolution(Settings(population=100), seed=1)
    while not evolution.finished:
        generation = evolution.tell([evaluate(genome, task, seed) for genome in evolution.ask()])

With `Settings(layers=...)` the population is layered by age (ALPS, Hornby 2006).  The age of an individual is that of its oldest
line, from the random genome on.  A layer is bred from itself and from the one below; who is too old for its layer moves up, where
the best remain; random genomes fill the youngest layer every `age_gap` generations.  So what is new competes with its like until
it has had its time, and the search begins again for ever beside the best that it has.

With `Settings(niches=...)` it is parted by body shape instead, see `niches`.  A niche is bred from itself, a child belongs to
where its own body does, and each niche keeps its best.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from evodevo_sim import Evaluation, Genome, ParameterError, Status, random_genome

from .niches import niche_of
from .operators import crossover, delete, duplicate, flip, mutate_points, mutate_scent, scatter_scent, tournament
from .settings import Settings


@dataclass(frozen=True)
class Individual:
    """Attributes: born: generation of the random genome from which its oldest line comes; layer: of ages, 0 the youngest."""

    genome: Genome
    evaluation: Evaluation
    born: int = 0
    layer: int = 0


class _Child(NamedTuple):
    genome: Genome
    born: int
    layer: int


@dataclass(frozen=True)
class Generation:
    """Statistics of one generation; the fields are those of `evodevo_msgs/GenerationStatistics`."""

    generation: int
    best: float
    median: float
    worst: float
    diversity: float
    median_elements: float
    evaluations: int
    stagnation: int
    status_count: tuple[int, ...]
    improved: bool


class Evolution:
    """A run: `ask` for the genomes to evaluate, `tell` their evaluations, until `finished`.

    Every generation draws from its own generator, seeded by (seed, generation), so a run does not depend on who evaluated
    what, or in which order.

    Args: start: genomes to begin from, each as it is and then in mutants, in turn, up to `settings.start_share` of the first
    population; the rest is random.

    Attributes: population (best first), champion, generation (of the population), evaluations.
    """

    def __init__(self, settings: Settings = Settings(), seed: int = 0, start: Sequence[Genome] = ()):
        if isinstance(seed, bool) or not isinstance(seed, int) or not 0 <= seed < 2**63:
            raise ParameterError(f"seed is {seed!r}: give a whole number from 0 to 2^63 - 1")
        self.settings = settings
        self.seed = seed
        self.start = tuple(start)
        self.population: list[Individual] = []
        self.generation = -1
        self.evaluations = 0
        self.stagnation = 0
        self._children: list[_Child] = []
        self._asked: list[Genome] = []

    @property
    def champion(self) -> Individual:
        return self.population[0]

    @property
    def finished(self) -> bool:
        return self.generation + 1 >= self.settings.generations or self.stagnation >= self.settings.patience

    def ask(self) -> list[Genome]:
        """The next generation's genomes that still need an evaluation: each once, and none that the population knows."""
        if not self._children:
            rng = np.random.default_rng((self.seed, self.generation + 1))
            self._children = self._breed(rng) if self.population else self._first(rng)
            known = self._known()
            self._asked = list({one.genome.key(): one.genome for one in self._children if one.genome.key() not in known}.values())
        return self._asked

    def tell(self, evaluations: list[Evaluation]) -> Generation:
        """Take the evaluations of what `ask` gave, in its order, and make the next population of them.

        Raises ValueError, and changes nothing, where there are not as many, or a fitness is no finite number.
        """
        if not self._children or len(evaluations) != len(self._asked):
            raise ValueError(f"{len(evaluations)} evaluations for {len(self._asked)} genomes: give one each, in the order asked")
        for k, evaluation in enumerate(evaluations):
            if not np.isfinite(evaluation.fitness):
                raise ValueError(f"evaluation {k} has a fitness of {evaluation.fitness}: give a finite number")
        known = self._known() | {genome.key(): evaluation for genome, evaluation in zip(self._asked, evaluations)}
        before = self.champion.evaluation.fitness if self.population else -np.inf
        children = [Individual(genome, known[genome.key()], born, layer) for genome, born, layer in self._children]
        self.generation += 1
        self.population = self._settle(children + self._elite())
        self._children, self._asked = [], []
        self.evaluations += len(evaluations)
        improved = self.champion.evaluation.fitness > before
        self.stagnation = 0 if improved else self.stagnation + 1
        return self._statistics(improved)

    def _known(self) -> dict[bytes, Evaluation]:
        return {one.genome.key(): one.evaluation for one in self.population}

    def _group(self, one: Individual) -> int:
        """Its layer or niche: who competes with whom."""
        return one.layer if self.settings.layers > 1 else niche_of(one.evaluation.metrics, self.settings.niches)

    def _elite(self) -> list[Individual]:
        elite, seen = [], Counter()
        for one in self.population:
            group = self._group(one)
            seen[group] += 1
            if seen[group] <= self.settings.elite:
                elite.append(one)
        return elite

    def _settle(self, everyone: list[Individual]) -> list[Individual]:
        """The best, as many as each layer or niche holds, best first.  Who is too old for its layer moves up."""
        s, kept, count = self.settings, [], Counter()
        # The sort is stable and children come first, so of equals the younger lives on: neutral drift.
        for one in sorted(everyone, key=lambda one: -one.evaluation.fitness):
            layer = max(one.layer, s.layer_of(self.generation - one.born))
            one = one if layer == one.layer else replace(one, layer=layer)
            group = self._group(one)
            count[group] += 1
            if count[group] <= s.size:
                kept.append(one)
        return kept

    def _breed(self, rng: np.random.Generator) -> list[_Child]:
        s, now, children = self.settings, self.generation + 1, []
        if s.niches > 1:
            return self._breed_niches(rng)
        for layer in range(s.layers):
            if layer == 0 and s.layers > 1 and now % s.age_gap == 0:
                children += [_Child(genome, now, 0) for genome in self._scattered(self._random(s.size, rng), rng)]
                continue
            # Where all have just moved up, there may be no parents nearer than the youngest layer, which is never empty.
            parents = [p for p in self.population if layer - 1 <= p.layer <= layer] or [p for p in self.population if p.layer < layer]
            fitness = np.array([one.evaluation.fitness for one in parents])
            children += [self._child(parents, fitness, layer, rng) for _ in range(s.size - s.elite)]
        return children

    def _breed_niches(self, rng: np.random.Generator) -> list[_Child]:
        """Children of parents of one niche each, which is drawn evenly from those that are settled."""
        s, niches = self.settings, {}
        for one in self.population:
            niches.setdefault(self._group(one), []).append(one)
        settled = [(parents, np.array([one.evaluation.fitness for one in parents])) for parents in niches.values()]
        return [self._child(*settled[rng.integers(len(settled))], 0, rng) for _ in range(s.population - s.elite)]

    def _child(self, parents: list[Individual], fitness: np.ndarray, layer: int, rng: np.random.Generator) -> _Child:
        s = self.settings
        mother = parents[tournament(fitness, rng, s.tournament)]
        genome, born = mother.genome, mother.born
        if rng.random() < s.crossover:
            father = parents[tournament(fitness, rng, s.tournament)]
            genome, born = crossover(genome, father.genome, rng), min(born, father.born)
        return _Child(self._mutant(genome, rng), born, layer)

    def _first(self, rng: np.random.Generator) -> list[_Child]:
        """The first generation: what is given and its mutants in the oldest layers, random genomes in the others."""
        s, given = self.settings, list(self.start[: self.settings.population])
        count = round(s.start_share * s.population) if given else 0
        others = [self._mutant(given[k % len(given)], rng) for k in range(len(given), count)]
        others += self._random(max(s.population, s.founders) - len(given) - len(others), rng)
        genomes = given + self._scattered(others, rng)
        return [_Child(genome, 0, max(0, s.layers - 1 - k // s.size)) for k, genome in enumerate(genomes)]

    def _random(self, count: int, rng: np.random.Generator) -> list[Genome]:
        return [random_genome(rng, self.settings.units, self.settings.extent) for _ in range(count)]

    def _scattered(self, genomes: list[Genome], rng: np.random.Generator) -> list[Genome]:
        extent = self.settings.scent_extent
        return [scatter_scent(genome, rng, extent) for genome in genomes] if extent else genomes

    def _mutant(self, genome: Genome, rng: np.random.Generator) -> Genome:
        s = self.settings
        if rng.random() < s.duplication:
            genome = duplicate(genome, rng, s.run_length)
        if rng.random() < s.deletion:
            genome = delete(genome, rng, s.run_length)
        scale = s.point_scale * 10.0 ** (-s.point_decades * rng.random()) if s.point_decades else s.point_scale
        genome = flip(mutate_points(genome, rng, s.point_mutation, scale), rng, s.flip)
        if s.scent_mutation and rng.random() < s.scent_mutation:
            genome = mutate_scent(genome, rng, s.point_scale, s.scent_extent)
        return genome

    def _statistics(self, improved: bool) -> Generation:
        fitness = [one.evaluation.fitness for one in self.population]
        status = Counter(one.evaluation.status for one in self.population)
        return Generation(
            generation=self.generation,
            best=fitness[0],
            median=float(np.median(fitness)),
            worst=fitness[-1],
            diversity=diversity([one.genome for one in self.population]),
            median_elements=float(np.median([len(one.genome) for one in self.population])),
            evaluations=self.evaluations,
            stagnation=self.stagnation,
            status_count=tuple(status[s] for s in Status),
            improved=improved,
        )


def diversity(genomes: list[Genome]) -> float:
    """Mean over all pairs of the share of their elements that the two do not have in common, 0 (clones) to 1."""
    if len(genomes) < 2:
        return 0.0
    carriers = Counter(element for genome in genomes for element in set(zip(*(a.tolist() for a in genome.arrays()))))
    elements = sum(carriers.values())
    return 1.0 - sum(n * (n - 1) for n in carriers.values()) / ((len(genomes) - 1) * elements)
