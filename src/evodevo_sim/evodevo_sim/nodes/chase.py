"""An animat on a simulator node, and targets for it to follow."""

from __future__ import annotations

import argparse
import threading
import time
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np
import rclpy
from rclpy.experimental import EventsExecutor
from rclpy.task import Future
from tqdm import tqdm

from evodevo_msgs.srv import Load

from ..command_process import exit_code, heeded
from ..live.targets import Drawn, Random, load_points
from ..parameters import ParameterError
from ..recording import RecordingError, is_recording, read_recording
from ..recording.champion import Champion, champion_of
from ..recording.guarded import GuardedRecorder
from ..ros.barrier import Callbacks, brief
from ..ros.command_line import see_it, settings_of, warn
from ..ros.environment import started
from ..ros.messages import genome_message, target_message, task_message
from ..ros.own_simulators import OwnSimulators
from ..ros.process import stay_on_this_host
from ..ros.topics import ACTUATION, BODY, CELL_STATES, EVENTS, TARGET_POSE, Topic
from ..view.files import OutputError

_START = 90.0  # s for a simulator of our own to start; it may have to compile
_ANSWER = 10.0  # s for a simulator of the graph to answer
_SILENCE = 10.0  # s without cell states after which a simulator counts as lost
_LATE = 2.0  # s after a birth within which states of another animat may still come


class ChaseError(RuntimeError):
    """The chase cannot go on; the message says why."""


def chase(given: argparse.Namespace, arguments: list[str]) -> int:
    """Chase as the command line says.

    Args: given: what `chase_command` parsed; arguments: those of ROS among them.  Returns: the exit code.
    Raises ChaseError; where the input is bad EnvironmentFault, GenomeError, OutputError, ParameterError or RecordingError.
    """
    stay_on_this_host()
    champion = champion_of(given.source, settings_of(given, "chemotaxis", warn("chase")), "chemotaxis", warn("chase"))
    if not champion.task.has_target:
        made = f"{given.source} was evolved for {champion.task.name}"
        raise ParameterError(f"{made}, without targets: give its champion.yaml, or another run")
    targets = _targets(given)
    stop = threading.Event()  # looked at between messages: an exception could come in the middle of a write
    with ExitStack() as stack:
        view = _viewer(given, stack, champion)
        recorder = stack.enter_context(GuardedRecorder(given.out)) if given.out else None
        stack.enter_context(heeded(lambda _: stop.set()))
        stack.enter_context(started("chase", arguments))
        return Chase(given, champion, targets, recorder, view, stop).run(stack)


def _targets(given):
    if given.targets == "random":
        return Random(given.seed, *given.distance)
    path = Path(given.targets)
    if is_recording(path):
        recording = read_recording(path)
        for line in recording.notes:
            warn("chase")(line)
        poses = recording.targets
        points = [(pose.pose.position.x, pose.pose.position.y) for pose in poses]
        if not points or not np.isfinite(points).all():
            raise RecordingError(f"{path} holds no targets, or one that is not finite: give a recording of chase")
        return Drawn(points)
    return Drawn(load_points(path))


def _viewer(given, stack, champion: Champion):
    if not (given.view or given.save):
        return None
    from ..view.live_view import LiveView

    return stack.enter_context(LiveView(champion.name, given.save, given.view, champion.task.chemotaxis.scent_reach, given.palette))


