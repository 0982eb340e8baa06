"""Emitters: where children of an archive come from.  Each draws a child of elites, and again where it grows to another than meant."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from evodevo_sim.development.shape import same_shape
from evodevo_sim.genetics.elements import HEADER
from evodevo_sim.inputs import shown
from evodevo_sim.parameters import ParameterError
from evodevo_sim.tasks.outcome import Status

from .individual import Child, Individual
from .nursery import Nursery
from .parts import COARSE, FINE, graft, growth_part, varied
from .settings import Settings
from .variation import Parents, child_of

_LITTLE = 12  # elements of a gait, below which a genome is not in two parts


@dataclass(frozen=True)
class Draft:
    """What an emitter draws.  Attributes: child, None where none came out as meant; growths: that it took; by: name of the emitter."""

    child: Child | None
    growths: int
    by: str = ""


Emitter = Callable[[list[Individual], Settings, Nursery, np.random.Generator], Draft]


def keep_body(elites: list[Individual], settings: Settings, nursery: Nursery, rng: np.random.Generator) -> Draft:
    """The body of a parent with a changed gait: drawn again until it grows the same shape, since muscles share units with growth."""
    parent = Parents(elites).draw(rng, settings.tournament)
    body = nursery.grow(parent.genome)
    gait = ~growth_part(parent.genome)
    if np.count_nonzero(gait[HEADER:]) < _LITTLE:
        gait[:] = True
    for growths in range(1, settings.redraws + 2):
        genome, made = varied(parent.genome, gait, rng, FINE)
        if same_shape(nursery.grow(genome).position, body.position):
            return Draft(_of((parent,), genome, made), growths)
    return Draft(None, settings.redraws + 1)


def change_body(elites: list[Individual], settings: Settings, nursery: Nursery, rng: np.random.Generator) -> Draft:
    """A changed body with the gait of its parent: drawn again until it has a chamber."""
    parent = Parents(elites).draw(rng, min(2, settings.tournament))
    part = growth_part(parent.genome)
    for growths in range(1, settings.redraws + 2):
        genome, made = varied(parent.genome, part, rng, COARSE)
        if nursery.grow(genome).status == Status.OK:
            return Draft(_of((parent,), genome, made), growths)
    return Draft(None, settings.redraws + 1)


def graft_gait(elites: list[Individual], settings: Settings, nursery: Nursery, rng: np.random.Generator) -> Draft:
    """The body of any elite with the gait of a good one, changed or not."""
    body, gait = elites[rng.integers(len(elites))], Parents(elites).draw(rng, settings.tournament)
    genome = graft(body.genome, gait.genome)
    made: tuple[str, ...] = ("crossover",)
    if rng.random() < 0.5:
        genome, more = varied(genome, ~growth_part(genome), rng, FINE)
        made += more
    return Draft(_of((body, gait), genome, made) if nursery.grow(genome).status == Status.OK else None, 1)


def mutate(elites: list[Individual], settings: Settings, nursery: Nursery, rng: np.random.Generator) -> Draft:
    """Mutation and crossover as in one population."""
    child = child_of(Parents(elites), settings, rng)
    return Draft(child if nursery.grow(child.genome).status == Status.OK else None, 1)


def _of(parents, genome, made) -> Child:
    return Child(genome, min(one.born for one in parents), parents=tuple(one.number for one in parents), operators=made)


EMITTERS: dict[str, Emitter] = {"keep": keep_body, "body": change_body, "graft": graft_gait, "mutate": mutate}
USUAL = ("keep", "body", "graft")


def emitter(name: str) -> Emitter:
    """Raises ParameterError where there is none of that name."""
    if name not in EMITTERS:
        raise ParameterError(f"emitter {shown(name)} is unknown: choose one of {', '.join(EMITTERS)}")
    return EMITTERS[name]
