"""Simulator nodes as one evaluator: finds them on the graph, and shares a generation's genomes among them.

Nothing rests on an answer that was not looked at (see `answers`).  Besides, one genome of the first answer of each node, and each
that would be champion, is evaluated here too: a node that gives another fitness for it is dropped, and what it answered goes to others.
"""

from __future__ import annotations

import time
from collections import Counter, deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from evodevo_sim.ros.barrier import brief, told
from evodevo_sim.ros.messages import genome_message, task_message
from evodevo_sim.tasks.evaluation import invalid
from rclpy.callback_groups import ReentrantCallbackGroup

from evodevo_msgs.srv import Evaluate
from evodevo_sim import Evaluation, Genome, Status, Task, evaluate

from .answers import AnswerError, alike, look_at
from .times import MESSAGES, Times

SERVICE_TYPE = "evodevo_msgs/srv/Evaluate"
BATCH = 16  # genomes in a request, at the most
IN_FLIGHT = 2  # requests queued at a node, so that it never waits for us
ANSWER_WITHIN = 120.0  # s for one request, and a hundred times what its steps take; a node that takes longer counts as lost
_SLOW_STEP = 1e-3  # s
_SLOW_PAIR = 1e-9  # s for a pair of genetic elements in a cell and a step
_MOST_ENDED = 2  # simulators that a genome may end before it counts as failed
_LOOK_EVERY = 0.1  # s, at the silent ones


class FleetError(RuntimeError):
    """No simulator can go on; the message says why and what to do."""


def find_simulators(node: Any) -> list[str]:
    """The evaluate services on the graph.  Those in hidden namespaces (`/_...`) belong to other runs."""
    services = node.get_service_names_and_types()
    return sorted(name for name, types in services if SERVICE_TYPE in types and "/_" not in name)


