"""A body of hardware that evaluates: one genome after the other, on the driver of one namespace.

It stands where a `Pool` stands, and has none of its proofs: what a body does is not repeated by our own evaluation, nor by a second one.
"""

from __future__ import annotations

import itertools
import random
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import rclpy
from evodevo_sim.development.shape import farthest_cell
from evodevo_sim.inputs import one_line
from evodevo_sim.ros.environment import started
from evodevo_sim.ros.messages import genome_message, task_message
from evodevo_sim.ros.requests import BROKEN, given_back
from evodevo_sim.ros.topics import CELL_STATES, CHANNELS
from evodevo_sim.tasks.evaluation import Performance
from evodevo_sim.tasks.grown import grow
from evodevo_sim.tasks.outcome import Metrics, Status, failure

from evodevo_msgs.srv import Cancel, Evaluate
from evodevo_sim import Evaluation, Genome, Task, perform

from ..answers import looked_at
from ..arguments import Options
from ..backends.contract import AnswerError
from ..backends.simulator import evaluations_of
from ..one_body import NEAR
from ..pool.vigil import PoolError

_FIND = 10.0  # s for a driver to be found
_TURN = 0.1  # s
_REST = 1.0  # s until a body that is not ready is asked again
_AGAIN = 30.0  # s beyond a life and its settling, after which an answer counts as lost
_LIVES = 2  # of a genome that may be broken off, e.g. by too much pressure, before it fails
_PER_LIFE = 3.0  # s for each s of a life, as a driver lives it again where it was spoilt
_ids = itertools.count(random.SystemRandom().getrandbits(62) + 1)


@dataclass(frozen=True, eq=False)
class Body:
    """The body of a driver.  channels: its message `Channels`; position (N, 2) m: of its cells at rest."""

    channels: Any
    position: np.ndarray


def find_body(options: Options, arguments: list[str]) -> Body:
    """The body of the rig of a run.  Raises PoolError where there is none, or a genome to begin from grows another one."""
    with started("evolve", arguments):
        node = rclpy.create_node("evolve")
        heard: list[Any] = []
        node.create_subscription(CHANNELS.type, CHANNELS.at(options.rig), heard.append, CHANNELS.quality)
        until = time.monotonic() + _FIND
        while not heard and time.monotonic() < until:
            rclpy.spin_once(node, timeout_sec=_TURN)
        node.destroy_node()
    if not heard:
        raise PoolError(f"nobody tells {CHANNELS.at(options.rig)}: start the driver of the body, or give another namespace by --rig")
    body = Body(heard[-1], np.column_stack((heard[-1].x, heard[-1].y)))
    if len(body.position) != len(heard[-1].channel) or not np.isfinite(body.position).all():
        raise PoolError(f"{CHANNELS.at(options.rig)} does not tell where the cells of its body are: let the driver fill x and y")
    for k, genome in enumerate(options.start):
        if why := _why_not(grow(genome, options.task).position, body):
            source = options.sources[k] if k < len(options.sources) else f"genome {k}"
            raise PoolError(f"{source}: {why}: give a genome that grows this body, and its --cells and --set")
    return body


def _why_not(position: np.ndarray, body: Body) -> str:
    """Why a grown body (N, 2) m is not that of the rig, or nothing."""
    name = body.channels.name[:40]
    if len(position) != len(body.position):
        return f"it grows {len(position)} cells, and the body {name!r} has {len(body.position)}"
    cell, far = farthest_cell(position, body.position)
    return f"its cell {cell} grows {far:.2g} m from where the body {name!r} has it, more than {NEAR:g} m" if far > NEAR else ""


