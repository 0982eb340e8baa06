"""The genetic algorithm of the paper (section 3), ask/tell shaped: evaluation belongs to the caller.

    evolution = Evolution(Settings(population=100), seed=1)
    while not evolution.finished:
        generation = evolution.tell([evaluate(genome, task, seed) for genome in evolution.ask()])
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from evodevo_sim import Evaluation, Genome, ParameterError, Status, random_genome
from evodevo_sim.parameters import Checked, parameter

from .operators import crossover, delete, duplicate, flip, mutate_points, mutate_scent, scatter_scent, tournament


@dataclass(frozen=True)
class Settings(Checked):
    """The genetic algorithm's numbers, and the random genomes that it starts from."""

    population: int = parameter(100, 2, 1_000_000, "", "individuals")
    generations: int = parameter(50, 1, 1_000_000_000, "", "to run at the most")
    patience: int = parameter(500, 1, 1_000_000_000, "", "generations without improvement that end a run")
    elite: int = parameter(2, 1, 1_000_000, "", "best individuals that live on unchanged")
    tournament: int = parameter(4, 1, 1_000_000, "", "individuals drawn to choose a parent")
    crossover: float = parameter(0.2, 0.0, 1.0, "", "share of the children that have two parents")
    point_mutation: float = parameter(0.03, 0.0, 1.0, "", "probability that an element's point moves")
    point_scale: float = parameter(1.0, 0.0, 1e3, "", "standard deviation of the length of that move")
    duplication: float = parameter(0.05, 0.0, 1.0, "", "probability per child")
    deletion: float = parameter(0.05, 0.0, 1.0, "", "probability per child")
    run_length: float = parameter(2.6, 1.0, 1e3, "", "mean elements in a duplicated or deleted run")
    flip: float = parameter(0.005, 0.0, 1.0, "", "probability per element of a change of sign, or of a gene's kind")
    units: int = parameter(20, 0, 10_000, "", "regulatory units in a random genome")
    extent: float = parameter(1.0, 0.0, 1e3, "", "half side of the square of a random genome's points")
    scent_extent: float = parameter(0.0, 0.0, 1e3, "", "half side of the square of the scent's points in the first population; 0 is extent")
    scent_mutation: float = parameter(0.0, 0.0, 1.0, "", "probability per child that the scent's point moves, beyond point_mutation")
    start_share: float = parameter(0.5, 0.0, 1.0, "", "of the first population, that given genomes and their mutants make up")

    def __post_init__(self):
        super().__post_init__()
        if self.elite >= self.population:
            raise ParameterError(f"settings.elite is {self.elite}: give less than the population of {self.population}")


@dataclass(frozen=True)
class Individual:
    genome: Genome
    evaluation: Evaluation


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
        self._children: list[Genome] = []
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
            s = self.settings
            rng = np.random.default_rng((self.seed, self.generation + 1))
            if self.population:
                self._children = [self._child(rng) for _ in range(s.population - s.elite)]
            else:
                self._children = self._first(rng)
            known = self._known()
            self._asked = list({genome.key(): genome for genome in self._children if genome.key() not in known}.values())
        return self._asked

    def tell(self, evaluations: list[Evaluation]) -> Generation:
        """Take the evaluations of what `ask` gave, in its order, and make the next population of them."""
        if not self._children or len(evaluations) != len(self._asked):
            raise ValueError(f"{len(evaluations)} evaluations for {len(self._asked)} genomes: give one each, in the order asked")
        known = self._known() | {genome.key(): evaluation for genome, evaluation in zip(self._asked, evaluations)}
        before = self.champion.evaluation.fitness if self.population else -np.inf
        children = [Individual(genome, known[genome.key()]) for genome in self._children]
        elite = self.population[: self.settings.elite]
        # The sort is stable and children come first, so of equals the younger lives on: neutral drift.
        self.population = sorted(children + elite, key=lambda one: -one.evaluation.fitness)
        self._children, self._asked = [], []
        self.generation += 1
        self.evaluations += len(evaluations)
        improved = self.champion.evaluation.fitness > before
        self.stagnation = 0 if improved else self.stagnation + 1
        return self._statistics(improved)

    def _known(self) -> dict[bytes, Evaluation]:
        return {one.genome.key(): one.evaluation for one in self.population}

    def _child(self, rng: np.random.Generator) -> Genome:
        s = self.settings
        fitness = np.array([one.evaluation.fitness for one in self.population])
        genome = self.population[tournament(fitness, rng, s.tournament)].genome
        if rng.random() < s.crossover:
            genome = crossover(genome, self.population[tournament(fitness, rng, s.tournament)].genome, rng)
        return self._mutant(genome, rng)

    def _first(self, rng: np.random.Generator) -> list[Genome]:
        s, given = self.settings, list(self.start[: self.settings.population])
        count = round(s.start_share * s.population) if given else 0
        others = [self._mutant(given[k % len(given)], rng) for k in range(len(given), count)]
        others += [random_genome(rng, s.units, s.extent) for _ in range(s.population - len(given) - len(others))]
        return given + [scatter_scent(genome, rng, s.scent_extent) if s.scent_extent else genome for genome in others]

    def _mutant(self, genome: Genome, rng: np.random.Generator) -> Genome:
        s = self.settings
        if rng.random() < s.duplication:
            genome = duplicate(genome, rng, s.run_length)
        if rng.random() < s.deletion:
            genome = delete(genome, rng, s.run_length)
        genome = flip(mutate_points(genome, rng, s.point_mutation, s.point_scale), rng, s.flip)
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
