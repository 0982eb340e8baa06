"""One evaluation on a body that is there: the task's fitness of a life on the hardware."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..genetics.genome import Genome
from ..live.animat import Animat, NotViable
from ..parameters import ParameterError, Task
from ..tasks.evaluation import evaluate, invalid
from ..tasks.life import activity
from ..tasks.outcome import FAILURE, Evaluation, Status
from ..tasks.swim.fitness import score
from ..tasks.swim.kernel import Swim
from .plant import HardwarePlant
from .serial_body import SerialBody

_GIVE_UP = 10.0  # s without a state


class TrialError(RuntimeError):
    """The hardware did not carry a trial to its end; the message says why."""


def check_task(task: Task) -> None:
    """Raises ParameterError where a task cannot be tried on hardware."""
    if task.name != "swim":
        raise ParameterError(f"task {task.name!r} cannot be evaluated on hardware, where nothing is carried back to its start: give swim")


def trial(
    genome: Genome, task: Task, seed: int, body: SerialBody, stop: Callable[[], bool] = lambda: False,
) -> Evaluation:
    """Evaluate a genome's network on the body: the swim of `task`, from rest, with the fitness of its simulated one.

    A genome that grows another body than that of the calibration fails, with the cause.  Raises TrialError where the line is lost
    for longer than a trial can wait, or `stop()` says so; ParameterError where the task cannot be tried.
    """
    check_task(task)
    try:
        animat = Animat(genome, task, seed, lambda grown: embody(grown.position, body))
    except NotViable as error:
        grown = evaluate(genome, task, seed)
        return grown if grown.status in FAILURE else invalid(str(error))
    animat.plant.reset()
    length, windows = task.control_steps // task.windows, task.windows
    path, amplitude, active = np.zeros((windows + 1, 2)), 2.0, 1.0
    path[0] = _centre(animat.position)
    for window in range(windows):
        widest = np.stack([np.full(len(animat.activation), np.inf), np.full(len(animat.activation), -np.inf)])
        until = (window + 1) * length
        while animat.steps < until:
            _step(animat, body, stop)
            np.minimum(widest[0], animat.activation, out=widest[0])
            np.maximum(widest[1], animat.activation, out=widest[1])
        path[window + 1] = _centre(animat.position)
        mean, working = activity(widest, task.full_activity)
        amplitude, active = min(amplitude, mean), min(active, working / task.development.max_cells)
    grown_body = animat.body
    chambers = len(grown_body.triangle_area) + len(grown_body.polygon_area)
    cells, springs = len(animat.activation), len(grown_body.rest_length)
    return score(Swim(int(Status.OK), -1, path, amplitude, active, 0, cells, springs, chambers), task)


def embody(position: np.ndarray, body: SerialBody) -> HardwarePlant:
    """The body as a plant for an animat whose cells grew at `position` (N, 2) m.  Raises NotViable where it is another body."""
    if fault := body.calibration.why_not(position):
        raise NotViable(f"{fault}: load a genome that grows this body, or calibrate for its own")
    return HardwarePlant(body)


def _step(animat: Animat, body: SerialBody, stop: Callable[[], bool]) -> None:
    """One control step, waiting while the line is lost."""
    steps, waits = animat.steps, round(_GIVE_UP / body.calibration.state_within)
    for _ in range(waits):
        if stop():
            raise TrialError("it was stopped")
        animat.step()
        if animat.steps > steps:
            return
    raise TrialError(f"the body did not answer for {_GIVE_UP:g} s: {body.why}")


def _centre(position: np.ndarray) -> np.ndarray:
    """The centre (2,) m of the cells that are seen."""
    return np.nanmean(position, axis=0)