class Rig:
    """Evaluates on the body of a driver.

    Args: node, executor: of rclpy, whose owner is the caller; namespace: of the driver; say: is told what people must know; give_up_after:
    s to wait for a body that is gone, or not ready.
    """

    def __init__(self, node: Any, executor: Any, namespace: str, say: Callable[[str], object], give_up_after: float):
        self._node, self._executor, self._say, self._give_up_after = node, executor, say, give_up_after
        self._namespace = namespace.rstrip("/")
        self._client = node.create_client(Evaluate, f"{self._namespace}/evaluate")
        self._canceller = node.create_client(Cancel, f"{self._namespace}/cancel")
        self._told = ""
        self._since: float | None = None  # s, since when nobody answers

    def close(self) -> None:
        self._node.destroy_client(self._client)
        self._node.destroy_client(self._canceller)

    def evaluate(
        self, genomes: Sequence[Genome], task: Task, seed: int, stop: Callable[[], bool] = lambda: False, best: float = 0.0,
        bars: Sequence[float] = (),
    ) -> list[Evaluation] | None:
        """Evaluate genomes in order, each with its whole life; None when `stop()` said to stop.  Raises PoolError where the driver
        refuses, or nobody answers for too long.  Args: best, bars: see `Pool`; a body has no use of them."""
        found = []
        for genome in genomes:
            evaluation = self._evaluation(genome, task, seed, stop)
            if evaluation is None:
                return None
            found.append(evaluation)
        return found

    def perform(self, genome: Genome, task: Task, seed: int, stop: Callable[[], bool]) -> Performance:
        """A life to look at: growth as it is simulated, and locomotion as the body shows it; none of it where `stop()` says to stop."""
        simulated = perform(genome, task, seed)
        heard: list[Any] = []
        topic, quality = CELL_STATES.at(self._namespace), replace(CELL_STATES.service, depth=1000).profile()
        subscription = self._node.create_subscription(CELL_STATES.type, topic, heard.append, quality)
        try:
            evaluation = self._evaluation(genome, task, seed, stop)
        finally:
            self._node.destroy_subscription(subscription)
        steps = [message.step for message in heard]
        begin = max((k for k in range(1, len(steps)) if steps[k] <= steps[k - 1]), default=0)  # a life that was spoilt comes before
        time_, position, velocity, activation = (
            np.array(values) for values in (simulated.time, simulated.position, simulated.velocity, simulated.activation)
        )
        for values in (position, velocity, activation):
            values[...] = np.nan
        for message in heard[begin:] if evaluation is not None else []:
            k = message.step
            if k < len(time_) and len(message.position_x) == position.shape[1]:
                time_[k] = message.header.stamp.sec + message.header.stamp.nanosec * 1e-9
                position[k] = np.column_stack((message.position_x, message.position_y))
                velocity[k] = np.column_stack((message.velocity_x, message.velocity_y))
                activation[k] = message.activation
        evaluation = evaluation or simulated.evaluation
        return replace(simulated, evaluation=evaluation, time=time_, position=position, velocity=velocity, activation=activation)

    def _evaluation(self, genome: Genome, task: Task, seed: int, stop: Callable[[], bool]) -> Evaluation | None:
        client = self._node.get_fully_qualified_name()
        request = Evaluate.Request(task=task_message(task), seed=seed, genomes=[genome_message(genome)], id=next(_ids), client=client)
        broken = 0
        while True:
            response = self._ask(request, task, stop)
            if response is None:
                return None
            if not response.error:
                self._since, self._told = None, ""
                try:
                    return looked_at(evaluations_of(response, 1), 1)[0]
                except AnswerError as error:
                    raise PoolError(f"{self._namespace}: {error}") from None
            if not given_back(response.error):
                raise PoolError(f"{self._namespace} refuses to evaluate: {one_line(response.error)}")
            broken += response.error.startswith(BROKEN)
            if broken >= _LIVES:
                return failure(Status.UNSTABLE, Metrics(), cause=one_line(f"{response.error}, in each of {broken} lives"))
            self._wait(one_line(response.error), stop)

    def _ask(self, request: Any, task: Task, stop: Callable[[], bool]) -> Any:
        """The answer to a request, asked again where it may be lost; None where `stop()` says to stop."""
        asked, patience, again = None, _AGAIN + _PER_LIFE * task.control_steps * task.control_step, 0.0
        while not stop():
            if not self._client.service_is_ready():
                asked = None
                self._wait(f"nobody offers {self._namespace}/evaluate", stop)
                continue
            if asked is None or time.monotonic() > again:
                asked, again = self._client.call_async(request), time.monotonic() + patience
            self._executor.spin_once(timeout_sec=_TURN)
            if asked.done():
                return asked.result()
        if asked is not None and self._canceller.service_is_ready():
            self._canceller.call_async(Cancel.Request(id=request.id))
            self._executor.spin_once(timeout_sec=_TURN)
        return None

    def _wait(self, why: str, stop: Callable[[], bool]) -> None:
        """Let a while pass in which the body may come back.  Raises PoolError where it has been gone for too long."""
        now = time.monotonic()
        self._since = self._since or now
        if now - self._since > self._give_up_after:
            raise PoolError(f"the body is not ready any more: {why}: start or arm it, and go on by --resume")
        if why != self._told and now - self._since >= _REST:
            self._told = why
            self._say(f"waiting for the body: {why}")
        until = now + _REST
        while time.monotonic() < until and not stop():
            self._executor.spin_once(timeout_sec=_TURN)
