"""Simulator nodes on the ROS graph as workers: those that are there, those that come, and those of our own."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Mapping, Sequence
from concurrent.futures import Future
from copy import copy
from typing import Any

import rclpy
from evodevo_sim.ros.loopback import loopback_alone
from evodevo_sim.ros.messages import genome_message, task_message
from evodevo_sim.ros.own_simulators import OwnSimulators
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.experimental import EventsExecutor

from evodevo_msgs.srv import Evaluate
from evodevo_sim import Task

from ..times import MESSAGES, Times
from .contract import Answer, Backend, Batch, NotEvaluated
from .simulator import LOOK_EVERY, Simulator

SERVICE_TYPE = "evodevo_msgs/srv/Evaluate"
AWAY = 120.0  # s out of reach after which a simulator counts as lost, where nobody can tell whether its process has ended
_LOOK_EVERY = 1.0  # s, on the graph
_GAP = 1.0  # s between two looks
_TURN = 0.01  # s for one of two executors
_AGAIN, _LONGEST = 5.0, 60.0  # s from one new node to the next, doubled each time until nobody is estranged


def find_simulators(node: Any) -> list[str]:
    """The evaluate services on the graph.  Those in hidden namespaces (`/_...`) belong to other runs."""
    services = node.get_service_names_and_types()
    return sorted(name for name, types in services if SERVICE_TYPE in types and "/_" not in name)


class RosBackend(Backend):
    """Evaluates on simulator nodes.

    Args: node, executor: of rclpy, whose owner is the caller; services: names of `evaluate` services; own: simulators of our own, which
        are watched; graph: whether those that come onto the graph are used too; say: is told what people must know; times: told how long
        messages take; away: s, see AWAY.
    """

    def __init__(
        self, node: Any, executor: Any, services: Sequence[str] = (), own: OwnSimulators | None = None, *, graph: bool = False,
        say: Callable[[str], object] | None = None, times: Times | None = None, away: float = AWAY,
    ):
        self._node, self._executor, self._own, self._graph = node, executor, own, graph
        self._other: Participant | None = None  # a node of our own, for those that DDS has lost
        self._next_other, self._pause = 0.0, _AGAIN
        self._say, self._times, self._away = say or node.get_logger().warning, times or Times(), away
        self._group = ReentrantCallbackGroup()
        self._simulators: dict[str, Simulator] = {}
        self._named = list(services)
        self._looked = self._looked_at_all = self._looked_last = 0.0
        self._asking: tuple[Task, Any] | None = None

    @property
    def workers(self) -> Mapping[str, int]:
        self._look()
        return {one.name: one.threads for one in self._simulators.values() if one.usable}

    def _look(self) -> None:
        before, self._looked_last = self._looked_last, time.monotonic()
        if self._looked_last > before + _GAP:  # it is us who stood still: nobody was heard, who spoke
            for one in self._simulators.values():
                one.excuse()
        there = list(self._named)
        if self._own is not None:
            for service in self._own.watch():
                if service in self._simulators:
                    self._simulators[service].end("it has ended")
                    self._simulators.pop(service).close()
            there += self._own.services
        if self._graph and time.monotonic() > self._looked + _LOOK_EVERY:
            self._looked = time.monotonic()
            there += find_simulators(self._node)
        for service in there:
            if service not in self._simulators:
                self._simulators[service] = Simulator(self._node, service, self._group, self._say, self._times, self._away)
        for service, one in list(self._simulators.items()):
            one.look()
            if one.gone and service not in there:
                self._simulators.pop(service).close()
        if self._looked_at_all + LOOK_EVERY < time.monotonic():
            self._looked_at_all = time.monotonic()
            self._reach_the_estranged()

    def _reach_the_estranged(self) -> None:
        """Fast DDS may never find a process again that was stopped soon after its start: a new participant finds it at once."""
        now = time.monotonic()
        estranged = [one for one in self._simulators.values() if one.estranged]
        if not estranged:
            if now > self._next_other + self._pause:
                self._pause = _AGAIN
        elif now > self._next_other:
            before, self._other = self._other, Participant(self._node)
            self._next_other, self._pause = now + self._pause, min(2.0 * self._pause, _LONGEST)
            for one in self._simulators.values():
                if one in estranged or (before and one.node is before.node):
                    one.move(self._other.node)
            if before:
                before.close()

    def submit(self, batch: Batch, worker: str) -> Future[Answer]:
        one = self._of(worker)
        if one is None:
            future: Future[Answer] = Future()
            future.set_exception(NotEvaluated(worker, "it is gone"))
            return future
        with self._times(MESSAGES):
            request = self._request_for(batch.task)
            request.seed, request.bars = batch.seed, list(batch.bars)
            request.genomes = [genome_message(genome) for genome in batch.genomes]
            return one.submit(request)

    def _request_for(self, task: Task) -> Any:
        """A new request.  Of one task after the other the message is made once: it takes as long as those of a hundred genomes."""
        if self._asking is None or self._asking[0] is not task:
            self._asking = task, Evaluate.Request(task=task_message(task))
        return copy(self._asking[1])

    def _of(self, worker: str) -> Simulator | None:
        return next((one for one in self._simulators.values() if one.name == worker), None)

    def drop(self, worker: str, reason: str) -> None:
        one = self._of(worker)
        if one is not None:
            one.drop(reason)
            if self._own is not None:
                self._own.restart(one.service)

    def wait(self, futures: Collection[Future], seconds: float) -> None:
        if any(future.done() for future in futures):
            return
        if self._other is None:
            self._executor.spin_once(timeout_sec=seconds)
            return
        there = sum(one.node is self._other.node for one in self._simulators.values())
        first, second = self._executor, self._other.executor
        if 2 * there > len(self._simulators):
            first, second = second, first
        second.spin_once(timeout_sec=0.0)
        first.spin_once(timeout_sec=seconds if there in (0, len(self._simulators)) else min(seconds, _TURN))

    def hopeless(self) -> str:
        if self._own is not None and not self._graph and not self._named and self._own.spent():
            return "simulators of our own end again and again: simulators.log says why, as does ros2 run evodevo_sim simulator"
        return ""

    def close(self) -> None:
        for one in self._simulators.values():
            one.close()
        self._simulators.clear()
        if self._other:
            self._other.close()
            self._other = None


class Participant:
    """A node in a DDS participant of its own, beside another node."""

    def __init__(self, beside: Any):
        self.context = rclpy.Context()
        with loopback_alone():
            rclpy.init(context=self.context)
        self.node = rclpy.create_node(
            f"{beside.get_name()}_again", namespace=beside.get_namespace(), context=self.context, use_global_arguments=False,
            start_parameter_services=False, enable_rosout=False,
        )
        self.executor = EventsExecutor(context=self.context)
        self.executor.add_node(self.node)

    def close(self) -> None:
        self.node.destroy_node()
        self.executor.shutdown()
        rclpy.try_shutdown(context=self.context)
