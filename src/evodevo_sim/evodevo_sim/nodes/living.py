"""What every node that lets an animat live offers: load, pause, reset, the target; body, cells and actuation.

A simulator's animat drives a simulated body, a driver's one that is there: both have this.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from std_srvs.srv import SetBool, Trigger

from evodevo_msgs.srv import Load

from ..genetics.genome import GenomeError
from ..inputs import shown
from ..live.animat import Animat, NotViable, Stage, check_pace
from ..parameters import ParameterError
from ..ros.barrier import Callbacks, Desk, brief
from ..ros.messages import actuation_message, body_message, cell_states_message, genome_from_message, task_of_request
from ..ros.node_parameters import fixed, seconds
from ..ros.requests import ENDING
from ..ros.topics import ACTUATION, BODY, CELL_STATES, TARGET_POSE
from .drawn import DrawnTopics
from .limits import Limits


@dataclass(frozen=True)
class Manner:
    """How a node shows its animat and hears of targets.

    Attributes: frame: of positions and targets; every: control steps between cell states; oldest: s, of the oldest target that counts.
    """

    frame: str
    every: int
    oldest: float

    @classmethod
    def declared(cls, node: Any) -> Manner:
        """The parameters of a node of rclpy, set at its start only.  Raises ParameterError."""
        frame = node.declare_parameter("frame_id", "world", fixed("frame of positions and targets")).value
        if not frame:
            raise ParameterError("frame_id is empty: give the name of a frame, e.g. world")
        every = node.declare_parameter("publish_every", 1, fixed("control steps between cell states", 1, 100_000)).value
        return cls(frame, every, seconds(node, "target_age", 1.0, "s, of the oldest target that counts"))


class Living:
    """The live animat of a node.

    Args: node: it; callbacks: of the node; desk: where births wait; manner; limits: of what is asked; ending: whether the node ends;
    make: makes the animat of a genome, a task and a seed.
    """

    def __init__(
        self, node: Any, callbacks: Callbacks, desk: Desk, manner: Manner, limits: Limits, ending: Callable[[], bool],
        make: Callable[..., Animat] = Animat,
    ):
        self._node, self._callbacks, self._limits, self._ending, self._make = node, callbacks, limits, ending, make
        self._frame, self._oldest = manner.frame, manner.oldest
        self._newest = 0  # ns, stamp of the last target
        self._body = node.create_publisher(BODY.type, BODY.name, BODY.quality)
        self._states = node.create_publisher(CELL_STATES.type, CELL_STATES.name, CELL_STATES.quality)
        self._actuation = node.create_publisher(ACTUATION.type, ACTUATION.name, ACTUATION.quality)
        self._drawn = DrawnTopics(node, manner.frame)
        self._shown: Animat | None = None
        self.stage = Stage(self.show, self._report, manner.every, self.act)
        callbacks.subscription(TARGET_POSE.type, TARGET_POSE.name, self._aim, TARGET_POSE.quality)
        callbacks.service(Load, "load", self._load, desk)
        callbacks.service(SetBool, "pause", self._pause)
        callbacks.service(Trigger, "reset", self._reset)

    def close(self) -> None:
        self.stage.close()

    def _load(self, request, response):
        if self._ending():
            response.message = ENDING
            return response
        if why := self._limits.refuse_life(request.genome, request.task):
            response.message = why
            return response
        try:
            check_pace(request.real_time_factor)
            animat = self._make(genome_from_message(request.genome), task_of_request(request.task), request.seed)
            replaced = self.stage.load(animat, request.real_time_factor)
        except (GenomeError, ParameterError, NotViable) as error:
            response.message = brief(error)
            return response
        instead = ", instead of the one before" if replaced else ""
        response.success, response.message = True, f"an animat of {len(animat.position)} cells lives{instead}"
        return response

    def _pause(self, request, response):
        response.success = self.stage.pause(request.data)
        response.message = ("paused" if request.data else "goes on") if response.success else _NOBODY
        return response

    def _reset(self, _, response):
        response.success = self.stage.reset()
        held = ", paused: let it go on by pause with data false" if self.stage.paused else ""
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
            self.stage.aim((point.x, point.y))

    def _stamp_and_age(self, stamp) -> tuple[int, float | None]:
        """(ns, s ago) of a target; a stamp of 0 is none, and of any age.  The age is None where simulated time has not begun."""
        nanoseconds = stamp.sec * 10**9 + stamp.nanosec  # of a negative stamp, which the type allows, rclpy makes no time
        if not nanoseconds:
            return 0, 0.0
        now = self._node.get_clock().now().nanoseconds
        if not now:
            return nanoseconds, None
        if self._newest > now + self._oldest * 1e9:  # simulated time began anew
            self._newest = 0
        return nanoseconds, (now - nanoseconds) * 1e-9

    def _warn(self, kind, text):
        self._callbacks.warn(kind, text)

    def show(self, animat: Animat) -> None:
        """In the thread in which it lives: publish what somebody listens to."""
        if animat is not self._shown:
            self._shown = None
            self._body.publish(body_message(animat.body, self._frame, animat.time))
            self._shown = animat
        if self._states.get_subscription_count():
            self._states.publish(
                cell_states_message(animat.position, animat.velocity, animat.activation, animat.steps, animat.time, self._frame)
            )
        self._drawn.show(animat)

    def act(self, animat: Animat) -> None:
        """Likewise, after each control step: publish what the muscles were told in it."""
        if self._actuation.get_subscription_count():
            self._actuation.publish(actuation_message(animat.activation, animat.steps, animat.time, self._frame))

    def _report(self, cause):
        self._shown = None
        self._node.get_logger().error(brief(f"the live animat ended: {cause}: load another one"))


_NOBODY = "no animat lives: load one first"