class Chase:
    """One chase: the node, its animat and its targets.

    Attributes: sent, captured: numbers of targets; closest: m, the least distance to each; states: how many came.
    """

    def __init__(self, given: argparse.Namespace, champion: Champion, targets: Any, recorder: Any, view: Any, stop: threading.Event):
        self.given, self.champion, self.targets, self.recorder, self.view = given, champion, targets, recorder, view
        self.stop = stop
        self.sent = self.captured = self.states = 0
        self.most = given.count or (10 if given.targets == "random" else None)
        self.closest: list[float] = []
        self.target: np.ndarray | None = None
        self.ended = False
        self._answer: Future | None = None
        self._lives = False
        self._others: dict[type, int] = {}  # the last step of another animat, by the type of message that told it
        self._born_by = 0.0  # s, of the clock, from which on whatever comes is ours
        self._since, self._step = 0.0, -1
        self._bar: Any = None  # of tqdm

    def run(self, stack: ExitStack) -> int:
        node = rclpy.create_node("chase")
        stack.callback(node.destroy_node)
        executor = EventsExecutor()
        executor.add_node(node)
        own = None if self.given.simulator else stack.enter_context(OwnSimulators(1, owner="chase", task="chemotaxis"))
        namespace = (own.namespaces[0] if own else "/" + self.given.simulator.strip("/")).rstrip("/")
        self._publisher = node.create_publisher(TARGET_POSE.type, TARGET_POSE.at(namespace), TARGET_POSE.quality)
        self._node = node
        loader = node.create_client(Load, f"{namespace}/load")
        self._wait(executor, loader.service_is_ready, own, f"no simulator answers at {namespace}: start one, or leave --simulator out")
        callbacks = Callbacks(node, through=(OSError, RecordingError, OutputError))
        callbacks.subscription(BODY.type, BODY.at(namespace), self._embody, BODY.quality)
        callbacks.subscription(CELL_STATES.type, CELL_STATES.at(namespace), self._follow, CELL_STATES.quality)
        if self.recorder:  # a simulator makes these messages only where somebody listens
            callbacks.subscription(ACTUATION.type, ACTUATION.at(namespace), self._actuate, EVENTS.profile())  # each is kept
        self._wait(
            executor, lambda: self._publisher.get_subscription_count() and node.count_publishers(CELL_STATES.at(namespace)), own,
            f"{namespace} is no simulator",
        )
        c = self.champion
        request = Load.Request(
            task=task_message(c.task), seed=c.seed, genome=genome_message(c.genome), real_time_factor=self.given.real_time_factor
        )
        with tqdm(total=self.most, unit="target", disable=self.given.quiet, leave=False) as self._bar:
            self._answer = answer = loader.call_async(request)
            self._wait(executor, answer.done, own, "the simulator does not answer")
            if answer.done() and not answer.result().success:
                raise ParameterError(brief(f"{self.given.source}: {answer.result().message}"))
            heard, last = -1, time.monotonic()
            while not (self.ended or self.stop.is_set()):
                executor.spin_once(timeout_sec=0.1)
                if self.states != heard:
                    heard, last = self.states, time.monotonic()
                elif time.monotonic() - last > _SILENCE or (own and not own.alive()):
                    raise ChaseError(f"the simulator fell silent after {self.states} cell states, its animat failed or it ended")
        self._report()
        return exit_code()

    def _wait(self, executor, ready, own, otherwise: str) -> None:
        deadline = time.monotonic() + (_START if own else _ANSWER)
        while not ready() and not self.stop.is_set():
            executor.spin_once(timeout_sec=0.05)
            if own and not own.alive():
                raise ChaseError("the simulator ended at once: run `ros2 run evodevo_sim simulator` to see why")
            if time.monotonic() > deadline:
                raise ParameterError(otherwise)

    def _embody(self, message) -> None:
        self._write(BODY, message)
        if self.view:
            self.view.embody(message)

    def _follow(self, message) -> None:
        """One control step's cells: captured? the next target?"""
        if self.ended or not self._is_ours(message) or not len(message.position_x) or message.step <= self._step:
            return
        position = np.column_stack((message.position_x, message.position_y))
        if not np.isfinite(position).all():
            raise ValueError("a cell's position is not finite")
        self.states, self._step = self.states + 1, message.step
        centre, now = position.mean(axis=0), message.step * self.champion.task.control_step
        if self.target is not None:
            distance = float(np.hypot(*(centre - self.target)))
            self.closest[-1] = min(self.closest[-1], distance)
            captured = distance <= self.given.capture
            self.captured += captured
            if captured or now - self._since >= self.given.each:
                self.target = None
                self._bar.update()
        if self.target is None:
            self._aim(centre, now)
        self._write(CELL_STATES, message)
        if self.view:
            self.view.show(now, position, np.asarray(message.activation), self.target, self.captured)

    def _actuate(self, message) -> None:
        if self._is_ours(message) and not self.ended:
            self._write(ACTUATION, message)

    def _is_ours(self, message) -> bool:
        """Whether it is of our animat: another one may live on the simulator until ours is born, at step 0."""
        if self._lives or self._answer is None:
            return self._lives
        before = self._others.get(type(message))
        if self._answer.done() and not self._born_by:
            self._born_by = time.monotonic() + _LATE
        # What was on its way when ours was born has a later step than the other one's last; ours begins anew.
        began = self._answer.done() and (before is None or message.step < before or time.monotonic() > self._born_by)
        self._lives = message.step == 0 or began
        self._others[type(message)] = message.step
        return self._lives

    def _aim(self, centre, now: float) -> None:
        target = None if self.sent == self.most else self.targets.following(centre)
        if target is None:
            self.ended = True
            return
        self.target, self._since, self.sent = target, now, self.sent + 1
        self.closest.append(float(np.hypot(*(centre - target))))
        message = target_message(target, self._node.get_clock().now().to_msg())
        self._publisher.publish(message)
        self._write(TARGET_POSE, message)
        self._bar.set_postfix_str(f"{self.captured} captured", refresh=False)

    def _write(self, topic: Topic, message) -> None:
        if self.recorder:
            self.recorder.write(topic.name, message, time.time_ns())

    def _report(self) -> None:
        if not self.sent:
            print(f"{self.champion.name}: stopped before the first target{', and nothing was recorded' if self.given.out else ''}.")
            return
        print(
            f"{self.champion.name}: {self.captured} of {self.sent} targets captured within {self.given.capture:g} m, "
            f"closest {np.mean(self.closest):.2f} m in the mean, in {self._step * self.champion.task.control_step:.1f} s."
        )
        if self.given.out:
            print(see_it(self.given.out))
