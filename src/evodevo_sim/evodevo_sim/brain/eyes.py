"""How cells are seen by a camera: late, not quite where they are, and now and then not at all (docs/reference/plant.md)."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..kernels.jit import seam
from .chance import normal, uniform

if TYPE_CHECKING:
    from ..parameters import Task


class Eyes(NamedTuple):
    """A camera.  `seen` is empty where it sees at once what is."""

    seen: np.ndarray  # (2 + 2 D, most cells) m: x and y as they were last seen; then those of D control steps, on their way; NaN: none yet
    noise: float  # m, standard deviation
    resolution: float  # m, 0 for none
    lost: float  # probability of a marker not to be seen


def open_eyes() -> Eyes:
    """Eyes that see at once what is."""
    return Eyes(np.empty((0, 0)), 0.0, 0.0, 0.0)


def eyes_of(task: Task) -> Eyes:
    """The eyes of a task's rig, for one life at a time."""
    rig, waits = task.rig, task.rig.steps(task.rig.sensor_delay, task.control_step)
    noise, resolution, lost = rig.sensor_noise, rig.fine(rig.sensor_resolution), rig.sensor_lost
    if not task.has_target or not (waits or noise or resolution or lost):
        return open_eyes()
    return Eyes(np.full((2 + 2 * waits, task.development.max_cells), np.nan), noise, resolution, lost)


@seam
def see(eyes, position, random, step):
    """Fill the first two rows of `eyes.seen`.  Args: position (2, N) m; step: control step, before 0 of which cells were where they are."""
    seen, waits = eyes.seen, eyes.seen.shape[0] // 2 - 1
    if step == 0:
        for k in range(waits + 1):
            for i in range(position.shape[1]):
                seen[2 * k, i], seen[2 * k + 1, i] = position[0, i], position[1, i]
    row = 2 + 2 * (step % max(1, waits))
    for i in range(position.shape[1]):
        x, y = position[0, i], position[1, i]
        if waits:
            then_x, then_y = seen[row, i], seen[row + 1, i]
            seen[row, i], seen[row + 1, i] = x, y
            if then_x == then_x:
                x, y = then_x, then_y
        if eyes.noise > 0.0:
            x += eyes.noise * normal(random)
            y += eyes.noise * normal(random)
        if eyes.resolution > 0.0:
            x, y = np.rint(x / eyes.resolution) * eyes.resolution, np.rint(y / eyes.resolution) * eyes.resolution
        if eyes.lost > 0.0 and uniform(random) < eyes.lost and seen[0, i] == seen[0, i]:
            continue
        seen[0, i], seen[1, i] = x, y
