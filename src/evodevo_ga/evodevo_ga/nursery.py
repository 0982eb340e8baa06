"""Growth alone, side by side on all cores: kernels hold no lock, and what is grown does not depend on who grew it first."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import Any

from evodevo_sim.tasks.grown import Grown, grow

from evodevo_sim import Genome, Task

_KEPT = 4096  # bodies remembered, more than an archive and a batch have


@cache
def _pool() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(len(os.sched_getaffinity(0)), "nursery")


class Nursery:
    """Bodies of one task, each grown once while it is remembered."""

    def __init__(self, task: Task):
        self.task = task
        self._bodies: dict[bytes, Grown] = {}

    def grow(self, genome: Genome) -> Grown:
        """Its body.  Pure, but for the time it takes."""
        key = genome.key()
        found = self._bodies.get(key)
        if found is None:
            found = self._bodies[key] = self.new(genome)
        return found

    def new(self, genome: Genome) -> Grown:
        """A body that is not remembered."""
        return grow(genome, self.task)

    def map(self, work: Callable[[Any], Any], items: Iterable[Any]) -> list[Any]:
        """What `work` makes of each item, in their order, side by side."""
        return list(_pool().map(work, items))

    def forget(self, genomes: Iterable[Genome]) -> None:
        """Remember the bodies of these alone, where there are too many."""
        if len(self._bodies) > _KEPT:
            kept = {genome.key() for genome in genomes}
            self._bodies = {key: body for key, body in self._bodies.items() if key in kept}
