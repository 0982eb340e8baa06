"""What the archive of a run holds: its axes, and the animals in its cells."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from evodevo_sim.inputs import InputError
from evodevo_sim.tasks.grown import Grown
from evodevo_sim.tasks.outcome import FAILURE, Status
from evodevo_sim.view.body_map import Axis

from evodevo_sim import GenomeError, ParameterError, Task

from ..individual import Individual, individual_of_plain
from ..keeping.checkpoint import read_checkpoint, task_of_plain
from ..schemes import search_of
from ..settings import Settings

# Measures by name: the axis' title, and what is shown of a value.
_TITLES: dict[str, tuple[str, Callable[[float], float]]] = {
    "elongation": ("length over width of the grown body", math.exp),
    "chambers": ("chambers, share of those of the most compact body", float),
    "cells": ("cells", float),
    "sprawl": ("radius of gyration over that of a round body of as many cells", float),
    "asymmetry": ("how unlike front and back are, m", float),
    "beat": ("beat of the muscles: 0 still, 1 of a part, 2 pulse, 3 sides against each other, 4 wave", float),
}


class GalleryError(InputError, RuntimeError):
    """A run that no gallery can be drawn of; the message says what it is, and what can be drawn instead."""


@dataclass(frozen=True, eq=False)
class Animal:
    """An elite.  Attributes: individual; grown: its body; column, row: its cell on the map."""

    individual: Individual
    grown: Grown
    column: int
    row: int


@dataclass(frozen=True, eq=False)
class Content:
    """name: of the run; scheme, seed, generation: of it; task; x, y: the map's axes; animals: by their cells, row after row."""

    name: str
    scheme: str
    seed: int
    generation: int
    evaluations: int
    task: Task
    x: Axis
    y: Axis
    animals: tuple[Animal, ...]


def read_content(directory: Path) -> tuple[Content, list[str]]:
    """The archive of a run as its last checkpoint has it.

    Returns: it; what must be known of the checkpoint, a line each.  Raises ResumeError where the directory is not that of a run,
    GalleryError where the run has no archive, or nobody lives in it.
    """
    run, notes = read_checkpoint(directory, f"`ros2 run evodevo_sim replay {directory} --show evolve` shows its champions")
    try:
        task, found = task_of_plain(run["task"]), run["evolution"]
        settings = Settings(**{field.name: found["settings"][field.name] for field in dataclasses.fields(Settings)})
        search: Any = search_of(settings, found["scheme"])
        individuals = [individual_of_plain(one) for one in found["population"]]
        scheme, seed, generation, evaluations = found["scheme"], found["seed"], found["generation"], found["evaluations"]
    except (ParameterError, GenomeError) as error:
        raise GalleryError(f"{directory}: {error}") from None
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        raise GalleryError(f"{directory}: its checkpoint is not whole ({type(error).__name__}: {error}): restore it") from None
    if not hasattr(search, "measures"):
        raise GalleryError(
            f"{directory} is a run of scheme {scheme!r}, which keeps no archive of unlike animals: `ros2 run evodevo_ga descent` draws "
            "the line of its champion, `ros2 run evodevo_sim replay` its life"
        )
    search.task = task
    x, y, animals = _placed(search, individuals)
    if not animals:
        raise GalleryError(f"{directory}: nobody lives in its archive yet: evolve it longer, by --resume")
    return Content(directory.resolve().name, scheme, seed, generation, evaluations, task, x, y, animals), notes


def _placed(search: Any, individuals: list[Individual]) -> tuple[Axis, Axis, tuple[Animal, ...]]:
    """The axes of an archive, and who is in which cell.  Of more than two measures the first two are drawn, and the fittest of a cell."""
    grid = search.grid()
    axes = [
        axis_of(measure.name, np.linspace(low, high, bins + 1))
        for measure, low, high, bins in zip(search.measures, grid.lower_bounds, grid.upper_bounds, grid.dims)
    ]
    x, y = (*axes, Axis("", (0.0, 1.0)))[:2]
    cells: dict[tuple[int, int], Animal] = {}
    for one in individuals:
        if one.evaluation.status in FAILURE or one.evaluation.status == Status.STOPPED:
            continue
        grown = search.nursery.grow(one.genome)
        kind = search.kind(grown)
        if kind is None:
            continue
        place = (*(int(k) for k in grid.int_to_grid_index([kind])[0]), 0)
        animal = Animal(one, grown, place[0], place[1])
        known = cells.get((animal.row, animal.column))
        if known is None or one.evaluation.fitness > known.individual.evaluation.fitness:
            cells[animal.row, animal.column] = animal
    return x, y, tuple(animal for _, animal in sorted(cells.items()))


def axis_of(name: str, edges: np.ndarray) -> Axis:
    """The axis of a measure.  Args: edges (bins + 1,): in the measure's own values."""
    title, shown = _TITLES.get(name, (name, float))
    return Axis(title, tuple(shown(edge) for edge in edges.tolist()))