def batches(count: int, servers: int) -> list[list[int]]:
    """Places 0 to count - 1 in requests that get smaller towards the end, so that the last to finish keeps nobody waiting."""
    parts, first = [], 0
    while first < count:
        size = min(max((count - first) // (IN_FLIGHT * servers), 1), BATCH)
        parts.append(list(range(first, first + size)))
        first += size
    return parts


@dataclass
class _Request:
    genomes: list[int]  # places in the generation
    server: Any  # a client of rclpy
    future: Any  # of rclpy
    deadline: float


@dataclass
class _Generation:
    """What is to be evaluated, and what is known of it.

    Attributes, by place: results; by: who gave them; ended: simulators that were lost while they evaluated it, alone or in a batch;
        doubted: who said that it is no genome, which another one is to confirm.
    """

    genomes: list[Genome]
    task: Task
    seed: int
    waiting: deque[list[int]]
    results: list[Evaluation | None]
    bars: Sequence[float] = ()
    by: dict[int, object] = field(default_factory=dict)
    ended: Counter = field(default_factory=Counter)
    doubted: dict[int, object] = field(default_factory=dict)

    def bars_of(self, places: list[int]) -> list[float]:
        """None, or one for each place."""
        return [self.bars[i] for i in places] if self.bars else []


class Fleet:
    """Evaluates genomes on simulator nodes.  The outcome does not depend on who evaluates what, or when.

    Args: node, executor: of the caller, who owns them; services: names of `evaluate` services; times: told how long messages take.
    """

    def __init__(self, node: Any, executor: Any, services: list[str], times: Times | None = None):
        self._times = times or Times()
        group = ReentrantCallbackGroup()
        self._executor = executor
        self._node = node
        self._servers = [node.create_client(Evaluate, name, callback_group=group) for name in services]
        self._proved: list = []  # servers whose first answer was right

    def __len__(self) -> int:
        return len(self._servers)

    def wait(self, seconds: float, alive: Callable[[], bool] = lambda: True, stop: Callable[[], bool] = lambda: False) -> None:
        """Wait until every service answers, or `stop()`; those that do not in time are dropped.

        Raises FleetError when none answers, or when `alive()` says that one cannot.
        """
        deadline = time.monotonic() + seconds
        while not stop() and (silent := [server for server in self._servers if not server.service_is_ready()]):
            if not alive():
                raise FleetError("a simulator ended at once: run `ros2 run evodevo_sim simulator` to see why")
            if time.monotonic() > deadline:
                for server in silent:
                    self._drop(server, "it does not answer")
            else:
                silent[0].wait_for_service(timeout_sec=0.05)

    def evaluate(
        self, genomes: list[Genome], task: Task, seed: int, stop: Callable[[], bool] = lambda: False, best: float = float("-inf"),
        bars: Sequence[float] = (),
    ) -> list[Evaluation] | None:
        """Evaluate genomes in order; None when `stop()` said to stop.

        A node that dies, hangs, refuses or answers what cannot be is dropped, and its genomes go to the others.  A genome that ends
        one node after the other counts as failed.  Raises FleetError when no node is left.

        Args: best: fitness from which on the best of these genomes is evaluated here too; bars: none, or one for each, see `evaluate`.
        """
        work = _Generation(genomes, task, seed, deque(batches(len(genomes), len(self._servers))), [None] * len(genomes), bars)
        while self._share(work, stop):
            if self._best_is_right(work, best):
                return [one for one in work.results if one is not None]  # all, since nothing waits
        return None

    def _share(self, work: _Generation, stop) -> bool:
        """Have all that waits evaluated.  Returns: False where `stop()` said to stop."""
        with self._times(MESSAGES):
            message = task_message(work.task)
        under_way: list[_Request] = []
        next_look = time.monotonic() + _LOOK_EVERY
        steps = work.task.development.steps + work.task.starts * (work.task.settling_limit + work.task.control_steps)
        while work.waiting or under_way:
            if stop():
                return False
            for server in self._servers:
                while sum(request.server is server for request in under_way) < IN_FLIGHT and (places := self._next(server, work)):
                    with self._times(MESSAGES):
                        batch = [genome_message(work.genomes[i]) for i in places]
                        future = server.call_async(Evaluate.Request(task=message, seed=work.seed, genomes=batch, bars=work.bars_of(places)))
                    largest = max(len(work.genomes[i]) for i in places) ** 2 * work.task.development.max_cells
                    patience = ANSWER_WITHIN + BATCH * IN_FLIGHT * steps * (_SLOW_STEP + _SLOW_PAIR * largest)
                    under_way.append(_Request(places, server, future, time.monotonic() + patience))
            self._executor.spin_once(timeout_sec=_LOOK_EVERY)
            # Whether those that do not answer are still there is asked now and then only: that looks through the whole graph.
            if look := time.monotonic() >= next_look:
                next_look = time.monotonic() + _LOOK_EVERY
            under_way = [
                request for request in under_way
                if not (look or request.future.done()) or not self._take(request, work)
            ]
        return True

    def _next(self, server, work: _Generation) -> list[int]:
        """What a server is to evaluate next: nothing that it has called no genome, while others can say whether that is so."""
        for k, places in enumerate(work.waiting):
            if len(self._servers) == 1 or not any(work.doubted.get(i) is server for i in places):
                del work.waiting[k]
                return places
        return []

    def _take(self, request: _Request, work: _Generation) -> bool:
        """Whether a request is over, its results taken or its genomes back in the queue."""
        server = request.server
        if server not in self._servers:
            work.waiting.appendleft(request.genomes)
        elif request.future.done():
            try:
                self._accept(request, work)
            except AnswerError as error:
                work.waiting.appendleft(request.genomes)
                self._reject(server, str(error), work)
        elif (gone := not server.service_is_ready()) or time.monotonic() > request.deadline:
            self._drop(server, "it is gone" if gone else "it does not answer")
            self._blame(request, work)  # the oldest of its requests, which was under way
        else:
            return False
        request.future.cancel()
        return True

    def _accept(self, request: _Request, work: _Generation) -> None:
        """Take the results of a request.  Raises AnswerError where nothing can rest on them."""
        server = request.server
        with self._times(MESSAGES):
            try:
                evaluations = look_at(request.future.result(), len(request.genomes), work.bars_of(request.genomes))
            except AnswerError:
                raise
            except Exception as error:
                raise AnswerError(f"its answer cannot be read: {told(error)}") from None
        if server not in self._proved:
            self._prove(request.genomes[0], evaluations[0], work)
            self._proved.append(server)
        for i, evaluation in zip(request.genomes, evaluations):
            doubter = work.doubted.get(i)
            if evaluation.status == Status.INVALID_GENOME and doubter is None:
                work.doubted[i] = server
                work.waiting.append([i])
                continue
            if evaluation.status != Status.INVALID_GENOME and doubter is not None and doubter is not server:
                self._reject(doubter, f"it calls a genome invalid that {server.srv_name} evaluates", work)
            work.results[i], work.by[i] = evaluation, server

    def _prove(self, place: int, evaluation: Evaluation, work: _Generation) -> None:
        """Raises AnswerError where our own evaluation of a genome is another one."""
        own = evaluate(work.genomes[place], work.task, work.seed, *work.bars_of([place]))
        if not alike(own, evaluation):
            raise AnswerError(f"it gives a genome a fitness of {evaluation.fitness:.6g} that has {own.fitness:.6g} by our own evaluation")

    def _best_is_right(self, work: _Generation, best: float) -> bool:
        """Whether the best of a generation, if it is better than `best`, is so by our own evaluation too; else who gave it is dropped."""
        found = [(one.fitness, -place, one) for place, one in enumerate(work.results) if one and one.status != Status.STOPPED]
        if not found:
            return True
        fitness, place, evaluation = max(found, key=lambda of: of[:2])  # of equals the first one
        place = -place
        if not fitness > best or place not in work.by:
            return True
        try:
            self._prove(place, evaluation, work)
        except AnswerError as error:
            self._reject(work.by[place], str(error), work)
            return False
        return True

    def _reject(self, server, reason: str, work: _Generation) -> None:
        """Drop a node on which nothing can rest; what it has answered in this generation goes to the others."""
        places = [i for i, by in work.by.items() if by is server]
        for i in places:
            work.results[i] = None
            del work.by[i]
        work.waiting.extend([i] for i in places)
        for i in [i for i, doubter in work.doubted.items() if doubter is server]:
            del work.doubted[i]
        self._drop(server, reason)

    def _blame(self, request: _Request, work: _Generation) -> None:
        """After a node was lost: the genomes that it evaluated go on one by one, last of all; who ends another one counts as failed."""
        for i in request.genomes:
            work.ended[i] += 1
            if work.ended[i] < _MOST_ENDED or len(request.genomes) > 1:
                work.waiting.append([i])
                continue
            cause = f"{work.ended[i]} simulators ended while they evaluated it"
            work.results[i] = invalid(cause)
            self._node.get_logger().warning(f"a genome of {len(work.genomes[i])} elements counts as failed: {cause}")

    def _drop(self, server, reason: str) -> None:
        """Go on without a node, if it is not dropped already."""
        if server not in self._servers:
            return
        self._servers.remove(server)
        if not self._servers:
            raise FleetError(
                f"no simulator is left, the last one was {server.srv_name}: {brief(reason, 160)}: "
                "run again with --simulators 2 to start two"
            )
        self._node.get_logger().warning(brief(f"going on without simulator {server.srv_name}: {reason}"))
