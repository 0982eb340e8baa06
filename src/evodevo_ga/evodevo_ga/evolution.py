"""The genetic algorithm (paper section 3), ask/tell shaped: evaluation belongs to the caller.

    evolution = Evolution(Settings(population=100), seed=1)
    while not evolution.finished:
        generation = evolution.tell([evaluate(genome, task, seed) for genome in evolution.ask()])

Who breeds and who stays is up to a `Search`: one population (`panmictic`), in layers of age (`layers`), in niches of body shapes
(`niches`), or one of your own (docs/guide/search.md).
"""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from operator import index
from typing import Any

import numpy as np

from evodevo_sim import Evaluation, Genome, GenomeError, ParameterError, Status, Task

from .individual import Child, Individual, genome_of_plain, individual_of_plain, plain_genome, plain_individual
from .likeness import diversity
from .schemes import search_of
from .settings import Settings

_STATE = 1  # version of the plain data
_COUNTERS = ("generation", "evaluations", "stagnation", "bred", "growths")


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
    population; the rest is random.  scheme: name of the one whose search this is; where that is one population, layers or niches
    above 1 in `settings` part it; task: what for, for searches that grow bodies before they live.

    Attributes: population (best first), champion, generation (of the population), evaluations, children (of the last generation,
    whether they stayed or not), bred (children so far), growths (of bodies alone so far, an eighth of an evaluation each), search, bars
    (none, or for each genome asked the fitness that it must reach to be of any use, see `evaluate`).
    """

    def __init__(
        self, settings: Settings = Settings(), seed: int = 0, start: Sequence[Genome] = (), scheme: str = "panmictic",
        task: Task | None = None,
    ):
        if isinstance(seed, bool) or not isinstance(seed, int) or not 0 <= seed < 2**63:
            raise ParameterError(f"seed is {seed!r}: give a whole number from 0 to 2^63 - 1")
        self.settings = settings
        self.seed = seed
        self.start = tuple(start)
        self.scheme = scheme
        self.search = search_of(settings, scheme)
        self.search.task, self.search.start = task, self.start
        self.population: list[Individual] = []
        self.children: list[Individual] = []
        self.generation = -1
        self.evaluations = 0
        self.stagnation = 0
        self.bred = 0
        self.growths = 0
        self.bars: tuple[float, ...] = ()
        self._children: list[Child] = []
        self._keys: list[bytes] = []  # of their genomes
        self._known: dict[bytes, Evaluation] = {}  # of the population, by its genomes
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
            now = self.generation + 1
            rng = np.random.default_rng((self.seed, now))
            bred = self.search.breed(self.population, now, rng) if self.population else self.search.first(self.start, rng)
            self._children = list(_some(bred, "bred", self.scheme))
            self._keys = [one.genome.key() for one in self._children]
            self._known = {one.genome.key(): one.evaluation for one in self.population}
            asked = {key: one.genome for key, one in zip(self._keys, self._children) if key not in self._known}
            self._asked = list(asked.values())
            bars: dict[bytes, float] = {}
            for key, one in zip(self._keys, self._children):
                bars[key] = min(one.bar, bars.get(key, one.bar))
            given = tuple(bars[key] for key in asked)
            self.bars = given if any(bar > -np.inf for bar in given) else ()
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
        keys = (key for key in dict.fromkeys(self._keys) if key not in self._known)  # as `ask` gave their genomes
        known = self._known | dict(zip(keys, evaluations))
        before = self.champion.evaluation.fitness if self.population else -np.inf
        children = [
            Individual(one.genome, known[key], one.born, one.layer, self.bred + k, one.parents, one.operators)
            for k, (key, one) in enumerate(zip(self._keys, self._children))
        ]
        settled = _some(self.search.survive(self.population, children, self.generation + 1), "settled", self.scheme)
        if any(one.evaluation.status == Status.STOPPED for one in settled):
            raise ValueError(f"the search of scheme {self.scheme!r} has settled one whose life was stopped: its fitness is a bound alone")
        self.population = sorted(settled, key=lambda one: -one.evaluation.fitness)
        self.children = children
        self.generation += 1
        self.bred += len(children)
        self.growths += sum(one.growths for one in self._children)
        self._children, self._asked, self.bars, self._keys, self._known = [], [], (), [], {}
        self.evaluations += len(evaluations)
        improved = self.champion.evaluation.fitness > before
        self.stagnation = 0 if improved else self.stagnation + 1
        return self._statistics(improved)

    def state(self) -> dict[str, Any]:
        """All that the run is after its last generation, as plain data that JSON carries without the loss of a bit."""
        genomes = {"start": [plain_genome(genome) for genome in self.start]}
        return self.progress() | genomes | {"population": [plain_individual(one) for one in self.population]}

    def progress(self) -> dict[str, Any]:
        """`state` without its `start` and `population`."""
        return {
            "version": _STATE, "scheme": self.scheme, "settings": dataclasses.asdict(self.settings), "seed": self.seed,
            **{name: getattr(self, name) for name in _COUNTERS}, "search": self.search.state(),
        }

    @classmethod
    def resumed(cls, state: dict[str, Any], task: Task | None = None) -> Evolution:
        """The run that gave this state away, for the same task: it goes on with the same bits.  Its scheme must be registered."""
        version = state.get("version")
        if version != _STATE:
            raise ParameterError(f"state of version {version!r}: give one of version {_STATE}, which this program reads")
        try:
            start = [genome_of_plain(genome) for genome in state["start"]]
            settings = Settings(**{field.name: state["settings"][field.name] for field in dataclasses.fields(Settings)})
            evolution = cls(settings, state["seed"], start, state["scheme"], task)
            for name in _COUNTERS:
                setattr(evolution, name, index(state[name]))
            evolution.population = [individual_of_plain(one) for one in state["population"]]
            evolution.search.restore(state["search"])
        except (ParameterError, GenomeError):
            raise
        except (AttributeError, KeyError, TypeError, ValueError) as error:
            what = f"{type(error).__name__}: {error}"[:200]
            raise ParameterError(f"state that is not whole ({what}): give what a run gave away, unchanged") from None
        return evolution

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


def _some(given: list, done: str, scheme: str) -> list:
    if not given:
        raise ValueError(f"the search of scheme {scheme!r} has {done} nobody: let it give one at the least")
    return given
