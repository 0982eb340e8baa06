"""N simulator nodes and, when they are ready, an evolution on them.

    ros2 launch evodevo_ga evolve.launch.py simulators:=4 task:=walk arguments:="--generations 200 --out bags/walk"
"""

import shlex

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction, RegisterEventHandler, SetEnvironmentVariable, Shutdown
from launch.event_handlers import OnProcessIO
from launch.substitutions import EnvironmentVariable, LaunchConfiguration
from launch_ros.actions import Node

MOST = 256  # simulators


def _nodes(context):
    count = LaunchConfiguration("simulators").perform(context)
    task = LaunchConfiguration("task").perform(context)
    arguments = shlex.split(LaunchConfiguration("arguments").perform(context))
    if not count.isdecimal() or not 1 <= int(count) <= MOST:
        raise RuntimeError(f"simulators is {count!r}: give 1 to {MOST}")
    evolve = Node(
        package="evodevo_ga", executable="evolve", arguments=["--task", task, *arguments], output="screen", on_exit=[Shutdown()],
    )
    waiting = set(range(int(count)))

    def settled(k):
        """Simulator k is ready, or has ended: of the last one the evolution follows."""
        if k not in waiting:
            return None
        waiting.remove(k)
        return None if waiting else [evolve]

    def actions_of(k):
        simulator = Node(
            package="evodevo_sim", executable="simulator", namespace=f"sim_{k}", parameters=[{"task": task}], output="screen",
            on_exit=lambda event, context: settled(k),
        )

        def heard(event):
            return settled(k) if b"ready" in event.text else None

        return [simulator, RegisterEventHandler(OnProcessIO(target_action=simulator, on_stdout=heard, on_stderr=heard))]

    return [action for k in range(int(count)) for action in actions_of(k)]


def generate_launch_description():
    return LaunchDescription([
        DeclareLaunchArgument("simulators", default_value="2", description="simulator nodes, one a core"),
        DeclareLaunchArgument("task", default_value="swim", description="what to evolve for"),
        DeclareLaunchArgument("arguments", default_value="", description="more arguments of evolve"),
        SetEnvironmentVariable(
            "ROS_AUTOMATIC_DISCOVERY_RANGE", EnvironmentVariable("ROS_AUTOMATIC_DISCOVERY_RANGE", default_value="LOCALHOST")
        ),
        OpaqueFunction(function=_nodes),
    ])
