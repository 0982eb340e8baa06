"""The numbers of the genetic algorithm.  They are one flat set, as the command line's flags and the message `Evolution` have them."""

from __future__ import annotations

from dataclasses import dataclass

from evodevo_sim.genetics.elements import HEADER
from evodevo_sim.genetics.limits import MAX_ELEMENTS
from evodevo_sim.parameters import Checked, ParameterError, parameter

UNLIMITED = 1_000_000_000  # generations: more than any run takes, so that patience ends it
MOST_UNITS = (MAX_ELEMENTS - HEADER) // 4  # of up to four elements each


@dataclass(frozen=True)
class Settings(Checked):
    """The genetic algorithm's numbers, and the random genomes that it starts from."""

    population: int = parameter(100, 2, 1_000_000, "", "individuals")
    generations: int = parameter(50, 1, UNLIMITED, "", "to run at the most")
    patience: int = parameter(500, 1, 1_000_000_000, "", "generations without improvement that end a run")
    elite: int = parameter(2, 1, 1_000_000, "", "best individuals, of each layer or niche, that live on unchanged")
    tournament: int = parameter(4, 1, 1_000_000, "", "individuals drawn to choose a parent")
    layers: int = parameter(
        1, 1, 1000, "", "of ages (ALPS), equal parts of the population; 1: none, every individual competes with every other"
    )
    age_gap: int = parameter(20, 1, 1_000_000_000, "", "generations after which random genomes fill the youngest layer again")
    niches: int = parameter(1, 1, 1000, "", "of body shapes, equal parts of the population that do not compete; 1: none")
    founders: int = parameter(0, 0, 1_000_000, "", "genomes in the first generation, of which the best stay; 0: as many as the population")
    elongations: int = parameter(1, 1, 1000, "", "of bodies, parts of their range that an archive keeps apart")
    fillings: int = parameter(1, 1, 1000, "", "shares of chambers, parts of their range that an archive keeps apart")
    redraws: int = parameter(0, 0, 1000, "", "times at the most that an archive's child is drawn again, until its body is as meant")
    crossover: float = parameter(0.2, 0.0, 1.0, "", "share of the children that have two parents")
    point_mutation: float = parameter(0.03, 0.0, 1.0, "", "probability that an element's point moves")
    point_scale: float = parameter(1.0, 0.0, 1e3, "", "standard deviation of the length of that move")
    point_decades: float = parameter(
        0.0, 0.0, 10.0, "", "powers of ten below point_scale down to which each child draws a scale of its own"
    )
    duplication: float = parameter(0.05, 0.0, 1.0, "", "probability per child")
    deletion: float = parameter(0.05, 0.0, 1.0, "", "probability per child")
    run_length: float = parameter(2.6, 1.0, 1e3, "", "mean elements in a duplicated or deleted run")
    flip: float = parameter(0.005, 0.0, 1.0, "", "probability per element of a change of sign, or of a gene's kind")
    units: int = parameter(20, 0, MOST_UNITS, "", "regulatory units in a random genome")
    extent: float = parameter(1.0, 0.0, 1e3, "", "half side of the square of a random genome's points")
    apart: float = parameter(
        0.0, 0.0, 1e3, "", "way from the inputs to the networks of growth and of gait, on either side, in random genomes; 0: one network"
    )
    scent_extent: float = parameter(0.0, 0.0, 1e3, "", "half side of the square of the scent's points in random genomes; 0 is extent")
    scent_mutation: float = parameter(0.0, 0.0, 1.0, "", "probability per child that the scent's point moves, beyond point_mutation")
    start_share: float = parameter(0.5, 0.0, 1.0, "", "of the first population, that given genomes and their mutants make up")

    def __post_init__(self):
        super().__post_init__()
        for name in ("layers", "niches"):
            if self.population % getattr(self, name):
                raise ParameterError(
                    f"settings.{name} is {getattr(self, name)}: give a number that divides the population of {self.population}"
                )
        if self.layers > 1 and self.niches > 1:
            raise ParameterError(f"settings.niches is {self.niches} and settings.layers {self.layers}: give 1 for one of them")
        what = "a layer" if self.layers > 1 else "a niche"
        group = f"the {self.size} individuals of {what}" if self.size < self.population else f"the population of {self.population}"
        if self.elite >= self.size:
            raise ParameterError(f"settings.elite is {self.elite}: give less than {group}")
        if self.tournament > self.size:
            raise ParameterError(f"settings.tournament is {self.tournament}: give no more than {group}")

    @property
    def size(self) -> int:
        """Individuals of a layer or niche."""
        return self.population // max(self.layers, self.niches)
