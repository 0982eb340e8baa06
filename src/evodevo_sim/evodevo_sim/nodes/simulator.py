"""`ros2 run evodevo_sim simulator`: evaluates batches of genomes, and runs one animat live as a hardware driver would."""

from __future__ import annotations

import math
from typing import Any

from rcl_interfaces.msg import IntegerRange, ParameterDescriptor
from rclpy.node import Node
from std_srvs.srv import SetBool, Trigger

from evodevo_msgs.srv import Load

from ..genetics.genome import GenomeError
from ..inputs import shown
from ..live.animat import Animat, NotViable, Stage, check_pace
from ..parameters import ParameterError, default_task
from ..ros.barrier import Callbacks, Desk, brief
from ..ros.host import cores
from ..ros.messages import actuation_message, body_message, cell_states_message, genome_from_message, task_of_request
from ..ros.requests import ENDING
from ..ros.topics import ACTUATION, BODY, CELL_STATES, TARGET_POSE
from ..task_kinds import names
from ..tasks.evaluation import prepare
from .evaluations import Evaluations
from .limits import Limits


class Simulator(Node):
    """The node.  Evaluations are answered in threads of their own (see `Evaluations`), births of live animats in another, and the
    live animat goes on meanwhile in one more; so what controls it waits for none of them.

    Args: stop: an Event; set, a batch ends early.
    """

    def __init__(self, stop: Any):
        super().__init__("simulator")
        self._stop = stop
        self._frame = self.declare_parameter("frame_id", "world", _fixed("frame of positions and targets")).value
        if not self._frame:
            raise ParameterError("frame_id is empty: give the name of a frame, e.g. world")
        self._limits = Limits.declared(self)
        threads = self.declare_parameter("threads", 1, _fixed("requests evaluated at once; 0: one a core", 0, 1024)).value
        every = self.declare_parameter("publish_every", 1, _fixed("control steps between cell states", 1, 100_000)).value
        first = self.declare_parameter("task", names()[0], _fixed("task whose first request does not wait")).value
        self._oldest = _seconds(self, "target_age", 1.0, "s, of the oldest target that counts")
        prepare(default_task(first), self.get_logger().info)
        self._newest = 0  # ns, stamp of the last target
        self._callbacks = Callbacks(self)
        self._evaluations, self._births = Evaluations(self, self._callbacks, threads or cores(), self._limits, stop.is_set), Desk("births")

        self._body = self.create_publisher(BODY.type, BODY.name, BODY.quality)
        self._states = self.create_publisher(CELL_STATES.type, CELL_STATES.name, CELL_STATES.quality)
        self._actuation = self.create_publisher(ACTUATION.type, ACTUATION.name, ACTUATION.quality)
        self._shown = None
        self._stage = Stage(self._show, self._report, every, self._act)
        self._callbacks.subscription(TARGET_POSE.type, TARGET_POSE.name, self._aim, TARGET_POSE.quality)
        self._callbacks.service(Load, "load", self._load, self._births)
        self._callbacks.service(SetBool, "pause", self._pause)
        self._callbacks.service(Trigger, "reset", self._reset)
        self.get_logger().info("ready")

    def close(self) -> None:
        self._evaluations.close()
        self._births.close()
        self._stage.close()
        self.destroy_node()

    # --- the live animat -------------------------------------------------------------------------------------------------

    def _load(self, request, response):
        if self._stop.is_set():
            response.message = ENDING
            return response
        if why := self._limits.refuse_life(request.genome, request.task):
            response.message = why
            return response
        try:
            check_pace(request.real_time_factor)
            animat = Animat(genome_from_message(request.genome), task_of_request(request.task), request.seed)
            replaced = self._stage.load(animat, request.real_time_factor)
        except (GenomeError, ParameterError, NotViable) as error:
            response.message = brief(error)
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
        held = ", paused: let it go on by pause with data false" if self._stage.paused else ""
        response.message = f"back to birth{held}" if response.success else _NOBODY
        return response

    def _aim(self, message):
        point, (stamp, age) = message.pose.position, self._stamp_and_age(message.header.stamp)
        if message.header.frame_id != self._frame:
            given = shown(message.header.frame_id)
            self._warn("frame", f"target in frame {given} ignored: give it in {self._frame!r}")
        elif not (math.isfinite(point.x) and math.isfinite(point.y)):
            self._warn("number", f"target at ({point.x}, {point.y}) ignored: give finite metres")
        elif stamp < 0:
            self._warn(
                "negative", f"target with a stamp of {stamp * 1e-9:.9g} s ignored: stamp it with the time at which it is sent, or with 0"
            )
        elif age is None:
            self._warn(
                "clock",
                "target with a stamp ignored: use_sim_time is set, and no /clock has come yet: publish one, or stamp targets with 0",
            )
        elif age > self._oldest:
            self._warn("past", f"target of {age:.3g} s ago ignored: stamp it with the time at which it is sent, or with 0")
        elif age < -self._oldest:
            self._warn("future", f"target of {-age:.3g} s in the future ignored: stamp it with the time at which it is sent, or with 0")
        elif stamp and stamp < self._newest:
            self._warn("order", f"target older than the last one by {(self._newest - stamp) * 1e-9:.3g} s ignored: send targets in order")
        else:
            self._newest = max(self._newest, stamp)
            self._stage.aim((point.x, point.y))

    def _stamp_and_age(self, stamp) -> tuple[int, float | None]:
        """(ns, s ago) of a target; a stamp of 0 is none, and of any age.  The age is None where simulated time has not begun."""
        nanoseconds = stamp.sec * 10**9 + stamp.nanosec  # of a negative stamp, which the type allows, rclpy makes no time
        if not nanoseconds:
            return 0, 0.0
        now = self.get_clock().now().nanoseconds
        if not now:
            return nanoseconds, None
        if self._newest > now + self._oldest * 1e9:  # simulated time began anew
            self._newest = 0
        return nanoseconds, (now - nanoseconds) * 1e-9

    def _warn(self, kind, text):
        self._callbacks.warn(kind, text)

    def _show(self, animat):
        """In the stage's thread: publish what somebody listens to."""
        if animat is not self._shown:
            self._shown = None
            self._body.publish(body_message(animat.body, self._frame, animat.time))
            self._shown = animat
        if self._states.get_subscription_count():
            self._states.publish(
                cell_states_message(animat.position, animat.velocity, animat.activation, animat.steps, animat.time, self._frame)
            )

    def _act(self, animat):
        """In the stage's thread, after each control step: publish what the muscles were told in it, if somebody listens."""
        if self._actuation.get_subscription_count():
            self._actuation.publish(actuation_message(animat.activation, animat.steps, animat.time, self._frame))

    def _report(self, cause):
        self._shown = None
        self.get_logger().error(brief(f"the live animat ended: {cause}: load another one"))


_NOBODY = "no animat lives: load one first"


def _fixed(meaning: str, low: int | None = None, high: int | None = None) -> ParameterDescriptor:
    """The descriptor of a parameter that is set at the start only."""
    limits = [] if low is None else [IntegerRange(from_value=low, to_value=high, step=1)]
    return ParameterDescriptor(description=meaning, read_only=True, integer_range=limits)


def _seconds(node, name: str, default: float, meaning: str) -> float:
    """A parameter in seconds, whole numbers too, set at the start only.  Raises ParameterError unless it is 0 to 1e9."""
    descriptor = ParameterDescriptor(description=meaning, read_only=True, dynamic_typing=True)
    value = node.declare_parameter(name, default, descriptor).value
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0.0 <= value <= 1e9:  # a range of ROS's lets NaN pass
        raise ParameterError(f"{name} is {brief(repr(value), 60)}: give seconds from 0 to 1e9")
    return float(value)
