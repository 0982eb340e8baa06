"""What a search is: who breeds, and who stays (docs/guide/search.md).  `Evolution` does the rest: it asks, tells, counts and ends a run."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any

import numpy as np

from evodevo_sim import Genome, Task

from .individual import Child, Individual
from .settings import Settings
from .variation import founders


class Search(ABC):
    """A way to search, with the numbers of `settings`.

    All randomness comes from the `rng` given, which is new in each generation.  `first` and `breed` change nothing: what a search
    learns, it learns in `survive` and gives away in `state`.  So a run that goes on from its state has the same bits.

    Attributes: task: of the run, for searches that look at bodies before they live; None where the run was not told; start: the
    genomes that the run began with.
    """

    task: Task | None = None
    start: Sequence[Genome] = ()

    def __init__(self, settings: Settings):
        self.settings = settings

    def first(self, start: Sequence[Genome], rng: np.random.Generator) -> list[Child]:
        """The first generation, from the genomes that a run begins with, if there are any: they become numbers 0, 1, 2, ..."""
        return founders(start, self.settings, rng)

    @abstractmethod
    def breed(self, population: list[Individual], generation: int, rng: np.random.Generator) -> list[Child]:
        """The children of a generation, one at the least.  Equals of each other or of the population cost no evaluation.

        Args: population: who stayed, best first; generation: of the children, from 1.
        """

    @abstractmethod
    def survive(self, population: list[Individual], children: list[Individual], generation: int) -> list[Individual]:
        """Who stays, one at the least, in any order; of equals, the first one counts as better.

        Args: population: who had stayed, best first; children: in the order in which they were bred; generation: theirs.
        """

    def state(self) -> dict[str, Any]:
        """What it knows beside the population, as plain data: dicts with names, lists, numbers, texts."""
        return {}

    def restore(self, state: dict[str, Any]) -> None:  # noqa: B027  (a scheme that knows nothing has nothing to restore)
        """Know again what `state` gave away."""
