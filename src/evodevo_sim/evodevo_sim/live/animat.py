"""Living animats, one control step at a time, by the kernels that evaluation runs: the same life, bit for bit."""

from __future__ import annotations

import contextlib
import dataclasses
import queue
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any

import numpy as np

from ..genetics.genome import Genome
from ..inputs import shown
from ..parameters import ParameterError, Rig, Task
from ..plant import Outcome
from ..tasks.memory import over_limit
from ..tasks.outcome import FAILURE, STIFF, Status

_LOOK = 50  # control steps between looks at whether all rests, as in evaluations
_CATCH_UP = 0.1  # s behind its pace from which a stage no longer tries to catch up
_ANSWER_WITHIN = 10.0  # s; a step of the largest body takes less


class NotViable(ValueError):
    """A genome that grows nothing which could move; the message says what is missing."""


class Animat:
    """An animat that lives for as long as it is stepped: a brain that drives a plant.

    Args: genome, task, seed: as for `evaluate`, but that no number of control steps ends it; embody: makes the plant that it drives in
    the place of the simulated one, of that one, and has actuators and sensors of its own, not those of the task; it may refuse it by
    NotViable.  Raises NotViable.

    Attributes:
        brain: see `brain.controller.Controller`; plant: see `plant.Plant`; body: see `body.Body`.
        position (N, 2) m, velocity (N, 2) m/s, activation (N,) of e - c: read-only views of the present state.
        steps: control steps lived; time: see there.
        status: OK; RESTING, when nothing will ever change again; UNSTABLE or INVERTED, after which it stays as it is.
        target: (x, y) m, whose scent the cells sense from the next step on if the task has targets; or None.
    """

    def __init__(self, genome: Genome, task: Task = Task(), seed: int = 0, embody: Callable[[Any], Any] | None = None):
        task = task if embody is None else dataclasses.replace(task, rig=Rig())
        self.genome, self.task, self.seed = genome, task, seed
        self.target: tuple[float, float] | None = None
        if too_much := over_limit(genome, task):
            raise NotViable(too_much)
        status, self.brain, self.plant = task.kind.function("begin")(genome, task, seed)
        self.steps, self.status = 0, Status(status)
        if self.status != Status.OK:
            raise NotViable(STIFF if self.status == Status.UNSTABLE else self.cause)
        self.body = self.plant.body
        if embody is not None:
            self.plant = embody(self.plant)
        self._sensed = self.plant.position.copy()  # where cells were last seen
        self._lost = False  # whether the plant has not answered
        self.position, self.velocity, self.activation = self.plant.position, self.plant.velocity, self.brain.activation

    def reset(self) -> None:
        """Back to birth, at once however long growth took.  The target stays."""
        self.brain.reset()
        self.plant.reset()
        self.steps, self.status, self._lost = 0, Status.OK, False

    @property
    def time(self) -> float:
        """s since birth: of the control steps lived, or where the plant has a clock of its own, at which the cells were seen."""
        return getattr(self.plant, "time", self.steps * self.task.control_step)

    @property
    def cause(self) -> str:
        """What failed, or nothing."""
        return FAILURE[self.status][1] if self.status in FAILURE else ""

    def step(self) -> None:
        """Live for one control step: one regulation step, then the body's."""
        if self.status == Status.OK:
            if not self._lost:
                self.brain.step(self.known(), self.target if self.task.has_target else None)
            outcome = self.plant.move(self.activation, self.task.control_step)
            self._lost = outcome == Outcome.LOST
            if self._lost:  # the brain waits with the body
                return
            if outcome != Outcome.SOUND:
                self.status = Status.INVERTED if outcome == Outcome.INVERTED else Status.UNSTABLE
            elif not self.task.has_target and (self.steps + 1) % _LOOK == 0 and self.brain.rests() and self.plant.rests():
                self.status = Status.RESTING  # where there are targets, one may come and wake it
        self.steps += 1


    def known(self) -> np.ndarray:
        """The cells (N, 2) m as the brain senses them: where one is not seen, where it was last."""
        if np.isfinite(self.position).all():
            return self.position
        seen = np.isfinite(self.position)
        self._sensed[seen] = self.position[seen]
        return self._sensed


