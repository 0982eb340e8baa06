"""`ros2 run evodevo_sim driver`: a body of rubber and air in the place of the simulator's, behind the same topics and services."""

from __future__ import annotations

from typing import Any

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from std_srvs.srv import Trigger

from evodevo_msgs.msg import Channels

from ..genetics.genome import Genome
from ..hardware.calibration import Calibration
from ..hardware.serial_body import Health, SerialBody
from ..hardware.serial_line import LineError
from ..hardware.trial import TrialError, check_task, living, trial
from ..live.animat import Animat
from ..parameters import ParameterError, Task
from ..ros.barrier import Callbacks, Desk, brief
from ..ros.node_parameters import fixed
from ..ros.requests import BROKEN, UNREADY
from ..ros.topics import CHANNELS, COMMAND_STREAM
from ..tasks.halt import raise_if_halted
from ..tasks.outcome import Evaluation
from .evaluations import Evaluations
from .joints import Joints
from .limits import Limits
from .living import Living, Manner

_DIAGNOSE_EVERY = 1.0  # s
_CODE = "hardware"  # what evaluates is no code
_LEVEL = {
    Health.FINE: DiagnosticStatus.OK, Health.VENTED: DiagnosticStatus.WARN, Health.STALE: DiagnosticStatus.WARN,
    Health.SILENT: DiagnosticStatus.STALE, Health.UNPLUGGED: DiagnosticStatus.ERROR, Health.FOREIGN: DiagnosticStatus.ERROR,
    Health.STOPPED: DiagnosticStatus.ERROR,
}


