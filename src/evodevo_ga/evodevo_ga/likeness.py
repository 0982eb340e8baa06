"""How unlike the genomes of a population are."""

from __future__ import annotations

from collections import Counter

import numpy as np

from evodevo_sim import Genome

_FACTORS = tuple(np.uint64(factor) for factor in (0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9))  # odd, of many bits
_HALF = np.uint64(32)


def diversity(genomes: list[Genome]) -> float:
    """Mean over all pairs of the share of their elements that the two do not have in common, 0 (clones) to 1."""
    if len(genomes) < 2:
        return 0.0
    carriers = _carriers(genomes)
    elements = sum(carriers)
    return 1.0 - sum(n * (n - 1) for n in carriers) / ((len(genomes) - 1) * elements)


def _carriers(genomes: list[Genome]) -> list[int]:
    """How many genomes have each element that there is, in any order."""
    kind, sign, x, y = (np.concatenate(column) for column in zip(*(genome.arrays() for genome in genomes)))
    x, y = x + 0.0, y + 0.0  # -0 is 0
    mark = _marks(kind, sign, x, y)
    order = np.argsort(mark, kind="stable")  # and so by genome
    new = np.diff(mark[order]) != 0
    if not all(np.all(new | (of[order][1:] == of[order][:-1])) for of in (kind, sign, x, y)):
        return _counted(genomes)  # two elements of one mark
    owner = np.repeat(np.arange(len(genomes)), [len(genome) for genome in genomes])[order]
    first = np.append(True, new | (owner[1:] != owner[:-1]))  # of an element in a genome
    return np.bincount(np.append(0, np.cumsum(new))[first]).tolist()


def _marks(kind: np.ndarray, sign: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """(E,) uint64, equal for equal elements and next to never for others."""
    a, b, c = _FACTORS
    mixed = (x.view(np.uint64) * a) ^ ((2 * kind + (sign > 0)) * c)
    return ((mixed ^ (mixed >> _HALF)) * b) ^ (y.view(np.uint64) * c)


def _counted(genomes: list[Genome]) -> list[int]:
    return list(Counter(element for genome in genomes for element in set(zip(*(a.tolist() for a in genome.arrays())))).values())
