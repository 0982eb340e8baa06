"""A node in the simulator's place, whose body is yours: here, cells on springs of their own.

    python examples/driver_of_your_own.py [SECONDS]

Without SECONDS it lives until Ctrl-C; in another terminal: ros2 run evodevo_sim conform /springs --genome champion.yaml
"""

import contextlib
import sys
import threading

import numpy as np
import rclpy
from evodevo_sim.live.animat import Animat
from evodevo_sim.nodes.limits import Limits
from evodevo_sim.nodes.living import Living, Manner
from evodevo_sim.plant import Outcome
from evodevo_sim.ros.barrier import Callbacks, Desk, spin
from evodevo_sim.ros.process import stay_on_this_host
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node


class Springs:
    """Each cell is a mass on a spring, pulled up by its activation.  `evodevo_sim.plant.Plant` says what a plant must offer."""

    def __init__(self, born):
        self.born = born.copy()
        self.position, self.velocity = self.born.copy(), np.zeros_like(self.born)

    def move(self, activation, seconds):
        self.velocity[:, 1] += seconds * (activation - (self.position - self.born)[:, 1])
        self.position += seconds * self.velocity
        return Outcome.SOUND

    def reset(self):
        self.position[:], self.velocity[:] = self.born, 0.0

    def rests(self):
        return False


class Driver(Node):
    def __init__(self, stop):
        super().__init__("driver")
        self._births = Desk("births")
        manner, limits = Manner.declared(self), Limits.declared(self)
        self._living = Living(self, Callbacks(self), self._births, manner, limits, stop.is_set, self._make)

    def _make(self, genome, task, seed):
        return Animat(genome, task, seed, lambda grown: Springs(grown.position))

    def close(self):
        self._births.close()
        self._living.close()
        self.destroy_node()


stay_on_this_host()
rclpy.init(args=["--ros-args", "-r", "__ns:=/springs"])
stop = threading.Event()
if len(sys.argv) > 1:
    threading.Timer(float(sys.argv[1]), stop.set).start()
node = Driver(stop)
executor = SingleThreadedExecutor()
executor.add_node(node)
print("ready", flush=True)
with contextlib.suppress(KeyboardInterrupt):
    spin(executor, node, stop)
node.close()
rclpy.try_shutdown()
