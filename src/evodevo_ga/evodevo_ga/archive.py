"""An archive of unlike animals (MAP-Elites: Mouret and Clune 2015): of each kind of body the fittest, held by pyribs.

A kind is a cell of a grid over measures of bodies, which growth alone tells, so a child is known to compete with one elite before it
lives.  Children come from emitters (`emitters.py`), of which each gets the share of a batch that it has lately paid back.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from evodevo_sim.tasks.grown import Grown
from evodevo_sim.tasks.outcome import FAILURE, Status

from evodevo_sim import Genome, ParameterError, Task

from .emitters import USUAL, Draft, emitter
from .founding import bodies_of_founders, given_and_mutants, random_founder
from .individual import Child, Individual
from .measures import measure
from .nursery import Nursery
from .parts import graft
from .search import Search
from .settings import Settings

if TYPE_CHECKING:
    from ribs.archives import GridArchive

GROWTH = 0.125  # of an evaluation, that growth alone takes
_CHUNK = 16  # children drawn side by side
_MEMORY = 0.9  # of what an emitter brought, a batch later
_LEAST = {"keep": 0.4}  # share of the children, for an emitter; the champion is refined by what keeps its body
_LEAST_SHARE = 0.1  # for any other


class Archive(Search):
    """The fittest of each kind of body is an elite, and the elites are the population.

    Args: measures: names of `measures.MEASURES`, the axes of the grid, which `settings.elongations` and `settings.fillings` part;
    emitters: names of `emitters.EMITTERS`.
    """

    LOOK = 0  # growths' worth of time that it takes, beyond growth, to tell the kind of a child

    def __init__(self, settings: Settings, measures: Sequence[str] = ("elongation", "chambers"), emitters: Sequence[str] = USUAL):
        super().__init__(settings)
        self.measures = tuple(measure(name) for name in measures)
        self.emitters = {name: emitter(name) for name in emitters}
        self._brought = {name: [0.0, 0.0] for name in self.emitters}  # fitness that the archive has gained by its children; their number
        self._known: tuple[Nursery, GridArchive] | None = None

    @property
    def nursery(self) -> Nursery:
        return self._place()[0]

    def kind(self, grown: Grown) -> int | None:
        """The cell of a body, a number of the grid; None where nothing can live in it."""
        values = self._values(grown)
        return None if values is None else int(self._place()[1].index_of_single(values))

    def _values(self, grown: Grown) -> list[float] | None:
        """The measures of a body, all of them finite numbers; None where nothing can live in it."""
        values = [one.of(grown) for one in self.measures] if grown.status == Status.OK else [np.nan]
        return values if np.isfinite(values).all() else None

    def _place(self) -> tuple[Nursery, GridArchive]:
        """What grows bodies, and an empty grid for them."""
        if self._known is None:
            if self.task is None:
                raise ParameterError("an archive grows bodies to tell them apart: give it a task, as Evolution(..., task=task)")
            self._known = self.nursery_for(self.task), self.grid()
        return self._known

    def nursery_for(self, task: Task) -> Nursery:
        """What grows bodies, with all that its measures ask of them."""
        return Nursery(task)

    def kind_of_body(self, grown: Grown) -> int | None:
        """What keeps bodies apart when they are founded, before they have a gait; None where nothing can live in it."""
        return self.kind(grown)

    def parents(self, elites: list[Individual], rng: np.random.Generator) -> list[Individual]:
        """Those of whom a child comes."""
        return elites

    def grid(self) -> GridArchive:
        """An empty archive.  Its field `individual` holds who is in it."""
        assert self.task is not None
        from ribs.archives import GridArchive  # a second or two, that whoever asks for help does not wait

        numbers = iter((self.settings.elongations, self.settings.fillings))
        dims = [one.bins or next(numbers) for one in self.measures]
        ranges = [(one.low, one.high(self.task)) for one in self.measures]
        return GridArchive(solution_dim=(), dims=dims, ranges=ranges, extra_fields={"individual": ((), object)})

    def first(self, start: Sequence[Genome], rng: np.random.Generator) -> list[Child]:
        """What is given and its mutants; then bodies that growth alone found, the largest of each kind, with gaits at random.

        Raises ParameterError where none of all these bodies has a chamber.
        """
        s, nursery = self.settings, self.nursery
        given = given_and_mutants(start, s, rng)
        bodies, growths = bodies_of_founders(s, nursery, self.kind_of_body, rng)
        if not bodies and not any(grown.status == Status.OK for grown in nursery.map(nursery.grow, [one.genome for one in given])):
            raise ParameterError(f"settings.founders is {s.founders}: give more, no body of those that grew has a chamber")
        genomes = [graft(bodies[rng.integers(len(bodies))], random_founder(s, rng)) for _ in range(3 * s.population if bodies else 0)]
        nursery.map(nursery.grow, genomes)
        children = given + [Child(genome, operators=("random",)) for genome in genomes]
        return [replace(children[0], growths=growths), *children[1:]]

    def breed(self, population: list[Individual], generation: int, rng: np.random.Generator) -> list[Child]:
        """Children that are worth `settings.population` evaluations, growth of all that were drawn among it."""
        elites = [one for one in population if lives(one)]
        if not elites:
            return self.first((), rng)
        nursery = self.nursery
        known = nursery.map(lambda one: nursery.grow(one.genome), elites)
        bars = {self.kind(grown): one.evaluation.fitness for one, grown in zip(elites, known)}
        lived, names, shares = {grown.key for grown in known}, list(self.emitters), self.shares()

        def draft(seed: int) -> Draft:
            own = np.random.default_rng(seed)
            name = names[own.choice(len(names), p=shares)]
            return replace(self.emitters[name](self.parents(elites, own), self.settings, nursery, own), by=name)

        children: list[Child] = []
        worth, growths, drawn = 0.0, 0, 0
        while worth < self.settings.population and drawn < 100 * self.settings.population:
            drafts = nursery.map(draft, rng.integers(2**62, size=_CHUNK).tolist())
            nursery.map(lambda found: found.child and self.kind(nursery.grow(found.child.genome)), drafts)
            drawn += len(drafts)
            for found in drafts:
                if worth >= self.settings.population:
                    break
                growths, worth = growths + found.growths, worth + GROWTH * found.growths
                if found.child is None:
                    continue
                grown = nursery.grow(found.child.genome)
                growths, worth = growths + self.LOOK, worth + GROWTH * self.LOOK
                kind = self.kind(grown)
                if kind is not None and grown.key not in lived:
                    lived.add(grown.key)
                    made = (found.by, *found.child.operators)
                    children.append(replace(found.child, growths=growths, bar=bars.get(kind, -np.inf), operators=made))
                    worth, growths = worth + 1.0, 0
        return children or [Child(elites[0].genome, elites[0].born, parents=(elites[0].number,))]

    def survive(self, population: list[Individual], children: list[Individual], generation: int) -> list[Individual]:
        self._place()
        archive = self.grid()
        before = self._add(archive, population)
        after = self._add(archive, children)
        self._learn(children, before, after)
        elites = list(after.values())
        self.nursery.forget(one.genome for one in elites)
        return elites or [max([*population, *children], key=lambda one: one.evaluation.fitness)]

    def _add(self, archive: GridArchive, individuals: list[Individual]) -> dict[int, Individual]:
        """Put in who lives, in their order: of a kind the fittest stays, of equals the first.  Returns: the elites by their cells."""
        bodies = self.nursery.map(lambda one: self.nursery.grow(one.genome), individuals)
        viable = [(one, values) for one, grown in zip(individuals, bodies) if lives(one) and (values := self._values(grown)) is not None]
        if viable:
            held = np.empty(len(viable), object)
            held[:] = [one for one, _ in viable]
            fitness = np.array([one.evaluation.fitness for one in held])
            archive.add(np.zeros(len(viable)), fitness, np.array([values for _, values in viable]), individual=held)
        return dict(sorted(zip(archive.data("index").tolist(), archive.data("individual"))))

    def shares(self) -> np.ndarray:
        """Of the children, by emitter: in proportion to what its children have lately brought, beyond a least one for each."""
        gain = np.array([(brought + 1e-3) / (children + 1.0) for brought, children in self._brought.values()])
        least = np.array([_LEAST.get(name, _LEAST_SHARE) if gain.size > 1 else 0.0 for name in self._brought])
        return least + (1.0 - least.sum()) * gain / gain.sum()

    def _learn(self, children: list[Individual], before: dict[int, Individual], after: dict[int, Individual]) -> None:
        """Credit emitters with what the fitness of all elites has gained by their children."""
        gains = {
            one.number: one.evaluation.fitness - (before[cell].evaluation.fitness if cell in before else 0.0)
            for cell, one in after.items() if before.get(cell) is not one
        }
        for name, tally in self._brought.items():
            own = [one for one in children if one.operators[:1] == (name,)]
            brought = sum(max(0.0, gains.get(one.number, 0.0)) for one in own)
            tally[:] = [_MEMORY * tally[0] + brought, _MEMORY * tally[1] + len(own)]

    def state(self) -> dict[str, Any]:
        return {"brought": {name: list(tally) for name, tally in self._brought.items()}}

    def restore(self, state: dict[str, Any]) -> None:
        brought = {name: [float(value) for value in state["brought"][name]] for name in self._brought}
        if any(len(tally) != 2 or not np.isfinite(tally).all() for tally in brought.values()):
            raise ValueError("brought")
        self._brought = brought


def lives(one: Individual) -> bool:
    """Whether it has lived to the end."""
    return one.evaluation.status not in FAILURE and one.evaluation.status != Status.STOPPED
