"""The numbers of the genetic algorithm, and named sets of them: the schemes of a search."""

from __future__ import annotations

from dataclasses import dataclass

from evodevo_sim.parameters import Checked, ParameterError, parameter


@dataclass(frozen=True)
class Settings(Checked):
    """The genetic algorithm's numbers, and the random genomes that it starts from."""

    population: int = parameter(100, 2, 1_000_000, "", "individuals")
    generations: int = parameter(50, 1, 1_000_000_000, "", "to run at the most")
    patience: int = parameter(500, 1, 1_000_000_000, "", "generations without improvement that end a run")
    elite: int = parameter(2, 1, 1_000_000, "", "best individuals, of each layer or niche, that live on unchanged")
    tournament: int = parameter(4, 1, 1_000_000, "", "individuals drawn to choose a parent")
    layers: int = parameter(1, 1, 1000, "", "of ages (ALPS), equal parts of the population; 1: none, every individual competes with every other")
    age_gap: int = parameter(20, 1, 1_000_000_000, "", "generations after which random genomes fill the youngest layer again")
    niches: int = parameter(1, 1, 1000, "", "of body shapes, equal parts of the population that do not compete; 1: none")
    founders: int = parameter(0, 0, 1_000_000, "", "genomes in the first generation, of which the best stay; 0: as many as the population")
    crossover: float = parameter(0.2, 0.0, 1.0, "", "share of the children that have two parents")
    point_mutation: float = parameter(0.03, 0.0, 1.0, "", "probability that an element's point moves")
    point_scale: float = parameter(1.0, 0.0, 1e3, "", "standard deviation of the length of that move")
    point_decades: float = parameter(0.0, 0.0, 10.0, "", "powers of ten below point_scale down to which each child draws a scale of its own")
    duplication: float = parameter(0.05, 0.0, 1.0, "", "probability per child")
    deletion: float = parameter(0.05, 0.0, 1.0, "", "probability per child")
    run_length: float = parameter(2.6, 1.0, 1e3, "", "mean elements in a duplicated or deleted run")
    flip: float = parameter(0.005, 0.0, 1.0, "", "probability per element of a change of sign, or of a gene's kind")
    units: int = parameter(20, 0, 10_000, "", "regulatory units in a random genome")
    extent: float = parameter(1.0, 0.0, 1e3, "", "half side of the square of a random genome's points")
    scent_extent: float = parameter(0.0, 0.0, 1e3, "", "half side of the square of the scent's points in random genomes; 0 is extent")
    scent_mutation: float = parameter(0.0, 0.0, 1.0, "", "probability per child that the scent's point moves, beyond point_mutation")
    start_share: float = parameter(0.5, 0.0, 1.0, "", "of the first population, that given genomes and their mutants make up")

    def __post_init__(self):
        super().__post_init__()
        for name in ("layers", "niches"):
            if self.population % getattr(self, name):
                raise ParameterError(f"settings.{name} is {getattr(self, name)}: give a number that divides the population of {self.population}")
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

    def layer_of(self, age: int) -> int:
        """The lowest layer that is open to an age in generations: those below 1, 2, 4, 9, 16, ... gaps; the last has no limit."""
        layer = 0
        while layer < self.layers - 1 and age >= self.age_gap * max(layer + 1, layer**2):
            layer += 1
        return layer


# What differs from the defaults of Settings, by scheme.  "paper": its section 3, and what its authors' saved files fit.
SCHEMES: dict[str, dict[str, float]] = {
    "panmictic": {},
    "paper": {"tournament": 2, "point_mutation": 0.1, "point_scale": 3.0, "flip": 0.0},
    "alps": {"layers": 5},
    "niches": {"niches": 5, "founders": 1000, "point_decades": 1.0, "tournament": 2},
}
_ROOM = 10  # individuals of a niche, at the least, of which something can evolve
# The same by task, below what a scheme says: docs/chemotaxis.md.
OF_TASK = {"chemotaxis": {"scent_extent": 6.0, "scent_mutation": 0.25, "point_mutation": 0.015, "point_scale": 0.7}}


def default_scheme(task: str, settings: dict[str, float] | None = None) -> str:
    """The scheme of a search that names none: niches for swimmers, where its other settings leave them room (docs/model.md)."""
    chosen, niches = settings or {}, SCHEMES["niches"]["niches"]
    size, over = divmod(chosen.get("population", Settings.population), niches)
    fits = size >= _ROOM and not over and chosen.get("layers", 1) == 1
    return "niches" if task == "swim" and fits else "panmictic"


def scheme(name: str, task: str = "swim") -> dict[str, float]:
    """What a scheme and a task change, for `Settings(**scheme(name, task))`.  Raises ParameterError where there is none of that name."""
    if name not in SCHEMES:
        raise ParameterError(f"scheme {name!r} is unknown: choose one of {', '.join(SCHEMES)}")
    return OF_TASK.get(task, {}) | SCHEMES[name]
