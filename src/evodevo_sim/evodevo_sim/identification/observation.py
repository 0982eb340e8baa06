"""What was seen of a body, and what its muscles were told meanwhile: all that a simulation of it needs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..analysis.stretches import filled
from ..development.body import Body, build_body
from ..development.gabriel import adjacency
from ..development.shape import principal

LEAST = 30  # moments


class ObservationError(ValueError):
    """A motion from which nothing can be told of a body; the message says why, and the mend."""


@dataclass(frozen=True, eq=False)
class Observation:
    """A motion of a body of N cells.

    Attributes: name; body: see `development.body.Body`; time (T,) s; position (T, N, 2) m: of cells, NaN where one was not seen;
    activation (T, N) of e - c: what muscles were told in the control step that ends at that time, or in which it is.
    """

    name: str
    body: Body
    time: np.ndarray
    position: np.ndarray
    activation: np.ndarray

    def __post_init__(self):
        if len(self.time) < LEAST:
            raise ObservationError(f"{self.name} holds {len(self.time)} states of a body: give {LEAST} or more")
        if not (np.diff(self.time) > 0.0).all():
            raise ObservationError(f"{self.name}: its stamps do not grow: record one life at a time")
        if not np.isfinite(self.activation).all():
            raise ObservationError(f"{self.name}: an activation is no number: record it again")

    @property
    def cells(self) -> int:
        return self.position.shape[1]

    @cached_property
    def length(self) -> float:
        """m: of the body at rest, along its longest axis, cells with their own size."""
        return float(np.ptp(principal(self.body.position)[1][:, 0])) + 1.0

    def begin(self) -> np.ndarray:
        """See `first_pose`."""
        return first_pose(self.name, self.time, self.position)


def first_pose(name: str, time: np.ndarray, position: np.ndarray) -> np.ndarray:
    """(N, 2) m: where the cells are at the first moment at which all are known.  Raises ObservationError where one is not seen near it."""
    near = time - time[:1] <= 0.5
    found = filled(time[near], position[near])
    whole = np.flatnonzero(np.isfinite(found).all(axis=(1, 2)))
    if not len(whole):
        seen = np.isfinite(found).all(axis=2).mean(axis=0) if len(found) else np.zeros(1)
        raise ObservationError(f"{name}: cell {int(seen.argmin())} is hardly seen in the first half second: mend its marker")
    return found[whole[0]]


def body_of_parts(
    name: str, position: np.ndarray, springs: np.ndarray, rest_length: np.ndarray, chambers: Sequence[np.ndarray], areas: np.ndarray,
) -> Body:
    """A body of what recordings tell of it.

    Args: position (N, 2) m: a pose in which it is not folded; springs (E, 2): cells; rest_length (E,) m; chambers: cells of each,
    counter-clockwise; areas: m^2 of each at rest.  Raises ObservationError where they do not fit each other.
    """
    cells = len(position)
    if not len(springs):
        raise ObservationError(f"{name} tells no springs of its body: record the topic body too")
    pairs = np.sort(np.asarray(springs, np.int64), axis=1)
    order = np.lexsort((pairs[:, 1], pairs[:, 0]))
    edges = pairs[order]
    start, neighbour = np.zeros(cells + 1, np.int64), np.empty(2 * len(edges), np.uint32)
    adjacency(edges, len(edges), cells, start, neighbour)
    body = build_body(np.array(position, float), edges, start, neighbour, 1.0)
    lengths = dict(zip(map(tuple, pairs.tolist()), rest_length))
    rest = np.array([lengths[pair] for pair in zip(body.spring_a.tolist(), body.spring_b.tolist())])
    known = {_ring(chamber): area for chamber, area in zip(chambers, areas)}
    polygons = np.split(body.polygon_cell, body.polygon_start[1:-1].astype(int)) if len(body.polygon_area) else []
    try:
        triangle = np.array([known[_ring(chamber)] for chamber in body.triangle])
        polygon = np.array([known[_ring(chamber)] for chamber in polygons])
    except KeyError:
        raise ObservationError(f"{name}: its first state is folded, so that its chambers are others: begin it at rest") from None
    return body._replace(rest_length=rest, shortest=float(rest.min()), triangle_area=triangle, polygon_area=polygon)


def _ring(chamber: np.ndarray) -> tuple[int, ...]:
    """The cells of a chamber, from the least one on."""
    cells = [int(cell) for cell in chamber]
    first = cells.index(min(cells))
    return tuple(cells[first:] + cells[:first])
