"""Measures of bodies by which an archive keeps unlike animals apart, known as soon as a body has grown."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from evodevo_sim.inputs import shown
from evodevo_sim.parameters import ParameterError, Task
from evodevo_sim.tasks.grown import Grown

BEATS = 5  # kinds of beats: see `beat.Beat`


@dataclass(frozen=True)
class Measure:
    """An axis of an archive.

    Attributes: name; of: its value of a body; low, high(task): the range that is parted evenly, values beyond it count to its ends;
    bins: parts of the range, where it has some by its nature; 0: as many as the search's settings say.
    """

    name: str
    of: Callable[[Grown], float]
    low: float
    high: Callable[[Task], float]
    bins: int = 0

    def place(self, grown: Grown, task: Task, bins: int) -> int:
        """Which of so many equal parts of its range a body is in, 0 the lowest.  Raises ValueError where the value is no number."""
        value, high = self.of(grown), self.high(task)
        if not math.isfinite(value):
            raise ValueError(f"{self.name} of a body of {grown.cells} cells is {value}")
        return min(max(math.floor((value - self.low) / (high - self.low) * bins), 0), bins - 1)


def _longest(task: Task) -> float:
    """Logarithm of the elongation of three rows of cells, beyond which all bodies are of one kind; 0.1 at the least."""
    columns = max(2.0, task.development.max_cells / 3.0)
    return max(0.1, math.log(math.sqrt((columns**2 / 12.0 + 1 / 16.0) / (0.5 + 1 / 16.0))))


def beat_of_body(grown: Grown) -> float:
    """Number of the `beat.Beat` of a body that a `BeatingNursery` grew."""
    return float(getattr(grown, "beat", math.nan))


MEASURES = {
    one.name: one
    for one in (
        Measure("elongation", lambda grown: math.log(grown.elongation), 0.0, lambda task: 1.5 * _longest(task)),
        Measure("chambers", lambda grown: grown.share_of_chambers, 0.35, lambda task: 0.85),
        Measure("cells", lambda grown: float(grown.cells), 2.5, lambda task: max(4.0, task.development.max_cells + 0.5)),
        Measure("sprawl", lambda grown: grown.sprawl, 0.9, lambda task: 2.5),
        Measure("asymmetry", lambda grown: grown.asymmetry, 0.0, lambda task: 1.0),
        Measure("beat", beat_of_body, -0.5, lambda task: BEATS - 0.5, BEATS),
    )
}


def measure(name: str) -> Measure:
    """Raises ParameterError where there is none of that name."""
    if name not in MEASURES:
        raise ParameterError(f"measure {shown(name)} is unknown: choose one of {', '.join(MEASURES)}")
    return MEASURES[name]
