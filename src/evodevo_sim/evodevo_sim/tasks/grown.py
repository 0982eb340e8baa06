"""What growth alone makes of a genome: its body, known in an eighth of an evaluation; and which genomes are one animal.

    grown = grow(genome, task)
    if same_shape(grown.position, parent.position): ...
    if grown.key in evaluations: ...      # the same animal: an evaluation would have the same bits
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from hashlib import blake2b
from typing import Any

import numpy as np

from ..brain.brain import make_brain
from ..development.body import build_body
from ..development.shape import asymmetry, elongation, share_of_chambers, sprawl
from ..genetics.elements import INPUTS, OUTPUTS
from ..genetics.genome import Genome
from ..genetics.regulation import CONTRACTION, EXPANSION
from ..kernels.lanes import padded
from ..parameters import Task
from .life import develop
from .memory import over_limit
from .outcome import Status
from .swim.fitness import kernel_arguments

_UNKEPT = np.empty((0, 0, 0)), np.empty((0, 0)), np.empty((0, 0, 0), np.int64)
_DIGEST = 24  # bytes: two of a billion billion animals are mistaken for one with a probability of 1e-22


@dataclass(frozen=True, eq=False)
class Grown:
    """A body as it grew, before its muscles give it its shape at birth.

    Attributes:
        status: OK, or why nothing can live in it: NO_GROWTH, NO_CHAMBER; INVALID_GENOME where growth would take too much memory.
        position (N, 2) m; edges (E, 2): pairs of cells that springs join.
        cells, springs, chambers: numbers of them, as in `Metrics`; steps: regulation steps until growth was at rest.
        key: of the animal.  For one task, genomes of one key have evaluations of the same bits, whatever the seed; of a task whose `run`
            is not marked `outcome.by_body`, the key of the genome itself.
    """

    status: Status
    position: np.ndarray
    edges: np.ndarray
    springs: int
    chambers: int
    steps: int
    key: bytes

    @property
    def cells(self) -> int:
        return len(self.position)

    @cached_property
    def elongation(self) -> float:
        """See `development.shape.elongation`."""
        return elongation(self.position)

    @cached_property
    def sprawl(self) -> float:
        """See `development.shape.sprawl`."""
        return sprawl(self.position)

    @cached_property
    def asymmetry(self) -> float:
        """See `development.shape.asymmetry`, m."""
        return asymmetry(self.position)

    @property
    def share_of_chambers(self) -> float:
        """See `development.shape.share_of_chambers`."""
        return share_of_chambers(self.cells, self.chambers)


def grow(genome: Genome, task: Task = Task()) -> Grown:
    """Grow a genome.  Pure; the kernels are those of evaluations and hold no GIL, so threads grow side by side."""
    if over_limit(genome, task):
        return Grown(Status.INVALID_GENOME, np.zeros((1, 2)), np.empty((0, 2), np.int64), 0, 0, 0, _digest("genome", genome.key()))
    genes, model = kernel_arguments(genome, task)
    weights, units, embryo = develop(genes, model, *_UNKEPT)
    cells = len(embryo.position)
    body = build_body(embryo.position, embryo.edges, embryo.start, embryo.neighbour, task.material.mass)
    springs, chambers = len(body.rest_length), len(body.triangle_area) + len(body.polygon_area)
    status = Status.NO_GROWTH if cells < 2 else Status.OK if chambers else Status.NO_CHAMBER
    if not getattr(task.kind.function("run"), "by_body", False):
        key = _digest("genome", genome.key())
    elif status != Status.OK:
        key = _digest("dead", np.array([status, cells, springs]).tobytes())
    else:
        key = _key_of(make_brain(weights, units, embryo, model.given_inputs, model.continual), embryo, model.continual)
    return Grown(status, embryo.position, embryo.edges, springs, chambers, embryo.steps, key)


def animal_key(genome: Genome, task: Task = Task()) -> bytes:
    """`Grown.key` of a genome."""
    return grow(genome, task).key


def _key_of(brain: Any, embryo: Any, continual: bool) -> bytes:
    """The key of all that a life begins from.  Rows of the table are numbered without the units that locomotion does not need.

    What is left out is never read: rows of other units, morphogens as perceived, which each step writes first, and in variant B the past.
    """
    network, units, cells = brain.network, brain.units, len(embryo.position)
    needed = network.nodes[network.nodes < units]
    place = np.full(2 * units + OUTPUTS + INPUTS, -1)
    place[needed] = np.arange(len(needed))
    place[units + OUTPUTS + needed] = len(needed) + np.arange(len(needed))
    place[2 * units + OUTPUTS :] = 2 * len(needed) + np.arange(INPUTS)
    source = np.where(network.weight == 0.0, -2, place[network.source // padded(cells)])
    rows = np.concatenate((needed, [units + EXPANSION, units + CONTRACTION], 2 * units + OUTPUTS + np.arange(INPUTS)))
    parts = [
        embryo.position, embryo.edges, embryo.start, embryo.neighbour, brain.table[rows, :cells],
        network.start, source, network.weight, np.searchsorted(needed, network.morphogens),
    ]
    if not continual:
        parts += [brain.past, brain.delay, np.array([brain.born])]
    sizes = np.array([part.size for part in parts])
    return _digest("alive", sizes.tobytes(), *(np.ascontiguousarray(part).tobytes() for part in parts))


def _digest(kind: str, *parts: bytes) -> bytes:
    found = blake2b(kind.encode(), digest_size=_DIGEST)
    for part in parts:
        found.update(part)
    return found.digest()
