"""The descent of a run's champion: from the directory of the run to the picture."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
from evodevo_sim.tasks.life import develop
from evodevo_sim.tasks.swim.fitness import kernel_arguments

from evodevo_sim import Genome, Task

from ..keeping.checkpoint import read_checkpoint, task_of_plain
from ..keeping.errors import ResumeError
from ..keeping.history import champion_of_row, read_table
from .lineage import Lineage, lineage
from .picture import BODIES, Ancestor, save_descent

_UNKEPT = np.empty((0, 0, 0)), np.empty((0, 0)), np.empty((0, 0, 0), np.int64)
_BETWEEN = "  ·  "


def descent(directory: Path, number: int | None = None) -> Lineage:
    """The ancestors of a run's last champion, or of the individual of a number.  Raises ResumeError."""
    if number is None:
        number = read_table(directory, "hall_of_fame")["number"][-1].as_py()
    return lineage(read_table(directory, "history"), number)


def draw_descent(directory: Path, path: str | os.PathLike, number: int | None = None) -> str:
    """Draw the descent of a run's champion.  Returns: it in a line.  Raises ResumeError."""
    run, _ = read_checkpoint(directory, _shows(directory))
    found = descent(directory, number)
    generations, fame = read_table(directory, "generations"), read_table(directory, "hall_of_fame").to_pylist()
    bodies = _bodies(found, fame, task_of_plain(run["task"]))
    who = "champion" if number is None else f"individual {number}"
    title = f"{directory.resolve().name}: descent of the {who}"
    best, median = (generations[name].to_numpy() for name in ("best", "median"))
    told = words(found)
    about = f"{run['task']['name']}, {run['evolution']['scheme']}, seed {run['evolution']['seed']}"
    save_descent(found, bodies, best, median, (title, _BETWEEN.join([about, *told])), path)
    return ", ".join(told)


def words(found: Lineage) -> list[str]:
    """A lineage in words."""
    line = found.line
    crossed = sum("crossover" in found.operators[place] for place in line)
    return [
        f"individual {found.number[-1]} of generation {found.generation[-1]}, fitness {found.fitness[-1]:.3f} m",
        f"a line of {len(line)}, {crossed} of them by crossover",
        f"{len(found.number) - 1} ancestors in all",
        f"from {found.elements[line[0]]} to {found.elements[-1]} genetic elements, {found.cells[line[0]]} to {found.cells[-1]} cells",
    ]


def _bodies(found: Lineage, fame: list[dict[str, Any]], task: Task) -> list[Ancestor]:
    """Bodies of those in the line whose genomes the hall of fame has, evenly over the line."""
    genomes = {row["number"]: champion_of_row(row).genome for row in fame}
    known = [int(place) for place in found.line if int(found.number[place]) in genomes]
    if not known:
        return []
    wanted = np.linspace(found.generation[known[0]], found.generation[known[-1]], BODIES)
    nearest = [known[int(np.argmin(np.abs(found.generation[known] - at)))] for at in wanted]
    return [Ancestor(place, *_grown(genomes[int(found.number[place])], task)) for place in sorted(set(nearest))]


def _grown(genome: Genome, task: Task) -> tuple[np.ndarray, np.ndarray]:
    """Positions of the cells of a grown body (N, 2) m, and the pairs of neighbours (E, 2)."""
    _, _, embryo = develop(*kernel_arguments(genome, task), *_UNKEPT)
    return embryo.position, embryo.edges.reshape(-1, 2)


def check(directory: Path) -> None:
    """Raises ResumeError where a directory is not that of a run with a history."""
    read_checkpoint(directory, _shows(directory))  # says what else it is
    if not (directory / "hall_of_fame").is_dir():
        raise ResumeError(f"{directory} has no history yet: it is there after ten generations, or when the run has ended")


def _shows(directory: Path) -> str:
    return f"`ros2 run evodevo_sim replay {directory} --show evolve` shows its champions"
