"""What a request may ask of a simulator node: looked at before anything of its size is allocated, converted or evaluated."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from rcl_interfaces.msg import IntegerRange, ParameterDescriptor

from ..genetics.limits import MAX_ELEMENTS
from ..parameters import Development, ParameterError, Task
from ..profiles import MOST_POINTS
from ..ros.barrier import brief
from ..ros.messages import task_of_request
from ..tasks.cost import seconds_of, steps_of

MOST_CELLS = 4096  # that the library knows
MOST = 10**12  # of steps and seconds: none that counts
# name: default, least, most, what it limits
PARAMETERS = {
    "max_batch": (1000, 1, 10_000, "genomes in one request, at the most"),
    "max_elements": (MAX_ELEMENTS, 8, MAX_ELEMENTS, "elements of a genome, at the most"),
    "max_cells": (1024, 1, MOST_CELLS, "development.max_cells of a task, at the most"),
    "max_steps": (1_000_000, 1, MOST, "steps of one evaluation, of growth and of all starts and tests, at the most"),
    "max_seconds": (3600, 1, MOST, "s of one core that a request may take, as its numbers tell"),
    "max_waiting": (100, 1, 10_000, "requests that wait or are under way, at the most"),
}
UNLIMITED = {name: most for name, (_, _, most, _) in PARAMETERS.items()}  # for simulators that answer to who started them alone


@dataclass(frozen=True)
class Limits:
    """The parameters `max_...` of a node, see `PARAMETERS`."""

    max_batch: int
    max_elements: int
    max_cells: int
    max_steps: int
    max_seconds: int
    max_waiting: int

    @classmethod
    def declared(cls, node: Any) -> Limits:
        """Those of a node of rclpy, set at its start only."""
        return cls(**{name: node.declare_parameter(name, given[0], _descriptor(*given[1:])).value for name, given in PARAMETERS.items()})

    def refuse(self, genomes: Sequence[Any], message: Any, waiting: int = 0) -> str:
        """Why a request is not taken, and the mend; empty where it is.  It takes no longer than to look at lengths.

        Args: genomes: messages; message: of their task; waiting: requests that are there already.
        """
        if not 0 < len(genomes) <= self.max_batch:
            return f"{len(genomes)} genomes in a request: give 1 to {self.max_batch}"
        if waiting >= self.max_waiting:
            return f"{waiting} requests wait already, as many as max_waiting allows: ask again later, or another simulator"
        try:
            task = task_within(message)
        except ParameterError as error:
            return brief(error)
        return self._refuse_task(task) or self._refuse_genomes(genomes, task)

    def _refuse_task(self, task: Task) -> str:
        cells, steps = task.development.max_cells, steps_of(task)
        if cells > self.max_cells:
            return f"development.max_cells is {cells}: give up to {self.max_cells}, or start the simulator with -p max_cells:={cells}"
        if steps > self.max_steps:
            return (
                f"an evaluation of up to {steps} steps in all its starts and tests: give up to {self.max_steps}, "
                f"or start the simulator with -p max_steps:={steps}"
            )
        return ""

    def _refuse_genomes(self, genomes: Sequence[Any], task: Task) -> str:
        seconds = 0.0
        for place, genome in enumerate(genomes):
            elements = max(len(part) for part in (genome.kind, genome.sign, genome.x, genome.y))
            if elements > MAX_ELEMENTS:
                continue  # it fails alone, whoever evaluates it
            if elements > self.max_elements:
                return (
                    f"genome {place} has {elements} elements: give up to {self.max_elements}, "
                    f"or start the simulator with -p max_elements:={elements}"
                )
            seconds += seconds_of(genome.kind, task)
        if seconds > self.max_seconds:
            return (
                f"{len(genomes)} genomes of up to {task.development.max_cells} cells and {steps_of(task)} steps may take {seconds:.3g} s: "
                f"give fewer in a request, or start the simulator with -p max_seconds:={int(np.ceil(seconds))}"
            )
        return ""


def task_within(message: Any) -> Task:
    """The task that a request asks for.  Raises ParameterError, for a profile of too many points before they are converted."""
    for name in ("ground", "ceiling"):
        points = len(getattr(message.scene, name))
        if points > MOST_POINTS:
            raise ParameterError(f"scene: {name} has {points} points: give none, or 2 to {MOST_POINTS}")
    return task_of_request(message)


def _descriptor(low: int, high: int, meaning: str) -> ParameterDescriptor:
    ranges = [IntegerRange(from_value=low, to_value=high, step=1)]
    return ParameterDescriptor(description=meaning, read_only=True, integer_range=ranges)


assert Development.__dataclass_fields__["max_cells"].metadata["range"][1] == MOST_CELLS
