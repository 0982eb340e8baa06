"""One evaluation on a body that is there: the task's fitness of a life on the hardware."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..genetics.genome import Genome
from ..live.animat import Animat, NotViable
from ..parameters import ParameterError, Task
from ..tasks.evaluation import evaluate, invalid
from ..tasks.life import activity
from ..tasks.outcome import FAILURE, Evaluation, Metrics, Status, failure
from ..tasks.swim.fitness import score
from ..tasks.swim.kernel import LOOK, Swim
from .plant import HardwarePlant
from .serial_body import Health, SerialBody

_GIVE_UP = 10.0  # s without a state
_SPOILT = 0.05  # share of a life in which the body did not do what it was told, from which on that life says nothing
_MOMENT = 10  # control steps that spoil no life, however short it is
_LIVES = 3  # that are tried
_FRESH = 15  # control steps within which a cell must have been seen to count as seen


class TrialError(RuntimeError):
    """The hardware did not carry a trial to its end; the message says why.  Attribute: moved: whether the life had begun."""

    def __init__(self, why: str, moved: bool = True):
        super().__init__(why)
        self.moved = moved


def check_task(task: Task) -> None:
    """Raises ParameterError where a task cannot be tried on hardware."""
    if task.name != "swim":
        raise ParameterError(f"task {task.name!r} cannot be evaluated on hardware, where nothing is carried back to its start: give swim")


def living(genome: Genome, task: Task, seed: int, body: SerialBody) -> Animat:
    """An animat that drives the body.  Raises NotViable where the genome grows another one."""
    animat = Animat(genome, task, seed, lambda grown: embody(grown.body.position, body))
    animat.plant.born = animat.activation.copy()
    return animat


def embody(position: np.ndarray, body: SerialBody) -> HardwarePlant:
    """The body as a plant for an animat whose cells grew at `position` (N, 2) m.  Raises NotViable where it is another body."""
    if fault := body.calibration.why_not(position):
        raise NotViable(f"{fault}: load a genome that grows this body, or calibrate for its own")
    return HardwarePlant(body)


def trial(
    genome: Genome, task: Task, seed: int, body: SerialBody, stop: Callable[[], bool] = lambda: False,
    show: Callable[[Animat], None] = lambda animat: None,
) -> Evaluation:
    """Evaluate a genome's network on the body: the swim of `task`, from rest, with the fitness of its simulated one.

    A genome that grows another body than that of the calibration fails, with the cause, and nothing moves.  A life in which the body
    was vented for long is lived again, and the genome fails with the cause where that happens each time.

    Args: stop: whether the trial is to end; show: called with the animat at its birth and after each control step.
    Raises TrialError where the line is lost for longer than a trial can wait, the body is stopped, or `stop()` says so; ParameterError
    where the task cannot be tried.
    """
    check_task(task)
    try:
        animat = living(genome, task, seed, body)
    except NotViable as error:
        grown = evaluate(genome, task, seed)
        return grown if grown.status in FAILURE else invalid(str(error))
    if body.health == Health.STOPPED:
        raise TrialError(body.why, moved=False)
    why = ""
    for _ in range(_LIVES):
        animat.reset()
        show(animat)
        swim, why = _live(animat, body, stop, show)
        if not why:
            return score(swim, task)
    return failure(Status.UNSTABLE, _metrics(animat), cause=f"{why} in each of {_LIVES} lives on the body")


def _live(animat: Animat, body: SerialBody, stop: Callable[[], bool], show: Callable[[Animat], None]) -> tuple[Swim, str]:
    """A life.  Returns: what it came to, and why it says nothing, or nothing."""
    task, plant = animat.task, animat.plant
    length, windows = task.control_steps // task.windows, task.windows
    path, amplitude, active, status = np.zeros((windows + 1, 2)), 2.0, 1.0, Status.OK
    where = _Where(len(animat.activation))
    where.see(animat)
    for window in range(windows):
        widest = np.stack([np.full(len(animat.activation), np.inf), np.full(len(animat.activation), -np.inf)])
        start, until = where.now(animat.steps), (window + 1) * length
        while animat.steps < until and status == Status.OK:
            _step(animat, body, stop)
            show(animat)
            where.see(animat)
            np.minimum(widest[0], animat.activation, out=widest[0])
            np.maximum(widest[1], animat.activation, out=widest[1])
            if window + 1 < windows and _will_never_move(animat):
                status = Status.RESTING
        moved = where.now(animat.steps) - start
        if not np.isfinite(moved).any():
            return _swim(animat, status, path, 0.0, 0.0), "no marker was seen from one window to the next"
        path[window + 1] = path[window] + np.nanmean(moved, axis=0)
        if status == Status.RESTING:
            path[window + 2 :] = path[window + 1]
            return _swim(animat, status, path, 0.0, 0.0), ""
        mean, working = activity(widest, task.full_activity)
        amplitude, active = min(amplitude, mean), min(active, working / task.development.max_cells)
    spoilt = plant.idle > max(_SPOILT * task.control_steps, _MOMENT)
    return _swim(animat, status, path, amplitude, active), f"the body was not armed for {plant.idle} control steps" if spoilt else ""


class _Where:
    """Where cells were last seen, and when.  Args: cells: number of them."""

    def __init__(self, cells: int):
        self._position, self._at = np.full((cells, 2), np.nan), np.full(cells, -np.inf)

    def see(self, animat: Animat) -> None:
        """Take what is seen after a control step."""
        seen = np.isfinite(animat.position).all(axis=1)
        self._position[seen], self._at[seen] = animat.position[seen], animat.steps

    def now(self, step: int) -> np.ndarray:
        """(N, 2) m: where cells are, NaN for those that have not been seen for a while."""
        return np.where((self._at > step - _FRESH)[:, None], self._position, np.nan)


def _will_never_move(animat: Animat) -> bool:
    """Whether its network is at rest for good, which earns nothing but plain distance."""
    return animat.task.fitness != "distance" and animat.steps % LOOK == 0 and animat.brain.rests()


def _metrics(animat: Animat) -> Metrics:
    body = animat.body
    chambers = len(body.triangle_area) + len(body.polygon_area)
    return Metrics(cells=len(animat.activation), springs=len(body.rest_length), chambers=chambers)


def _swim(animat: Animat, status: Status, path: np.ndarray, amplitude: float, active: float) -> Swim:
    m = _metrics(animat)
    return Swim(int(status), -1, path, amplitude, active, 0, m.cells, m.springs, m.chambers)


def _step(animat: Animat, body: SerialBody, stop: Callable[[], bool]) -> None:
    """One control step, waiting while the line is lost."""
    steps, waits = animat.steps, round(_GIVE_UP / body.calibration.state_within)
    for _ in range(waits):
        if stop():
            raise TrialError("it was stopped")
        if body.health == Health.STOPPED:
            raise TrialError(body.why)
        animat.step()
        if animat.steps > steps:
            return
    raise TrialError(f"the body did not answer for {_GIVE_UP:g} s: {body.why}")
