"""`ros2 run evodevo_sim simulator`: evaluates batches of genomes, and runs one animat live as a hardware driver would."""

from __future__ import annotations

import math
import sys
import time

from geometry_msgs.msg import PoseStamped
from rcl_interfaces.msg import IntegerRange, ParameterDescriptor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy, qos_profile_sensor_data
from rclpy.time import Time
from std_srvs.srv import SetBool, Trigger

from evodevo_msgs.msg import Body, CellStates
from evodevo_msgs.srv import Evaluate, Load

from ..genetics.genome import Genome, GenomeError
from ..live.animat import Animat, NotViable, Stage
from ..parameters import TASKS, ParameterError, default_task
from ..ros.messages import (
    body_message,
    cell_states_message,
    evaluation_message,
    genome_from_message,
    task_from_message,
)
from ..tasks.evaluation import evaluate, invalid, prepare
from ..tasks.outcome import Evaluation

LATCHED = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL)
NEWEST = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE)
_WARN_EVERY = 1.0  # s between warnings of one kind


class Simulator(Node):
    """The node.  Services are answered one after the other; the live animat goes on meanwhile in a thread of its own.

    Args: stop: an Event; set, a batch ends early.
    """

    def __init__(self, stop):
        super().__init__("simulator")
        self._stop = stop
        self._frame = self.declare_parameter("frame_id", "world", _fixed("frame of positions and targets")).value
        self._most = self.declare_parameter("max_batch", 1000, _fixed("genomes in one request, at the most", 1, 10_000)).value
        every = self.declare_parameter("publish_every", 1, _fixed("control steps between cell states", 1, 100_000)).value
        first = self.declare_parameter("task", TASKS[0], _fixed("task whose first request does not wait")).value
        prepare(default_task(first), self.get_logger().info)
        self._oldest = self.declare_parameter("target_age", 1.0, _fixed("s, of the oldest target that counts")).value
        self._newest = 0  # ns, stamp of the last target
        self._warned: dict[str, float] = {}

        self._body = self.create_publisher(Body, "body", LATCHED)
        self._states = self.create_publisher(CellStates, "cell_states", qos_profile_sensor_data)
        self._shown = None
        self._stage = Stage(self._show, self._report, every)
        self.create_subscription(PoseStamped, "target_pose", self._aim, NEWEST)
        self.create_service(Evaluate, "evaluate", self._evaluate)
        self.create_service(Load, "load", self._load)
        self.create_service(SetBool, "pause", self._pause)
        self.create_service(Trigger, "reset", self._reset)
        self.get_logger().info("ready")

    def close(self):
        self._stage.close()
        self.destroy_node()

    # --- evaluation ------------------------------------------------------------------------------------------------------

    def _evaluate(self, request, response):
        if not 0 < len(request.genomes) <= self._most:
            response.error = f"{len(request.genomes)} genomes in a request: give 1 to {self._most}"
            return response
        try:
            task = task_from_message(request.task)
        except ParameterError as error:
            response.error = str(error)
            return response
        # Messages before and after all evaluations: one by one between them, where caches hold a body, they cost a generation 1.7 % more.
        genomes, evaluations = [_genome_or_fault(message) for message in request.genomes], []
        for genome in genomes:
            if self._stop.is_set():
                response.error = "the simulator is ending: ask another one"
                return response
            evaluations.append(genome if isinstance(genome, Evaluation) else evaluate(genome, task, request.seed))
        response.evaluations = [evaluation_message(evaluation) for evaluation in evaluations]
        return response

    # --- the live animat -------------------------------------------------------------------------------------------------

    def _load(self, request, response):
        try:
            animat = Animat(genome_from_message(request.genome), task_from_message(request.task), request.seed)
            replaced = self._stage.load(animat, request.real_time_factor)
        except (GenomeError, ParameterError, NotViable) as error:
            response.message = str(error)
            return response
        instead = ", instead of the one before" if replaced else ""
        response.success, response.message = True, f"an animat of {len(animat.position)} cells lives{instead}"
        return response

    def _pause(self, request, response):
        response.success = self._stage.pause(request.data)
        response.message = ("paused" if request.data else "goes on") if response.success else _NOBODY
        return response

    def _reset(self, _, response):
        response.success = self._stage.reset()
        response.message = "back to birth" if response.success else _NOBODY
        return response

    def _aim(self, message):
        point, stamp = message.pose.position, Time.from_msg(message.header.stamp).nanoseconds
        age = (self.get_clock().now().nanoseconds - stamp) * 1e-9 if stamp else 0.0  # a stamp of 0 is none
        if message.header.frame_id != self._frame:
            self._warn("frame", f"target in frame {message.header.frame_id!r} ignored: give it in {self._frame!r}")
        elif not (math.isfinite(point.x) and math.isfinite(point.y)):
            self._warn("number", f"target at ({point.x}, {point.y}) ignored: give finite metres")
        elif age > self._oldest:
            self._warn("past", f"target of {age:.3g} s ago ignored: stamp it with the time at which it is sent, or with 0")
        elif age < -self._oldest:
            self._warn("future", f"target of {-age:.3g} s in the future ignored: stamp it with the time at which it is sent, or with 0")
        elif stamp and stamp < self._newest:
            self._warn("order", f"target older than the last one by {(self._newest - stamp) * 1e-9:.3g} s ignored: send targets in order")
        else:
            self._newest = max(self._newest, stamp)
            self._stage.aim((point.x, point.y))

    def _warn(self, kind, text):
        now = time.monotonic()
        if now >= self._warned.get(kind, -math.inf) + _WARN_EVERY:
            self._warned[kind] = now
            self.get_logger().warning(text)

    def _show(self, animat):
        """In the stage's thread: publish what somebody listens to."""
        if animat is not self._shown:
            self._shown = animat
            self._body.publish(body_message(animat.body, self._frame, animat.time))
        if self._states.get_subscription_count():
            self._states.publish(
                cell_states_message(animat.position, animat.velocity, animat.activation, animat.steps, animat.time, self._frame)
            )

    def _report(self, cause):
        self.get_logger().error(f"the live animat ended: {cause}: load another one")


_NOBODY = "no animat lives: load one first"


def _genome_or_fault(message) -> Genome | Evaluation:
    """The genome of a message, or the evaluation that a malformed one gets."""
    try:
        return genome_from_message(message)
    except GenomeError as error:
        return invalid(str(error))


def _fixed(meaning: str, low: int | None = None, high: int | None = None) -> ParameterDescriptor:
    """The descriptor of a parameter that is set at the start only."""
    limits = [] if low is None else [IntegerRange(from_value=low, to_value=high, step=1)]
    return ParameterDescriptor(description=meaning, read_only=True, integer_range=limits)


if __name__ == "__main__":
    from ..commands.entry import simulator as entry

    sys.exit(entry())
