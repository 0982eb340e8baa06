"""Genetic operators (paper section 3): small functions of genomes and a random generator.

The header of special elements is never moved, copied or deleted; its points mutate like any others.
"""

from __future__ import annotations

import numpy as np
from evodevo_sim.genetics.elements import HEADER, INPUT_NAMES, MORPHOGEN, TRANSCRIPTION_FACTOR
from evodevo_sim.genetics.genome import Genome
from evodevo_sim.genetics.limits import MAX_ELEMENTS

SCENT = INPUT_NAMES.index("scent")
_SIGN_TOO, _ANYWHERE = 0.1, 0.2


def mutate_points(genome: Genome, rng: np.random.Generator, probability: float, scale: float) -> Genome:
    """Move each element's point with `probability`, in a random direction by |N(0, scale)|."""
    moved = rng.random(len(genome)) < probability
    if not np.count_nonzero(moved):
        return genome
    direction = rng.uniform(0.0, 2.0 * np.pi, len(genome))
    length = np.where(moved, np.abs(rng.normal(0.0, scale, len(genome))), 0.0)
    return Genome(genome.kind, genome.sign, genome.x + length * np.cos(direction), genome.y + length * np.sin(direction))


def scatter_scent(genome: Genome, rng: np.random.Generator, extent: float) -> Genome:
    """Put the scent's point anywhere in [-extent, extent]^2."""
    x, y = genome.x.copy(), genome.y.copy()
    x[SCENT], y[SCENT] = rng.uniform(-extent, extent, 2)
    return Genome(genome.kind, genome.sign, x, y)


def mutate_scent(genome: Genome, rng: np.random.Generator, scale: float, extent: float = 0.0) -> Genome:
    """Move the scent's point, in a random direction by |N(0, scale)|; one time in ten its sign changes, too, and one time in five
    the point goes anywhere in [-extent, extent]^2, if there is an extent: most swimmers steer to both sides from some place."""
    direction, length = rng.uniform(0.0, 2.0 * np.pi), abs(rng.normal(0.0, scale))
    x, y, sign = genome.x.copy(), genome.y.copy(), genome.sign.copy()
    x[SCENT] += length * np.cos(direction)
    y[SCENT] += length * np.sin(direction)
    if rng.random() < _SIGN_TOO:
        sign[SCENT] = -sign[SCENT]
    moved = Genome(genome.kind, sign, x, y)
    return scatter_scent(moved, rng, extent) if extent and rng.random() < _ANYWHERE else moved


def flip(genome: Genome, rng: np.random.Generator, probability: float) -> Genome:
    """With `probability` each, change the sign of an element, and turn a transcription factor into a morphogen or back."""
    signs = rng.random(len(genome)) < probability
    kinds = (rng.random(len(genome)) < probability) & (genome.kind >= TRANSCRIPTION_FACTOR)
    if not (np.count_nonzero(signs) or np.count_nonzero(kinds)):
        return genome
    swapped = np.where(kinds, TRANSCRIPTION_FACTOR + MORPHOGEN - genome.kind, genome.kind)
    return Genome(swapped, np.where(signs, -genome.sign, genome.sign), genome.x, genome.y)


def _random_run(genome: Genome, rng: np.random.Generator, mean_length: float) -> tuple[int, int]:
    """A contiguous run behind the header: (first, last), of geometric length."""
    first = int(rng.integers(HEADER, len(genome)))
    return first, min(len(genome), first + int(rng.geometric(1.0 / mean_length)))


def duplicate(genome: Genome, rng: np.random.Generator, mean_length: float) -> Genome:
    """Copy a run of elements to a random place behind the header, if a genome may be as long as that."""
    if len(genome) == HEADER:
        return genome
    first, last = _random_run(genome, rng, mean_length)
    if len(genome) + last - first > MAX_ELEMENTS:
        return genome
    place = int(rng.integers(HEADER, len(genome) + 1))
    index = np.arange(len(genome))
    return genome.take(np.concatenate((index[:place], index[first:last], index[place:])))


def delete(genome: Genome, rng: np.random.Generator, mean_length: float) -> Genome:
    """Remove a run of elements."""
    if len(genome) == HEADER:
        return genome
    first, last = _random_run(genome, rng, mean_length)
    index = np.arange(len(genome))
    return genome.take(np.concatenate((index[:first], index[last:])))


def crossover(mother: Genome, father: Genome, rng: np.random.Generator, points: int = 2) -> Genome:
    """Multipoint crossover: segments from the two in turn, cut at `points` places.

    Each element of the header comes from the same place in either parent; behind it, cuts fall at the same share of each
    parent's length, so that parents of unlike lengths stay aligned.
    """
    header = rng.random(HEADER) < 0.5
    cuts = np.concatenate(([0.0], np.sort(rng.random(points)), [1.0]))
    parents = [mother if k % 2 == 0 else father for k in range(points + 1)]
    ends = [HEADER + np.rint(cuts[k : k + 2] * (len(parent) - HEADER)).astype(int) for k, parent in enumerate(parents)]
    columns = []
    for a, (m, f) in enumerate(zip(mother.arrays(), father.arrays())):
        pieces = [parent.arrays()[a][first:last] for parent, (first, last) in zip(parents, ends)]
        # Rounded cuts may add an element, which a child of the longest parents has no room for.
        columns.append(np.concatenate([np.where(header, m[:HEADER], f[:HEADER]), *pieces])[:MAX_ELEMENTS])
    return Genome(*columns)


def tournament(fitness: np.ndarray, rng: np.random.Generator, size: int) -> int:
    """The index of the best of `size` individuals drawn with replacement; the first drawn among equals."""
    drawn = rng.integers(0, len(fitness), size)
    return int(drawn[np.argmax(fitness[drawn])])
