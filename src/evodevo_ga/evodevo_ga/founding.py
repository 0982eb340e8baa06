"""What an archive begins with: given genomes, and random ones whose bodies growth alone has spread over the kinds that there are."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from evodevo_sim.tasks.grown import Grown

from evodevo_sim import Genome, random_genome

from .individual import Child
from .nursery import Nursery
from .operators import scatter_scent
from .parts import COARSE, growth_part, random_parted, varied
from .settings import Settings
from .variation import mutant

_RANDOM = 0.4  # share of the founders that are random genomes; the others are mutants of the bodies found before
_CHUNK = 64


def random_founder(settings: Settings, rng: np.random.Generator) -> Genome:
    """A random genome, in two parts where `settings.apart` has them so."""
    s = settings
    if s.apart:
        return random_parted(rng, s.units, s.extent, s.apart, s.scent_extent)
    genome = random_genome(rng, s.units, s.extent)
    return scatter_scent(genome, rng, s.scent_extent) if s.scent_extent else genome


def bodies_of_founders(
    settings: Settings, nursery: Nursery, kind: Callable[[Grown], int | None], rng: np.random.Generator
) -> tuple[list[Genome], int]:
    """Spread bodies over their kinds, by growth alone: random genomes, then mutants of those found.

    Args: kind: of a body, None where nothing can live in it.  Returns: (the last one with the most cells of each kind; growths).
    """
    found: dict[int, tuple[Genome, int]] = {}
    most = max(settings.founders, settings.population)
    done = 0
    while done < most:
        genomes: list[Genome] = []
        for _ in range(min(_CHUNK, most - done)):
            if done < _RANDOM * most or not found:
                genomes.append(random_founder(settings, rng))
            else:
                parent = list(found.values())[rng.integers(len(found))][0]
                genomes.append(varied(parent, growth_part(parent), rng, COARSE)[0])
        done += len(genomes)
        for genome, grown in zip(genomes, nursery.map(nursery.grow, genomes)):
            place = kind(grown)
            if place is not None and (place not in found or grown.cells >= found[place][1]):
                found[place] = genome, grown.cells
    return [genome for genome, _ in found.values()], done


def given_and_mutants(start: Sequence[Genome], settings: Settings, rng: np.random.Generator) -> list[Child]:
    """The genomes that a run begins with, each as it is and then in mutants, in turn, up to `settings.start_share` of a batch."""
    children = [Child(genome, operators=("given",)) for genome in start[: settings.population]]
    given = len(children)
    for k in range(given, round(settings.start_share * settings.population) if given else 0):
        genome, made = mutant(start[k % given], settings, rng)
        children.append(Child(genome, parents=(k % given,), operators=made))
    return children
