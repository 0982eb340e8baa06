"""The command line of `ros2 run evodevo_sim simulator`."""

from __future__ import annotations

import sys

from ..ros.command_line import Parser
from ..ros.environment import EnvironmentFault, check_environment, without_ros

_EPILOG = """\
examples:
  ros2 run evodevo_sim simulator
      a node in the namespace /

in a namespace of its own, so that several can stand side by side:
  ros2 run evodevo_sim simulator --ros-args -r __ns:=/sim_0

names in the namespace:
  services  evaluate  evodevo_msgs/srv/Evaluate   a batch of genomes for a task and a seed
            cancel    evodevo_msgs/srv/Cancel     give up requests for evaluations, by their id or by who asked
            load      evodevo_msgs/srv/Load       grow a genome and let it live at a real-time factor
            pause     std_srvs/srv/SetBool        hold the animat, or let it go on; a loaded one is never held
            reset     std_srvs/srv/Trigger        back to birth, held if it was
  topics    body, cell_states                     of the live animat; body is latched
            actuation                             what its muscles are told, each control step, where somebody listens
            worker                                who it is and how it evaluates; ros2 run evodevo_ga status shows it
            drawn/cells, drawn/markers, drawn/pose   the same for RViz, Foxglove and others, where somebody listens
            target_pose (subscribed)              geometry_msgs/PoseStamped; the last good one holds

parameters, e.g. -p publish_every:=4
  frame_id       world   frame of positions and targets
  max_batch      1000    genomes in one request, at the most; the other limits stand in docs/reference/limits.md: max_elements, max_cells,
                         max_steps, max_seconds, max_waiting
  publish_every  1       control steps between cell states
  task           swim    task whose first request does not wait for kernels
  threads        1       requests evaluated at once; 0: one a core
  target_age     1.0     s, of the oldest target that counts; one with a stamp of 0 always does

Nothing leaves this host unless ROS_AUTOMATIC_DISCOVERY_RANGE says so.
"""


def main(arguments: list[str]) -> int:
    parser = Parser("simulator", "Simulate animats: batches for evolution, and one live.", _EPILOG)
    parser.parse_args(without_ros(arguments))
    try:
        check_environment()
    except EnvironmentFault as error:
        print(f"{parser.prog}: {error}", file=sys.stderr)
        return 2
    from ..nodes.simulator import Simulator
    from ..ros.process import run

    return run(Simulator, parser, arguments)


if __name__ == "__main__":
    from .entry import simulator as entry

    sys.exit(entry())