class Driver(LifecycleNode):
    """The node, managed: `configure` opens the line and asks who is there, `activate` lets commands through, `deactivate` vents,
    `cleanup` leaves the line.

    Args: stop: an Event; set, a trial ends early; port, baud: of the line; calibration.
    """

    def __init__(self, stop: Any, port: str, baud: int, calibration: Calibration):
        super().__init__("driver")
        self._stop, self._port, self._baud, self._calibration = stop, port, baud, calibration
        manner = Manner.declared(self)
        limits = Limits.declared(self)
        joints = self.declare_parameter("joints", False, fixed("whether commands and states go as JointState too")).value
        commands, states = (
            self.declare_parameter(f"joint_{what}_topic", f"joint_{what}", fixed(f"of JointState {what}, with joints")).value
            for what in ("commands", "states")
        )
        self._frame = manner.frame
        self.hardware: SerialBody | None = None
        self._active = False
        self._barrier = Callbacks(self)
        self._births = Desk("births")
        self._evaluations = Evaluations(self, self._barrier, 1, limits, stop.is_set, self._trial, _CODE)
        self._diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self._channels = self.create_publisher(CHANNELS.type, CHANNELS.name, CHANNELS.quality)
        self._living = Living(self, self._barrier, self._births, manner, limits, stop.is_set, self._make)
        self._barrier.service(Trigger, "stop", self._emergency)
        self._barrier.service(Trigger, "arm", self._arm)
        self._barrier.subscription(COMMAND_STREAM.type, COMMAND_STREAM.name, self._stream, COMMAND_STREAM.quality)
        self._joints = Joints(self, self._barrier, calibration, commands, states, self._move) if joints else None
        self.create_timer(_DIAGNOSE_EVERY, self._diagnose)
        self.create_timer(calibration.command_within / 4, self._keep)
        self._trying = False

    # --- lifecycle -------------------------------------------------------------------------------------------------------

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        try:
            self.open()
        except LineError as error:
            self.get_logger().error(brief(error))
            return TransitionCallbackReturn.FAILURE
        return super().on_configure(state)

    def open(self) -> None:
        """Open the line and tell its channels.  Raises LineError; nothing has moved then."""
        if self.hardware is None:
            seen = self._joints.show if self._joints else lambda sight: None
            self.hardware = SerialBody(self._port, self._calibration, self._baud, self._report, seen)
        c = self._calibration
        message = Channels(name=c.name, channel=c.channel.tolist(), marker=c.marker.tolist())
        message.x, message.y = (values.tolist() for values in c.position.T)
        for name in ("vent", "rest", "span", "least", "most", "rate"):
            setattr(message, name, getattr(c, name).tolist())
        message.header.frame_id = self._frame
        self._channels.publish(message)

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        self._active = True
        self.get_logger().info("ready")
        return super().on_activate(state)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        self._active = False
        self._living.stage.unload()
        if self.hardware is not None:
            self.hardware.release()
        return super().on_deactivate(state)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        self._leave()
        return super().on_cleanup(state)

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        self._leave()
        return super().on_shutdown(state)

    def _leave(self) -> None:
        self._active = False
        self._living.stage.unload()
        if self.hardware is not None:
            self.hardware.close()
            self.hardware = None

    def close(self) -> None:
        self._active = False
        self._evaluations.close()
        self._births.close()
        self._living.close()
        if self.hardware is not None:
            self.hardware.close()
        self.destroy_node()

    # --- what is asked of the body ---------------------------------------------------------------------------------------

    def _ready(self) -> SerialBody:
        if self.hardware is None or not self._active:
            raise ParameterError(f"{UNREADY}: the driver is not active: configure and activate it first")
        return self.hardware

    def _make(self, genome, task, seed) -> Animat:
        if self._trying:
            raise ParameterError("an evaluation is under way on the body: wait for its answer")
        return living(genome, task, seed, self._ready())

    def _trial(self, genome: Genome, task: Task, seed: int, bar: float) -> Evaluation:
        """Evaluate a genome on the body, which takes as long as its life; nobody else lives there meanwhile."""
        check_task(task)
        body = self._ready()
        self._trying = True
        self._living.stage.unload()
        try:
            return trial(genome, task, seed, body, self._is_to_end, self._seen)
        except TrialError as error:
            raise ParameterError(f"{BROKEN if error.moved else UNREADY}: {error}") from None
        finally:
            self._trying = False
            body.release()

    def _is_to_end(self) -> bool:
        """Whether a trial is.  Raises Halted where nobody waits for it any more."""
        raise_if_halted()
        return self._stop.is_set() or not self._active

    def _seen(self, animat: Animat) -> None:
        """Publish a control step of a trial, for whoever listens."""
        self._living.show(animat)
        if animat.steps:
            self._living.act(animat)

    def _stream(self, message) -> None:
        """A command of somebody else's brain."""
        if len(message.activation) != self._calibration.cells:
            given = len(message.activation)
            self._barrier.warn("length", f"a command for {given} cells ignored: the body has {self._calibration.cells}")
            return
        asked = np.array(message.activation)
        if not np.isfinite(asked).all():
            self._barrier.warn("finite", "a command with a number that is not finite ignored: give -1 to 1")
            return
        self._move(asked)

    def _move(self, asked: np.ndarray) -> None:
        """Go to an activation (N,) that somebody else's brain asks for, where none of ours lives."""
        if self._living.stage.lives or self._trying:
            self._barrier.warn("stream", "a command ignored: an animat lives on the body: stop ends it, and arm lets commands through")
            return
        self._ready().command(np.clip(asked, -1.0, 1.0))

    def _keep(self) -> None:
        """An animat that is paused keeps its shape."""
        if self.hardware is not None and self._living.stage.paused:
            self.hardware.hold()

    def _emergency(self, _, response):
        if self.hardware is not None:
            self.hardware.stop()
        self._living.stage.unload()
        response.success = self.hardware is not None
        response.message = "stopped and vented: arm lets it move again" if response.success else "the driver is not configured"
        return response

    def _arm(self, _, response):
        self._ready().rearm()
        response.success, response.message = True, "it may move"
        return response

    # --- what is said of it ----------------------------------------------------------------------------------------------

    def _report(self, health: Health, why: str) -> None:
        line = brief(f"{health.value}: {why}")
        self.get_logger().info(line) if health == Health.FINE else self.get_logger().warning(line)
        self._diagnose()

    def _diagnose(self) -> None:
        body = self.hardware
        status = DiagnosticStatus(name=f"driver: {self._calibration.name}", hardware_id=self._port)
        if body is None:
            status.level, status.message = DiagnosticStatus.STALE, "not configured"
        else:
            status.level, status.message = _LEVEL[body.health], brief(f"{body.health.value}: {body.why}")
            limits, latency = body.limiter.report, list(body.latency)[-1000:]
            values = {
                "health": body.health.name, "states lost": body.counts.lost, "frames damaged": body.damaged,
                "line reopened": body.counts.reopened, "firmware restarted": body.counts.restarted, "vented": body.counts.vented,
                "limited in magnitude": limits.magnitude, "limited in rate": limits.rate, "levels refused": limits.refused,
                "latency ms, 99 %": f"{1e3 * float(np.percentile(latency, 99)):.2f}" if latency else "",
            }
            status.values = [KeyValue(key=key, value=str(value)) for key, value in values.items()]
        message = DiagnosticArray(status=[status])
        message.header.stamp = self.get_clock().now().to_msg()
        self._diagnostics.publish(message)


def activate(driver: Driver) -> None:
    """Configure and activate at once, for who has no manager.  Raises LineError where that fails."""
    driver.open()
    for transition in (driver.trigger_configure, driver.trigger_activate):
        if transition() != TransitionCallbackReturn.SUCCESS:
            raise LineError("the driver does not come up: see its log")
