"""One body for all: networks vary, and what a genome grows to does not.  For a body that is there, and cannot change.

The body is that of the first genome given, or else of the first random one that has a chamber.  Children whose cells grow elsewhere are
drawn again, by growth alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from evodevo_sim.development.shape import same_cells
from evodevo_sim.tasks.grown import Grown
from evodevo_sim.tasks.outcome import Status

from evodevo_sim import Evaluation, Genome, Metrics, ParameterError

from .archive import lives
from .emitters import Draft, graft_gait, keep_body
from .founding import random_founder
from .individual import Child, Individual
from .nursery import Nursery
from .parts import graft
from .search import Search
from .settings import Settings
from .variation import Parents

_UNKNOWN = Evaluation(0.0, Status.OK, "", Metrics())  # of what is given, before it has lived
NEAR = 0.05  # m, half of what a driver of hardware allows: farthest that a cell may grow from where the body has it
_TRIES = 60  # drafts for each child
_GRAFTS, _RANDOM = 0.2, 0.1  # shares of the drafts that take the gait of another elite, or one at random


class OneBody(Search):
    """The fittest of all networks of one body stay."""

    def __init__(self, settings: Settings):
        super().__init__(settings)
        self._nursery: Nursery | None = None

    @property
    def nursery(self) -> Nursery:
        if self._nursery is None:
            if self.task is None:
                raise ParameterError("the search of one body grows bodies: give Evolution the task")
            self._nursery = Nursery(self.task)
        return self._nursery

    def first(self, start: Sequence[Genome], rng: np.random.Generator) -> list[Child]:
        given = [Child(genome, operators=("given",)) for genome in start] or [self._random_body(rng)]
        body = self.nursery.grow(given[0].genome)
        if body.status != Status.OK:
            raise ParameterError("the first genome grows no body with a chamber: give another one by --start")
        ours = self.settings.start_share if start else 0.0
        parents = [Individual(one.genome, _UNKNOWN, number=k) for k, one in enumerate(given) if self._fits(one.genome, body)]
        mutants = max(0, round(ours * self.settings.population) - len(given))
        children = given + self._drawn(mutants, body, lambda own: keep_body(parents, self.settings, self.nursery, own), rng, given)
        missing = self.settings.population - len(children)
        return children + self._drawn(missing, body, lambda own: self._random_gait(given[0].genome, own), rng, children)

    def breed(self, population: list[Individual], generation: int, rng: np.random.Generator) -> list[Child]:
        elites = [one for one in population if lives(one)]
        if not elites:
            return self.first(self.start, rng)
        first = self.start[0] if self.start else elites[0].genome
        count = self.settings.population - self.settings.elite
        known = [Child(one.genome) for one in population]
        body = self.nursery.grow(first)
        children = self._drawn(count, body, lambda own: self._draft(elites, own), rng, known)
        return children or [Child(elites[0].genome, elites[0].born, parents=(elites[0].number,))]

    def survive(self, population: list[Individual], children: list[Individual], generation: int) -> list[Individual]:
        stay: dict[bytes, Individual] = {}
        for one in sorted(children + population, key=lambda one: -one.evaluation.fitness):  # of equals the younger lives on
            stay.setdefault(one.genome.key(), one)
        best = list(stay.values())[: self.settings.population]
        self.nursery.forget([*self.start[:1], *(one.genome for one in best)])
        return best

    def _fits(self, genome: Genome, body: Grown) -> bool:
        return same_cells(self.nursery.grow(genome).position, body.position, NEAR)

    def _drawn(self, count, body, draft, rng, known: Sequence[Child]) -> list[Child]:
        """So many children of the body that are not yet known, or fewer where they are hard to find."""
        lived = {self.nursery.grow(one.genome).key for one in known}
        children: list[Child] = []
        growths = 0
        for _ in range(_TRIES * count):
            if len(children) == count:
                break
            found = draft(rng)
            growths += found.growths
            if found.child is None or not self._fits(found.child.genome, body):
                continue
            key = self.nursery.grow(found.child.genome).key
            if key not in lived:
                lived.add(key)
                children.append(replace(found.child, growths=growths))
                growths = 0
        return children

    def _draft(self, elites: list[Individual], rng: np.random.Generator) -> Draft:
        drawn = rng.random()
        if drawn < _GRAFTS:
            return graft_gait(elites, self.settings, self.nursery, rng)
        if drawn < _GRAFTS + _RANDOM:
            parent = Parents(elites).draw(rng, self.settings.tournament)
            found = self._random_gait(parent.genome, rng)
            return found if found.child is None else replace(found, child=replace(found.child, parents=(parent.number,)))
        return keep_body(elites, self.settings, self.nursery, rng)

    def _random_gait(self, body: Genome, rng: np.random.Generator) -> Draft:
        return Draft(Child(graft(body, random_founder(self.settings, rng)), operators=("random",)), 1)

    def _random_body(self, rng: np.random.Generator) -> Child:
        for _ in range(max(self.settings.founders, 1000)):
            genome = random_founder(self.settings, rng)
            if self.nursery.grow(genome).status == Status.OK:
                return Child(genome, operators=("random",))
        raise ParameterError("no random genome grows a body with a chamber: give one by --start")
