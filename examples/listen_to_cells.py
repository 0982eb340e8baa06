"""A ROS node that prints where a live animat is: run a simulator, load a genome, then this.

    python examples/listen_to_cells.py [NAMESPACE]
"""

import os
import sys

import rclpy
from rclpy.qos import qos_profile_sensor_data

from evodevo_msgs.msg import CellStates

os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
rclpy.init()
node = rclpy.create_node("listener", namespace=sys.argv[1] if len(sys.argv) > 1 else "/sim_0")


def show(cells):
    print(f"step {cells.step}: {len(cells.position_x)} cells, the first at ({cells.position_x[0]:.2f}, {cells.position_y[0]:.2f}) m")


node.create_subscription(CellStates, "cell_states", show, qos_profile_sensor_data)
try:
    rclpy.spin(node)
except KeyboardInterrupt:
    rclpy.try_shutdown()
