"""The same commands and states as `sensor_msgs/JointState`, as ros2_control's `joint_state_topic_hardware_interface` takes them.

A cell is a joint, `cell_0`, `cell_1`, ...: its position is e - c, from -1 to 1, and its effort the pressure that was measured, in the
unit of the calibration.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from sensor_msgs.msg import JointState

from ..hardware.calibration import Calibration
from ..hardware.serial_body import Sight
from ..ros.topics import COMMAND, STREAM


class Joints:
    """Two topics of a driver.

    Args: node; callbacks: of the node; calibration; commands, states: names of the topics; take: called with the activation (N,) that
    a command asks for, NaN where it names no such cell.
    """

    def __init__(
        self, node: Any, callbacks: Any, calibration: Calibration, commands: str, states: str, take: Callable[[np.ndarray], None],
    ):
        self._node, self._callbacks, self._calibration, self._take = node, callbacks, calibration, take
        self._names = [f"cell_{i}" for i in range(calibration.cells)]
        self._place = {name: i for i, name in enumerate(self._names)}
        self._asked = np.zeros(calibration.cells)
        self._states = node.create_publisher(JointState, states, STREAM.profile())
        callbacks.subscription(JointState, commands, self._command, COMMAND.profile())

    def _command(self, message: JointState) -> None:
        """Joints that a command does not name keep what they were told last."""
        if len(message.position) != len(message.name):
            given = f"{len(message.position)} positions for {len(message.name)} names"
            self._callbacks.warn("joints", f"a joint command with {given} ignored: give a position, e - c, for each name")
            return
        for name, position in zip(message.name, message.position):
            if name not in self._place:
                self._callbacks.warn("joint", f"a joint command for {name[:40]!r} ignored: joints are cell_0 to {self._names[-1]}")
                return
            if np.isfinite(position):  # a controller that has no command yet says NaN
                self._asked[self._place[name]] = position
        self._take(self._asked)

    def show(self, sight: Sight) -> None:
        """Publish a state, if somebody listens."""
        if not self._states.get_subscription_count():
            return
        pressure = self._calibration.by_cell(sight.state.pressure)
        message = JointState(name=self._names, position=self._calibration.activation_of(pressure).tolist(), effort=pressure.tolist())
        message.header.stamp = self._node.get_clock().now().to_msg()
        self._states.publish(message)
