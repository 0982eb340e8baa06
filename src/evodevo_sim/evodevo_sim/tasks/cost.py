"""How long an evaluation takes at the most, told by its numbers alone, before anything of its size is allocated or computed."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..parameters import Task
from ..physics.step_size import ACCURATE_REST, MOST_SUBSTEPS
from .memory import units_and_morphogens

# ns of one core, of a processor that is not new; docs/reference/limits.md tells how they were measured.
_CELL = 160.0  # a cell in a control step: its part of growth, network and senses
_SUBSTEP = 80.0  # the same in a step of physics
_WEIGHT = 0.12  # a weight of the network, in each cell and step
_DELAYED = 2.0  # variant A: a morphogen that goes from a cell to another, in each step


def steps_of(task: Task) -> int:
    """Steps that an evaluation takes at the most: of growth, and of all that follows, from each start and towards each target."""
    lives = task.control_steps
    if task.has_ground:
        lives = task.starts * (task.settling_limit + task.control_steps)
    elif task.has_target:
        lives = (1 + 2 * task.chemotaxis.pairs) * task.control_steps
    return task.development.steps + lives


def seconds_of(kind: Any, task: Task, steps: int | None = None) -> float:
    """Seconds of one core that an evaluation takes at the most, within a factor of three or so of what it can take.

    Most take far less: bodies stay smaller, come to rest, or earn no second test.

    Args: kind (E,) uint8: of a genome's elements; steps: by default all.
    """
    units, morphogens = units_and_morphogens(np.asarray(kind, np.uint8))
    cells = task.development.max_cells
    weights = (units + 4.0) * (units + morphogens + 4.0)
    delayed = 0.0 if task.development.variant == "continual_graph" else _DELAYED * morphogens * cells
    steps = steps_of(task) if steps is None else steps
    return 1e-9 * steps * cells * (_CELL + _SUBSTEP * _substeps(task) + _WEIGHT * weights + delayed)


def _substeps(task: Task) -> float:
    """Steps of physics in a control step of a body with as many springs at each cell as fit."""
    m = task.material
    fastest = max(math.sqrt((12.0 * m.stiffness + 6.0 * m.pressure) / m.mass), 12.0 * m.damping / m.mass)
    return min(max(1.0, task.control_step * fastest / ACCURATE_REST), MOST_SUBSTEPS)
