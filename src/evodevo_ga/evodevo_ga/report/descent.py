"""The descent of a champion in a report, where its run has a history."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..descent.lineage import Lineage


@dataclass(frozen=True)
class Ancestor:
    """number; generation in which it was born; fitness, m; operators that made it; parents: their numbers."""

    number: int
    generation: int
    fitness: float
    operators: tuple[str, ...]
    parents: tuple[int, ...]


def descent_of(run: Path) -> tuple[list[Ancestor], list[str]]:
    """The line of a run's champion through its fitter parents, the newest first; and what must be known, a line each.

    A run without a history has none, and nothing is said of that.
    """
    if not ((run / "history").is_dir() and (run / "hall_of_fame").is_dir()):
        return [], []
    try:
        from ..descent.run import descent
    except ModuleNotFoundError as error:
        return [], [f"its history cannot be read: pip install {error.name}"]
    try:
        return line_of(descent(run)), []
    except Exception as error:  # of a damaged file: those of its reader have no common class
        return [], [f"the descent of its champion is left out: {error}"[:290]]


def line_of(found: Lineage) -> list[Ancestor]:
    """The line of a lineage, the newest first."""
    parents: dict[int, list[int]] = {}
    for parent, child in found.links.tolist():
        parents.setdefault(child, []).append(int(found.number[parent]))
    return [
        Ancestor(
            int(found.number[place]), int(found.generation[place]), float(found.fitness[place]), found.operators[place],
            tuple(parents.get(place, ())),
        )
        for place in found.line[::-1].tolist()
    ]
