"""An archive of unlike animals that keeps unlike gaits apart, too: of each kind of body and of each way in which muscles beat the fittest.

How muscles will beat is known before a life (`beat.py`), as the body is, so a child is known to compete with one elite, and lives stop at
its bar, as in `archive.py`.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from evodevo_sim.tasks.grown import Grown
from evodevo_sim.tasks.outcome import Status

from evodevo_sim import Task

from .archive import Archive
from .beat import Beat, BeatingNursery
from .emitters import USUAL
from .individual import Individual
from .measures import measure
from .settings import Settings

_OF_ONE = 0.5  # share of the children whose parents are all of one beat, each beat alike


class Gaits(Archive):
    """An archive by length, beat and density.  Args: as of `Archive`."""

    LOOK = 1

    def __init__(
        self, settings: Settings, measures: Sequence[str] = ("elongation", "beat", "chambers"), emitters: Sequence[str] = USUAL
    ):
        super().__init__(settings, measures, emitters)
        self._bodies = Archive(settings, [name for name in measures if not measure(name).bins])

    def nursery_for(self, task: Task) -> BeatingNursery:
        self._bodies.task = task
        return BeatingNursery(task)

    def kind_of_body(self, grown: Grown) -> int | None:
        return self._bodies.kind(grown)

    def parents(self, elites: list[Individual], rng: np.random.Generator) -> list[Individual]:
        """All, or those of one beat; who hardly moves is nobody's parent as long as somebody else moves."""
        beats: dict[int, list[Individual]] = {}
        for one in elites:
            beats.setdefault(self.beat(one), []).append(one)
        if rng.random() >= _OF_ONE or beats.keys() <= {Beat.STILL}:
            return elites
        moving = sorted(beats.keys() - {Beat.STILL})
        return beats[moving[rng.integers(len(moving))]]

    def beat(self, one: Individual) -> Beat:
        """How the muscles of an elite beat."""
        grown = self.nursery.grow(one.genome)
        return Beat(getattr(grown, "beat", Beat.STILL)) if grown.status == Status.OK else Beat.STILL
