"""`ros2 run evodevo_sim simulator`: evaluates batches of genomes, and runs one animat live as a hardware driver would."""

from __future__ import annotations

from typing import Any

from rclpy.node import Node

from ..parameters import default_task
from ..ros.barrier import Callbacks, Desk
from ..ros.host import cores
from ..ros.node_parameters import fixed
from ..task_kinds import names
from ..tasks.evaluation import prepare
from .evaluations import Evaluations
from .limits import Limits
from .living import Living, Manner


class Simulator(Node):
    """The node.  Evaluations are answered in threads of their own (see `Evaluations`), births of live animats in another, and the
    live animat goes on meanwhile in one more; so what controls it waits for none of them.

    Args: stop: an Event; set, a batch ends early.
    """

    def __init__(self, stop: Any):
        super().__init__("simulator")
        manner = Manner.declared(self)
        limits = Limits.declared(self)
        threads = self.declare_parameter("threads", 1, fixed("requests evaluated at once; 0: one a core", 0, 1024)).value
        first = self.declare_parameter("task", names()[0], fixed("task whose first request does not wait")).value
        prepare(default_task(first), self.get_logger().info)
        callbacks = Callbacks(self)
        self._evaluations, self._births = Evaluations(self, callbacks, threads or cores(), limits, stop.is_set), Desk("births")
        self._living = Living(self, callbacks, self._births, manner, limits, stop.is_set)
        self.get_logger().info("ready")

    def close(self) -> None:
        self._evaluations.close()
        self._births.close()
        self._living.close()
        self.destroy_node()
