"""How much memory an evaluation takes, known before anything is allocated, so that what would not fit is refused by name."""

from __future__ import annotations

import numpy as np

from ..genetics.elements import HEADER, MORPHOGEN, REGULATORY
from ..genetics.genome import Genome
from ..parameters import Task

MOST_MEMORY = 2e9  # bytes of one evaluation
_PER_WEIGHT = 48  # bytes: the table of all weights, and two networks of those that count
_LONGEST = 255  # steps that variant A remembers, at the most


def needed(genome: Genome, task: Task) -> float:
    """Bytes that an evaluation allocates at the most, within a factor of two."""
    cells, development = task.development.max_cells, task.development
    units, morphogens = units_and_morphogens(genome.kind)
    rows = 3 * units + 16 + 2 * morphogens  # of concentrations, of what drives them, and of what neighbours exchange
    bytes_ = _PER_WEIGHT * (units + 4.0) ** 2 + 8.0 * cells * rows
    if development.variant == "continual_graph":
        return bytes_ + 4.0 * cells**2  # which pairs were found apart
    remembered = min(2.0 * cells / development.morphogen_speed + 2.0, _LONGEST + 1.0)
    return bytes_ + 16.0 * remembered * morphogens * cells + 52.0 * cells**2  # every pair is an edge, and has a delay


def units_and_morphogens(kind: np.ndarray) -> tuple[int, int]:
    """(regulatory units, those that may make morphogens) of a genome, the latter at the most.  Args: kind (E,) uint8."""
    behind = kind[HEADER:]
    begins = (behind == REGULATORY) & (np.append(behind[1:], REGULATORY) != REGULATORY)
    units = int(begins.sum())
    return units, min(units, int((behind == MORPHOGEN).sum()))


def over_limit(genome: Genome, task: Task) -> str:
    """What to lower where an evaluation would take more than MOST_MEMORY; empty where it fits."""
    bytes_ = needed(genome, task)
    if bytes_ <= MOST_MEMORY:
        return ""
    return (
        f"a genome of {len(genome)} elements with up to {task.development.max_cells} cells takes {bytes_ * 1e-9:.1f} GB, "
        f"more than {MOST_MEMORY * 1e-9:g}: lower development.max_cells, or shorten the genome"
    )
