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
from .parts import COARSE, FINE, entangled, graft, parts_of, varied
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
    """The body of a parent with a changed gait: drawn again until it grows the same shape, since muscles may share units with growth."""
    parent = Parents(elites).draw(rng, settings.tournament)
    body = nursery.grow(parent.genome)
    growth, gait = parts_of(parent.genome)
    apart = np.count_nonzero(gait[HEADER:]) >= _LITTLE
    part, growths = gait if apart else np.ones_like(gait), 0
    for _ in range(settings.redraws + 1):
        genome, made = varied(parent.genome, part, rng, FINE)
        if apart and entangled(genome, growth):
            continue
        growths += 1
        if same_shape(nursery.grow(genome).position, body.position):
            return Draft(_of((parent,), genome, made), growths)
    return Draft(None, growths)


def change_body(elites: list[Individual], settings: Settings, nursery: Nursery, rng: np.random.Generator) -> Draft:
    """A changed body with the gait of its parent: drawn again until it has a chamber, and growth depends on nothing of the gait."""
    parent = Parents(elites).draw(rng, min(2, settings.tournament))
    growth, gait = parts_of(parent.genome)
    growths = 0
    for _ in range(settings.redraws + 1):
        genome, made = varied(parent.genome, growth, rng, COARSE)
        if np.count_nonzero(parts_of(genome)[1]) < np.count_nonzero(gait):
            continue
        growths += 1
        if nursery.grow(genome).status == Status.OK:
            return Draft(_of((parent,), genome, made), growths)
    return Draft(None, growths)


def graft_gait(elites: list[Individual], settings: Settings, nursery: Nursery, rng: np.random.Generator) -> Draft:
    """The body of any elite with the gait of a good one, changed or not."""
    body, gait = elites[rng.integers(len(elites))], Parents(elites).draw(rng, settings.tournament)
    genome = graft(body.genome, gait.genome)
    made: tuple[str, ...] = ("crossover",)
    if rng.random() < 0.5:
        growth, gait_part = parts_of(genome)
        changed, more = varied(genome, gait_part, rng, FINE)
        if not entangled(changed, growth):
            genome, made = changed, made + more
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
