"""What growth was like inside: who is whose daughter, and the morphogens that each cell perceived; by growing a genome again."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..genetics.genome import Genome
from ..genetics.regulation import DIVISION, prune
from ..parameters import Task, with_settings
from ..tasks.life import develop
from ..tasks.swim.fitness import kernel_arguments

_OUTPUTS = 4  # rows of output factors in a table of concentrations


@dataclass(frozen=True, eq=False)
class Lineage:
    """mother (N,): of each cell, -1 of the egg; born (N,): the step of growth at which it first is there."""

    mother: np.ndarray
    born: np.ndarray

    def clones(self, founders: int = 4) -> np.ndarray:
        """(N,): which of the first so many cells each one comes from."""
        line = np.arange(len(self.mother))
        for cell in range(founders, len(line)):
            line[cell] = line[self.mother[cell]]
        return line

    def order(self) -> np.ndarray:
        """(N,): a place from left to right for each cell, by which no lines of its tree cross."""
        daughters: list[list[int]] = [[] for _ in self.mother]
        for cell, mother in enumerate(self.mother):
            if mother >= 0:
                daughters[mother].append(cell)
        placed, ahead = [], [0]
        while ahead:
            cell = ahead.pop()
            placed.append(cell)
            ahead += daughters[cell]  # the last one comes next: later daughters stand nearer
        order = np.empty(len(placed), int)
        order[placed] = np.arange(len(placed))
        return order


@dataclass(frozen=True, eq=False)
class GrowthStory:
    """lineage; steps (S,) of growth that were looked at; morphogens (M,): their units; perceived: of each step (M, cells)."""

    lineage: Lineage
    steps: np.ndarray
    morphogens: np.ndarray
    perceived: list[np.ndarray]


def born(genome: Genome, task: Task) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The body of a genome when it has grown: position (N, 2) m, activation (N,) of e - c, edges (E, 2) of its graph."""
    units, embryo = _grown(genome, task)
    expansion, contraction = embryo.table[units + 2 : units + 4, : len(embryo.position)]
    return embryo.position, expansion - contraction, embryo.edges


def _grown(genome: Genome, task: Task, steps: int | None = None):
    if steps is not None:
        task = with_settings(task, {"development.steps": steps})
    genes, model = kernel_arguments(genome, task)
    _, units, embryo = develop(genes, model, np.empty((0, 0, 0)), np.empty((0, 0)), np.empty((0, 0, 0), np.int64))
    return units, embryo


def story_of_growth(genome: Genome, task: Task, cells: list[int], every: int = 5) -> GrowthStory:
    """Grow a genome again, to look at its concentrations on the way.

    Args: cells: how many cells the embryo has at each step of growth, as recorded; every: steps from one look to the next.
    """
    counts = np.asarray(cells)
    divisions = np.flatnonzero(np.diff(counts) > 0) + 1
    wanted = np.unique(np.concatenate((np.arange(every, len(counts), every), divisions, divisions - 1, [len(counts) - 1])))
    tables = {int(step): _grown(genome, task, int(step)) for step in wanted if step > 0}
    mother, at = np.full(counts[-1], -1), np.zeros(counts[-1], int)
    for step in divisions:
        before, now = int(counts[step - 1]), int(counts[step])
        at[before:now] = step
        mother[before:now] = _mothers(tables, int(step), before, now)
    units, last = tables[int(wanted[-1])]
    morphogens = _morphogens(genome, task)
    looked = [step for step in sorted(tables) if step % every == 0 or step == len(counts) - 1]
    perceived = [tables[step][1].table[units + _OUTPUTS + morphogens, : counts[step]] for step in looked]
    spread = np.ptp(last.table[units + _OUTPUTS + morphogens, : counts[-1]], axis=1) if len(morphogens) else np.empty(0)
    strongest = np.argsort(-spread, kind="stable")
    return GrowthStory(Lineage(mother, at), np.array(looked), morphogens[strongest], [values[strongest] for values in perceived])


def _mothers(tables, step: int, before: int, now: int) -> np.ndarray:
    """The cells that divided in a step: their division factor, which was high, is used up.  As their daughters they are in order of age."""
    if step <= 1:
        return np.zeros(now - before, int)
    units, after = tables[step]
    factor = after.table[units + DIVISION, :before] == 0.0
    ready = tables[step - 1][1].table[units + DIVISION, :before]
    divided = np.flatnonzero(factor & (ready > 0.0))
    if len(divided) < now - before:
        divided = np.flatnonzero(factor)
    return np.sort(divided[np.argsort(-ready[divided], kind="stable")][: now - before])


def _morphogens(genome: Genome, task: Task) -> np.ndarray:
    from ..genetics.regulation import express

    _, model = kernel_arguments(genome, task)
    weights, units = express(*genome.arrays())
    network = prune(weights, units, np.array([True, True, True, True]), model.given_inputs, 1)
    return network.morphogens


def shared_genes(one: Genome, other: Genome) -> float:
    """Share of the second genome's elements that the first has too, to the last bit."""
    def rows(genome: Genome) -> list[tuple]:
        return list(zip(*(values.tolist() for values in genome.arrays())))

    have = set(rows(one))
    return float(np.mean([row in have for row in rows(other)]))
