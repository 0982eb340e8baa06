"""A ROS node that prints where a live animat is: run a simulator, load a genome, then this.

    python examples/listen_to_cells.py [NAMESPACE] [MESSAGES]
"""

import os
import sys

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.qos import qos_profile_sensor_data

from evodevo_msgs.msg import CellStates

os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")  # nothing leaves this computer
namespace = sys.argv[1] if len(sys.argv) > 1 else "/sim_0"
left = int(sys.argv[2]) if len(sys.argv) > 2 else None  # None: until Ctrl-C


def show(cells):
    global left
    print(f"step {cells.step}: {len(cells.position_x)} cells, the first at ({cells.position_x[0]:.2f}, {cells.position_y[0]:.2f}) m")
    if left is not None and (left := left - 1) <= 0:
        raise KeyboardInterrupt


rclpy.init()
try:
    node = rclpy.create_node("listener", namespace=namespace)
    node.create_subscription(CellStates, "cell_states", show, qos_profile_sensor_data)
    rclpy.spin(node)
except (KeyboardInterrupt, ExternalShutdownException):
    pass
finally:
    rclpy.try_shutdown()