class Stage:
    """Lets one animat live in a thread of its own, at a pace.

    Args:
        show: called in that thread with the animat when it is loaded or reset, and after every `every` steps.
        act: called in that thread with the animat after each step, whose activation is what its muscles were told in it; or None.
        stopped: called in that thread with a one-line reason when the animat cannot go on.

    The thread owns the animat: the methods ask it, and return when it has done as they ask.  What is refused, or not begun in
    time, changes nothing.
    """

    def __init__(
        self, show: Callable[[Animat], None], stopped: Callable[[str], None], every: int = 1,
        act: Callable[[Animat], None] | None = None,
    ):
        self.every = every
        self._show, self._stopped, self._act = show, stopped, act
        self._asked: queue.SimpleQueue = queue.SimpleQueue()
        self._animat: Animat | None = None
        self._target: tuple[float, float] | None = None
        self._interval, self._due = 0.0, 0.0
        self._paused = self._closed = False  # paused: only while there is an animat
        self._thread = threading.Thread(target=self._run, name="stage", daemon=True)
        self._thread.start()

    def load(self, animat: Animat, real_time_factor: float) -> bool:
        """Let an animat live, instead of the one before, paused or not; the last target stays.

        Args: real_time_factor: see `check_pace`.  Returns whether another one lived until then.
        """
        check_pace(real_time_factor)
        return self._do(lambda: self._enter(animat, animat.task.control_step / real_time_factor if real_time_factor else 0.0))

    def pause(self, paused: bool) -> bool:
        """Hold the animat, or let it go on.  Returns whether there is one; nothing changes where there is none."""
        return self._do(lambda: self._hold(paused))

    def reset(self) -> bool:
        """Back to birth; an animat that is held stays so.  Returns whether there is an animat."""
        return self._do(self._begin_anew)

    def unload(self) -> bool:
        """Let nobody live any more.  Returns whether there was one."""
        return self._do(self._leave)

    @property
    def lives(self) -> bool:
        """Whether there is an animat, held or not."""
        return self._animat is not None

    @property
    def paused(self) -> bool:
        """Whether an animat is held."""
        return self._paused

    def aim(self, target: tuple[float, float] | None) -> None:
        """Set the target of this animat and of those to come, from the next control step on.

        Nobody waits: however often this is called, the animat keeps its pace.
        """
        self._target = target

    def close(self) -> None:
        """End the thread.  Nothing is shown afterwards."""
        if not self._closed:
            self._asked.put((lambda: setattr(self, "_closed", True), Future()))
        self._thread.join()

    def _do(self, action):
        if self._closed:
            raise RuntimeError("the stage is closed")
        future: Future = Future()
        self._asked.put((action, future))
        try:
            return future.result(_ANSWER_WITHIN)
        except TimeoutError:
            if not future.cancel():  # under way by then
                return future.result()
            raise RuntimeError(f"a control step takes more than {_ANSWER_WITHIN:g} s: ask again later") from None

    def _run(self):
        while not self._closed:
            lives = self._animat is not None and not self._paused
            try:
                action, future = self._asked.get(timeout=max(0.0, self._due - time.monotonic()) if lives else None)
            except queue.Empty:
                self._step()
                continue
            if not future.set_running_or_notify_cancel():
                continue
            try:
                future.set_result(action())
            except BaseException as error:
                future.set_exception(error)

    def _step(self) -> None:
        self._due = max(self._due + self._interval, time.monotonic() - _CATCH_UP)
        animat = self._animat
        if animat is None:
            return
        try:
            animat.target = self._target
            lived = animat.steps
            animat.step()
            if animat.steps > lived:  # or else its body has not answered
                if self._act:
                    self._act(animat)
                if animat.steps % self.every == 0:
                    self._show(animat)
            cause = animat.cause
        except Exception as error:
            cause = f"unexpectedly: {error!r}"
        if cause:
            self._animat, self._paused = None, False
            with contextlib.suppress(Exception):  # nobody is left to be told
                self._stopped(cause)

    def _enter(self, animat, interval):
        others = self._animat is not None
        animat.target = self._target
        self._show(animat)  # before the other one leaves: where this fails, that one lives on
        self._animat, self._interval, self._due, self._paused = animat, interval, time.monotonic() + interval, False
        return others

    def _begin_anew(self):
        if self._animat is None:
            return False
        self._animat.reset()
        self._animat.target = self._target
        self._due = time.monotonic() + self._interval
        self._show(self._animat)
        return True

    def _leave(self):
        there = self._animat is not None
        self._animat, self._paused = None, False
        return there

    def _hold(self, paused):
        if self._animat is None:
            return False
        self._paused, self._due = paused, time.monotonic() + self._interval
        return True


def check_pace(real_time_factor: float) -> None:
    """Raises ParameterError unless it is a number of simulated s per s that a stage can keep; 0 is as fast as it goes."""
    if not 0.0 <= real_time_factor <= 1e6:
        raise ParameterError(f"real_time_factor is {shown(real_time_factor)}: give a number up to 1e6, or 0 for as fast as it goes")
