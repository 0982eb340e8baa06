"""Simulator nodes as one evaluator: finds them on the graph, and shares a generation's genomes among them."""

from __future__ import annotations

import time
from collections import deque
from dataclasses import dataclass

from evodevo_sim.ros.messages import evaluation_from_message, genome_message, task_message
from rclpy.callback_groups import ReentrantCallbackGroup

from evodevo_msgs.srv import Evaluate
from evodevo_sim import Evaluation, Genome, Task

from .times import MESSAGES, Times

SERVICE_TYPE = "evodevo_msgs/srv/Evaluate"
BATCH = 16  # genomes in a request, at the most
IN_FLIGHT = 2  # requests queued at a node, so that it never waits for us
ANSWER_WITHIN = 120.0  # s for one request, and a hundred times what its steps take; a node that takes longer counts as lost
_SLOW_STEP = 1e-3  # s
_LOOK_EVERY = 0.1  # s, at the silent ones


class FleetError(RuntimeError):
    """No simulator can go on; the message says why and what to do."""


def find_simulators(node) -> list[str]:
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
    server: object
    future: object
    deadline: float


class Fleet:
    """Evaluates genomes on simulator nodes.  The outcome does not depend on who evaluates what, or when.

    Args: node, executor: of the caller, who owns them; services: names of `evaluate` services; times: told how long messages take.
    """

    def __init__(self, node, executor, services: list[str], times: Times | None = None):
        self._times = times or Times()
        group = ReentrantCallbackGroup()
        self._executor = executor
        self._node = node
        self._servers = [node.create_client(Evaluate, name, callback_group=group) for name in services]

    def __len__(self) -> int:
        return len(self._servers)

    def wait(self, seconds: float, alive=lambda: True, stop=lambda: False) -> None:
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

    def evaluate(self, genomes: list[Genome], task: Task, seed: int, stop=lambda: False) -> list[Evaluation] | None:
        """Evaluate genomes in order; None when `stop()` said to stop.

        A node that dies, hangs or refuses is dropped and its genomes go to the others.  Raises FleetError when none is left.
        """
        waiting = deque(batches(len(genomes), len(self._servers)))
        results: list[Evaluation | None] = [None] * len(genomes)
        with self._times(MESSAGES):
            message = task_message(task)
        under_way: list[_Request] = []
        next_look = time.monotonic() + _LOOK_EVERY
        steps = task.development.steps + task.starts * (task.settling_limit + task.control_steps)
        patience = ANSWER_WITHIN + _SLOW_STEP * BATCH * IN_FLIGHT * steps
        while waiting or under_way:
            if stop():
                return None
            for server in self._servers:
                while waiting and sum(request.server is server for request in under_way) < IN_FLIGHT:
                    places = waiting.popleft()
                    with self._times(MESSAGES):
                        batch = [genome_message(genomes[i]) for i in places]
                        future = server.call_async(Evaluate.Request(task=message, seed=seed, genomes=batch))
                    under_way.append(_Request(places, server, future, time.monotonic() + patience))
            self._executor.spin_once(timeout_sec=_LOOK_EVERY)
            # Whether those that do not answer are still there is asked now and then only: that looks through the whole graph.
            if look := time.monotonic() >= next_look:
                next_look = time.monotonic() + _LOOK_EVERY
            under_way = [
                request for request in under_way
                if not (look or request.future.done()) or not self._take(request, results, waiting)
            ]
        return results

    def _take(self, request: _Request, results: list, waiting: deque) -> bool:
        """Whether a request is over, its results taken or its genomes back in the queue."""
        if request.future.done():
            response = request.future.result()
            if not response.error:
                with self._times(MESSAGES):
                    for i, evaluation in zip(request.genomes, response.evaluations, strict=True):
                        results[i] = evaluation_from_message(evaluation)
                return True
            self._drop(request.server, response.error)
        elif not request.server.service_is_ready():
            self._drop(request.server, "it is gone")
        elif time.monotonic() > request.deadline:
            self._drop(request.server, "it does not answer")
        elif request.server in self._servers:
            return False
        request.future.cancel()
        waiting.appendleft(request.genomes)
        return True

    def _drop(self, server, reason: str) -> None:
        """Go on without a node, if it is not dropped already."""
        if server not in self._servers:
            return
        self._servers.remove(server)
        if not self._servers:
            raise FleetError(f"no simulator is left, the last one was {server.srv_name}: {reason}: run again with --simulators 2 to start two")
        self._node.get_logger().warning(f"going on without simulator {server.srv_name}: {reason}")
